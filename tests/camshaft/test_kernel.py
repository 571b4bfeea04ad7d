"""The rules of a camshaft controller (000 §5.5), in plain Python and as machine code.

Steady speeds are compared with closed forms.
"""

import math
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.camshaft import CamController, CamEncoder, CamInput, CamOutput, CamType
from achse.camshaft.kernel import run_controller
from achse.camshaft.record import CAM, CONTROLLER
from achse.native.declare import plain_record
from tests.camshaft.closed_form import EDGE, closed_form

MS = 1_000_000
RATES = (1, 2, 3, 5, 7, 10, 15, 20, 30, 45, 60, 90, 120, 180, 250, 400, 600, 900, 1200, 2000)
"""Strokes per minute: twenty speeds."""


def test_the_entry_takes_one_controller_and_its_cams() -> None:
    controller: Any = plain_record(CONTROLLER)()
    cam: Any = plain_record(CAM)()
    cam.type, cam.end, cam.track = CamType.WAY, 90, 3
    assert run_controller([controller], [cam]) == 1 << 3
    assert controller.configured_cams == 1


# way cams ---------------------------------------------------------------------------------------


def test_a_way_cam_is_on_from_start_to_end(shaft: Any) -> None:
    shaft.cam(type=CamType.WAY, start=90, end=180, track=4)
    assert shaft.go((0, 89.9, 90, 120, 179.9, 180, 200)) == [0, 0, 16, 16, 16, 0, 0]


def test_a_start_behind_the_end_goes_over_0(shaft: Any) -> None:
    shaft.cam(type=CamType.WAY, start=350, end=10)
    assert shaft.go((340, 350, 359.9, 360, 369.9, 370)) == [0, 1, 1, 1, 1, 0]


def test_equal_start_and_end_are_never_on(shaft: Any) -> None:
    shaft.cam(type=CamType.WAY, start=90, end=90)
    assert set(shaft.go(range(0, 720, 10))) == {0}


def test_direction_flags(shaft: Any) -> None:
    shaft.cam(1, type=CamType.WAY, start=0, end=180, track=0, backward=0)
    shaft.cam(2, type=CamType.WAY, start=0, end=180, track=1, forward=0)
    shaft.cam(3, type=CamType.WAY, start=0, end=180, track=2, forward=0, backward=0)
    assert shaft.go((10, 20, 30, 20, 20, 30)) == [1, 1, 1, 2, 2, 1]


def test_a_cam_acts_in_every_nth_stroke(shaft: Any) -> None:
    shaft.cam(type=CamType.WAY, start=10, end=350, count=3)
    on = shaft.go(range(20, 6 * 360 + 20, 60))
    assert [on[k] for k in range(2, 36, 6)] == [0, 0, 1, 0, 0, 1]
    shaft.cam(load=1)
    shaft.at(6 * 360 + 20)
    assert shaft.controller.cams[0].load == 0
    assert shaft.controller.cams[0].stroke == 0


def test_a_multi_cycle_cam_has_a_pattern(shaft: Any) -> None:
    """2 strokes off, 3 on."""
    shaft.cam(type=CamType.MULTI_CYCLE, start=10, end=350, count=2, cycles_on=3)
    on = shaft.go(range(20, 10 * 360 + 20, 60))
    assert [on[k] for k in range(2, 60, 6)] == [0, 0, 1, 1, 1] * 2


def test_strokes_are_not_counted_to_and_fro_at_0(shaft: Any) -> None:
    shaft.cam(type=CamType.WAY, start=10, end=350, count=3)
    shaft.controller.set_input(CamInput.COUNTER_ENABLE, 0b10001)
    shaft.go((340, 359, 361, 359, 361, 359, 361, 370))
    assert list(shaft.controller.record.counters) == [1, 0, 0, 0, 1]
    assert shaft.controller.cams[0].stroke == 1
    shaft.go(range(370, 370 - 3 * 360, -60))  # back over the same 0°, then over two more
    assert list(shaft.controller.record.counters) == [3, 0, 0, 0, 3]


@pytest.mark.parametrize("begin", [0.0, 10.0])
@pytest.mark.parametrize("turns", [1, -1, 2, -3])
def test_the_first_pass_counts_in_either_direction(begin: float, turns: int) -> None:
    controller = CamController(encoder=CamEncoder(3600.0))
    controller.set_input(CamInput.COUNTER_ENABLE, 1)
    step = 25 if turns > 0 else -25
    for k in range(abs(turns) * 3600 // 25 + 1):
        controller.take_position(begin * 10 + k * step)
        controller.cycle()
    assert controller.record.counters[0] == abs(turns)


# closed forms -----------------------------------------------------------------------------------


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("rate", RATES)
def test_switching_positions_at_steady_speed(rate: int, direction: int) -> None:
    """Dead time and hysteresis in both directions: on where angle + speed * dead time says.

    An integer encoder with 4096 increments: angle and measured speed are each known to one
    increment, so switching is where the closed form says, to one cycle of travel and these.
    """
    increments, window = 4096, 10
    controller = CamController(encoder=CamEncoder(increments, window_ns=window * MS))
    dead, start, end = 100, 900, 1800
    controller.set_cam(
        1,
        {"type": 1, "start": 90, "end": 180, "dynamic": 1, "dead_time": dead}
        | {"hysteresis_on": 1, "hysteresis": 20},
    )
    speed = direction * rate * 60.0  # 0.1 degree per s
    unsure = 3600 / increments * (1 + dead / 10 / window) + abs(speed) / 1000 + EDGE
    checked, changes, before = 0, 0, 0
    for k in range(min(max(3 * 60_000 // rate, 300), 8_000)):
        angle = 700.0 * (1 if direction > 0 else 3) + speed * k / 1000
        controller.take_position(math.floor(angle * increments / 3600))
        on = controller.cycle()
        changes += on != before
        before = on
        if k < 100:  # the first cycles measure the speed
            continue
        place = angle + speed * dead * 1e-4
        low, high = closed_form(start, end, place - unsure), closed_form(start, end, place + unsure)
        if low == high and low is not None:
            assert on == low, (k, place % 3600)
            checked += 1
    assert checked > 100
    if rate >= 15:
        assert changes >= 2


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("rate", RATES)
def test_the_cycle_of_switching_is_that_of_the_closed_form(rate: int, direction: int) -> None:
    """With an encoder that knows the place exactly: the very cycle, on and off, over 3 turns."""
    controller = CamController(encoder=CamEncoder(3600.0))
    controller.set_cam(
        1,
        {"type": 1, "start": 90, "end": 180, "dynamic": 1, "dead_time": 73}
        | {"hysteresis_on": 1, "hysteresis": 15},
    )
    speed = direction * rate * 60.0
    wrong = 0
    for k in range(min(max(3 * 60_000 // rate, 300), 8_000)):
        angle = 850.0 * (1 if direction > 0 else 2.2) + speed * k / 1000
        controller.take_position(angle)
        on = controller.cycle()
        expected = closed_form(900, 1800, angle + speed * 73e-4)
        if k > 0 and expected is not None:
            wrong += on != expected
    assert wrong == 0


def test_another_dead_time_is_not_a_movement(shaft: Any) -> None:
    shaft.cam(type=CamType.TIME, start=90, duration=100, dynamic=1)
    shaft.go(range(0, 60, 2))
    shaft.cam(dead_time=200)  # 40° ahead
    assert shaft.at(60) == 0
    assert shaft.at(62) == 0


def test_a_lead_of_ten_milliseconds_at_60_per_minute_is_3_6_degrees(shaft: Any) -> None:
    shaft.cam(type=CamType.WAY, start=90, end=180, dynamic=1, dead_time=100)
    angles = [80 + 0.36 * k for k in range(400)]
    on = shaft.go(angles)
    assert angles[on.index(1)] == pytest.approx(86.4, abs=0.36)
    assert angles[len(on) - on[::-1].index(1)] == pytest.approx(176.4, abs=0.36)


# hysteresis -------------------------------------------------------------------------------------


def test_hysteresis_holds_at_a_reversal() -> None:
    """4096 increments, 20 of them: 1.7578125 degrees."""
    width = 20 * 360 / 4096
    for back, on in ((width - 0.01, 1), (width, 1), (width + 0.01, 0)):
        controller = CamController(encoder=CamEncoder(4096.0))
        controller.set_cam(
            1, {"type": 1, "start": 90, "end": 180, "hysteresis_on": 1, "hysteresis": 20}
        )
        for degrees in (80, 85, 90, 90 - back):
            controller.take_position(degrees * 4096 / 360)
            controller.cycle()
        assert controller.record.outputs == on, back
        assert controller.cams[0].heading == (1 if on else -1)


def test_without_the_flag_there_is_none(shaft: Any) -> None:
    shaft.cam(type=CamType.WAY, start=90, end=180, hysteresis=20)
    assert shaft.go((89, 90, 89.9, 90)) == [0, 1, 0, 1]


def test_hysteresis_keeps_direction_cams_quiet(shaft: Any) -> None:
    shaft.cam(
        type=CamType.WAY, start=0, end=180, backward=0, hysteresis_on=1, hysteresis=5
    )  # half a degree
    assert shaft.go((10, 20, 19.7, 20, 19.6, 20.1, 19)) == [1, 1, 1, 1, 1, 1, 0]


# time cams --------------------------------------------------------------------------------------


@pytest.mark.parametrize("rate", [60, 600])
@pytest.mark.parametrize("direction", [1, -1])
def test_a_time_cam_is_on_for_its_duration(shaft: Any, rate: int, direction: int) -> None:
    shaft.cam(type=CamType.TIME, start=90, duration=50)
    step = direction * rate * 360 / 60_000
    on = shaft.go(90 - direction * 20 + step * k for k in range(200))
    first = on.index(1)
    assert on[first : first + 6] == [1, 1, 1, 1, 1, 0]
    assert abs(90 - (90 - direction * 20 + step * first)) < abs(step) + EDGE
    assert sum(on) == 5 * (1 + (200 * abs(step) > 360 + 20))


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from((360, 1000, 3600, 4096)),
    st.sampled_from((0.1, 0.36, 0.72, 1.0, 1.2, 7.2, 12.0)) | st.floats(0.05, 12.0),
    st.integers(0, 359),
    st.sampled_from((1, -1)),
    st.integers(1, 25),
    st.integers(0, 1),
)
def test_each_pass_is_one_time(
    increments: int, step: float, start: int, direction: int, duration: int, dynamic: int
) -> None:
    """Also where the shaft meets the start exactly: never twice."""
    controller = CamController(encoder=CamEncoder(float(increments), window_ns=3 * MS))
    cam = {"type": 2, "start": start, "duration": duration * 10}
    controller.set_cam(1, cam | {"dynamic": dynamic, "dead_time": 30})
    on = []
    for k in range(200 + int(1500 / step) % 3000):
        controller.take_position((start + direction * step * (k - 100)) * increments / 360)
        on.append(controller.cycle())
        if k == 10:
            on.clear()  # the speed is known, and the cam is far from its start
    first = on.index(1)
    if 360 / step > duration + 5 and step * 100 < 300:
        assert on[first : first + duration + 2] == [1] * duration + [0, 0]


def test_a_time_cam_begins_again_at_the_next_pass(shaft: Any) -> None:
    shaft.cam(type=CamType.TIME, start=90, duration=10 * 20)
    on = shaft.go(80 + 36 * k for k in range(30))  # a pass every ten cycles
    assert on[0] == 0
    assert set(on[1:]) == {1}


def test_a_pass_within_a_cycle_is_seen_by_time_cams_only(shaft: Any) -> None:
    shaft.cam(1, type=CamType.WAY, start=90, end=100, track=0)
    shaft.cam(2, type=CamType.TIME, start=90, track=1)
    assert shaft.go((80, 110, 140)) == [0, 2, 0]


def test_a_fraction_of_a_cycle_is_a_whole_one(shaft: Any) -> None:
    shaft.cam(type=CamType.TIME, start=90, duration=1)
    assert shaft.go((80, 90, 100)) == [0, 1, 0]


def test_a_time_cam_wants_direction_and_stroke(shaft: Any) -> None:
    shaft.cam(1, type=CamType.TIME, start=90, backward=0, track=0)
    shaft.cam(2, type=CamType.TIME, start=90, count=2, track=1)
    assert shaft.go((80, 95, 80, 180, 270, 360, 400, 455)) == [0, 1, 0, 1, 0, 0, 0, 3]


@pytest.mark.parametrize("kind", [CamType.TIME, CamType.BRAKE])
@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("start", [1, 359, 0])
@pytest.mark.parametrize("count", [2, 3])
def test_a_start_and_0_in_one_cycle(
    shaft: Any, kind: int, direction: int, start: int, count: int
) -> None:
    """A start before 0° is one of the stroke that ends, however far a cycle goes."""
    shaft.controller.set_input(CamInput.BRAKE_ENABLE, 1)
    shaft.cam(type=kind, start=start, count=count, duration=1)
    on = shaft.go(direction * (60 * k + 30) for k in range(25))
    before = start % 360 > 0 and (start > 180) == (direction > 0)  # of the stroke that ends at 0
    passes = range(5, 25, 6)  # 0° is passed in the cycles before these: 330 to 390
    first = [on[k + 1] for k in passes]
    acts = [int((n + (not before)) % count == count - 1) for n in range(4)]
    assert on[0] == 0
    if kind == CamType.BRAKE:
        assert on.index(1) == 6 + 6 * acts.index(1)
    else:
        assert first == acts


# brake cams -------------------------------------------------------------------------------------


def test_a_brake_cam_stays_until_the_enable_goes_and_its_time_is_over(shaft: Any) -> None:
    shaft.cam(type=CamType.BRAKE, start=90, track=2, end_value=30)
    assert shaft.go((80, 95)) == [0, 0]  # not enabled
    shaft.controller.set_input(CamInput.BRAKE_ENABLE, 1 << 2)
    assert shaft.go((180, 300, 440, 455, 455, 500)) == [0, 0, 0, 4, 4, 4]
    assert shaft.controller.cams[0].brake_enabled == 1
    shaft.controller.set_input(CamInput.BRAKE_ENABLE, 0)
    assert shaft.go([500] * 5) == [4, 4, 4, 0, 0]


def test_without_end_value_it_goes_with_the_enable(shaft: Any) -> None:
    shaft.cam(type=CamType.BRAKE, start=90)
    shaft.controller.set_input(CamInput.BRAKE_ENABLE, 1)
    assert shaft.go((80, 95, 100)) == [0, 1, 1]
    shaft.controller.set_input(CamInput.BRAKE_ENABLE, 0)
    assert shaft.go((100, 100)) == [0, 0]


def test_force_brakes_at_once(shaft: Any) -> None:
    shaft.cam(type=CamType.BRAKE, start=90, force=1, end_value=10)
    assert shaft.go((200, 200)) == [1, 1]
    shaft.cam(force=0)
    assert shaft.go((200, 200)) == [1, 0]


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("rate", RATES)
def test_a_braked_shaft_stops_where_the_lead_says(rate: int, direction: int) -> None:
    """A brake that takes 20 ms: with this dead time the shaft stops at the cam's start."""
    controller = CamController(encoder=CamEncoder(3600.0))
    controller.set_cam(1, {"type": 3, "start": 180, "dynamic": 1, "dead_time": 200})
    speed = direction * rate * 60.0
    angle, begun, k = 700.0, None, 0
    while begun is None or k < begun + 20:
        if k == 20:  # the speed is known
            controller.set_input(CamInput.BRAKE_ENABLE, 1)
        angle += speed / 1000
        controller.take_position(angle)
        if controller.cycle() and begun is None:
            begun = k
        k += 1
        assert k < 61_000
    beside = math.remainder(angle - 1800, 3600)
    assert abs(beside) <= abs(speed) / 1000 + EDGE


# tracks and masks -------------------------------------------------------------------------------


def test_cams_of_a_track_are_ored(shaft: Any) -> None:
    shaft.cam(1, type=CamType.WAY, start=0, end=10, track=31)
    shaft.cam(128, type=CamType.WAY, start=5, end=20, track=31)
    assert shaft.go((2, 7, 15, 25)) == [1 << 31, 1 << 31, 1 << 31, 0]
    assert shaft.controller.configured_cams == 2


def test_masks_force_bits_and_or_wins(shaft: Any) -> None:
    shaft.cam(type=CamType.WAY, start=0, end=359, track=0)
    record = shaft.controller.record
    record.and_mask = 0xFFFF_FFFE
    assert shaft.at(10) == 0
    record.or_mask = 0x8000_0001
    assert shaft.at(10) == 0x8000_0001
    record.and_mask, record.or_mask = 0xFFFF_FFFF, 0
    shaft.controller.set_input(CamInput.AND_MASK, 0x2)
    assert shaft.at(10) == 0
    shaft.controller.set_input(CamInput.AND_MASK, 0)  # nobody sets it
    assert shaft.at(10) == 1
    record.and_mask_linked = 1
    assert shaft.at(10) == 0
    shaft.controller.set_input(CamInput.OR_MASK, 0x6)
    assert shaft.at(10) == 0x6


def test_without_calculation_only_masks_count(shaft: Any) -> None:
    shaft.cam(1, type=CamType.WAY, start=0, end=359, track=0)
    shaft.cam(2, type=CamType.TIME, start=10, duration=65535, track=1)
    assert shaft.go((5, 15)) == [1, 3]
    shaft.controller.record.active = 0
    shaft.controller.record.or_mask = 0x10
    assert shaft.at(20) == 0x10
    shaft.controller.record.active = 1
    assert shaft.at(25) == 0x11


# encoder ----------------------------------------------------------------------------------------


def test_zero_point_offset_and_reversal(shaft: Any) -> None:
    record = shaft.controller.record
    record.zero_point, record.position_offset = 100, -30
    shaft.at(10)
    assert record.angle == 170
    record.reversed = 1
    shaft.at(10)
    assert record.angle == 3600 - 170
    shaft.at(11)
    assert (record.angle, record.direction) == (3420, -1)
    record.reversed = 0
    shaft.controller.set_input(CamInput.REVERSED, 1)
    shaft.at(12)
    assert (record.angle, record.direction) == (3410, -1)
    words = shaft.controller.output_words()
    assert words[CamOutput.ANGLE] == 3410
    assert words[CamOutput.RAW] == 120


def test_a_shifted_zero_is_no_movement(shaft: Any) -> None:
    shaft.cam(type=CamType.TIME, start=90, duration=100)
    shaft.controller.set_input(CamInput.COUNTER_ENABLE, 1)
    shaft.go((80, 80))
    shaft.controller.record.zero_point = 3000
    assert shaft.go((80, 80)) == [0, 0]
    assert shaft.controller.record.counters[0] == 0


def test_a_single_turn_encoder_goes_on_after_its_end() -> None:
    controller = CamController(encoder=CamEncoder(4096.0, span=4096.0, window_ns=MS))
    controller.record.encoder_monitoring = 1
    controller.set_input(CamInput.COUNTER_ENABLE, 1)
    for k in range(100):
        controller.take_position(k * 100 % 4096)
        controller.cycle()
    record = controller.record
    assert (record.counters[0], record.encoder_error) == (2, 0)
    assert record.actual_rate == round(100 * 1000 * 60 / 4096)
    for position in (4096, -1):
        record.encoder_error = 0
        controller.take_position(position)
        controller.cycle()
        assert record.encoder_error == 1


def test_jumps_and_values_that_are_none_are_encoder_errors(shaft: Any) -> None:
    record = shaft.controller.record
    shaft.go((0, 180))
    assert record.encoder_error == 0
    shaft.at(361)  # more than half a turn, not monitored
    assert record.encoder_error == 0
    record.encoder_monitoring = 1
    for position in (None, math.nan, math.inf, -1e300):
        shaft.controller.take_position(position)
        shaft.controller.cycle()
        assert record.encoder_error == 1
        record.encoder_error = 0
        shaft.at(361)
        assert record.encoder_error == 0
    shaft.at(541.1)
    assert record.encoder_error == 1
    shaft.go((541, 542))
    assert record.encoder_error == 1  # it stays until it is reset
    shaft.controller.set_input(CamInput.RESET_ENCODER_ERROR, 1)
    shaft.at(542)
    assert record.encoder_error == 0
    shaft.at(0)
    assert record.encoder_error == 1  # the input has not risen since
    shaft.at(1)
    assert record.encoder_error == 1


# monitoring -------------------------------------------------------------------------------------


def test_a_rate_that_deviates_for_too_long_is_an_error(shaft: Any) -> None:
    record = shaft.controller.record
    record.set_rate, record.rate_tolerance, record.rate_time = 60, 5, 100
    record.rate_monitoring = 1
    results = []
    for k in range(130):
        shaft.at(0.3 * k)  # 50 per minute
        results.append(record.rate_error)
    assert record.actual_rate == 50
    assert results.index(1) == 100
    shaft.controller.set_input(CamInput.RESET_RATE_ERROR, 1)
    shaft.at(0.3 * 130)
    assert record.rate_error == 0
    record.set_rate = 54
    for k in range(131, 400):
        shaft.at(0.3 * k)
    assert record.rate_error == 0


def test_a_shaft_that_stays_still_while_engaged_is_broken(shaft: Any) -> None:
    record = shaft.controller.record
    record.shaft_monitoring, record.shaft_time, record.set_rate = 1, 50, 60
    shaft.go([10] * 200)
    assert record.shaft_error == 0  # not engaged
    record.coupled = 1
    results = []
    for _ in range(60):
        shaft.at(10)
        results.append(record.shaft_error)
    assert results.index(1) == 50
    shaft.controller.set_input(CamInput.RESET_SHAFT_ERROR, 1)
    shaft.at(10)
    assert record.shaft_error == 0
    record.coupled = 0
    shaft.controller.set_input(CamInput.ENGAGED, 1)
    shaft.go(10 + 0.06 * k for k in range(300))
    assert record.shaft_error == 0
    shaft.go([28] * 60)
    assert record.shaft_error == 1


def test_without_a_set_rate_a_shaft_may_stand(shaft: Any) -> None:
    record = shaft.controller.record
    record.shaft_monitoring, record.coupled = 1, 1
    shaft.go([10] * 10)
    assert record.shaft_error == 0


# counters and inputs ----------------------------------------------------------------------------


def test_counters_take_set_values_when_these_change(shaft: Any) -> None:
    shaft.controller.set_input(CamInput.COUNTER_ENABLE, 0b01100)
    shaft.controller.set_input(CamInput.COUNTER_3, 0xFFFF_FFFF)
    shaft.go(range(10, 730, 60))
    assert list(shaft.controller.record.counters) == [0, 0, 0, 1, 0]
    shaft.at(735)
    assert list(shaft.controller.record.counters) == [0, 0, 1, 2, 0]
    shaft.controller.set_input(CamInput.COUNTER_4, 100)
    shaft.go((740, 745))
    assert list(shaft.controller.record.counters) == [0, 0, 1, 100, 0]


def test_rates_of_the_inputs_are_taken_when_they_change(shaft: Any) -> None:
    record = shaft.controller.record
    record.set_rate, record.rate_tolerance = 60, 5
    shaft.at(0)
    assert (record.set_rate, record.rate_tolerance) == (60, 5)
    shaft.controller.set_input(CamInput.SET_RATE, 30)
    shaft.controller.set_input(CamInput.RATE_TOLERANCE, 2)
    shaft.at(0)
    assert (record.set_rate, record.rate_tolerance) == (30, 2)
    shaft.controller.set_input(CamInput.SET_RATE, 0xFFFF_FFFF)
    shaft.at(0)
    assert record.set_rate == 2000
    record.set_rate = 80
    shaft.at(0)
    assert record.set_rate == 80
    record.io_errors = 3
    shaft.controller.set_input(CamInput.RESET_IO_ERROR, 5)
    shaft.at(0)
    assert record.io_errors == 0
