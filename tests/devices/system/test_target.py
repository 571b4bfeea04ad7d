"""Target description: XML that a tool can read, platform, project."""

import xml.etree.ElementTree as ET
from typing import Any


def test_the_xml_reports_version_and_net_id(client: Any) -> None:
    data = client.read(700, 1, 2048)
    assert data.endswith(b"\0")
    root = ET.fromstring(data[:-1])
    assert root.tag == "TcTargetDesc"
    version = [root.findtext(f"TargetVersion/{name}") for name in ("Version", "Revision", "Build")]
    assert version == ["3", "1", "4024"]
    assert root.findtext("TargetFeatures/NetId") == "5.1.2.3.1.1"
    assert root.findtext("Hardware/SerialNo") == "test & more"


def test_platform_and_project(client: Any) -> None:
    assert client.read(700, 4, 64) == b"TwinCAT RT (x64)\0"
    assert client.read(700, 7, 64) == b"test & more\0"
    assert client.read(700, 7, 4) == b"test"


def test_other_offsets_are_refused(client: Any, refused: Any) -> None:
    with refused(0x703):
        client.read(700, 2, 4)
