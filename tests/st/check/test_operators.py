"""Operators: widths, signs and results as recorded of real controllers (execution facts, §2)."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.st.check import check
from achse.st.check.folding import folded
from achse.st.declare import declare
from achse.st.syntax.parser import parse
from achse.st.typed.expressions import Computed, Converted, Known, Read, Stored, TypedValue
from achse.st.typed.statements import Do

Lines = Callable[..., list[str]]

ROWS = [
    # integers compute in DINT, or in the wider type; signed if either is
    ("n : INT;", "n := n + 1;", "n := CUT.INT(ADD.DINT(EXTEND.DINT(n), 1));"),
    ("d : DINT; l : LINT;", "l := d + 1;", "l := EXTEND.LINT(ADD.DINT(d, 1));"),
    ("d : DINT; l : LINT;", "l := d + l;", "l := ADD.LINT(EXTEND.LINT(d), l);"),
    ("w : WORD; d : DWORD;", "d := w + 1;", "d := CUT.DWORD(ADD.DINT(EXTEND.DINT(w), 1));"),
    ("u : UDINT; d : UDINT;", "d := u + 1;", "d := ADD.UDINT(u, 1);"),
    ("u : UDINT; s : USINT;", "u := u + s;", "u := ADD.UDINT(u, EXTEND.UDINT(s));"),
    ("b : BOOL; u : UDINT; d : DINT;", "b := u > d;", "b := GT.BOOL(CUT.DINT(u), d);"),
    ("b : BOOL; w : WORD;", "b := (w - 1) = 65535;",
     "b := EQ.BOOL(SUB.DINT(EXTEND.DINT(w), 1), 65535);"),
    ("b : BOOL; w : WORD;", "b := TO_WORD(w - 1) = 65535;",
     "b := EQ.BOOL(EXTEND.DINT(CUT.WORD(SUB.DINT(EXTEND.DINT(w), 1))), 65535);"),
    # constants alone are folded at full width
    ("l : LINT;", "l := 2000000000 + 2000000000;", "l := 4000000000;"),
    ("b : BOOL;", "b := TO_WORD(65535 + 1) = 0;", "b := True;"),
    ("r : REAL;", "r := 7 / 2;", "r := 3.0;"),
    ("r : REAL;", "r := 7 / 2.0;", "r := 3.5;"),
    ("n : INT;", "n := -7 / 2 * 100 + (-7 MOD 2);", "n := -301;"),
    ("n : INT;", "n := 7 MOD 0;", "n := 0;"),
    ("n : INT;", "n := 7 / 0;", "fault: a division by zero"),
    # a constant takes the type of what it meets, if that holds it
    ("u : ULINT;", "u := u - 1;", "u := SUB.ULINT(u, 1);"),
    ("b : BOOL; d : DINT;", "b := d < 3000000000;", "b := LT.BOOL(EXTEND.LINT(d), 3000000000);"),
    ("b : BOOL; d : DINT;", "b := d = 16#FFFFFFFF;", "b := EQ.BOOL(d, -1);"),
    # bits
    ("d : DINT; s : SINT;", "d := s AND 255;", "d := AND.DINT(EXTEND.DINT(s), 255);"),
    ("a, b : BOOL;", "a := a AND b OR NOT a XOR b;",
     "a := OR.BOOL(AND.BOOL(a, b), XOR.BOOL(NOT.BOOL(a), b));"),
    ("d : DINT; u : USINT;", "d := NOT u;", "d := EXTEND.DINT(NOT.USINT(u));"),
    ("n : INT;", "n := NOT n;", "n := CUT.INT(NOT.UINT(CUT.UINT(n)));"),
    ("d : DINT;", "d := NOT INT#-5;", "d := 4;"),
    ("w : WORD;", "w := NOT 0;", "w := 65535;"),
    ("a : BOOL; n : INT;", "a := a AND n;", "fault: a BOOL and a INT do not go together"),
    ("a : REAL;", "a := a AND 1;", "fault: AND takes BOOL or bits, got a REAL"),
    ("w : DWORD; b, e : BOOL;", "b := w.8 OR_ELSE w.1 OR_ELSE (e := TRUE);",
     "b := OR_ELSE(OR_ELSE(w.8, w.1), e := True);"),
    ("a, b : BOOL;", "b := a AND_THEN b;", "b := AND_THEN(a, b);"),
    ("a : BOOL; n : INT;", "a := a AND_THEN n;", "fault: expected a BOOL, got a INT"),
    # negation
    ("n : INT;", "n := -n;", "n := CUT.INT(NEG.DINT(EXTEND.DINT(n)));"),
    ("u : UDINT; d : DINT;", "d := -u;", "d := NEG.DINT(CUT.DINT(u));"),
    ("b : BOOL;", "b := -b;", "fault: - takes a number, got a BOOL"),
    # reals: an untyped literal is LREAL, and goes into a REAL without a word
    ("r : REAL;", "r := r * r;", "r := MUL.REAL(r, r);"),
    ("r : REAL;", "r := r * 1.5;", "r := RESIZE_REAL.REAL(MUL.LREAL(RESIZE_REAL.LREAL(r), 1.5));"),
    ("r : REAL; n : INT;", "r := r + n;", "r := ADD.REAL(r, TO_REAL.REAL(n));"),
    ("r : REAL;", "r := r MOD 2;", "fault: MOD takes whole numbers"),
    ("l : LREAL; n : INT;", "l := n ** 2;", "l := EXPT.LREAL(TO_REAL.LREAL(n), 2.0);"),
    # times
    ("t : TIME;", "t := T#500ms - T#1s;", "t := 4294966796;"),
    ("t : TIME; n : INT;", "t := t * n;", "t := MUL.TIME(t, CUT.TIME(n));"),
    ("t : TIME;", "t := t * 1.5;", "t := ROUND.TIME(MUL.LREAL(TO_REAL.LREAL(t), 1.5));"),
    ("t : TIME; n : INT;", "t := n / t;", "fault: '/' does not take a INT and a TIME"),
    ("t : TIME; l : LTIME;", "l := l + t;", "l := ADD.LTIME(l, RESCALE.LTIME(t));"),
    ("a, b : DT; t : TIME;", "t := a - b;", "t := RESCALE.TIME(SUB.DATE_AND_TIME(a, b));"),
    ("a : DT; t : TIME;", "a := a + t;", "a := ADD.DATE_AND_TIME(a, RESCALE.DATE_AND_TIME(t));"),
    ("a : DT;", "a := a - T#1500ms;", "a := SUB.DATE_AND_TIME(a, 1);"),
    ("a, b : DT;", "a := a + b;", "fault: '+' does not take two dates"),
    ("t : TIME; b : BOOL;", "b := t > T#1s;", "b := GT.BOOL(t, 1000);"),
    ("t : TIME; n : UDINT;", "n := t / T#1s;", "n := DIV.TIME(t, 1000);"),
    # pointers count bytes
    ("p : POINTER TO INT;", "p := p + 2;", "p := ADD.POINTER TO INT(p, 2);"),
    ("p, q : POINTER TO INT; n : ULINT;", "n := p - q;", "n := SUB.ULINT(p, q);"),
    ("p : POINTER TO INT; b : BOOL;", "b := p = 0;", "b := EQ.BOOL(p, 0);"),
    # comparisons
    ("s : STRING; b : BOOL;", "b := s = 'abc';", "b := EQ.BOOL(s, b'abc');"),
    ("s : STRING; b : BOOL;", "b := s = 1;", "fault: a STRING(80) and a USINT do not go together"),
    ("a, c : ARRAY [0..1] OF INT; b : BOOL;", "b := a = c;",
     "fault: a ARRAY [0..1] OF INT cannot be compared; compare its parts"),
]  # fmt: skip


@pytest.mark.parametrize(("variables", "statement", "expected"), ROWS)
def test_operators(lines: Lines, variables: str, statement: str, expected: str) -> None:
    assert lines(variables, statement) == [expected]


def test_a_strict_enumeration_is_not_computed_with(lines: Lines) -> None:
    strict = "{attribute 'strict'} TYPE E : (A, B); END_TYPE"
    assert lines("e : E;", "e := TO_INT(E.B);", strict) == ["e := 1;"]
    assert lines("e : E;", "e := TO_INT(E.B) + 1;", strict) == [
        "fault: E is strict: it takes its values only"
    ]
    assert lines("e : E; n : INT;", "n := e + 1;", strict) == [
        "fault: E is strict: nothing is computed with it"
    ]


def test_long_sums_are_walked(lines: Lines) -> None:
    (line,) = lines("n : DINT;", f"n := {' + '.join(['n'] * 900)};")
    assert line.count(", ") == 899
    (line,) = lines("n : DINT;", f"n := {' - '.join(['n'] * 900)};")
    assert line.startswith("n := ADD.DINT(n, NEG.DINT(n), NEG.DINT(n), ")


# any expression of integers, against the rules in words -----------------------------------------

WIDTHS = {
    "SINT": (8, True), "USINT": (8, False), "BYTE": (8, False), "INT": (16, True),
    "UINT": (16, False), "WORD": (16, False), "DINT": (32, True), "UDINT": (32, False),
    "DWORD": (32, False), "LINT": (64, True), "ULINT": (64, False), "LWORD": (64, False),
}  # fmt: skip
"""Bits and sign of the types; variable `v_int` is an INT."""

Shape = tuple[int, bool]
Tree = Any


def bits(value: int, shape: Shape) -> int:
    width, signed = shape
    value &= (1 << width) - 1
    return value - (1 << width) if signed and value >> (width - 1) else value


def meet(left: Shape, right: Shape) -> Shape:
    if left[0] < 32 and right[0] < 32:
        return 32, True
    return max(left[0], right[0]), left[1] or right[1]


def expected(tree: Tree, values: dict[str, int]) -> tuple[int, Shape]:
    """What the execution facts say: §2, rows on widths, signs, division, MOD, NOT."""
    if isinstance(tree, str):
        return values[tree], WIDTHS[tree]
    if len(tree) == 2:
        value, shape = expected(tree[1], values)
        if tree[0] == "NOT":
            unsigned = (shape[0], False)
            return bits(~value, unsigned), unsigned
        wide = (max(shape[0], 32), True)
        return bits(-bits(value, wide), wide), wide
    sign, left_tree, right_tree = tree
    (left, a), (right, b) = expected(left_tree, values), expected(right_tree, values)
    shape = meet(a, b)
    left, right = bits(left, shape), bits(right, shape)
    if sign in ("=", "<"):
        return int(left == right if sign == "=" else left < right), (0, False)
    if sign == "MOD":
        result = 0 if right == 0 else left - right * int_quotient(left, right)
    else:
        result = {
            "+": left + right, "-": left - right, "*": left * right,
            "AND": left & right, "OR": left | right, "XOR": left ^ right,
        }[sign]  # fmt: skip
    return bits(result, shape), shape


def int_quotient(left: int, right: int) -> int:
    magnitude = abs(left) // abs(right)
    return magnitude if (left < 0) == (right < 0) else -magnitude


def written(tree: Tree) -> str:
    if isinstance(tree, str):
        return f"v_{tree}"
    if len(tree) == 2:
        return f"{tree[0]} ({written(tree[1])})"
    return f"({written(tree[1])} {tree[0]} {written(tree[2])})"


def computed(value: TypedValue, values: dict[str, int]) -> int:
    """The typed form, run: what folding makes of it when its variables are constants."""
    match value:
        case Read(storage, type):
            return values[storage.name.removeprefix("v_")]
        case Converted(operand, type, rule):
            known = Known(computed(operand, values), operand.type or type)
            return number(folded(Converted(known, type, rule)))
        case Computed(operator, operands, type):
            first, *rest = (Known(computed(one, values), one.type or type) for one in operands)
            result: TypedValue = first
            if not rest:
                result = folded(Computed(operator, (first,), type))
            for one in rest:
                result = folded(Computed(operator, (result, one), type))
            return number(result)
    raise AssertionError(value)


def number(value: TypedValue) -> int:
    assert isinstance(value, Known)
    assert isinstance(value.value, int)
    return int(value.value)


NUMBERS = st.recursive(
    st.sampled_from(sorted(WIDTHS)),
    lambda inner: st.one_of(
        st.tuples(st.sampled_from(["+", "-", "*", "MOD", "AND", "OR", "XOR"]), inner, inner),
        st.tuples(st.sampled_from(["NOT", "-"]), inner),
    ),
    max_leaves=8,
)


@settings(max_examples=38, deadline=None)
@given(st.data())
def test_any_expression_of_integers(data: st.DataObject) -> None:
    tree = data.draw(NUMBERS)
    if data.draw(st.booleans()):
        tree = (data.draw(st.sampled_from(["=", "<"])), tree, data.draw(NUMBERS))
    values = {
        name: bits(data.draw(st.integers(-(1 << 63), (1 << 64) - 1)), shape)
        for name, shape in WIDTHS.items()
    }
    declared = "; ".join(f"v_{name} : {name}" for name in WIDTHS)
    is_truth = isinstance(tree, tuple) and tree[0] in ("=", "<")
    result = f"r : {'BOOL' if is_truth else 'LINT'}"
    source = f"PROGRAM MAIN VAR {declared}; {result}; END_VAR r := {written(tree)}; END_PROGRAM"
    (statement,) = check(declare([parse(source).check()])).routines["main"].body or ()
    assert isinstance(statement, Do)
    assert isinstance(statement.value, Stored)
    outcome = computed(statement.value.value, values)
    value, _ = expected(tree, values)
    assert outcome == (value if is_truth else bits(value, (64, True)))
