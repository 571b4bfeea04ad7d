"""What supervises an axis, at each of its bounds: just inside, at the bound, just outside."""

from collections.abc import Callable
from itertools import product
from math import inf, nextafter
from typing import Any

import pytest

from achse.codes import NcError
from achse.codes.axis import HomingState
from achse.codes.nc.choices import MotionPhase, SignalType
from achse.motion.features import Feature
from achse.motion.generators.table import UNPLANNED
from achse.motion.monitoring import (
    _at_limit,
    _limit_error,
    _supervise_following_error,
    _supervise_limits,
    _watch_signals,
    report,
    supervise_arrival,
    supervise_enable,
    supervise_motion,
    watch_standstill,
)
from achse.motion.port import STATUS_ABSENT, STATUS_ERROR, STATUS_FAST_STOP, STATUS_READY
from achse.motion.setpoints.limits import TOLERANCE

DT = 2.0**-9
"""A cycle whose multiples are exact, s."""

CODE = NcError.FOLLOWING_ERROR_POSITION.number
OTHER = NcError.NO_MOVEMENT_SEEN.number
MAX, MIN = NcError.SOFT_LIMIT_MAX_PASSED.number, NcError.SOFT_LIMIT_MIN_PASSED.number


def put(axis: Any, **values: Any) -> None:
    """Write fields of the axis and of its parts: `drive__io_time`."""
    for name, value in values.items():
        owner, names = axis, name.split("__")
        for part in names[:-1]:
            owner = getattr(owner, part)
        setattr(owner, names[-1], value)


def moving(axis: Any, phase: MotionPhase = MotionPhase.ENDLESS, velocity: float = 0.5) -> None:
    put(axis, set_motion_phase=phase, set_velocity=velocity, error_code=0, output_cut=0)
    put(axis, job__deceleration=1.0, job__jerk=1.0, loop_closed=1, has_been_stopped=0)


@pytest.mark.parametrize(
    ("mode", "delay", "error", "delayed", "after"),
    [
        (0, 0.1, 0, 0, (CODE, 0, 1)),
        (1, 0.0, 0, 0, (CODE, 0, 1)),
        (2, 0.1, 0, 0, (CODE, 0, 1)),
        (1, 0.1, 0, 0, (0, CODE, 0)),
        (1, 0.1, 0, OTHER, (0, OTHER, 0)),
        (1, 0.1, OTHER, 0, (OTHER, 0, 1)),
    ],
)
def test_reaction_to_the_first_error_waits_for_its_delay(
    rig: Any,
    set_features: Callable[[Any, int], None],
    mode: int,
    delay: float,
    error: int,
    delayed: int,
    after: tuple[int, int, int],
) -> None:
    axis = rig.axis
    put(axis, error_reaction_mode=mode, error_reaction_delay=delay, error_code=error)
    put(axis, delayed_error_code=delayed, delayed_error__time=7.0, delayed_error__cut=0)
    set_features(axis, 0)
    report(axis, CODE, 1)
    assert bool(axis.features & Feature.DELAYED_ERROR) is (after[1] == CODE and delayed == 0)
    assert bool(axis.features & Feature.ERROR) is (after[1] == 0)
    assert (axis.error_code, axis.delayed_error_code, axis.output_cut) == after
    begun = after[1] == CODE
    assert (axis.delayed_error.cut, axis.delayed_error.time) == ((1, 0.0) if begun else (0, 7.0))


def test_fast_stop_signal_stops_what_moves_by_its_type(rig: Any) -> None:
    axis, drive = rig.axis, rig.axis.drive
    for kind, before, now, phase in product(
        SignalType, (0, 1), (0, 1), (MotionPhase.NONE, MotionPhase.ENDLESS)
    ):
        moving(axis, phase)
        put(axis, fast_axis_stop_signal_type=kind, drive__signal_before=before)
        drive.io.state4 = now * STATUS_FAST_STOP
        _watch_signals(axis, DT)
        counts = {
            SignalType.OFF: False,
            SignalType.RISING_EDGE: now > before,
            SignalType.FALLING_EDGE: now < before,
            SignalType.BOTH_EDGES: now != before,
            SignalType.HIGH: now == 1,
            SignalType.LOW: now == 0,
        }
        stopped = counts[kind] and phase != MotionPhase.NONE
        assert axis.has_been_stopped == stopped, (kind, before, now)
        assert drive.signal_before == (now if kind else before)
        assert drive.io_time == 0.0


@pytest.mark.parametrize("time", [7.0 * DT, 7.5 * DT, 7.75 * DT])
def test_invalid_data_of_a_drive_in_use_are_an_error_after_eight_cycles(
    rig: Any, time: float
) -> None:
    """In use is a closed loop, or an enabled axis without error whose drive is not on the bus."""
    axis = rig.axis
    for invalid, closed, enable, absent, error in product((0, 1), repeat=5):
        moving(axis)
        put(axis, io_invalid=invalid, loop_closed=closed, control_dword=6 + enable)
        put(axis, error_code=error * OTHER, drive__io_time=time)
        axis.drive.io.state4 = absent * STATUS_ABSENT
        _watch_signals(axis, DT)
        in_use = closed or (enable and absent and not error)
        failed = bool(invalid and in_use and time > 7.5 * DT)
        assert axis.output_cut == failed, (invalid, closed, enable, absent, error)
        code = NcError.DRIVE_IO_INVALID.number if failed else 0
        assert axis.error_code == (OTHER if error else code)
        assert axis.drive.io_time == (time + DT if invalid else 0.0)


FEED = {7: (0, 0), 5: (1, 0), 3: (0, 1), 1: (1, 1)}
"""Control words, and whether the feed enables forward and backward are missing."""


@pytest.mark.parametrize("word", [7, 6, 5, 3, 1])
@pytest.mark.parametrize("velocity", [0.5, 0.0, -0.5])
def test_enable_closes_the_loop_and_its_loss_stops_what_moves(
    rig: Any, word: int, velocity: float
) -> None:
    axis = rig.axis
    for ready, disabled, cut, phase in product(
        (0, 1),
        ("", "axis_disabled", "drive_output_disabled"),
        (0, 1),
        (MotionPhase.NONE, MotionPhase.ENDLESS, MotionPhase.STOPPING, MotionPhase.COUPLED),
    ):
        moving(axis, phase, velocity)
        put(axis, control_dword=word, drive_status=ready * STATUS_READY, job__direction=0.0)
        put(axis, axis_disabled=0, drive_output_disabled=0, output_cut=cut, limit_switch=0)
        if disabled:
            setattr(axis, disabled, 1)
        supervise_enable(axis, DT)
        enabled = word & 1 and ready and not disabled
        moves = phase != MotionPhase.NONE
        code = 0
        if enabled and moves:
            forward, backward = FEED[word]
            if forward and velocity > 0.0:
                code = NcError.FEED_ENABLE_PLUS_WITHDRAWN.number
            elif backward and velocity < 0.0:
                code = NcError.FEED_ENABLE_MINUS_WITHDRAWN.number
        elif moves and (phase != MotionPhase.COUPLED or velocity != 0.0):
            lost = NcError.CONTROLLER_ENABLE_MISSING if ready else NcError.DRIVE_NOT_READY
            code = lost.number
        case = word, velocity, ready, disabled, cut, phase
        assert axis.error_code == code, case
        brakes = moves and ready and not (phase == MotionPhase.COUPLED and velocity == 0.0)
        assert axis.loop_closed == int(bool((enabled or brakes) and not cut)), case
        assert axis.output_cut == int(cut or code == NcError.DRIVE_NOT_READY), case


def test_lost_enable_of_an_axis_in_error_changes_nothing_but_the_loop(rig: Any) -> None:
    """The stop that the error has begun goes on as long as the drive is ready."""
    axis = rig.axis
    for phase, ready in product((MotionPhase.STOPPING, MotionPhase.ENDLESS), (0, 1)):
        moving(axis, phase)
        put(axis, error_code=OTHER, control_dword=6, drive_status=ready * STATUS_READY)
        supervise_enable(axis, DT)
        brakes = ready and phase == MotionPhase.STOPPING
        assert (axis.error_code, axis.output_cut, axis.loop_closed) == (OTHER, 0, brakes)
        assert axis.set_motion_phase == (phase if brakes else MotionPhase.NONE)
        assert (axis.job.deceleration, axis.job.jerk) == (1.0, 1.0)


def test_loop_that_closes_begins_where_the_axis_is(rig: Any) -> None:
    axis, encoder = rig.axis, rig.axis.encoder
    for phase, error in product((MotionPhase.NONE, MotionPhase.COUPLED), (0, OTHER)):
        moving(axis, phase, 0.0)
        put(axis, loop_closed=0, control_dword=7, drive_status=STATUS_READY, error_code=error)
        put(
            axis,
            monitoring__following_error_time=1.0,
            monitoring__following_error_velocity_time=1.0,
        )
        put(axis, target_position=9.0, monitoring__motion_position=9.0, set_position=9.0)
        encoder.actual_position = 5.0
        supervise_enable(axis, DT)
        assert axis.set_position == 5.0
        if error:
            assert (axis.loop_closed, axis.target_position) == (0, 5.0)
            continue
        assert (axis.loop_closed, axis.monitoring.motion_position) == (1, 5.0)
        assert (
            axis.monitoring.following_error_time,
            axis.monitoring.following_error_velocity_time,
        ) == (0.0, 0.0)
        assert axis.target_position == (5.0 if phase == MotionPhase.NONE else 9.0)
        put(axis, set_position=9.0, monitoring__following_error_time=1.0)
        supervise_enable(axis, DT)
        assert (axis.set_position, axis.monitoring.following_error_time) == (9.0, 1.0)


def test_blocked_drive_is_ready_without_an_error_where_that_is_accepted(rig: Any) -> None:
    axis = rig.axis
    for switch, word, status in product(
        (0, 1, -1), (7, 0x107), (0, STATUS_READY, STATUS_ERROR, STATUS_READY | STATUS_ERROR)
    ):
        moving(axis, MotionPhase.NONE, 0.0)
        put(axis, limit_switch=switch, control_dword=word, drive_status=status, loop_closed=0)
        supervise_enable(axis, DT)
        accepted = switch and word != 7
        ready = not status & STATUS_ERROR if accepted else status & STATUS_READY
        assert axis.loop_closed == int(bool(ready)), (switch, word, status)


def test_external_error_is_reported_once(rig: Any) -> None:
    axis = rig.axis
    put(axis, external_error=OTHER)
    supervise_enable(axis, DT)
    assert (axis.error_code, axis.external_error, axis.output_cut) == (OTHER, 0, 0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("kind", ["position", "velocity"])
def test_following_error_is_one_beyond_its_window_and_filter_time(
    rig: Any, kind: str, sign: float
) -> None:
    axis, controller = rig.axis, rig.axis.controller
    name, time = {
        "position": ("following_error", "following_error_time"),
        "velocity": ("following_error_velocity", "following_error_velocity_time"),
    }[kind]
    codes = {
        "position": NcError.FOLLOWING_ERROR_POSITION,
        "velocity": NcError.FOLLOWING_ERROR_VELOCITY,
    }
    for each in codes:
        setattr(controller, f"following_error_{each}_monitoring_enable", int(each == kind))
    setattr(controller, f"following_error_{kind}_max", 5.0)
    setattr(controller, f"following_error_{kind}_filter_time", 4.0 * DT)
    for enable, error, begun, after, failed in (
        (1, 5.0, 9.0, 0.0, False),
        (1, nextafter(5.0, inf), 0.0, DT, False),
        (1, 5.1, 3.0 * DT, 4.0 * DT, False),
        (1, 5.1, 3.5 * DT, 4.5 * DT, True),
        (0, 5.1, 9.0, 9.0, False),
    ):
        moving(axis)
        setattr(controller, f"following_error_{kind}_monitoring_enable", enable)
        setattr(controller, name, sign * error)
        setattr(axis.monitoring, time, begun)
        _supervise_following_error(axis, DT)
        assert getattr(axis.monitoring, time) == after
        assert axis.error_code == (codes[kind].number if failed else 0)
        assert axis.output_cut == failed
    moving(axis)
    put(axis, error_reaction_mode=1, error_reaction_delay=1.0)
    setattr(controller, f"following_error_{kind}_monitoring_enable", 1)
    _supervise_following_error(axis, DT)
    assert (axis.delayed_error_code, axis.delayed_error.cut) == (codes[kind].number, 1)


def test_homing_that_comes_to_a_limit_says_what_it_has_limit_error(rig: Any) -> None:
    axis = rig.axis
    missing = {
        HomingState.AWAIT_CAM: NcError.HOMING_CAM_NOT_FOUND.number,
        HomingState.AWAIT_CAM_OFF: NcError.HOMING_CAM_STAYS.number,
        HomingState.AWAIT_LATCH: NcError.HOMING_SYNC_PULSE_NOT_FOUND.number,
    }
    for phase, state in product((MotionPhase.HOMING, MotionPhase.ENDLESS), HomingState):
        put(axis, set_motion_phase=phase, homing_state=state)
        expected = missing.get(state, CODE) if phase == MotionPhase.HOMING else CODE
        assert _limit_error(axis, CODE) == expected


@pytest.mark.parametrize("sign", [1, -1])
def test_set_position_may_be_beyond_a_limit_by_rounding(rig: Any, sign: int) -> None:
    axis = rig.axis
    put(axis, limits__low=-60.0, limits__high=60.0)
    bound = 60.0 + TOLERANCE
    for place, velocity, where in (
        (bound, 1.0, 0),
        (nextafter(bound, inf), 1.0, sign),
        (nextafter(bound, inf), 0.0, 0),
        (nextafter(bound, inf), -1.0, 0),
    ):
        put(axis, set_position=sign * place, set_velocity=sign * velocity, limits__reached=0)
        assert _at_limit(axis) == where
    put(axis, set_position=0.0, limits__reached=-sign)
    assert (_at_limit(axis), axis.limits.reached) == (-sign, 0)


@pytest.mark.parametrize("sign", [1, -1])
def test_soft_limit_ends_each_motion_at_once_unless_it_stands(rig: Any, sign: int) -> None:
    """What no table makes is braked ahead of the limit."""
    axis = rig.axis
    put(axis, error_reaction_mode=1, error_reaction_delay=1.0)
    for phase, compensating, external, leads, reached, place, velocity in product(
        (MotionPhase.ENDLESS, MotionPhase.SINE),
        *((0, 1),) * 4,
        (0.0, 59.999),
        (0.0, 32.0),
    ):
        moving(axis, phase, sign * velocity)
        put(axis, limits__low=-60.0, limits__high=60.0, delayed_error_code=0, delayed_error__cut=0)
        put(axis, compensating=compensating, external_setpoint_active=external)
        put(axis, external_set_direction=0, set_position=sign * place)
        put(axis, external_set__velocity=float(leads), external__velocity=0.0)
        put(axis, external_set__position=0.0, external__position=0.0, external__acceleration=0.0)
        put(axis, limits__reached=sign * reached)
        _supervise_limits(axis, DT)
        unplanned = compensating or (external and leads) or UNPLANNED[phase]
        ahead = unplanned and place > 0.0 and velocity > 0.0
        code = 0 if not (reached or ahead) else MAX if sign > 0 else MIN
        case = phase, compensating, external, leads, reached, place, velocity
        stands = velocity == 0.0
        assert axis.error_code == (0 if stands else code), case
        assert axis.delayed_error_code == (code if stands else 0), case
        assert (axis.output_cut, axis.delayed_error.cut) == (0, 0)


def test_delayed_error_reacts_when_its_delay_is_over(rig: Any) -> None:
    axis = rig.axis
    for fast, closed, time, reacts in (
        (False, 1, 3.0 * DT, True),
        (False, 0, 3.0 * DT, True),
        (False, 1, nextafter(3.0 * DT, 0.0), False),
        (True, 1, 3.0 * DT, False),
    ):
        moving(axis)
        put(axis, error_reaction_delay=4.0 * DT, loop_closed=closed)
        put(axis, delayed_error_code=OTHER, delayed_error__cut=1, delayed_error__time=time)
        supervise_motion(axis, DT, fast)
        assert (axis.error_code, axis.output_cut) == ((OTHER, 1) if reacts else (0, 0))
        assert axis.delayed_error_code == (0 if reacts else OTHER)
    moving(axis)
    put(axis, delayed_error_code=0)
    supervise_motion(axis, DT)
    assert (axis.error_code, axis.set_motion_phase) == (0, MotionPhase.ENDLESS)


def test_limits_are_supervised_where_a_closed_loop_moves(rig: Any) -> None:
    axis = rig.axis
    for fast, limited, closed, phase in product(
        (False, True), (0, 1), (0, 1), (MotionPhase.NONE, MotionPhase.ENDLESS)
    ):
        moving(axis, phase)
        put(axis, limits__active=limited, loop_closed=closed, limits__reached=1)
        supervise_motion(axis, DT, fast)
        watched = not fast and limited and closed and phase != MotionPhase.NONE
        assert axis.error_code == (MAX if watched else 0), (fast, limited, closed, phase)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_movement_is_seen_beyond_its_window_or_missed_after_its_time(rig: Any, sign: float) -> None:
    axis, encoder = rig.axis, rig.axis.encoder
    put(axis, motion_monitoring_window=0.5, motion_monitoring_time=4.0 * DT)
    for enable, velocity, place, time, after, failed in (
        (1, 32.0, 0.5, 0.0, (0.0, DT), False),
        (1, 32.0, 0.5, 3.0 * DT, (0.0, 4.0 * DT), False),
        (1, 32.0, 0.5, 3.5 * DT, (0.0, 4.5 * DT), True),
        (1, 32.0, 0.5 + DT, 3.5 * DT, (0.5 + DT, 0.0), False),
        (1, 0.0, 0.25, 3.5 * DT, (0.25, 0.0), False),
        (0, 0.0, 0.25, 3.5 * DT, (0.25, 0.0), False),
        (0, 32.0, 0.75, 3.5 * DT, (0.0, 3.5 * DT), False),
    ):
        moving(axis, velocity=velocity)
        put(
            axis,
            motion_monitoring_enable=enable,
            monitoring__motion_position=sign * 8.0,
            monitoring__motion_time=time,
        )
        encoder.actual_position = sign * (8.0 + place)
        supervise_motion(axis, DT, fast=True)
        assert (axis.monitoring.motion_position, axis.monitoring.motion_time) == (
            sign * (8.0 + after[0]),
            after[1],
        )
        assert (axis.error_code, axis.output_cut) == ((OTHER, 1) if failed else (0, 0))
    moving(axis)
    put(axis, error_reaction_mode=1, error_reaction_delay=1.0, motion_monitoring_enable=1)
    put(axis, monitoring__motion_position=encoder.actual_position, monitoring__motion_time=9.0)
    supervise_motion(axis, DT)
    assert (axis.delayed_error_code, axis.delayed_error.cut) == (OTHER, 1)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_encoder_axis_stands_below_its_window_for_its_time(rig: Any, sign: float) -> None:
    axis = rig.axis
    put(axis, no_motion_window=2.0, no_motion_time=4.0 * DT)
    for velocity, moves, time, after in (
        (nextafter(2.0, inf), 0, 9.0, (1, 0.0)),
        (2.0, 0, 9.0, (0, 9.0)),
        (2.0, 1, 3.0 * DT, (1, 4.0 * DT)),
        (0.0, 1, 3.5 * DT, (0, 4.5 * DT)),
    ):
        put(axis, monitoring__encoder_moves=moves, monitoring__standstill_time=time)
        axis.encoder.actual_velocity = sign * velocity
        watch_standstill(axis, DT)
        assert (axis.monitoring.encoder_moves, axis.monitoring.standstill_time) == after


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_windows_of_the_target_end_at_their_width(rig: Any, sign: float) -> None:
    axis = rig.axis
    put(axis, target_position=100.0, position_range_window=5.0, target_position_window=2.0)
    put(axis, target_position_monitoring_time=4.0 * DT, job__timing=0)
    phases = MotionPhase.NONE, MotionPhase.POSITIONING, MotionPhase.ENDLESS, MotionPhase.HOMING
    for way, enable, phase, velocity, loop, fast in product(
        (2.0, 2.125, 5.0, 5.125),
        (0, 1),
        (*phases, MotionPhase.COUPLED),
        (0.0, -32.0),
        (0, 1),
        (False, True),
    ):
        moving(axis, phase, velocity)
        put(axis, position_range_monitoring_enable=enable, loop__outward=loop)
        put(axis, target_position_monitoring_enable=enable, encoder__actual_position=100.0 + way)
        put(axis, in_position_range=1, in_target_position=1, monitoring__target_window_time=9.0)
        axis.encoder.actual_position = 100.0 + sign * way
        supervise_arrival(axis, DT, fast)
        passes = loop or phase == MotionPhase.ENDLESS
        passes = passes or (phase == MotionPhase.COUPLED and velocity != 0.0)
        passes = passes or (phase == MotionPhase.HOMING and velocity != 0.0 and not fast)
        case = way, enable, phase, velocity, loop, fast
        assert axis.in_position_range == int(enable and way <= 5.0 and not passes), case
        inside = enable and way <= 2.0 and not passes
        assert axis.in_target_position == int(inside), case
        assert axis.monitoring.target_window_time == (9.0 if inside else 0.0), case


def test_target_is_reached_after_its_time_inside_the_window(rig: Any) -> None:
    axis = rig.axis
    put(axis, target_position_monitoring_enable=1, target_position_monitoring_time=4.0 * DT)
    put(axis, set_motion_phase=MotionPhase.NONE, target_position=0.0, loop__outward=0)
    axis.encoder.actual_position = 0.0
    for time, reached in ((nextafter(4.0 * DT, 0.0), 0), (4.0 * DT, 1)):
        put(axis, in_target_position=0, monitoring__target_window_time=time)
        supervise_arrival(axis, DT)
        assert (axis.in_target_position, axis.monitoring.target_window_time) == (reached, time + DT)


def test_positioning_is_timed_until_it_arrives_or_its_time_is_over(rig: Any) -> None:
    axis, job = rig.axis, rig.axis.job
    late = NcError.PEH_TIME_OVER.number
    put(axis, peh_monitoring_time=4.0 * DT, last_positioning_time=0.0, target_position=0.0)
    put(axis, position_range_monitoring_enable=0, target_position_window=2.0)
    axis.encoder.actual_position = 100.0
    moves, rests = MotionPhase.POSITIONING, MotionPhase.NONE
    for timing, phase, window, peh, time, after, error in (
        (0, rests, 0, 1, 9.0, (0, 1.0, 9.0, 0.0), 0),
        (1, moves, 1, 1, 9.0, (1, 1.0 + DT, 0.0, 0.0), 0),
        (1, rests, 0, 1, 9.0, (0, 1.0 + DT, 9.0, 1.0 + DT), 0),
        (1, rests, 1, 0, 9.0, (1, 1.0 + DT, 9.0, 0.0), 0),
        (1, rests, 1, 1, 3.0 * DT, (1, 1.0 + DT, 4.0 * DT, 0.0), 0),
        (1, rests, 1, 1, 3.5 * DT, (0, 1.0 + DT, 4.5 * DT, 0.0), late),
    ):
        moving(axis, phase, 0.0)
        put(axis, peh_monitoring_enable=peh, monitoring__peh_time=time, last_positioning_time=0.0)
        put(axis, job__timing=timing, job__time=1.0, target_position_monitoring_enable=window)
        supervise_arrival(axis, DT)
        assert (job.timing, job.time, axis.monitoring.peh_time, axis.last_positioning_time) == after
        assert (axis.error_code, axis.output_cut) == (error, 0)
    moving(axis, rests, 0.0)
    put(axis, position_range_monitoring_enable=1, position_range_window=2.0, job__timing=1)
    put(
        axis, target_position_monitoring_enable=0, peh_monitoring_enable=1, monitoring__peh_time=9.0
    )
    supervise_arrival(axis, DT)
    assert (axis.monitoring.peh_time, axis.error_code, job.timing) == (9.0, 0, 1)
