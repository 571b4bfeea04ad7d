"""Reals: all functions at all edges, with and without exceptions, as plain code."""

from collections.abc import Callable
from typing import Any

import pytest

Run = Callable[..., Any]

VALUES = ("0.0", "-0.0", "1.0", "-1.0", "0.5", "-2.5", "3.0", "1E300", "-1E300", "1E-300", "d",
          "-d", "d - d")  # fmt: skip
"""d is infinity."""
ONE = ("SQRT", "LN", "LOG", "EXP", "SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN", "ABS")
TWO = ("EXPT(x, y)", "x / y", "MIN(x, y)", "MAX(x, y)", "LIMIT(x, y, 1.0)", "x - y")
RESULTS = len(VALUES) * len(ONE) + len(VALUES) ** 2 * len(TWO)


def _text(kind: str) -> str:
    """A program that computes each function of each value in loops, code for each only once."""

    def tried(statement: str) -> str:
        return f"__TRY {statement} __CATCH(c) k[i] := c; __ENDTRY i := i + 1;"

    last = len(VALUES) - 1
    values = "\n".join(tried(f"v[{n}] := {value};") for n, value in enumerate(VALUES))
    one = "\n".join(tried(f"a[i] := {name}(x);") for name in ONE)
    two = "\n".join(tried(f"a[i] := {term};") for term in TWO)
    count = RESULTS + len(VALUES)
    return (
        f"PROGRAM MAIN VAR a : ARRAY[0..{count}] OF {kind}; x, y, d : {kind}; i, m, n : INT;"
        f" c : UDINT; v : ARRAY[0..{last}] OF {kind}; k : ARRAY[0..{count}] OF UDINT; END_VAR\n"
        f"i := 0; d := 1E38; d := d * d; d := d * d; d := d * d; d := d * d;\n{values}\n"
        f"FOR m := 0 TO {last} DO x := v[m];\n{one}\n"
        f"FOR n := 0 TO {last} DO y := v[n];\n{two}\nEND_FOR END_FOR\nEND_PROGRAM"
    )


@pytest.mark.parametrize("kind", ["LREAL", "REAL"])
@pytest.mark.parametrize("exceptions", [True, False])
def test_each_function_at_each_edge(run: Run, kind: str, exceptions: bool) -> None:
    ran = run(_text(kind), exceptions=exceptions)
    assert ran.plc.failure == ""
    assert ran["i"] == RESULTS + len(VALUES)
    assert any(ran["k"]) is exceptions
