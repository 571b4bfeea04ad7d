"""Reals: all functions at all edges, with and without exceptions, as plain code."""

import itertools
from collections.abc import Callable
from typing import Any

import pytest

Run = Callable[..., Any]

VALUES = ("0.0", "-0.0", "1.0", "-1.0", "0.5", "-2.5", "3.0", "1E300", "-1E300", "1E-300", "d",
          "-d", "d - d")  # fmt: skip
"""d is infinity."""
ONE = ("SQRT", "LN", "LOG", "EXP", "SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN", "ABS")


def _text(kind: str) -> str:
    lines = []
    for value in VALUES:
        lines += [f"x := {value}; a[i] := {name}(x);" for name in ONE]
    for left, right in itertools.product(VALUES, VALUES):
        for made in ("EXPT(x, y)", "x / y", "MIN(x, y)", "MAX(x, y)", "LIMIT(x, y, 1.0)", "x - y"):
            lines.append(f"x := {left}; y := {right}; a[i] := {made};")
    body = "\n".join(f"__TRY {line} __CATCH(c) k[i] := c; __ENDTRY i := i + 1;" for line in lines)
    count = len(lines)
    return (
        f"PROGRAM MAIN VAR a : ARRAY[0..{count}] OF {kind}; x, y, d : {kind}; i : INT; c : UDINT;"
        f" k : ARRAY[0..{count}] OF UDINT; END_VAR\n"
        f"i := 0; d := 1E38; d := d * d; d := d * d; d := d * d; d := d * d;\n{body}\nEND_PROGRAM"
    )


@pytest.mark.parametrize("kind", ["LREAL", "REAL"])
@pytest.mark.parametrize("exceptions", [True, False])
def test_each_function_at_each_edge(run: Run, kind: str, exceptions: bool) -> None:
    ran = run(_text(kind), exceptions=exceptions)
    assert ran.plc.failure == ""
    assert any(ran["k"]) is exceptions
