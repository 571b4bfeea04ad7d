"""The object dictionary against the manual's list, row by row."""

import csv
from pathlib import Path

import pytest

from achse.codes import AbortCode
from achse.drive import VirtualDrive
from achse.drive.objects import DICTIONARY, OBJECTS, ROWS, Access, DataType, find
from achse.drive.objects.dictionary import is_unsupported

_TABLE = Path(__file__).parents[2] / "data" / "drive_objects.tsv"
LISTED = list(csv.DictReader(_TABLE.read_text(encoding="utf-8").splitlines(), delimiter="\t"))
SINGLE = [row for row in LISTED if "-" not in row["index"] and row["subindex"] != "-"]
AREAS = [row for row in LISTED if "-" in row["index"] or row["subindex"] == "-"]


def _key(row: dict[str, str]) -> int:
    return int(row["index"], 16) << 8 | int(row["subindex"], 16)


def _number(text: str) -> float:
    return (
        int(text, 0)
        if ("." not in text and "e" not in text.lower()) or "x" in text
        else float(text)
    )


@pytest.mark.parametrize("listed", SINGLE, ids=lambda row: f"{row['index']}:{row['subindex']}")
def test_each_entry_is_as_listed(listed: dict[str, str]) -> None:
    row = DICTIONARY[_key(listed)]
    assert row.name == listed["object_name"]
    if listed["data_type"] != "-":
        assert row.type is DataType[listed["data_type"]]
    assert row.writable == (listed["access"] == "rw")
    assert row.pdo == (listed["pdo"] == "Y")
    for text, value in ((listed["valid_min"], row.least), (listed["valid_max"], row.most)):
        if text:
            assert value == pytest.approx(_number(text), rel=1e-5)
    if listed["default"]:
        assert row.default == _number(listed["default"])
    if listed["unit"]:
        assert row.unit == listed["unit"]


@pytest.mark.parametrize("listed", SINGLE, ids=lambda row: f"{row['index']}:{row['subindex']}")
def test_a_fresh_drive_holds_the_default_or_a_value_of_the_range(listed: dict[str, str]) -> None:
    row = DICTIONARY[_key(listed)]
    value = VirtualDrive().get(row.index, row.subindex)
    if listed["default"] and listed["index"] != "0x1C32":
        assert value == _number(listed["default"])
    assert row.least <= value <= row.most


@pytest.mark.parametrize("listed", AREAS, ids=lambda row: row["index"])
def test_areas(listed: dict[str, str], aborts) -> None:
    first, _, last = listed["index"].partition("-")
    low, high = int(first, 16), int(last or first, 16)
    if listed["subindex"] == "-":
        assert is_unsupported(low)
        assert is_unsupported(high)
        with aborts(AbortCode.UNSUPPORTED_ACCESS):
            find(low, 0)
        assert not any(low <= each.index <= high for each in OBJECTS)
    else:
        assert any(low <= row.index <= high for row in ROWS)
        with aborts(AbortCode.NO_OBJECT):
            find(high, 0)


def test_nothing_else_is_in_the_dictionary() -> None:
    known = {_key(row) for row in SINGLE}
    others = [row for row in ROWS if row.key not in known]
    own = {0x10F3, 0x4095, 0x4096}  # named in the manual's text
    assert {row.index for row in others if not 0x2000 <= row.index < 0x3000} == own


def test_rows_ascend_and_tell_what_they_are() -> None:
    keys = [row.key for row in ROWS]
    assert keys == sorted(set(keys))
    assert all(row.doc.endswith(".") for row in ROWS)


def test_unknown_entries(aborts) -> None:
    with aborts(AbortCode.NO_OBJECT):
        find(0x5000, 0)
    with aborts(AbortCode.NO_OBJECT):
        find(0x6040, 1)


def test_objects_for_sdo_information() -> None:
    by_index = {each.index: each for each in OBJECTS}
    assert [each.index for each in OBJECTS] == sorted(by_index)
    controlword = by_index[0x6040]
    assert (controlword.code, controlword.data_type, len(controlword.entries)) == (7, 6, 1)
    assert controlword.entries[0].access == 0x003F | 0x40 | 0x80
    statusword = by_index[0x6041].entries[0]
    assert (statusword.access, statusword.bits) == (0x0007 | 0x80, 16)
    mapping = by_index[0x1600]
    assert (mapping.code, mapping.data_type, len(mapping.entries)) == (9, 0x21, 9)
    assert mapping.entries[1].default == bytes.fromhex("10004060")
    assert mapping.entries[0].access & 0x3F == 0x000F, "written in PreOp only"
    assert (by_index[0x1018].code, by_index[0x1018].data_type) == (9, 0x23)
    assert (by_index[0x10F1].code, by_index[0x10F3].code) == (9, 9)
    assert (by_index[0x1C12].code, by_index[0x1C12].data_type) == (8, 6)
    assert by_index[0x1C32].name == "SyncManager 2 synchronization"
    assert by_index[0x1C32].entries[-1].subindex == 12


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row.index:04X}:{row.subindex:02X}")
def test_access_and_range_of_each_row(row, aborts) -> None:
    """SDO reads always work; writes obey access and range, and what is written is read back."""
    drive = VirtualDrive()
    data = drive.read_object(row.index, row.subindex)
    assert len(data) * 8 == row.type.bits
    if not row.writable:
        with aborts(AbortCode.READ_ONLY):
            drive.write_object(row.index, row.subindex, data)
        return
    if row.access is Access.RW_PREOP:
        with aborts(AbortCode.READ_ONLY):
            drive.write_object(row.index, row.subindex, data)
        return
    with aborts(AbortCode.UNSUPPORTED_ACCESS):
        drive.write_object(row.index, row.subindex, data + b"\0")
    for value in (row.least - 1, row.most + 1):
        if row.type.least <= value <= row.type.most and row.type is not DataType.F32:
            with aborts(AbortCode.VALUE_RANGE):
                drive.write_object(row.index, row.subindex, row.type.pack(value))
    if row.write is None and row.key not in drive.mapping.received.keys:
        for value in row.values or (row.least, row.most):
            drive.write_object(row.index, row.subindex, row.type.pack(value))
            assert drive.get(row.index, row.subindex) == pytest.approx(value, rel=1e-6)
