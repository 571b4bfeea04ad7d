"""Tc2_Math against Python."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.plc.code.conftest import Ran


@settings(max_examples=10, deadline=None)
@given(x=st.floats(-1e6, 1e6), y=st.floats(0.01, 1000))
def test_whole_parts_and_remainders(x: float, y: float) -> None:
    ran = Ran(
        f"PROGRAM MAIN VAR x : LREAL := {x!r}; y : LREAL := {y!r}; f, t, r, m, a : LREAL; n : DINT;"
        " big : LREAL; END_VAR f := FLOOR(x); t := LTRUNC(x); r := FRAC(x); m := LMOD(x, y);"
        " a := Tc2_Math.MODABS(x, y); n := MODTURNS(x, y); big := FLOOR(-1E300); END_PROGRAM"
    ).cycle()
    assert ran.plc.failure == ""
    assert (ran["f"], ran["t"]) == (math.floor(x), math.trunc(x))
    assert ran["r"] == x - math.trunc(x)
    assert ran["m"] == pytest.approx(x - y * math.trunc(x / y))
    assert ran["a"] == pytest.approx(x - y * math.floor(x / y))
    assert (ran["n"], ran["big"]) == (math.floor(x / y), -1e300)
