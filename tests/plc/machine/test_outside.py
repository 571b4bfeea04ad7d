"""Texts that Python makes and reads for machine code."""

from collections.abc import Callable
from typing import Any

from achse.plc.machine.outside import maker_of, nodes_outside, reader_of
from achse.st.check import check
from achse.st.declare import declare
from achse.st.syntax.parser import parse

Run = Callable[..., Any]

BODY = """
s := INT_TO_STRING(-5); s := CONCAT(s, LREAL_TO_STRING(2.5)); s := CONCAT(s, REAL_TO_STRING(r));
s := CONCAT(s, BOOL_TO_STRING(b)); s := CONCAT(s, TIME_TO_STRING(T#1m2s));
s := CONCAT(s, ULINT_TO_STRING(u)); w := STRING_TO_WSTRING(s); s := WSTRING_TO_STRING(w);
n := STRING_TO_INT('-123'); r := STRING_TO_REAL('1.25x'); b := STRING_TO_BOOL('TRUE');
u := STRING_TO_ULINT('18446744073709551615'); d := STRING_TO_LREAL('1e308');
t := STRING_TO_TIME('T#5s');
"""
DECLARED = (
    "s : STRING; w : WSTRING; r : REAL := 0.1; b : BOOL; u : ULINT; n : INT; d : LREAL; t : TIME;"
)


def test_all_kinds_of_values(run: Run) -> None:
    ran = run(f"PROGRAM MAIN VAR {DECLARED} END_VAR {BODY} END_PROGRAM", cycles=2)
    assert ran["n"] == -123
    assert ran["u"] == (1 << 64) - 1
    assert ran["s"].startswith("-52.51.25TRUE")
    assert not ran.plain_routines if ran.twin else True


def test_names_of_enumerations(run: Run) -> None:
    ran = run(
        "{attribute 'to_string'}\nTYPE E : (one := 1, two := 2); END_TYPE\n"
        "PROGRAM MAIN VAR e : E := two; s, t : STRING; END_VAR s := TO_STRING(e); e := 7;"
        " t := TO_STRING(e); END_PROGRAM"
    )
    assert (ran["s"], ran["t"]) == ("two", "7")


def test_nodes_are_found_in_the_same_order() -> None:
    text = f"PROGRAM MAIN VAR {DECLARED} END_VAR {BODY} END_PROGRAM"
    first, second = (check(declare([parse(text)])).routines["main"] for _ in range(2))
    nodes = list(nodes_outside(first))
    assert [type(one) for one in nodes] == [type(one) for one in nodes_outside(second)]
    texts = [maker_of(one) for one in nodes if getattr(one.type, "unit", 0)]
    assert texts[0](-5, b"") == b"-5"
    numbers = [reader_of(one) for one in nodes if not getattr(one.type, "unit", 0)]
    assert numbers[0](b"-123") == -123
