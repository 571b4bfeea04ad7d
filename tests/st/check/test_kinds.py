"""The type that two integers meet at, and types whose bytes mean the same."""

from enum import IntEnum
from typing import Any

import pytest

from achse.iec.arrays import ArrayType, Bounds
from achse.iec.derived import PointerType
from achse.iec.elementary import (
    BOOL,
    BYTE,
    DINT,
    DWORD,
    INT,
    LINT,
    LREAL,
    LWORD,
    REAL,
    SINT,
    UDINT,
    UINT,
    ULINT,
    USINT,
    IntegerType,
)
from achse.iec.enums import EnumType
from achse.iec.strings import StringType, WStringType
from achse.iec.structs import RecordKind, StructType
from achse.iec.types import IecType
from achse.iec.variables import Variable
from achse.st.check.kinds import (
    common_integer,
    common_real,
    known_from,
    natural,
    promoted,
    same_shape,
)


@pytest.mark.parametrize(
    ("left", "right", "expected"),
    [
        (SINT, USINT, DINT),
        (BYTE, BYTE, DINT),
        (INT, DINT, DINT),
        (UINT, UDINT, UDINT),
        (INT, UDINT, DINT),
        (DWORD, DWORD, DWORD),
        (UDINT, ULINT, ULINT),
        (DINT, ULINT, LINT),
        (LWORD, SINT, LINT),
    ],
)
def test_integers_meet(left: IntegerType, right: IntegerType, expected: IntegerType) -> None:
    assert common_integer(left, right) is expected
    assert common_integer(right, left) is expected


def test_one_operand_is_dint_at_least() -> None:
    assert [promoted(type) for type in (BYTE, INT, UDINT, LINT)] == [DINT, DINT, UDINT, LINT]


def test_reals_meet_at_the_wider() -> None:
    assert common_real(REAL, REAL) is REAL
    assert common_real(REAL, LREAL) is LREAL


@pytest.mark.parametrize(
    ("value", "type"),
    [(0, USINT), (255, USINT), (256, UINT), (-1, SINT), (-129, INT), (1 << 40, ULINT)],
)
def test_a_number_has_the_smallest_type_that_holds_it(value: int, type: IntegerType) -> None:
    assert natural(value) is type


def test_shapes() -> None:
    base: StructType[Any] = StructType("FB_A", [], kind=RecordKind.FUNCTION_BLOCK)
    derived: StructType[Any] = StructType(
        "FB_B", [Variable(INT, name="n")], kind=RecordKind.FUNCTION_BLOCK, base=base
    )
    rows: list[tuple[IecType[Any], IecType[Any], bool]] = [
        (derived, base, True),
        (base, derived, False),
        (ArrayType(INT, [Bounds(0, 1)]), ArrayType(INT, [Bounds(5, 6)]), True),
        (ArrayType(INT, [Bounds(0, 1)]), ArrayType(UINT, [Bounds(0, 1)]), False),
        (PointerType(INT), PointerType(LREAL), True),
    ]
    assert [same_shape(left, right) for left, right, _ in rows] == [row[2] for row in rows]


def test_bytes_in_memory_are_constants() -> None:
    rows: list[tuple[IecType[Any], bytes, object]] = [
        (BOOL, b"\1", True),
        (INT, b"\xfe\xff", -2),
        (LREAL, bytes(8), 0.0),
        (StringType(3), b"ab\0z", b"ab"),
        (WStringType(2), b"a\0\0\0z\0", b"a\0"),
        (PointerType(INT), b"\5" + bytes(7), 5),
    ]
    for type, image, value in rows:
        assert known_from(image, type).value == value


def test_a_type_of_a_library_by_its_source_and_by_a_symbol_file() -> None:
    def read(space: str, second: str = "b", values: int = 2) -> StructType[Any]:
        members = IntEnum("E_Mode", [f"V{number}" for number in range(values)])  # type: ignore[misc]
        mode: EnumType[Any] = EnumType(members, name=f"{space}E_Mode")
        return StructType(f"{space}ST_A", [Variable(INT, name="a"), Variable(mode, name=second)])

    source, symbols = read(""), read("Lib.")
    assert same_shape(source, symbols)
    assert same_shape(symbols, source)
    assert not same_shape(source, read("Lib.", "c"))
    assert not same_shape(source, read("Lib.", values=3))
    assert not same_shape(source, StructType("Lib.ST_B", []))
