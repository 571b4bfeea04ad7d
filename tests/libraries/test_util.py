"""Util against Python: each block is called once a cycle of 10 ms."""

import math
import statistics

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.plc.code.conftest import Ran


def outputs(variables: str, body: str, name: str, count: int) -> list[object]:
    """The values of a variable after each of `count` cycles."""
    ran = Ran(f"PROGRAM MAIN VAR c : INT; {variables} END_VAR {body} c := c + 1; END_PROGRAM")
    values = [ran.cycle()[name] for _ in range(count)]
    assert ran.plc.failure == ""
    return values


def test_blink_is_on_first_and_stays_without_enable() -> None:
    body = "b(ENABLE := c < 7, TIMELOW := T#20MS, TIMEHIGH := T#30MS);"
    values = outputs("b : BLINK;", body, "b.OUT", 12)
    assert "".join(str(int(bool(one))) for one in values) == "111001111111"
    assert outputs("b : BLINK;", "b(ENABLE := FALSE);", "b.OUT", 2) == [False, False]


@pytest.mark.parametrize(
    ("mode", "expected"),
    [
        ("TRIANGLE", [0, 50, 100, 50, 0, -50, -100, -50, 0]),
        ("TRIANGLE_POS", [0, 25, 50, 75, 100, 75, 50, 25, 0]),
        ("SAWTOOTH_RISE", [-100, -75, -50, -25, 0, 25, 50, 75, -100]),
        ("SAWTOOTH_FALL", [100, 75, 50, 25, 0, -25, -50, -75, 100]),
        ("RECTANGLE", [100, 100, 100, 100, -100, -100, -100, -100, 100]),
        ("SINUS", [round(100 * math.sin(math.pi * n / 4)) for n in range(9)]),
        ("COSINUS", [round(100 * math.cos(math.pi * n / 4)) for n in range(9)]),
    ],
)
def test_gen_takes_a_period_by_time_or_by_calls(mode: str, expected: list[int]) -> None:
    inputs = f"MODE := GEN_MODE.{mode}, AMPLITUDE := 100, RESET := c = 9"
    both = (
        f"t({inputs}, BASE := TRUE, PERIOD := T#80MS); n({inputs}, CYCLES := 8);"
        " IF t.OUT <> n.OUT THEN differs := TRUE; END_IF"
    )
    variables = "t, n : GEN; differs : BOOL;"
    assert outputs(variables, both, "t.OUT", 11) == [*expected, 0, expected[0]]
    assert outputs(variables, both, "differs", 11)[-1] is False


def test_hysteresis_and_limit_alarm() -> None:
    body = "x := 10 * c - 20; IF c > 4 THEN x := 60 - 10 * c; END_IF"
    body += " h(IN := x, HIGH := 15, LOW := -5); a(IN := x, HIGH := 15, LOW := -5);"
    variables = "x : INT; h : HYSTERESIS; a : LIMITALARM;"
    # x: -20 -10 0 10 20 10 0 -10
    traces = {
        name: "".join(str(int(bool(one))) for one in outputs(variables, body, name, 8))
        for name in ("h.OUT", "a.O", "a.U", "a.IL")
    }
    assert traces == {"h.OUT": "11110001", "a.O": "00001000", "a.U": "11000001", "a.IL": "00110110"}


def test_ramps_follow_within_their_slopes() -> None:
    inputs = "IN := SEL(c > 0 AND c < 5, 0, 10), ASCEND := 3, DESCEND := 4, RESET := c = 8"
    body = f"r({inputs}); i({inputs}); t({inputs}, TIMEBASE := T#20MS);"
    variables = "r, t : RAMP_REAL; i : RAMP_INT;"
    assert outputs(variables, body, "r.OUT", 8) == [0, 3, 6, 9, 10, 6, 2, 0]
    assert outputs(variables, body, "i.OUT", 8) == [0, 3, 6, 9, 10, 6, 2, 0]
    assert outputs(variables, body, "t.OUT", 9) == [0, 1.5, 3, 4.5, 6, 4, 2, 0, 0]


def test_curves_are_interpolated_and_their_errors_have_numbers() -> None:
    variables = "p : ARRAY [0..10] OF POINT := [(X := 0, Y := 0), (X := 100, Y := 50), (X := 200,"
    variables += " Y := -50)]; k : CHARCURVE;"
    for x, n, expected in (
        (50, 3, (25, 0)), (100, 3, (50, 0)), (150, 3, (0, 0)), (-1, 3, (0, 2)),
        (201, 3, (-50, 2)), (50, 1, (0, 4)), (50, 12, (0, 4)), (50, 4, (0, 1)),
    ):  # fmt: skip
        body = f"k(IN := {x}, N := {n}, P := p);"
        ran = Ran(f"PROGRAM MAIN VAR {variables} END_VAR {body} END_PROGRAM").cycle()
        assert (ran["k.OUT"], ran["k.ERR"]) == expected


@settings(max_examples=5, deadline=None)
@given(values=st.lists(st.integers(-30_000, 30_000), min_size=3, max_size=6))
def test_statistics_and_variance(values: list[int]) -> None:
    body = (
        "i(IN := x[c]); r(IN := x[c]); v(IN := x[c]);"
        " l(IN := x[c], IN_MIN := -30000, IN_MAX := 30000, OUT_MIN := 0, OUT_MAX := 1);"
    )
    ran = Ran(
        f"PROGRAM MAIN VAR x : ARRAY [0..{len(values) - 1}] OF INT := {values}; c : INT;"
        " i : STATISTICS_INT; r : STATISTICS_REAL; v : VARIANCE; l : LIN_TRAFO; END_VAR"
        f" {body} c := c + 1; END_PROGRAM"
    )
    for _ in values:
        ran.cycle()
    assert (ran["i.MN"], ran["i.MX"]) == (min(values), max(values))
    assert ran["i.AVG"] == math.trunc(statistics.fmean(values))
    assert ran["r.AVG"] == pytest.approx(statistics.fmean(values), rel=1e-6)
    assert ran["v.OUT"] == pytest.approx(statistics.pvariance(values), rel=1e-6, abs=1e-3)
    assert ran["l.OUT"] == pytest.approx((values[-1] + 30_000) / 60_000, abs=1e-6)
    assert ran["l.ERROR"] is False


@settings(max_examples=5, deadline=None)
@given(x=st.integers(0, 0xFFFFFFFF), n=st.integers(0, 40), number=st.integers(-5, 105))
def test_bits_and_digits(x: int, n: int, number: int) -> None:
    bits = ", ".join(f"u.B{bit}" for bit in range(8))
    ran = Ran(
        f"PROGRAM MAIN VAR x : DWORD := {x}; n : BYTE := {n}; e : BOOL; s, z : DWORD; u : UNPACK;"
        f" p, d : BYTE; back, bad : INT; i : INT := {number}; END_VAR e := EXTRACT(x, n);"
        " s := PUTBIT(x, n, TRUE); z := PUTBIT(x, n, FALSE); u(B := DWORD_TO_BYTE(x));"
        f" p := PACK({bits}); d := INT_TO_BCD(i); back := BCD_TO_INT(d); bad := BCD_TO_INT(16#A1);"
        " END_PROGRAM"
    ).cycle()
    mask = 1 << n if n < 32 else 0
    assert (ran["e"], ran["s"], ran["z"]) == (bool(x & mask), x | mask, x & ~mask)
    assert ran["p"] == x & 0xFF
    assert ran["back"] == (number if 0 <= number <= 99 else -1)
    assert ran["d"] == (number // 10 * 16 + number % 10 if 0 <= number <= 99 else 255)
    assert ran["bad"] == -1
