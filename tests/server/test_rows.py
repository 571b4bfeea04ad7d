"""A row reads, checks and writes what it refers to, and refuses to exist without reference."""

import struct
from enum import IntEnum
from typing import Any, NamedTuple

import pytest

from achse.ams import DeviceError
from achse.iec import UDINT
from achse.server import BYTES, READ, READ_WRITE, VOID, WRITE, Layout, Repeated, Service


class Drive:
    def __init__(self) -> None:
        self.torque = 2.5
        self.motor = Motor()


class Motor:
    def __init__(self) -> None:
        self.poles = 4


class Stop(NamedTuple):
    deceleration: float
    jerk: float


class Mode(IntEnum):
    VELOCITY = 3
    TORQUE = 4


def refused(row: Service, data: bytes) -> int:
    with pytest.raises(DeviceError) as failure:
        row.decode(data)
    return failure.value.code


def test_a_field_is_read_and_written_on_the_target() -> None:
    drive = Drive()
    row = Service(1, "torque", READ | WRITE, Layout("<d"), field="torque")
    assert row.encoder(8)(row.get(drive)) == struct.pack("<d", 2.5)
    row.set(drive, row.decode(struct.pack("<d", -1.0)))
    assert drive.torque == -1.0


def test_a_dotted_field_reaches_into_parts() -> None:
    drive = Drive()
    row = Service(1, "poles", READ | WRITE, Layout("<H"), field="motor.poles")
    row.set(drive, 6)
    assert (drive.motor.poles, row.get(drive)) == (6, 6)


def test_an_iec_type_is_a_codec() -> None:
    row = Service(1, "poles", READ | WRITE, UDINT, field="motor.poles")
    assert row.encoder(4)(row.get(Drive())) == b"\x04\0\0\0"
    assert row.decode(b"\x05\0\0\0") == 5
    assert row.facts(0, 0).layout == "UDINT"


@pytest.mark.parametrize(
    ("access", "reference"),
    [
        (READ, {}),
        (WRITE, {}),
        (READ_WRITE, {}),
        (READ | WRITE, {"read": lambda drive: 1}),
        (READ, {"read": lambda drive: 1, "write": lambda drive, value: None}),
        (READ | READ_WRITE, {"field": "x", "exchange": lambda drive, value: None}),
        (READ, {"field": "x", "count": 2}),
        (READ, {"read": len, "count": 2, "element": lambda drive, n: drive}),
        (READ & WRITE, {"field": "x"}),
    ],
)
def test_a_row_that_refers_to_nothing_does_not_exist(access: Any, reference: Any) -> None:
    with pytest.raises(ValueError, match="row 'torque'"):
        Service(1, "torque", access, Layout("<d"), **reference)


@pytest.mark.parametrize("value", [-0.1, 10.1, float("nan"), float("inf"), float("-inf")])
def test_a_number_out_of_range_is_answered_the_rows_code(value: float) -> None:
    limits: Any = {"field": "torque", "minimum": 0.0, "maximum": 10.0}
    data = struct.pack("<d", value)
    assert refused(Service(1, "torque", WRITE, Layout("<d"), **limits), data) == 0x706
    assert refused(Service(1, "torque", WRITE, Layout("<d"), **limits, code=0x4221), data) == 0x4221


def test_both_ends_of_a_range_are_in_it() -> None:
    row = Service(1, "torque", WRITE, Layout("<d"), field="torque", minimum=0.0, maximum=10.0)
    assert row.decode(struct.pack("<d", 0.0)) == 0.0
    assert row.decode(struct.pack("<d", 10.0)) == 10.0


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_what_is_no_finite_number_is_refused_everywhere(value: float) -> None:
    plain = Service(1, "torque", WRITE, Layout("<d"), field="torque")
    record = Service(1, "stop", WRITE, Layout("<dd", Stop), write=lambda drive, stop: None)
    assert refused(plain, struct.pack("<d", value)) == 0x706
    assert refused(record, struct.pack("<dd", 1.0, value)) == 0x706


def test_a_row_may_allow_infinity() -> None:
    row = Service(1, "torque", WRITE, Layout("<d"), field="torque", non_finite=True)
    assert row.decode(struct.pack("<d", float("inf"))) == float("inf")


@pytest.mark.parametrize("choices", [Mode, (3, 4), range(3, 5)])
def test_choices_admit_only_themselves(choices: Any) -> None:
    row = Service(1, "mode", WRITE, Layout("<I"), field="torque", choices=choices)
    assert row.decode(b"\x03\0\0\0") == 3
    assert refused(row, b"\x05\0\0\0") == 0x706


@pytest.mark.parametrize("size", [0, 7, 9, 16])
def test_a_write_has_the_size_of_the_layout(size: int) -> None:
    row = Service(1, "torque", WRITE, Layout("<d"), field="torque")
    assert refused(row, bytes(size)) == 0x705


def test_a_function_without_data_takes_none() -> None:
    row = Service(1, "reset", WRITE, VOID, write=lambda drive, value: None)
    assert row.decode(b"") is None
    assert refused(row, b"\0") == 0x705


class Packed:
    """The first two fields only, from the same value."""

    size = 4
    name = "two"

    def encode(self, value: tuple[int, ...]) -> bytes:
        return struct.pack("<HH", *value[:2])

    def decode(self, data: bytes) -> tuple[int, ...]:
        return (*struct.unpack("<HH", data), 0, 0)


def test_the_requested_length_picks_the_layout_and_else_the_largest_is_cut() -> None:
    row = Service(0, "both", READ, (Packed(), Layout("<IIII")), read=lambda t: (1, 2, 3, 4))
    assert row.encoder(4)((1, 2, 3, 4)) == b"\1\0\2\0"
    for length in (0, 8, 16, 200):
        assert row.encoder(length)((1, 2, 3, 4)) == struct.pack("<IIII", 1, 2, 3, 4)
    assert row.facts(0, 0).layout == "two or {UINT32; UINT32; UINT32; UINT32}"


def test_the_written_size_picks_the_layout() -> None:
    row = Service(0, "both", WRITE, (Packed(), Layout("<IIII")), write=lambda t, value: None)
    assert row.decode(b"\1\0\2\0") == (1, 2, 0, 0)
    assert row.decode(struct.pack("<IIII", 1, 2, 3, 4)) == (1, 2, 3, 4)
    assert refused(row, bytes(8)) == 0x705


def test_two_layouts_of_one_size_cannot_be_distinguished() -> None:
    with pytest.raises(ValueError, match="same size"):
        Service(0, "both", READ, (Layout("<I"), Layout("<HH")), field="x")


def test_a_record_has_as_many_fields_as_its_format() -> None:
    assert Layout("<d4xd", Stop).decode(struct.pack("<d4xd", 1, 2)) == Stop(1.0, 2.0)
    with pytest.raises(ValueError, match="Stop has 2 fields"):
        Layout("<ddd", Stop)


@pytest.mark.parametrize(
    ("layout", "text"),
    [
        (Layout("<d"), "REAL64"),
        (Layout("<H2xI16s"), "{UINT16; 2 unused; UINT32; BYTE[16]}"),
        (Layout("<d4xf", Stop), "{deceleration:REAL64; 4 unused; jerk:REAL32}"),
    ],
)
def test_a_layout_is_named_as_the_manuals_write_it(layout: Layout, text: str) -> None:
    assert layout.name == text


def test_repeated_elements_come_whole() -> None:
    row = Service(0, "ids", READ | WRITE, Repeated(Layout("<I")), field="x")
    assert row.encoder(100)((1, 2)) == b"\1\0\0\0\2\0\0\0"
    assert row.decode(b"\1\0\0\0\2\0\0\0") == (1, 2)
    assert refused(row, bytes(5)) == 0x705
    with pytest.raises(ValueError, match="fixed size"):
        Repeated(BYTES)


def test_bytes_that_are_no_value_are_bad_data() -> None:
    class Picky:
        size = 2

        def encode(self, value: str) -> bytes:
            return value.encode()

        def decode(self, data: bytes) -> str:
            return data.decode("ascii")

    assert refused(Service(0, "text", WRITE, Picky(), field="x"), b"\xff\xff") == 0x706


def test_the_facts_say_what_the_row_says() -> None:
    row = Service(
        0x10,
        "mode",
        READ | WRITE,
        Layout("<I"),
        "Mode of the drive.",
        "1",
        field="x",
        choices=Mode,
        symbol="Mode",
        source="002 §1",
    )
    facts = row.facts(0x4100, 0x41FF)
    assert (facts.index_group, facts.last_index_group) == (0x4100, 0x41FF)
    assert (facts.index_offset, facts.last_index_offset) == (0x10, 0x10)
    assert str(facts.access) == "R W"
    assert facts.range == "3=VELOCITY, 4=TORQUE"
    assert (facts.unit, facts.symbol) == ("1", "Mode")


def test_the_range_in_words() -> None:
    def words(**limits: Any) -> str:
        return Service(0, "v", WRITE, Layout("<d"), field="v", **limits).range_text

    assert words(minimum=0.0) == "0.."
    assert words(maximum=1e6) == "..1e+06"
    assert words(minimum=-1.0, maximum=1.0) == "-1..1"
    assert words(choices=(1, 2)) == "(1, 2)"
    assert words() == ""
