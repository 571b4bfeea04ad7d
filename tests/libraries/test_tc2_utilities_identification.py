"""Tc2_Utilities: what a station says of its computer."""

import platform
from pathlib import Path
from typing import Any

from achse.devices.system.device import VERSION
from achse.station import Station
from achse.station.configuration.station_file import parse

MAIN = """PROGRAM MAIN
VAR
    long : FB_GetDeviceIdentificationEx; short : FB_GetDeviceIdentification;
    far : FB_GetDeviceIdentificationEx;
END_VAR
long(bExecute := TRUE);
short(bExecute := TRUE);
far(bExecute := TRUE, sNetId := '9.9.9.9.1.1');
END_PROGRAM"""


def test_identification_of_a_computer(tmp_path: Path) -> None:
    (tmp_path / "a.st").write_text(MAIN, encoding="utf-8")
    document = {"name": "Press 7 in the hall", "plc": [{"sources": "a.st"}]}
    station = Station(parse(document, "a.toml"), base=tmp_path)
    station.advance(1.0)
    main: Any = station.plcs[851].instance("MAIN")
    assert station.plcs[851].failure == ""
    for block, length in (("long", 16), ("short", 12)):
        assert (main[block]["bBusy"], main[block]["bError"]) == (False, False)
        identification = main[block]["stDevIdent"]
        assert (identification["strTargetType"], identification["strHardwareModel"]) == (
            "PC",
            "achse",
        )
        assert identification["strHardwareSerialNo"] == "Press 7 in the hall"[:length]
        assert identification["strHardwareCPU"] == platform.machine()[:20]
        assert identification["strImageOsName"] == platform.system()
        assert identification["strImageOsVersion"] == platform.release()[:8]
        versions = (
            identification["strTwinCATVersion"],
            identification["strTwinCATRevision"],
            identification["strTwinCATBuild"],
        )
        assert versions == tuple(map(str, VERSION))
        assert identification["strAmsNetId"] == str(station.router.net_id)
        assert identification["strHardwareDate"] == ""
    assert (main["far"]["bBusy"], main["far"]["bError"]) == (False, True)
    assert main["far"]["nErrorId"] == 7
