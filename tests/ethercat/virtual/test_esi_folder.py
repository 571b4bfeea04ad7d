"""Devices by name in a folder of files."""

from pathlib import Path

import pytest

from achse.ethercat.master.esi_reader import EsiError
from achse.ethercat.virtual.esi_folder import EsiFolder
from tests.ethercat.virtual.esi_text import DIGITAL_IN, device, esi


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    boxes = [device("", name="Box", revision=each) for each in (0x10000, 0x30000, 0x20000)]
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "boxes.XML").write_text(esi(*boxes))
    (tmp_path / "inputs.xml").write_text(esi(DIGITAL_IN))
    (tmp_path / "notes.xml").write_text("<Notes/>")
    (tmp_path / "readme.txt").write_text("no ESI")
    (tmp_path / "old.xml").mkdir()
    return tmp_path


def test_newest_revision_unless_one_is_named(folder: Path) -> None:
    found = EsiFolder([folder])
    assert found.find("Box").revision_number == 0x30000
    assert found.find("box@0x10000").revision_number == 0x10000
    assert found.find("DI8").product_code == 0x1008
    assert len(found.refused) == 1
    assert "notes.xml" in found.refused[0]


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("Bux", "no device 'Bux' in the ESI files; there are: Box"),
        ("Box@7", "no revision 0x00000007; there are: 0x00010000, 0x00030000"),
        ("Box@x", "revision: expected a number"),
    ],
)
def test_wrong_name_tells_what_there_is(folder: Path, name: str, told: str) -> None:
    with pytest.raises(EsiError, match=told):
        EsiFolder([folder]).find(name)


def test_file_that_is_named_has_to_be_one(folder: Path) -> None:
    assert len(EsiFolder([folder / "inputs.xml"]).devices) == 1
    with pytest.raises(EsiError, match=r"notes.xml: expected EtherCATInfo"):
        EsiFolder([folder / "notes.xml"])
    with pytest.raises(EsiError, match="No such file"):
        EsiFolder([folder / "none.xml"])
