"""What all types have in common."""

import tracemalloc
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec import BOOL, INT, LREAL, AliasType, ArrayType, IecType, StructType, Variable
from achse.iec.arrays import Bounds
from achse.iec.derived import SubrangeType
from achse.iec.errors import IecValueError
from achse.iec.strings import StringType
from achse.iec.structs import RecordKind
from achse.iec.types import Adst, derived_guid

LEAVES: list[IecType[Any]] = [INT, LREAL, BOOL, StringType(5), SubrangeType(INT, 3, 9)]


def test_derived_guids_are_stable_and_distinct() -> None:
    assert derived_guid("ST_A 8").hex() == "f01522690b44171a62df203852375c4e"
    assert derived_guid("ST_A 8") != derived_guid("ST_A 16")
    assert len(derived_guid("")) == 16


def test_rejecting_names_type_expectation_and_value() -> None:
    error = INT.reject(1.5)
    assert isinstance(error, IecValueError)
    assert str(error) == "INT takes an integer in -32768..32767, got 1.5"


def test_a_type_shows_its_name() -> None:
    assert repr(IecType("T_Any", 4, 4, Adst.BIGTYPE)) == "<IecType T_Any>"
    assert IecType("T_Any", 4, 4, Adst.BIGTYPE).default == bytes(4)


# default images ---------------------------------------------------------------------------------


def arrays(element: IecType[Any]) -> st.SearchStrategy[IecType[Any]]:
    return st.integers(1, 9).map(lambda last: ArrayType(element, [Bounds(1, last)]))


@st.composite
def structures(draw: Any, parts: st.SearchStrategy[IecType[Any]]) -> IecType[Any]:
    members: dict[str, Variable[Any, Any]] = {}
    for number, type in enumerate(draw(st.lists(parts, min_size=1, max_size=4))):
        initial = 5 if type is INT and draw(st.booleans()) else None
        members[f"m{number}"] = Variable(type, initial)
    kind = draw(st.sampled_from([RecordKind.STRUCT, RecordKind.UNION]))
    return StructType[Any]("ST", members, kind=kind)


TYPES = st.recursive(
    st.sampled_from(LEAVES),
    lambda parts: st.one_of(
        parts.flatmap(arrays), structures(parts), parts.map(lambda base: AliasType("A", base))
    ),
    max_leaves=8,
)


@given(TYPES, st.integers(0, 7), st.sampled_from([8, 16, 64, 1 << 16]))
def test_a_default_is_written_in_place_as_it_is_as_a_whole(
    type: IecType[Any], offset: int, chunk: int
) -> None:
    with pytest.MonkeyPatch.context() as patch:
        for module in ("types", "arrays", "structs", "derived"):
            patch.setattr(f"achse.iec.{module}.CHUNK", chunk)
        patch.setattr("achse.iec.types._ZEROS", bytes(chunk))
        is_zero = type.starts_at_zero
        buffer = bytearray(b"\xff" * (offset + type.size + 3))
        type.put_default(buffer, offset)
    assert buffer == b"\xff" * offset + type.default + b"\xff" * 3
    assert not (is_zero and any(type.default))


@pytest.mark.parametrize("initial", [None, 7])
def test_a_large_default_has_no_copy_in_memory(initial: int | None) -> None:
    part = StructType[Any]("ST_Part", {"n": Variable(INT, initial), "a": Variable(LREAL)})
    whole = StructType[Any]("ST", {"p": Variable(ArrayType(part, [Bounds(1, 100_000)]))})
    outer = StructType[Any]("ST_Outer", {"w": Variable(whole), "n": Variable(INT, 3)})
    buffer = bytearray(outer.size)
    tracemalloc.start()
    try:
        outer.put_default(buffer, 0)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < outer.size // 4
    assert buffer[outer.size - 8 : outer.size - 6] == b"\x03\0"


def test_an_initial_value_of_a_type_is_its_default() -> None:
    type = ArrayType(INT, [Bounds(0, 3)])
    type.default = bytes(range(8))
    alias = AliasType("A", type)
    for each in (type, alias):
        buffer = bytearray(8)
        each.put_default(buffer, 0)
        assert buffer == bytes(range(8))
        assert not each.starts_at_zero
