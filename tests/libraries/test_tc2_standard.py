"""Tc2_Standard: timers to the cycle, edges, counters, bistables."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.plc.code.conftest import Ran

CYCLE_MS = 10


def _trace(block: str, steps: list[bool], pt_ms: int) -> list[tuple[bool, int]]:
    """Q and ET in each cycle of 10 ms."""
    ran = Ran(
        f"PROGRAM MAIN VAR t : {block}; i : BOOL; p : TIME; END_VAR"
        " t(IN := i, PT := p); END_PROGRAM"
    )
    main: Any = ran.plc.instance("MAIN")
    main["p"] = pt_ms
    trace = []
    for step in steps:
        main["i"] = step
        ran.cycle()
        assert ran.plc.failure == ""
        trace.append((ran["t.Q"], round(ran["t.ET"].total_seconds() * 1000)))
    return trace


def _model(block: str, steps: list[bool], pt: int) -> list[tuple[bool, int]]:
    """The same by closed form: what matters is when the edge was."""
    trace, start, before, q, et = [], 0, False, False, 0
    for number, on in enumerate(steps):
        now = number * CYCLE_MS
        if block == "TON":
            if on and not before:
                start = now
            et = min(now - start, pt) if on else 0
            q = on and et >= pt
        elif block == "TOF":
            if on:
                q, et = True, 0
            else:
                if before:
                    start = now
                if q:
                    et = min(now - start, pt)
                    q = et < pt
        else:
            if not q and et == 0 and on:
                start, q = now, pt > 0
            elif q:
                et = min(now - start, pt)
                q = et < pt
            if not q and not on:
                et = 0
        before = on
        trace.append((q, et))
    return trace


@pytest.mark.parametrize("block", ["TON", "TOF", "TP"])
@given(steps=st.lists(st.booleans(), min_size=1, max_size=25), pt=st.integers(0, 80))
def test_timers_follow_their_edges(block: str, steps: list[bool], pt: int) -> None:
    assert _trace(block, steps, pt) == _model(block, steps, pt)


def test_long_timers_count_nanoseconds() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR t : LTON; END_VAR t(IN := TRUE, PT := LTIME#15ms); END_PROGRAM"
    ).cycle(2)
    assert ran["t.Q"] is False
    ran.cycle()
    assert (ran["t.Q"], int(ran["t.ET"])) == (True, 15_000_000)


def test_edges_counters_and_bistables() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR n : INT; up : R_TRIG; down : F_TRIG; c : CTU; d : CTD; ud : CTUD;"
        " s : SR; r : RS; rises : INT; falls : INT; x : BOOL; END_VAR"
        " x := n MOD 3 = 1; n := n + 1; up(CLK := x); down(CLK := x);"
        " IF up.Q THEN rises := rises + 1; END_IF IF down.Q THEN falls := falls + 1; END_IF"
        " c(CU := x, PV := 2); d(CD := x, LOAD := n = 1, PV := 2); ud(CU := x, CD := x, PV := 0);"
        " s(SET1 := x, RESET := TRUE); r(SET := TRUE, RESET1 := x); END_PROGRAM"
    ).cycle(9)
    assert (ran["rises"], ran["falls"]) == (3, 3)
    assert (ran["c.CV"], ran["c.Q"]) == (3, True)
    assert (ran["d.CV"], ran["d.Q"], ran["ud.CV"]) == (0, True, 0)
    assert (ran["s.Q1"], ran["r.Q1"]) == (False, True)
