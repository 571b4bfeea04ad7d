"""Devices by name in a folder of files."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ethercat.master.esi_reader import EsiError, read_esi
from achse.ethercat.virtual.esi_folder import EsiFolder
from tests.ethercat.virtual.esi_text import DIGITAL_IN, device, drawn_devices, esi


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
    result = EsiFolder([folder])
    assert result.find("Box").revision_number == 0x30000
    assert result.find("box@0x10000").revision_number == 0x10000
    assert result.find("DI8").product_code == 0x1008
    assert len(result.refused) == 1
    assert "notes.xml" in result.refused[0]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("Bux", "no device 'Bux' in the ESI files; there are: Box"),
        ("Box@7", "no revision 0x00000007; there are: 0x00010000, 0x00030000"),
        ("Box@x", "revision: expected a number"),
    ],
)
def test_wrong_name_reports_what_there_is(folder: Path, name: str, message: str) -> None:
    with pytest.raises(EsiError, match=message):
        EsiFolder([folder]).find(name)


def test_file_that_is_named_has_to_be_one(folder: Path) -> None:
    assert len(EsiFolder([folder / "inputs.xml"]).types) == 1
    with pytest.raises(EsiError, match=r"notes.xml: expected EtherCATInfo"):
        EsiFolder([folder / "notes.xml"])
    with pytest.raises(EsiError, match="No such file"):
        EsiFolder([folder / "none.xml"])


@settings(max_examples=15, deadline=None)
@given(
    st.lists(drawn_devices(), min_size=1, max_size=3),
    st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "iso-8859-1", "windows-1252"]),
    st.booleans(),
)
def test_device_alone_is_what_the_whole_file_has(
    tmp_path_factory: pytest.TempPathFactory, drawn: list[str], encoding: str, modules: bool
) -> None:
    """In each encoding, with the modules of the file and without."""
    file = tmp_path_factory.mktemp("esi") / "drawn.xml"
    module = '<Module><Type ModuleIdent="1">Mödul</Type></Module>' if modules else ""
    declared = "" if encoding.startswith("utf") else f"<?xml version='1.0' encoding='{encoding}'?>"
    file.write_bytes((declared + esi(*drawn, modules=module)).encode(encoding))
    whole, result = read_esi(file.read_bytes()), EsiFolder([file])
    assert [each.type_name for each in result.types] == [each.type_name for each in whole]
    for each in {each.type_name: each for each in reversed(whole)}.values():
        alone = result.find(each.type_name)
        assert alone == each
        assert alone.modules is not None
        assert [kind.text for kind in alone.modules.iterfind("Module/Type")] == ["Mödul"] * modules
    assert result.find(whole[0].type_name) is result.find(whole[0].type_name)


def test_file_that_is_another_one_meanwhile_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "box.xml"
    file.write_text(esi(DIGITAL_IN))
    result = EsiFolder([file])
    file.write_text("")
    with pytest.raises(EsiError, match=r"box.xml: changed while|box.xml: an ESI file"):
        result.find("DI8")
    file.unlink()
    with pytest.raises(EsiError, match="No such file"):
        result.find("DI8")


def test_types_are_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("achse.ethercat.virtual.esi_folder._MOST_TYPES", 3)
    for name in ("one", "two"):
        (tmp_path / f"{name}.xml").write_text(esi(*[DIGITAL_IN] * 2))
    result = EsiFolder([tmp_path])
    assert len(result.types) == 2
    assert "more than 3 devices" in result.refused[0]
