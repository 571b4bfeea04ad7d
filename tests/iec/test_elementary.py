"""The elementary numeric types."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec.elementary import (
    BIT,
    BOOL,
    BYTE,
    DINT,
    INT,
    LINT,
    LREAL,
    LWORD,
    NUMERIC,
    PVOID,
    REAL,
    SINT,
    UDINT,
    ULINT,
    USINT,
    WORD,
    IntegerType,
    base_guid,
)
from achse.iec.errors import IecDecodeError, IecValueError
from achse.iec.types import IecType

INTEGERS = [type for type in NUMERIC if isinstance(type, IntegerType)]


@pytest.mark.parametrize(
    ("type", "value", "data"),
    [
        (BOOL, True, "01"),
        (SINT, -1, "ff"),
        (USINT, 255, "ff"),
        (INT, -2, "feff"),
        (WORD, 0x1234, "3412"),
        (DINT, -2, "feffffff"),
        (UDINT, 0x12345678, "78563412"),
        (LINT, -1, "ff" * 8),
        (REAL, 1.0, "0000803f"),
        (LREAL, -2.0, "00000000000000c0"),
    ],
    ids=lambda item: item.name if isinstance(item, IecType) else "",
)
def test_values_are_little_endian(type: IecType[object], value: object, data: str) -> None:
    assert type.encode(value).hex() == data
    assert type.decode(bytes.fromhex(data)) == value


@pytest.mark.parametrize("type", INTEGERS, ids=lambda type: type.name)
def test_integers_take_their_whole_range_and_no_more(type: IntegerType) -> None:
    for value in (type.low, 0, type.high):
        assert type.decode(type.encode(value)) == value
    wrong: list[object] = [type.low - 1, type.high + 1, 1.0, "1", None, 10**5000]
    for bad in wrong:
        with pytest.raises(IecValueError, match=rf"{type.name} takes an integer in {type.low}\.\."):
            type.encode(bad)


@given(st.floats(allow_nan=False))
def test_lreal_comes_back(value: float) -> None:
    assert LREAL.decode(LREAL.encode(value)) == value


@given(st.floats(width=32, allow_nan=False))
def test_real_comes_back(value: float) -> None:
    assert REAL.decode(REAL.encode(value)) == value


def test_real_refuses_what_it_cannot_hold() -> None:
    assert math.isnan(REAL.decode(REAL.encode(math.nan)))
    for value in (1e39, 10**400, "1.0", None):
        with pytest.raises(IecValueError, match="REAL takes a number"):
            REAL.encode(value)
    with pytest.raises(IecValueError, match="LREAL takes a number"):
        LREAL.encode(10**400)


def test_any_byte_but_0_is_true() -> None:
    assert [BOOL.decode(bytes([n])) for n in (0, 1, 2, 255)] == [False, True, True, True]
    assert [BOOL.encode(value) for value in (0, 1, False, True)] == [b"\0", b"\1"] * 2
    wrong: list[object] = [2, "TRUE", None, []]
    for value in wrong:
        with pytest.raises(IecValueError, match="BOOL takes True or False"):
            BOOL.encode(value)


@pytest.mark.parametrize("type", NUMERIC, ids=lambda type: type.name)
def test_too_few_bytes_are_refused(type: IecType[object]) -> None:
    with pytest.raises(IecDecodeError, match=rf"{type.name} has {type.size} byte"):
        type.decode(bytes(type.size - 1))


@pytest.mark.parametrize("type", NUMERIC, ids=lambda type: type.name)
def test_in_place_is_the_same_as_alone(type: IecType[object]) -> None:
    memory = bytearray(b"\xff" * 24)
    type.write(memory, 8, 1)
    assert memory[8 : 8 + type.size] == type.encode(1)
    assert memory[:8] == b"\xff" * 8
    assert memory[8 + type.size :] == b"\xff" * (16 - type.size)
    assert type.read(memory, 8) == 1
    assert type.read(memoryview(memory), 8) == 1


def test_what_the_tables_say_of_them() -> None:
    assert base_guid(0x30).hex() == "95190718000000000000000000000030"
    assert BOOL.guid == base_guid(0x30)
    assert (BOOL.adst, BYTE.adst, INT.adst, LREAL.adst, LWORD.adst) == (33, 17, 2, 5, 21)
    assert dict(INT.attributes) == {"DisplayMinValue": "#x8000", "DisplayMaxValue": "#x7fff"}
    assert dict(BOOL.attributes) == {"DisplayMinValue": "0", "DisplayMaxValue": "1"}
    assert dict(REAL.attributes) == {"DisplayMinValue": "-10000", "DisplayMaxValue": "10000"}
    assert dict(ULINT.attributes)["DisplayMaxValue"] == "#x" + "f" * 16
    assert BIT.is_bit
    assert not BOOL.is_bit
    assert PVOID.size == 8


def test_each_guid_is_its_own() -> None:
    assert len({type.guid for type in NUMERIC}) == len(NUMERIC)
