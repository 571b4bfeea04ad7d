"""FB_WritePositionCorrection, FB_PositionCompensation: modes and faults (004 §3.4, §3.5)."""

import math
from typing import Any

import pytest

VARIABLES = """
    fb : FB_WritePositionCorrection;
    comp : FB_PositionCompensation;
    desc : ST_CompensationDesc := (fPosMin := 0.0, fPosMax := 100.0, nTableElements := 11);
    rows : ARRAY [0..10] OF ST_CompensationElement;
    other : ARRAY [0..3] OF ST_CompensationElement;
    nothing : BOOL;
    choose : INT;
    length : UDINT := 176;
"""
CALLS = """
fb(AxisRefIn := fromNc1, AxisRefOut := toNc1);
IF choose = 1 THEN
    comp(pTable := 0, cbSize := length, ReferenceAxis := fromNc1, Desc := desc);
ELSE
    comp(pTable := ADR(rows), cbSize := length, ReferenceAxis := fromNc1, Desc := desc);
END_IF
"""
CORRECTED = {"encoder_actual_position_correction_enable": 1}


@pytest.fixture
def on(bench: Any) -> Any:
    rig = bench(variables=VARIABLES, calls=CALLS, a="AXACT", axis=CORRECTED)
    for n in range(11):
        rig.main["rows"][n]["fPos"] = 10.0 * n
        rig.main["rows"][n]["fCompensation"] = n / 10
    return rig


def _move(on: Any, target: float, velocity: float = 100.0) -> None:
    on.set("a", AXID=1, MODE=1, TARGPOS=target, VELOCITY=velocity, START=True)
    on.call(3)
    on.set("a", START=False)
    on.call()


def _shown(on: Any) -> tuple[bool, bool, int, bool]:
    block = on.main["fb"]
    return block["Busy"], block["Error"], block["ErrorId"], block["Limiting"]


def test_unlimited_is_at_once_and_a_disabled_block_leaves_what_is(on: Any) -> None:
    on.set("fb", Enable=True, PositionCorrectionValue=0.75)
    on.call()
    assert on.main["toNc1"]["fActPosCorrection"] == 0.75
    assert _shown(on) == (True, False, 0, False)
    on.set("fb", Enable=False, PositionCorrectionValue=2.0)
    on.call(2)
    assert on.main["toNc1"]["fActPosCorrection"] == 0.75
    assert _shown(on) == (False, False, 0, False)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("mode", [0, 1, 2])
def test_a_value_that_is_no_number_is_refused(on: Any, value: float, mode: int) -> None:
    inputs = {"CorrectionMode": mode, "Acceleration": 500.0, "CorrectionLength": 10.0}
    on.set("fb", Enable=True, PositionCorrectionValue=value, **inputs)
    on.call(3)
    assert _shown(on) == (False, True, 0x4B06, False)
    assert on.main["toNc1"]["fActPosCorrection"] == 0.0


@pytest.mark.parametrize("value", [0.25, -0.25])
def test_fast_takes_125_calls(on: Any, value: float) -> None:
    """At 10 ms, 20 mm/s² are 0.002 per call."""
    on.set("fb", Enable=True, CorrectionMode=1, Acceleration=20.0, PositionCorrectionValue=value)
    for call in range(1, 126):
        on.call()
        assert _shown(on) == (True, False, 0, call < 125)
    assert on.main["toNc1"]["fActPosCorrection"] == value
    on.set("fb", PositionCorrectionValue=0.0)  # and back, from a half-way change too
    on.call(50)
    on.set("fb", PositionCorrectionValue=value)
    on.call(49)
    assert _shown(on)[3]
    on.call()
    assert not _shown(on)[3]


@pytest.mark.parametrize("acceleration", [0.0, -5.0, float("nan")])
def test_fast_needs_an_acceleration(on: Any, acceleration: float) -> None:
    on.set(
        "fb", Enable=True, CorrectionMode=1, Acceleration=acceleration, PositionCorrectionValue=1.0
    )
    on.call()
    assert _shown(on) == (False, True, 0x4B06, False)
    assert on.main["toNc1"]["fActPosCorrection"] == 0.0


@pytest.mark.parametrize("spelled", ["CorrectionLength", "CorrectionLenght"])
@pytest.mark.parametrize("target", [50.0, -50.0])
def test_full_length_spreads_a_change_over_the_way(on: Any, spelled: str, target: float) -> None:
    on.set("fb", Enable=True, CorrectionMode=2, PositionCorrectionValue=0.5, **{spelled: 40.0})
    on.call(20)
    assert on.main["toNc1"]["fActPosCorrection"] == 0.0  # no way, no step
    assert _shown(on)[3]
    _move(on, target)
    while _shown(on)[3]:
        way = abs(on.main["fromNc1"]["fPosSoll"])
        correction = on.main["toNc1"]["fActPosCorrection"]
        assert correction == pytest.approx(0.5 * way / 40.0, abs=1e-9)
        on.call()
    assert on.main["toNc1"]["fActPosCorrection"] == 0.5
    assert abs(on.main["fromNc1"]["fPosSoll"]) >= 40.0


def test_full_length_without_a_length_is_at_once(on: Any) -> None:
    on.set("fb", Enable=True, CorrectionMode=2, PositionCorrectionValue=0.5)
    on.call()
    assert on.main["toNc1"]["fActPosCorrection"] == 0.5


def test_an_axis_whose_correction_is_off_is_reported(bench: Any) -> None:
    on = bench(variables=VARIABLES, calls=CALLS, a="AXACT")
    on.set("fb", Enable=True, PositionCorrectionValue=0.75)
    on.call()
    assert _shown(on) == (False, True, 0x4B16, False)
    assert on.main["toNc1"]["fActPosCorrection"] == 0.0


def _looked_up(on: Any) -> tuple[float, bool, bool, int]:
    block = on.main["comp"]
    return block["Compensation"], block["Active"], block["Error"], block["ErrorId"]


@pytest.mark.parametrize(
    ("place", "value"),
    [(25.0, 0.25), (100.0, 1.0), (0.0, 0.0), (99.9, 0.999), (130.0, 1.0), (-7.0, 0.0)],
)
def test_the_table_at_a_place(on: Any, place: float, value: float) -> None:
    """Beyond the ends the last value holds, so that the axis does not jump."""
    on.set("comp", Enable=True)
    _move(on, place)
    on.call(300)
    assert _looked_up(on) == (pytest.approx(value), True, False, 0)
    on.set("comp", Enable=False)
    on.call()
    assert _looked_up(on) == (0.0, False, False, 0)


@pytest.mark.parametrize(("place", "value"), [(125.0, 0.25), (-10.0, 0.9), (100.0, 0.0)])
def test_a_modulo_table_wraps(on: Any, place: float, value: float) -> None:
    on.set("desc", bModulo=True)
    on.set("comp", Enable=True)
    _move(on, place)
    on.call(300)
    assert _looked_up(on) == (pytest.approx(value), True, False, 0)


@pytest.mark.parametrize(("direction", "plus", "minus"), [(1, True, True), (2, True, False), (3, False, True), (0, False, False)])  # fmt: skip  # noqa: E501
def test_working_directions(on: Any, direction: int, plus: bool, minus: bool) -> None:
    """At rest the last direction counts."""
    on.set("desc", eDirection=direction)
    on.set("comp", Enable=True)
    for target, active in ((60.0, plus), (40.0, minus), (50.0, plus)):
        _move(on, target)
        on.call(10)
        assert _looked_up(on)[1] is active
        on.call(300)
        value, now, *_ = _looked_up(on)
        assert now is active
        assert value == pytest.approx(target / 100.0 if active else 0.0)


@pytest.mark.parametrize(
    ("changes", "code"),
    [
        ({"choose": 1}, 0x4B30),
        ({"length": 175}, 0x4B31),
        ({"length": 0}, 0x4B31),
        ({"nTableElements": 1, "length": 16}, 0x4B31),
        ({"nTableElements": 0, "length": 0}, 0x4B31),
        ({"nTableElements": 0x1000000B}, 0x4B31),
        ({"eTableType": 0}, 0x4B35),
        ({"fPosMax": 0.0}, 0x4B06),
        ({"fPosMin": float("nan")}, 0x4B06),
    ],
)
def test_faults_of_a_table(on: Any, changes: dict[str, float], code: int) -> None:
    for name, value in changes.items():
        if name in ("choose", "length"):
            on.main[name] = value
        else:
            on.main["desc"][name] = value
    on.set("comp", Enable=True)
    on.call()
    assert _looked_up(on) == (0.0, False, True, code)


def test_cross_compensation_looks_at_another_axis(bench: Any) -> None:
    text = CALLS.replace("ReferenceAxis := fromNc1", "ReferenceAxis := fromNc2")
    on = bench(variables=VARIABLES, calls=text, a="AXACT")
    on.main["rows"][10]["fCompensation"] = 7.0
    on.set("comp", Enable=True)
    on.set("a", AXID=2, MODE=1, TARGPOS=100.0, VELOCITY=200.0, START=True)
    on.call(300)
    assert _looked_up(on) == (7.0, True, False, 0)
