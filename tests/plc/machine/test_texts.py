"""Texts: functions with positions in and out of range, aliases of the target, both widths."""

from collections.abc import Callable
from typing import Any

import pytest

Run = Callable[..., Any]

NUMBERS = (-3, 0, 1, 2, 5, 300)


@pytest.mark.parametrize("kind", ["STRING", "WSTRING"])
def test_functions_in_and_out_of_range(run: Run, kind: str) -> None:
    quote = "'" if kind == "STRING" else '"'
    wide = "W" if kind == "WSTRING" else ""
    texts = [f"{quote}{text}{quote}" for text in ("", "a", "abcab", "x" * 250)]
    lines = []
    for text in texts:
        # Numbers as variables, in loops; one of them as a literal, too.
        lines += [f"{name}({text}, {at})" for name in ("LEFT", "RIGHT") for at in ("p", 2)]
        lines += [f"INSERT({text}, s, {at})" for at in ("p", 1)]
        lines += [f"{name}({text}, {at})" for name in ("MID", "DELETE") for at in ("p, q", "2, 5")]
        lines += [f"REPLACE({text}, s, {at})" for at in ("p, q", "-3, 2")]
        lines += [f"CONCAT({text}, {other})" for other in texts]
    each = "\n".join(
        f"t := {wide}{line}; h := h * 31 + {wide}LEN(t); n := n + {wide}FIND(t, s);"
        for line in lines
    )
    last = len(NUMBERS) - 1
    body = (
        f"FOR i := 0 TO {last} DO p := v[i]; FOR j := 0 TO {last} DO q := v[j];\n{each}\n"
        "END_FOR END_FOR"
    )
    ran = run(
        f"PROGRAM MAIN VAR s : {kind} := {quote}ab{quote}; t : {kind}(255); u : {kind}(3);"
        f" h : UDINT; n : DINT; b, c : BOOL;"
        f" i, j, p, q : INT; v : ARRAY[0..{last}] OF INT := [{', '.join(map(str, NUMBERS))}];"
        f" END_VAR\n{body}\n"
        f"u := t; b := u < t; c := t >= u; s := {wide}MID(s, 1, 2); s := {wide}CONCAT(s, s);"
        "\nEND_PROGRAM"
    )
    assert ran["s"] == "bb"
    assert ran["b"]
    assert not ran.plain_routines if ran.twin else True


def test_what_calls_change_was_read_before(run: Run) -> None:
    ran = run(
        "VAR_GLOBAL g : STRING := 'old'; END_VAR\n"
        "FUNCTION F : STRING VAR_INPUT x : STRING; END_VAR g := 'new!'; F := x; END_FUNCTION\n"
        "PROGRAM MAIN VAR s, t : STRING; b : BOOL; END_VAR s := CONCAT(g, F('-x'));"
        " t := CONCAT(F(g), g); b := g = F(g); END_PROGRAM"
    )
    assert ran["s"] == "old-x"
    assert ran["t"] == "new!new!"
    assert ran["b"]
