"""Conversions that the source does not write: what each one is, and what is said of it."""

from collections.abc import Callable

import pytest

from achse.iec.elementary import BOOL, BYTE, DINT, INT, REAL, USINT
from achse.iec.strings import STRING, WSTRING
from achse.iec.times import DT, LTIME, TIME
from achse.iec.types import IecType
from achse.st.check.conversions import converted
from achse.st.typed.expressions import Converted, Read
from achse.st.typed.places import FrameBase, Storage

Lines = Callable[..., list[str]]

ROWS: list[tuple[str, str, list[str]]] = [
    ("n : INT;", "n := 40000;",
     ["n := -25536;", "warning: 40000 does not fit into a INT: it is cut"]),
    ("n : INT;", "n := 16#FFFF;", ["n := -1;"]),
    ("b : BOOL;", "b := 1;", ["b := True;"]),
    ("b : BOOL;", "b := 2;", ["fault: a USINT does not go into a BOOL"]),
    ("b : BOOL; n : INT;", "b := n;", ["fault: a INT does not go into a BOOL"]),
    ("b : BOOL; n : INT;", "n := b;", ["fault: a BOOL does not go into a INT"]),
    ("n : INT; s : STRING;", "s := n;", ["fault: a INT does not go into a STRING(80)"]),
    ("s : STRING; w : WSTRING;", "s := w;", ["fault: a WSTRING(80) does not go into a STRING(80)"]),
    ("s : STRING(3);", "s := 'abcdef';", ["s := b'abc';"]),
    ("s : STRING(3); t : STRING;", "s := t;", ["s := CUT_TEXT.STRING(3)(t);"]),
    ("w : WSTRING(2);", 'w := "abc";', [r"w := b'a\x00b\x00';"]),
    ("n : INT; d : DINT;", "n := d;",
     ["n := CUT.INT(d);", "warning: a DINT is cut to go into a INT"]),
    ("n : INT; d : DINT;", "d := n;", ["d := EXTEND.DINT(n);"]),
    ("u : UINT; n : INT;", "u := n;",
     ["u := CUT.UINT(n);", "warning: a INT may change its sign as a UINT"]),
    ("u : UDINT; n : INT;", "u := n;",
     ["u := CUT.UDINT(n);", "warning: a INT may change its sign as a UDINT"]),
    ("n : INT;", "n := n + 1;", ["n := CUT.INT(ADD.DINT(EXTEND.DINT(n), 1));"]),
    ("n : INT; r : REAL;", "n := r;",
     ["n := ROUND.INT(r);", "warning: a REAL is rounded to go into a INT"]),
    ("r : REAL; l : LREAL;", "r := l;",
     ["r := RESIZE_REAL.REAL(l);", "warning: an LREAL loses digits as a REAL"]),
    ("n : INT;", "n := 1.5;", ["n := 2;", "warning: 1.5 is rounded: a INT has no fraction"]),
    ("t : TIME;", "t := 5;",
     ["t := 5;", "warning: 5 goes into a TIME as a count; write a unit"]),
    ("t : TIME; l : LTIME;", "l := t;", ["l := RESCALE.LTIME(t);"]),
    ("a : ARRAY [0..1] OF INT; b : ARRAY [1..2] OF INT;", "a := b;", ["a := b;"]),
    ("a : ARRAY [0..1] OF INT; b : ARRAY [0..2] OF INT;", "a := b;",
     ["fault: a ARRAY [0..2] OF INT does not go into a ARRAY [0..1] OF INT"]),
    ("a : TON; b : TOF;", "a := b;", ["fault: a TOF does not go into a TON"]),
]  # fmt: skip


@pytest.mark.parametrize(("variables", "statement", "expected"), ROWS)
def test_conversions(lines: Lines, variables: str, statement: str, expected: list[str]) -> None:
    assert lines(variables, statement) == expected


@pytest.mark.parametrize(
    ("source", "target", "rule"),
    [
        (INT, DINT, "EXTEND"),
        (DINT, INT, "CUT"),
        (BYTE, USINT, None),
        (BOOL, INT, "FROM_BOOL"),
        (INT, BOOL, "TO_BOOL"),
        (INT, REAL, "TO_REAL"),
        (REAL, INT, "ROUND"),
        (TIME, LTIME, "RESCALE"),
        (DT, TIME, "RESCALE"),
        (TIME, DINT, "CUT"),
        (INT, STRING(), "WRITE_TEXT"),
        (STRING(), INT, "READ_TEXT"),
        (STRING(3), STRING(4), None),
        (STRING(4), STRING(3), "CUT_TEXT"),
        (STRING(4), WSTRING(4), "RECODE_TEXT"),
    ],
)
def test_the_rule_follows_from_the_types(
    source: IecType[object], target: IecType[object], rule: str | None
) -> None:
    value = Read(Storage(FrameBase(), 0, source), source)
    result = converted(value, target, 0)
    assert (result.rule.value if isinstance(result, Converted) else None) == rule
