"""Emitted expressions compute what the typed form says, for random trees and values."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.iec.elementary import (
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
    WORD,
    IntegerType,
)  # fmt: skip
from achse.plc.runtime import PlcState
from achse.st.check import folding
from achse.st.check.folding import folded
from achse.st.typed.expressions import (
    Computed,
    Conversion,
    Converted,
    Known,
    Operator,
    Read,
    Stored,
    TypedValue,
)  # fmt: skip
from achse.st.typed.statements import Do

INTEGERS = [SINT, USINT, BYTE, INT, UINT, WORD, DINT, UDINT, DWORD, LINT, ULINT, LWORD]
WIDE = [DINT, UDINT, DWORD, LINT, ULINT, LWORD]
TWO = [
    Operator.ADD,
    Operator.SUB,
    Operator.MUL,
    Operator.AND,
    Operator.OR,
    Operator.XOR,
    Operator.DIV,
    Operator.MOD,
    Operator.MIN,
    Operator.MAX,
]
ONE = [Operator.NEG, Operator.NOT, Operator.ABS]
SHIFTS = [Operator.SHL, Operator.SHR, Operator.ROL, Operator.ROR]
TYPES: dict[str, Any] = {f"v{type.name}": type for type in INTEGERS}
_bench: Any = None


def numbers(type: IntegerType) -> st.SearchStrategy[int]:
    edges = [type.low, type.high, 0, 1, type.high // 2, type.low + 1]
    return st.one_of(st.sampled_from(edges), st.integers(type.low, type.high))


def trees(type: IntegerType, depth: int) -> st.SearchStrategy[Any]:
    """Trees of computations: ('var' | 'known' | operator …)."""
    leaf = st.one_of(
        st.just(("var", type)), numbers(type).map(lambda value: ("known", value, type))
    )
    if not depth:
        return leaf
    inner = trees(type, depth - 1)
    converted = st.sampled_from(INTEGERS).flatmap(
        lambda source: trees(source, depth - 1).map(lambda tree: ("to", tree, source, type))
    )
    two = st.tuples(st.sampled_from(TWO), inner, inner).map(lambda t: (*t, type))
    one = st.tuples(st.sampled_from(ONE), inner).map(lambda t: (*t, type))
    shift = st.tuples(st.sampled_from(SHIFTS), inner, trees(DINT, depth - 1)).map(
        lambda t: (*t, type)
    )
    return st.one_of(leaf, converted, two, one, shift)


def built(tree: Any, read: Callable[[str, Any], TypedValue]) -> TypedValue:
    """The tree as a typed value; variables as `read` gives them."""
    head = tree[0]
    if head == "var":
        return read(f"v{tree[1].name}", tree[1])
    if head == "known":
        return Known(tree[1], tree[2])
    if head == "to":
        _, inner, source, target = tree
        inner = built(inner, read)
        if source is target or source.code == target.code:
            return inner
        fits = target.low <= source.low and source.high <= target.high
        return Converted(inner, target, Conversion.EXTEND if fits else Conversion.CUT)
    operands = tuple(built(one, read) for one in tree[1:-1])
    return Computed(head, operands, tree[-1])


def folded_tree(value: TypedValue) -> Any:
    """The oracle: every node folded by the checker's constants."""
    if isinstance(value, Converted):
        return folded(Converted(folded_tree(value.operand), value.type, value.rule))
    if isinstance(value, Computed):
        operands = tuple(folded_tree(one) for one in value.operands)
        if any(not isinstance(one, Known) for one in operands):
            return None
        return folded(Computed(value.operator, operands, value.type))
    return value


@settings(max_examples=40)
@given(data=st.data())
def test_random_whole_numbers(bench: Callable[..., Any], data: st.DataObject) -> None:
    """Random trees of all operators, widths and signs store the bytes that the oracle says."""
    type = data.draw(st.sampled_from(WIDE))
    tree = data.draw(trees(type, 3))
    target = data.draw(st.sampled_from(INTEGERS))
    values = {f"v{each.name}": data.draw(numbers(each)) for each in INTEGERS}
    known = built(tree, lambda name, kind: Known(values[name], kind))
    expected = folded_tree(known)
    if not isinstance(expected, Known):
        return  # A division by 0 in it.
    if target.code != type.code:
        fits = target.low <= type.low and type.high <= target.high
        rule = Conversion.EXTEND if fits else Conversion.CUT
        expected = folded(Converted(expected, target, rule))
    place = bench({**TYPES, "result": target})
    value = built(tree, lambda name, kind: Read(place.storage(name), kind))
    if target.code != type.code:
        value = Converted(value, target, rule)
    data_in = {
        name: number.to_bytes(TYPES[name].size, "little", signed=TYPES[name].low < 0)
        for name, number in values.items()
    }
    place.run(Do(Stored(place.storage("result"), value, target)), **data_in)
    got = int.from_bytes(place.read("result"), "little", signed=target.low < 0)
    assert got == expected.value


def test_a_number_shifted_by_a_variable_is_no_constant(run: Callable[..., Any]) -> None:
    """As a count of another shift it was taken for 31: for what SHR gives at a count of 0."""
    ran = run(
        "PROGRAM MAIN VAR n : DINT := -1; a, b : DINT; END_VAR"
        " a := SHL(n, SHR(DINT#2147483647, n)); b := MAX(SHR(DINT#7, n), 3); END_PROGRAM"
    )
    assert (ran["a"], ran["b"]) == (-1, 3)


REALS = [Operator.ADD, Operator.SUB, Operator.MUL, Operator.MIN, Operator.MAX]


def real_trees(depth: int) -> st.SearchStrategy[Any]:
    """Trees of real computations of either width, with conversions between them."""
    floats = st.floats(-1e6, 1e6, width=32)
    leaf = st.one_of(
        st.just(("var", "r")), st.just(("var", "d")), floats.map(lambda value: ("known", value))
    )
    if not depth:
        return leaf
    inner = real_trees(depth - 1)
    two = st.tuples(st.sampled_from(REALS), inner, inner, st.sampled_from([REAL, LREAL]))
    return st.one_of(leaf, two)


def real_built(tree: Any, type: Any, read: Callable[[str], TypedValue]) -> TypedValue:
    if tree[0] == "known":
        return Known(folding.real(tree[1], type), type)
    if tree[0] == "var":
        value = read(tree[1])
    else:
        operands = tuple(real_built(one, tree[3], read) for one in tree[1:3])
        value = Computed(tree[0], operands, tree[3])
    return value if value.type is type else folded(Converted(value, type, Conversion.RESIZE_REAL))


@settings(max_examples=38)
@given(
    tree=real_trees(4),
    r=st.floats(-1e6, 1e6, width=32),
    d=st.floats(-1e6, 1e6),
    target=st.sampled_from([REAL, LREAL]),
)
def test_random_reals(
    bench: Callable[..., Any], tree: Any, r: float, d: float, target: Any
) -> None:
    """REAL is rounded once per operation, LREAL never: the same bits as the oracle."""
    values = {"r": (r, REAL), "d": (d, LREAL)}
    expected = folded_tree(real_built(tree, target, lambda name: Known(*values[name])))
    assert isinstance(expected, Known)
    place = bench({"r": REAL, "d": LREAL, "result": target})
    value = real_built(tree, target, lambda name: Read(place.storage(name), values[name][1]))
    data = {name: type.codec.pack(number) for name, (number, type) in values.items()}
    place.run(Do(Stored(place.storage("result"), value, target)), **data)
    assert place.read("result") == target.codec.pack(expected.value)


Run = Callable[..., Any]

CHOICES = """TYPE T : STRUCT a : INT; b : LREAL; END_STRUCT END_TYPE
FUNCTION F : INT VAR_INPUT n : INT; END_VAR
MAIN.calls := MAIN.calls + 1; F := n; END_FUNCTION
FUNCTION G : STRING VAR_INPUT n : INT; END_VAR
MAIN.calls := MAIN.calls + 1; G := INT_TO_STRING(n); END_FUNCTION
FUNCTION H : T VAR_INPUT n : INT; END_VAR
MAIN.calls := MAIN.calls + 1; H.a := n; END_FUNCTION
PROGRAM MAIN
VAR
    calls, n, i, j : INT; k : DINT; b : BOOL; p : POINTER TO INT; x : REAL; s : STRING; t : T;
    list : ARRAY [0..2] OF INT := [5, 6, 7]; l : LREAL; w : WORD;
END_VAR
"""


@pytest.mark.parametrize(
    ("body", "name", "value", "calls"),
    [
        # A pointer that leads nowhere, an index outside, a division by nothing.
        ("n := SEL(p <> 0, -1, p^);", "n", -1, 0),
        ("p := ADR(list[1]); n := SEL(p <> 0, -1, p^);", "n", 6, 0),
        ("i := 9; n := SEL(i > 2, list[i], -2);", "n", -2, 0),
        ("n := SEL(i = 0, 10 / i, 77);", "n", 77, 0),
        ("i := 4; n := MUX(1, p^, 8 / i, list[i]);", "n", 2, 0),
        ("i := 4; n := MUX(9, p^, list[i], F(3));", "n", 3, 1),
        ("k := -1; n := MUX(k, p^, F(2), F(3));", "n", 3, 1),
        # Calls that change something.
        ("n := SEL(b, F(1), F(2));", "n", 1, 1),
        ("b := TRUE; n := SEL(b, F(1), F(2)) + SEL(NOT b, F(3), 4);", "n", 5, 2),
        ("i := 1; n := MUX(F(i), F(1), F(20), F(30), F(40));", "n", 20, 2),
        ("n := SEL(b, SEL(NOT b, F(1), F(2)), F(3));", "n", 2, 1),
        # Texts, records, reals, truths.
        ("s := SEL(b, G(1), G(2));", "s", "1", 1),
        ("b := TRUE; s := CONCAT(SEL(b, G(1), CONCAT(G(2), s)), 'x');", "s", "2x", 1),
        ("i := 2; s := MUX(i, G(1), G(2), G(3), s);", "s", "3", 1),
        ("t := SEL(b, H(1), H(2)); n := t.a;", "n", 1, 1),
        ("b := TRUE; t.a := 6; t := SEL(b, H(1), t); n := t.a;", "n", 6, 0),
        ("x := SEL(b, F(2) / 2.0, 1.0 / F(0));", "x", 1.0, 1),
        ("l := SEL(TRUE, LREAL#1.5, F(2)); n := LREAL_TO_INT(l * 2);", "n", 4, 1),
        ("b := SEL(n = 0, F(1) = 2, F(1) = 1);", "b", True, 1),
        ("w := SEL(b, INT_TO_WORD(F(-1)), 7);", "w", 65535, 1),
        # The end of a FOR goes on as it did.
        ("j := -1; FOR i := 3 TO F(1) BY j DO n := n + 1; END_FOR", "n", 3, 4),
    ],
)
def test_only_the_chosen_value(run: Run, body: str, name: str, value: object, calls: int) -> None:
    ran = run(f"{CHOICES}{body} END_PROGRAM")
    assert ran.plc.state is PlcState.RUN, ran.plc.failure
    assert (ran[name], ran["calls"]) == (value, calls)


def test_what_is_chosen_fails_as_ever(run: Run) -> None:
    ran = run(f"{CHOICES}n := SEL(p = 0, -1, p^); END_PROGRAM")
    assert ran.plc.state is PlcState.EXCEPTION
