"""The object dictionary against the manual's list, row by row, by SDO over frames."""

import csv
import struct
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from achse.codes import AbortCode, AlState, DataType, SdoAbort
from achse.drive import Drive
from achse.drive.identity import PRODUCT, VENDOR
from achse.drive.objects import DICTIONARY, OBJECTS, ROWS, find
from achse.ethercat import Segment, Slave
from achse.testing import SegmentReach

_TABLE = Path(__file__).parents[2] / "data" / "drive_objects.tsv"
LISTED = list(csv.DictReader(_TABLE.read_text(encoding="utf-8").splitlines(), delimiter="\t"))
SINGLE = [row for row in LISTED if row["entry"]]
AREAS = [row for row in LISTED if not row["entry"]]
OWN = {0x10F3, 0x4095, 0x4096}
"""Named in the manual's text; of its areas 2000h and 4000h no entry is listed."""

OWN_ENTRIES = {0x1C32: (11, 32), 0x1C33: (11, 32)}
"""Of ETG.1020, which the manual leaves out: missed SM events, sync error."""

IDENTITY = {"1018:1": VENDOR, "1018:2": PRODUCT}
"""Entries with numbers of our own by default: the manual prints those of its maker."""

_INFORMATION = 0x8000
_GET_LIST, _GET_OBJECT, _GET_ENTRY = 1, 3, 5
_ALL = 0x77
_READ, _WRITE, _WRITE_PREOP, _RX, _TX = 0x07, 0x38, 0x08, 0x40, 0x80


class Entry(NamedTuple):
    """What SDO information says of an entry."""

    name: str
    type: DataType
    access: int
    default: float
    least: float
    most: float


class Reach(SegmentReach):
    """A drive in PreOp on a segment of its own."""

    def __init__(self) -> None:
        self.drive = Drive()
        super().__init__(Segment([Slave(self.drive)]))
        assert self.request(AlState.PREOP) == (AlState.PREOP, 0)

    def information(self, operation: int, data: bytes) -> bytes:
        header = struct.pack("<HBxH", _INFORMATION, operation, 0)
        return self.coe(header + data)[6:]

    def entry(self, index: int, subindex: int) -> Entry:
        result = self.information(_GET_ENTRY, struct.pack("<HBB", index, subindex, _ALL))
        _, _, info, number, bits, access = struct.unpack_from("<HBBHHH", result)
        assert info == _ALL
        kind = next(each for each in DataType if each == number)
        assert bits == kind.bits
        size = bits // 8
        default, least, most = (
            kind.unpack(result[at : at + size]) for at in range(10, 10 + 3 * size, size)
        )
        return Entry(result[10 + 3 * size :].decode(), kind, access, default, least, most)

    def get(self, row: dict[str, str]) -> float:
        index, subindex = divmod(_key(row), 256)
        return DICTIONARY[_key(row)].type.unpack(self.read(index, subindex))


@pytest.fixture(scope="module")
def reach() -> Reach:
    """Shared by tests that leave it as it is."""
    return Reach()


def _key(row: dict[str, str]) -> int:
    return int(row["object"], 16) << 8 | int(row["entry"])


def _number(text: str) -> float:
    return float(text) if "." in text else int(text)


def _limits(row: dict[str, str], kind: DataType) -> tuple[float, float] | None:
    """Return the least and the most value of a column like `any`, `5`, `0..7` or `0..2 of 0 2`."""
    text = row["values"].partition("of ")[0].strip()
    if text == "any":
        return kind.least, kind.most
    first, dots, last = text.partition("..")
    return (_number(first), _number(last if dots else first)) if text else None


def _values(row: dict[str, str]) -> list[int]:
    return [int(value) for value in row["values"].partition("of ")[2].split()]


def _default(row: dict[str, str]) -> float | None:
    own = IDENTITY.get(_id(row))
    return own if own or not row["default"] else _number(row["default"])


def _id(row: dict[str, str]) -> str:
    return f"{row['object']}:{row['entry']}"


def test_the_drive_lists_what_the_manual_lists(reach: Reach) -> None:
    listed = reach.information(_GET_LIST, b"\x01\0")[2:]
    indices = set(struct.unpack(f"<{len(listed) // 2}H", listed))
    theirs = {int(row["object"], 16) for row in SINGLE}
    assert theirs <= indices
    assert {index for index in indices - theirs if not 0x2000 <= index < 0x3000} == OWN


@pytest.mark.parametrize("index", sorted({row["object"] for row in SINGLE}))
def test_each_object_has_the_subindices_listed(reach: Reach, index: str) -> None:
    subindices = [int(row["entry"]) for row in SINGLE if row["object"] == index]
    subindices = sorted([*subindices, *OWN_ENTRIES.get(int(index, 16), ())])
    result = reach.information(_GET_OBJECT, struct.pack("<H", int(index, 16)))
    _, _, last, code = struct.unpack_from("<HHBB", result)
    assert last == subindices[-1]
    assert (code == 7) == (subindices == [0])
    name = next(row.object_name for row in ROWS if row.index == int(index, 16))
    assert result[6:].decode() == name
    missing = sorted({*range(last + 2)} - {*subindices})
    for subindex in missing:
        with pytest.raises(SdoAbort) as refusal:
            reach.read(int(index, 16), subindex)
        assert refusal.value.code is AbortCode.NO_OBJECT


@pytest.mark.parametrize("listed", SINGLE, ids=_id)
def test_each_entry_is_as_listed(reach: Reach, listed: dict[str, str]) -> None:
    index, subindex = divmod(_key(listed), 256)
    entry = reach.entry(index, subindex)
    row = DICTIONARY[_key(listed)]
    assert entry.name == row.entry_name
    if listed["type"]:
        assert entry.type is DataType[listed["type"]]
    if "w" in listed["rights"]:
        assert entry.access & (_READ | _WRITE_PREOP) == _READ | _WRITE_PREOP
    else:
        assert entry.access & (_READ | _WRITE) == _READ
    directions = _RX | _TX if "w" in listed["rights"] else _TX
    assert entry.access & (_RX | _TX) == (directions if "m" in listed["rights"] else 0)
    limits = _limits(listed, entry.type)
    if limits is not None:
        assert (entry.least, entry.most) == pytest.approx(limits, rel=1e-5)
    default = _default(listed)
    assert default is None or entry.default == default
    assert (row.unit, row.modes) == (listed["unit"], listed["modes"])


@pytest.mark.parametrize("listed", SINGLE, ids=_id)
def test_a_fresh_drive_holds_the_default_or_a_value_allowed(
    reach: Reach, listed: dict[str, str]
) -> None:
    entry = reach.entry(*divmod(_key(listed), 256))
    value = reach.get(listed)
    default = _default(listed)
    assert default is None or value == default
    assert entry.least <= value <= entry.most
    assert not _values(listed) or value in _values(listed)


@pytest.mark.parametrize("listed", [row for row in SINGLE if row["rights"] in ("r", "rm")], ids=_id)
def test_what_is_read_only_refuses_writes(
    reach: Reach, aborts: Any, listed: dict[str, str]
) -> None:
    index, subindex = divmod(_key(listed), 256)
    with aborts(AbortCode.READ_ONLY):
        reach.write(index, subindex, reach.read(index, subindex))


TELLS_ANOTHER_WAY = {0x1010, 0x3200, 0x3215, 0x3216}
"""Objects that read back what became of a command."""

ACT_LATER = {0x6060, 0x6098}
"""Values that are not listed are taken too, and change nothing or are refused when they act."""

WRITTEN = {0x1010: [0x6576_6173], 0x605D: [1, 2]}
"""Values allowed that the list gives in words: "save"; halt by 6084h in pp alone."""


@pytest.mark.parametrize("listed", [row for row in SINGLE if "w" in row["rights"]], ids=_id)
def test_writes_keep_to_the_range(aborts: Any, listed: dict[str, str]) -> None:
    reach = Reach()
    index, subindex = divmod(_key(listed), 256)
    kind = DICTIONARY[_key(listed)].type
    entry = reach.entry(index, subindex)
    inside: list[float] = [entry.least, entry.most]
    outside = [entry.least - 1, entry.most + 1]
    if index not in ACT_LATER and (allowed := _values(listed) or WRITTEN.get(index)):
        inside = [*allowed]
        outside += [
            value + step for value in allowed for step in (-1, 1) if value + step not in allowed
        ]
    if kind is not DataType.F32:
        for value in outside:
            if kind.least <= value <= kind.most:
                with aborts(AbortCode.VALUE_RANGE):
                    reach.write(index, subindex, kind.pack(value))
    with aborts(AbortCode.UNSUPPORTED_ACCESS):
        reach.write(index, subindex, bytes(kind.bits // 8 + 1))
    if entry.access & _WRITE == _WRITE_PREOP:  # mapping; what entries may hold is tested there
        for assignment in (0x1C12, 0x1C13):
            reach.write(assignment, 0, b"\0")
        if index < 0x1C00 and subindex:
            reach.write(index, 0, b"\0")
            inside = [0x6041_0010] if index >= 0x1A00 else [0x6040_0010]
    for value in inside:
        data = kind.pack(value)
        reach.write(index, subindex, data)
        if index not in TELLS_ANOTHER_WAY:
            assert reach.read(index, subindex) == data


@pytest.mark.parametrize("listed", AREAS, ids=lambda row: row["object"])
def test_areas(reach: Reach, aborts: Any, listed: dict[str, str]) -> None:
    first, _, last = listed["object"].partition("..")
    low, high = int(first, 16), int(last or first, 16)
    if listed["rights"] == "none":
        for index in {low, high}:
            with aborts(AbortCode.UNSUPPORTED_ACCESS):
                reach.read(index)
        assert not any(low <= each.index <= high for each in OBJECTS)
    else:
        assert any(low <= row.index <= high for row in ROWS)
        with aborts(AbortCode.NO_OBJECT):
            reach.read(high)


def test_rows_ascend_and_report_what_they_are() -> None:
    keys = [row.key for row in ROWS]
    assert keys == sorted(set(keys))
    assert all(row.doc.endswith(".") for row in ROWS)


def test_unknown_entries(aborts: Any) -> None:
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
    assert by_index[0x1C32].entries[-1].subindex == 32
