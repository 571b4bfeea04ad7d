"""Places: what is known before the program runs, and what is checked when it does."""

from collections.abc import Callable
from typing import Any

from achse.iec.declare import ARRAY
from achse.iec.elementary import INT
from achse.iec.strings import StringType
from achse.plc.lowering.nodes import (
    Effects,
    Home,
    Keep,
    LoadValue,
    LoweredRoutine,
    ResolvedPlace,
    Sequence,
    StoreValue,
    Temporary,
)
from achse.plc.lowering.places import is_number
from achse.plc.memory import Area
from achse.st.typed.expressions import Known

Lower = Callable[..., LoweredRoutine]

TEXT = """
TYPE T : STRUCT a, b : INT; x : ARRAY [1..4] OF INT; END_STRUCT END_TYPE
FUNCTION F : DINT
VAR_INPUT n : DINT; s : STRING(2000); END_VAR
VAR_IN_OUT l : ARRAY [*] OF DINT; END_VAR
F := l[n];
END_FUNCTION
PROGRAM MAIN
VAR
    t : T; u : USINT; i : INT; w : WORD; p : POINTER TO INT; b AT %QX1.3 : BOOL;
    bytes : ARRAY [0..255] OF INT; big : ARRAY [0..999] OF DINT; other : ARRAY [0..999] OF DINT;
    list : ARRAY [5..9] OF DINT; s : STRING(2000);
END_VAR
t.x[3] := 7;
t.x[i] := 8;
bytes[u] := 9;
p^ := 1;
p[i] := 2;
b := w.9;
big := other;
i := TO_INT(F(i, s, list));
END_PROGRAM
"""


def _stores(routine: LoweredRoutine) -> list[StoreValue]:
    values = [one.values[0] for one in routine.body if isinstance(one, Effects)]
    return [value for value in values if isinstance(value, StoreValue)]


def test_constant_index_is_part_of_the_offset(lower: Lower) -> None:
    constant, checked, unchecked, *_ = [one.place for one in _stores(lower(TEXT))]
    assert constant.terms == ()
    (term,) = checked.terms
    assert (term.low, term.high, term.stride) == (_known(1, term), _known(4, term), 2)
    assert constant.offset == checked.offset + 3 * term.stride
    (term,) = unchecked.terms
    assert term.low is None
    assert term.high is None


def _known(value: int, term: Any) -> Known:
    return Known(value, term.low.type)


def test_pointer_and_bit_have_their_place(lower: Lower) -> None:
    stores = _stores(lower(TEXT))
    target, element, bit = (one.place for one in stores[3:6])
    assert (target.home, target.offset, target.is_bounded) == (Home.ADDRESS, 0, True)
    assert (element.home, element.offset, element.is_bounded) == (Home.ADDRESS, 0, False)
    assert [(term.stride, term.low) for term in element.terms] == [(2, None)]
    assert (bit.area, bit.offset, bit.bit) == (Area.OUTPUT, 1, 3)
    read = stores[5].value
    assert isinstance(read, LoadValue)
    assert read.place.bit == 1


def test_number_in_an_area_is_evaluated_before_its_index(lower: Lower) -> None:
    stores = _stores(lower(TEXT))
    assert [one.value_first for one in stores[:7]] == [True, True, True, False, False, False, False]


def test_large_value_takes_from_the_budget(lower: Lower) -> None:
    large = _stores(lower(TEXT))[6].value
    assert isinstance(large, LoadValue)
    assert large.spends
    (small, *_) = [one.value for one in _stores(lower(TEXT, "f"))]
    assert isinstance(small, LoadValue)
    assert not small.spends


def test_open_array_keeps_its_lower_bound(lower: Lower) -> None:
    (store,) = _stores(lower(TEXT, "f"))
    assert isinstance(store.value, LoadValue)
    index, first = store.value.place.terms
    assert isinstance(index.low, Keep)
    assert index.low.is_repeatable
    assert first.index == index.low.temporary
    assert first.stride == -index.stride


def test_hidden_variable_is_stored_before_it_is_read(lower: Lower) -> None:
    text = """
FUNCTION G : ARRAY [0..3] OF INT
G[1] := 5;
END_FUNCTION
PROGRAM MAIN VAR n, i : INT; END_VAR
n := G()[i];
END_PROGRAM"""
    (store,) = _stores(lower(text))
    assert isinstance(store.value, Sequence)
    (hidden,) = store.value.effects
    assert isinstance(hidden, StoreValue)
    assert hidden.place.home is Home.FRAME
    read = store.value.value
    assert isinstance(read, LoadValue)
    assert isinstance(read.place, ResolvedPlace)
    assert read.place.home is Home.FRAME


def test_parameter_in_a_register_begins_as_it_is_passed(lower: Lower) -> None:
    routine = lower(TEXT, "f")
    passed = {one.name: temporary for one, temporary in routine.parameters}
    starts = {one.place.variable.name: one.value for one in routine.start if one.place.variable}
    assert starts["n"] == passed["n"]
    assert isinstance(starts["n"], Temporary)
    assert [one.value for one in routine.entry] == [passed["s"]]


def test_texts_and_structures_are_no_numbers() -> None:
    assert is_number(INT)
    assert not is_number(StringType(5))
    assert not is_number(ARRAY(INT, (0, 3)))
