"""Instructions as text."""

import math
from typing import Any, cast

import pytest

from achse.native.declare import Layout
from achse.native.instructions import Instructions, TranslationError, Unit, real_constant
from achse.native.kinds import BOOL, INT, REAL, Record, Several, Value


def nothing() -> None:
    """Stands for the function that is translated."""


@pytest.fixture
def writer() -> Instructions:
    return Instructions(cast(Unit, None), cast(Any, nothing))


def test_numbers_are_written_bit_by_bit() -> None:
    assert real_constant(1.0) == "0x3FF0000000000000"
    assert real_constant(-0.0) == "0x8000000000000000"
    assert real_constant(math.inf) == "0x7FF0000000000000"


def test_what_is_stored_lies_in_a_slot_per_operand(writer: Instructions) -> None:
    pair = Several((INT, REAL))
    slot = writer.slot(pair)
    writer.store(Value(pair, ("1", "%x")), slot)
    assert writer.slots == ["  %s1 = alloca i64", "  %s2 = alloca double"]
    assert writer.lines == ["  store i64 1, ptr %s1", "  store double %x, ptr %s2"]


def test_a_value_becomes_a_wider_one(writer: Instructions) -> None:
    several = writer.several([Value(BOOL, ("true",)), Value(INT, ("7",))])
    wide = writer.convert(several, Several((INT, REAL)), cast(Any, None))
    assert wide.kind == Several((INT, REAL))
    assert [line.split(" = ")[1] for line in writer.lines] == [
        "zext i1 true to i64",
        "sitofp i64 7 to double",
    ]


def test_a_value_does_not_become_another(writer: Instructions) -> None:
    record = Value(Record(Layout("wheel", {}, 1)), ("%r",))
    for value, kind in ((record, INT), (Value(REAL, ("%x",)), INT), (Value(INT, ("1",)), BOOL)):
        with pytest.raises(TranslationError, match=r"test_instructions\.py:\d+: nothing: .* where"):
            writer.convert(value, kind, cast(Any, None))
