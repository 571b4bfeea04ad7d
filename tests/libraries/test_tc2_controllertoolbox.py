"""Tc2_ControllerToolbox against transfer functions, tables and pulses worked out in Python."""

import math
from collections.abc import Sequence
from datetime import timedelta
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.plc.code.execution import CodeForm
from tests.plc.code.conftest import BEST, Ran

SAMPLES = 40
MODES = {"IDLE": 0, "PASSIVE": 1, "ACTIVE": 2, "RESET": 3, "MANUAL": 4, "TUNE": 5}
ERROR_STATE = 8
NO_ERROR = 0
LIMITS = {"fOutMaxLimit": 1e38, "fOutMinLimit": -1e38}

BLOCKS = (
    *("PI", "PID", "PID_EXT", "PT1", "PT3", "MOVING_AVERAGE", "SCALE", "LIMITER", "HYSTERESIS"),
    *("LIN_INTERPOLATION", "NORMALIZE", "PWM_OUT", "RAMP_GENERATOR_EXT", "RAMP_GENERATOR"),
)

INPUT = {
    **dict.fromkeys(("PI", "PID", "PID_EXT"), "fSetpointValue := x[n], fActualValue := z[n]"),
    **dict.fromkeys(("PT1", "PT3", "MOVING_AVERAGE", "SCALE", "LIMITER"), "fIn := x[n]"),
    "HYSTERESIS": "fIn := x[n]",
    "LIN_INTERPOLATION": "fIn := x[n]",
    "NORMALIZE": "fIn := x[n]",
    "PWM_OUT": "fPwmInput := x[n]",
    "RAMP_GENERATOR_EXT": "fTargetValue := x[n]",
    "RAMP_GENERATOR": "fTarget := x[n]",
}
OUTPUT = {
    "HYSTERESIS": "BOOL_TO_LREAL(fHYSTERESIS.bOut)",
    "PWM_OUT": "BOOL_TO_LREAL(fPWM_OUT.bPwmOutBitPos) - BOOL_TO_LREAL(fPWM_OUT.bPwmOutBitNeg)",
}
WITHOUT_MODE = ("SCALE", "LIMITER", "RAMP_GENERATOR")


def program() -> str:
    """All blocks; `chosen` is called once a sample, all samples in one cycle."""
    declared = "".join(f"f{b} : FB_CTRL_{b}; p{b} : ST_CTRL_{b}_PARAMS;" for b in BLOCKS)
    body = ""
    for number, block in enumerate(BLOCKS):
        mode = "" if block in WITHOUT_MODE else ", eMode := mode"
        value = OUTPUT.get(block, f"f{block}.fOut")
        body += (
            f"{number}: f{block}({INPUT[block]}{mode}, stParams := p{block}); y[n] := {value};\n"
        )
    return (
        f"PROGRAM MAIN VAR {declared} chosen, n, count : INT; x, y, z, work :"
        f" ARRAY [0..{SAMPLES}] OF LREAL; mode : E_CTRL_MODE; c : FB_CTRL_GET_TASK_CYCLETIME;"
        " table : ARRAY [1..4, 1..2] OF FLOAT; END_VAR"
        " pMOVING_AVERAGE.pWorkArray_ADR := ADR(work);"
        " pMOVING_AVERAGE.nWorkArray_SIZEOF := SIZEOF(work);"
        " pLIN_INTERPOLATION.pDataTable_ADR := ADR(table);"
        " pNORMALIZE.pDataTable_ADR := ADR(table);"
        f" c(eMode := eCTRL_MODE_ACTIVE); FOR n := 0 TO count - 1 DO CASE chosen OF\n{body}"
        "END_CASE END_FOR END_PROGRAM"
    )


@cache
def bench(form: CodeForm = CodeForm.PLAIN) -> Ran:
    """One PLC for many examples."""
    return Ran(program(), form)


class Block:
    """A block with its parameters, and with inputs of its own."""

    def __init__(self, name: str, /, form: CodeForm = CodeForm.PLAIN, **parameters: Any) -> None:
        self.name = name
        self.main: Any = bench(form).plc.instance("MAIN")
        self.ran = bench(form)
        self.main["chosen"] = BLOCKS.index(name)
        self.block = self.main[f"f{name}"]
        self.parameters = self.main[f"p{name}"]
        defaults = {"tTaskCycleTime": 10, "tCtrlCycleTime": 10} | LIMITS
        for member in type(self.parameters).__iec__.members:
            value = parameters.get(member.name, defaults.get(member.name, 0))
            if member.name[0] == "t":
                value = timedelta(milliseconds=value)
            if not member.name.startswith(("p", "nWork", "nData")) or member.name in parameters:
                self.parameters[member.name] = value

    def run(
        self, x: Sequence[float], z: Sequence[float] = (), mode: str = "ACTIVE", reset: bool = True
    ) -> list[float]:
        """The outputs for these inputs, after a reset."""
        if reset:
            self._put([0.0], [0.0], MODES["RESET"])
        self._put(x, z or [0.0] * len(x), MODES[mode])
        return [float(self.main["y"][k]) for k in range(len(x))]

    def _put(self, x: Sequence[float], z: Sequence[float], mode: int) -> None:
        self.main["count"] = len(x)
        self.main["mode"] = mode
        for name, values in (("x", x), ("z", z)):
            for k, value in enumerate(values):
                self.main[name][k] = value
        self.ran.cycle()
        assert self.ran.plc.failure == ""

    @property
    def error(self) -> int:
        return int(self.block["eErrorId"])


def tustin(
    numerator: Sequence[Any], denominator: Sequence[Any], t: float, x: Sequence[float]
) -> np.ndarray[Any, Any]:
    """The response of a transfer function at rest, by the trapezoidal rule.

    `numerator` and `denominator` are coefficients of s, the lowest first: s is replaced by
    2/T (z - 1)/(z + 1), and the difference equation that results is played.
    """
    order = len(denominator) - 1
    minus, plus = np.poly1d([1, -1]), np.poly1d([1, 1])

    def in_z(coefficients: Sequence[Any]) -> np.ndarray[Any, Any]:
        total = np.poly1d([0.0])
        for power, value in enumerate(map(float, coefficients)):
            total += value * (2 / t) ** power * minus**power * plus ** (order - power)
        return np.pad(total.coeffs, (order + 1 - len(total.coeffs), 0))

    b, a = in_z(numerator), in_z(denominator)
    y = np.zeros(len(x))
    for k in range(len(x)):
        forward = sum(b[j] * x[k - j] for j in range(order + 1) if k >= j)
        y[k] = (forward - sum(a[j] * y[k - j] for j in range(1, order + 1) if k >= j)) / a[0]
    return y


signals = st.lists(st.floats(-10, 10), min_size=5, max_size=SAMPLES)
times = st.integers(20, 5000)
FEW = settings(max_examples=15, deadline=None)


@FEW
@given(x=signals, kp=st.floats(-5, 5), t1=times, t2=times, t3=times, every=st.integers(1, 4))
def test_lags_are_their_transfer_functions(
    x: list[float], kp: float, t1: int, t2: int, t3: int, every: int
) -> None:
    cycle = 0.01 * every
    sampled = x[::every]
    one = [1.0, t1 / 1000]
    three = np.polynomial.polynomial.polymul(
        np.polynomial.polynomial.polymul(one, [1.0, t2 / 1000]), [1.0, t3 / 1000]
    )
    for name, denominator in (("PT1", one), ("PT3", list(three))):
        block = Block(name, fKp=kp, tT1=t1, tT2=t2, tT3=t3, tCtrlCycleTime=10 * every)
        expected = tustin([kp], denominator, cycle, sampled)
        samples = [expected[k // every] for k in range(len(x))]
        assert block.run(x) == pytest.approx(samples, rel=1e-6, abs=1e-9)
        assert block.error == NO_ERROR


@FEW
@given(
    x=signals,
    z=signals,
    kp=st.floats(-5, 5),
    tn=times,
    tv=st.integers(0, 500),
    td=st.integers(20, 500),
    p=st.booleans(),
    d=st.booleans(),
)
def test_controllers_are_their_transfer_functions(
    x: list[float], z: list[float], kp: float, tn: int, tv: int, td: int, p: bool, d: bool
) -> None:
    z = (z * len(x))[: len(x)]
    deviation = [a - b for a, b in zip(x, z, strict=True)]
    negative = [-b for b in z]
    integral = tustin([kp], [0.0, tn / 1000], 0.01, deviation)
    assert Block("PI", fKp=kp, tTn=tn).run(x, z) == pytest.approx(
        list(kp * np.array(deviation) + integral), rel=1e-6, abs=1e-6
    )
    derived = tustin([0.0, kp * tv / 1000], [1.0, td / 1000], 0.01, negative if d else deviation)
    wanted = kp * np.array(negative if p else deviation) + integral + derived
    parts: dict[str, Any] = {"bPInTheFeedbackPath": p, "bDInTheFeedbackPath": d}
    for name in ("PID", "PID_EXT"):
        block = Block(name, fKp=kp, tTn=tn, tTv=tv, tTd=td, **parts)
        assert block.run(x, z) == pytest.approx(list(wanted), rel=1e-6, abs=1e-6)


@FEW
@given(
    kp=st.floats(0.1, 5),
    tn=st.integers(20, 200),
    limit=st.floats(1, 20),
    of_integral=st.booleans(),
)
def test_limited_controller_integrates_no_further(
    kp: float, tn: int, limit: float, of_integral: bool
) -> None:
    x = [20.0] * 30 + [-1.0] * 10
    integral, last, wanted = 0.0, 0.0, []
    for e in x:
        change = kp * 0.01 / (2 * tn / 1000) * (e + last)
        total = kp * e + integral + change
        if of_integral:
            integral = min(max(integral + change, -1.0), limit)
        else:
            too_much = min(max(total - limit, 0), max(change, 0))
            too_little = min(max(-1.0 - total, 0), max(-change, 0))
            integral += change - too_much + too_little
        last = e
        wanted.append(min(max(kp * e + integral, -1.0), limit))
    limits: dict[str, Any] = {
        "fOutMaxLimit": limit,
        "fOutMinLimit": -1.0,
        "bARWOnIPartOnly": of_integral,
    }
    for name in ("PI", "PID", "PID_EXT"):
        block = Block(name, fKp=kp, tTn=tn, tTv=0, **limits)
        assert block.run(x) == pytest.approx(wanted)
        assert bool(block.block["bARWactive"]) == (wanted[-1] in (limit, -1.0))


def test_extended_controller_windows_and_dead_bands() -> None:
    plain: dict[str, Any] = {"fKp": 1.0, "tTn": 1000}

    def last(x: float, count: int = 10, **more: float) -> float:
        return Block("PID_EXT", **{**plain, **more}).run([x] * count)[-1]

    # ten cycles integrate 0.095 of the deviation, the first one from zero
    assert last(4.0) == pytest.approx(4.0 * 1.095)
    assert last(4.0, fOuterWindow=3.0) == pytest.approx(4.0)
    assert last(2.0, fOuterWindow=3.0) == pytest.approx(2.0 * 1.095)
    assert last(1.0, fInnerWindow=4.0) == pytest.approx(1.0 + 0.095 / 4)
    assert last(0.5, fDeadBandInput=0.5) == 0.0
    assert last(0.5, fDeadBandOutput=0.6) == 0.0
    assert last(0.5, fDeadBandOutput=0.5) == pytest.approx(0.5 * 1.095)
    codes = {
        26: {"fOuterWindow": -1.0},
        27: {"fInnerWindow": -1.0},
        28: {"fOuterWindow": 1.0, "fInnerWindow": 2.0},
        29: {"fDeadBandInput": -1.0},
        30: {"fDeadBandOutput": -1.0},
        25: {"fOutMaxLimit": -2.0, "fOutMinLimit": -1.0},
    }
    for code, wrong in codes.items():
        block = Block("PID_EXT", **{**plain, **wrong})
        assert block.run([1.0]) == [0.0]
        assert (block.error, int(block.block["eState"])) == (code, ERROR_STATE)


@FEW
@given(x=signals, size=st.integers(1, 20), value=st.floats(-5, 5))
def test_moving_average(x: list[float], size: int, value: float) -> None:
    block = Block("MOVING_AVERAGE", nSamplesToFilter=size)
    wanted = [sum(x[max(0, k - size + 1) : k + 1]) / min(size, k + 1) for k in range(len(x))]
    assert block.run(x) == pytest.approx(wanted, abs=1e-9)
    block.block["fManSyncValue"] = value
    assert block.run(x, mode="MANUAL") == [value] * len(x)
    after = block.run([0.0] * 3, reset=False)
    assert after[0] == pytest.approx(value * (size - 1) / size, abs=1e-9)


@FEW
@given(x=signals, ranges=st.tuples(*[st.floats(-9, 9)] * 4), band=st.floats(0, 8))
def test_scale_limiter_and_hysteresis(
    x: list[float], ranges: tuple[float, float, float, float], band: float
) -> None:
    a, b, c, d = ranges
    scale = Block("SCALE", fInMin=a, fInMax=b, fOutMin=c, fOutMax=d)
    values = scale.run(x, reset=False)
    if a == b:
        assert (scale.error, values) == (23, [0.0] * len(x))
    else:
        wanted = [c + (v - a) * (d - c) / (b - a) for v in x]
        assert values == pytest.approx(wanted, rel=1e-9, abs=1e-9)
    limiter = Block("LIMITER", fMinOutput=c, fMaxOutput=d)
    values = limiter.run(x, reset=False)
    if d < c:
        assert (limiter.error, values) == (24, [0.0] * len(x))
    else:
        assert values == [min(max(v, c), d) for v in x]
        assert bool(limiter.block["bMaxLimit"]) == (min(max(x[-1], c), d) >= d)
        assert bool(limiter.block["bMinLimit"]) == (min(max(x[-1], c), d) <= c)
    state, wanted = 0.0, []
    for v in x:
        state = 1.0 if v > band / 2 else 0.0 if v < -band / 2 else state
        wanted.append(state)
    assert Block("HYSTERESIS", fHysteresisRange=band).run(x) == wanted


@FEW
@given(
    steps=st.lists(st.tuples(st.floats(0.1, 5), st.floats(0.1, 5)), min_size=3, max_size=3),
    start=st.tuples(st.floats(-5, 5), st.floats(-5, 5)),
    x=signals,
    extrapolate=st.booleans(),
)
def test_tables_and_their_inverse(
    steps: list[tuple[float, float]], start: tuple[float, float], x: list[float], extrapolate: bool
) -> None:
    points = [start]
    for dx, dy in steps:
        points.append((points[-1][0] + dx, points[-1][1] + dy))
    for block in (Block("LIN_INTERPOLATION"), Block("NORMALIZE")):
        for row, (left, right) in enumerate(points):
            block.main["table"][row + 1, 1] = left
            block.main["table"][row + 1, 2] = right
        block.parameters["nDataTable_SIZEOF"] = 64
        block.parameters["nDataTable_NumberOfRows"] = 4
        block.block["bExtrapolate"] = extrapolate
    xs, ys = [p[0] for p in points], [p[1] for p in points]

    def value(v: float) -> float:
        if extrapolate and v < xs[0]:
            return ys[0] + (v - xs[0]) * steps[0][1] / steps[0][0]
        if extrapolate and v > xs[-1]:
            return ys[-1] + (v - xs[-1]) * steps[-1][1] / steps[-1][0]
        return float(np.interp(v, xs, ys))

    table = Block("LIN_INTERPOLATION")
    y = table.run(x)
    assert y == pytest.approx([value(v) for v in x], rel=1e-6, abs=1e-6)
    assert bool(table.block["bInIsLessThanMinElement"]) == (x[-1] < xs[0])
    assert bool(table.block["bInIsGreaterThanMaxElement"]) == (x[-1] > xs[-1])
    back = Block("NORMALIZE").run(y)
    wanted = x if extrapolate else [min(max(v, xs[0]), xs[-1]) for v in x]
    assert back == pytest.approx(wanted, rel=1e-4, abs=1e-4)
    for key, wrong, code in (
        ("nDataTable_SIZEOF", 48, 105),
        ("nDataTable_NumberOfRows", 1, 11),
    ):
        table = Block("LIN_INTERPOLATION", nDataTable_SIZEOF=64, nDataTable_NumberOfRows=4)
        table.parameters[key] = wrong
        table.run([0.0])
        assert table.error == code
    table = Block("LIN_INTERPOLATION", nDataTable_SIZEOF=64, nDataTable_NumberOfRows=4)
    table.main["table"][2, 1] = xs[0]
    table.run([0.0])
    assert table.error == 12


@FEW
@given(
    duty=st.floats(-130, 130), period=st.integers(1, 10), later=st.floats(-100, 100),
    instant=st.booleans(),
)  # fmt: skip
def test_pulse_widths(duty: float, period: int, later: float, instant: bool) -> None:
    x = [duty] * (period + 1) + [later] * (2 * period)
    block = Block("PWM_OUT", tPWMPeriod=10 * period, bInstantPWMUpdate=instant)
    wanted = []
    for k, value in enumerate(x):
        taken = value if instant else x[k - k % period]
        taken = min(max(taken, -100.0), 100.0)
        # LREAL_TO_DINT rounds halves away from zero
        ticks = math.floor(abs(taken) * period / 100 + 0.5)
        wanted.append(math.copysign(1.0, taken) if k % period < ticks else 0.0)
    assert block.run(x) == wanted
    block = Block("PWM_OUT", tPWMPeriod=5)
    assert (block.run([50.0]), block.error) == ([0.0], 87)


@FEW
@given(
    start=st.floats(-5, 5),
    targets=st.lists(st.floats(-5, 5), min_size=3, max_size=3),
    up=st.floats(0.1, 100),
    down=st.floats(-100, -0.1),
)
def test_ramps(start: float, targets: list[float], up: float, down: float) -> None:
    x = [v for v in targets for _ in range(13)]
    wanted, y = [], start
    for k, target in enumerate(x):
        if k:
            y = min(y + up * 0.01, target) if target > y else max(y + down * 0.01, target)
        wanted.append(y)
    block = Block("RAMP_GENERATOR_EXT", fVeloPos=up, fVeloNeg=down)
    block.block["fStartValue"] = start
    assert block.run(x) == pytest.approx(wanted, abs=1e-9)
    assert bool(block.block["bValueReached"]) == (wanted[-1] == targets[-1])
    ramp = Block("RAMP_GENERATOR", fVeloPos=up, fVeloNeg=abs(down))
    ramp.block["fStart"] = start
    ramp.block["bEnable"] = False
    ramp.run(x, reset=False)
    ramp.block["bEnable"] = True
    assert ramp.run(x, reset=False) == pytest.approx(wanted, abs=1e-9)
    block = Block("RAMP_GENERATOR_EXT", fVeloPos=-1.0)
    assert (block.run([0.0]), block.error) == ([0.0], 76)


@FEW
@given(value=st.floats(-9, 9), x=st.floats(-9, 9))
def test_modes_errors_and_bumpless_return(value: float, x: float) -> None:
    blocks: dict[str, dict[str, Any]] = {
        "PT1": {"fKp": 1.0, "tT1": 1000},
        "PI": {"fKp": 0.5, "tTn": 1000},
    }
    for name, parameters in blocks.items():
        block = Block(name, **parameters)
        block.block["fManSyncValue"] = value
        assert block.run([x] * 3, mode="MANUAL") == [value] * 3
        step = block.run([x], reset=False)[0]
        assert step == pytest.approx(value, abs=0.011 * 20)
        assert block.run([x], mode="PASSIVE", reset=False) == [0.0]
        assert block.run([x], mode="IDLE", reset=False) == [0.0]
        block.block["bHold"] = True
        values = block.run([x, -x, 3.0], reset=False)
        assert values == [values[0]] * 3
        block.block["bHold"] = False
        block.block["bSync"] = True
        assert block.run([x], reset=False)[0] != 0.0 or value == 0.0
        block.block["bSync"] = False
        assert block.run([x], mode="TUNE") == [0.0]
        assert block.error == 37
        block.run([x], reset=False)
        assert block.error == 37  # an error stays until reset
        for key, code in (("tTaskCycleTime", 1), ("tCtrlCycleTime", 2)):
            block = Block(name, **{**parameters, key: 0})
            block.run([x])
            assert block.error == code


def test_all_blocks_in_machine_code_and_cycle_time() -> None:
    block = Block("PID", BEST, fKp=2.0, tTn=100, tTv=50, tTd=50)
    assert len(set(block.run([1.0] * 10))) > 1
    cycle = block.main["c"]
    assert bool(cycle["bCycleTimeValid"])
    assert cycle["tTaskCycleTime"].total_seconds() == 0.01
