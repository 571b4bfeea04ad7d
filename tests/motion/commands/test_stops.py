"""Stops, halts and the lock."""

from math import inf, nan, nextafter, sqrt
from typing import Any

import pytest

from achse.codes import NcError
from achse.codes.nc.choices import MotionPhase
from achse.motion import BufferMode, CommandState, StartType, StateBit, commands
from achse.motion.checks import STEEPEST_JERK
from achse.motion.commands.stops import halt
from achse.motion.profiles.profile import stopping_distance, stopping_time

V = 200.0


def refused(rig: Any, code: int, error: NcError) -> None:
    assert NcError.of(code) is error, hex(code)


def test_stop_and_lock_holds_the_axis_until_released(rig: Any) -> None:
    commands.universal_start(rig.axis, 3, 0.0, V)
    rig.seconds(0.5)
    assert commands.universal_start(rig.axis, StartType.STOP_AND_LOCK, 0.0, 0.0) == 0
    assert rig.has(StateBit.MOTION_COMMANDS_LOCKED)
    locked = NcError.AXIS_LOCKED_BY_STOP
    rig.refuses(locked, commands.universal_start, 1, 0.0, V)
    rig.refuses(locked, commands.universal_start, StartType.HALT, 0.0, 0.0)
    rig.until_rest()
    rig.run(1)
    assert rig.has(StateBit.MOTION_COMMANDS_LOCKED)
    rig.refuses(locked, commands.start, 1, 0.0, V)
    assert commands.release_lock(rig.axis) == 0
    assert commands.start(rig.axis, 1, 0.0, V) == 0
    rig.until_rest()
    assert rig.axis.set_position == 0.0


def test_halt_can_be_aborted(rig: Any) -> None:
    commands.universal_start(rig.axis, 3, 0.0, V)
    rig.seconds(0.5)
    assert commands.universal_start(rig.axis, StartType.HALT, 0.0, 0.0) == 0
    rig.run(5)
    assert rig.has(StateBit.HAS_BEEN_STOPPED)
    assert commands.universal_start(rig.axis, 1, 500.0, V) == 0
    rig.until_rest()
    assert rig.axis.set_position == 500.0
    assert not rig.has(StateBit.HAS_BEEN_STOPPED)


def test_a_halt_is_a_command_with_number_and_state(rig: Any) -> None:
    commands.universal_start(rig.axis, 3, 0.0, V)
    rig.seconds(0.5)
    commands.universal_start(rig.axis, StartType.HALT, 0.0, 0.0)
    assert rig.axis.set_command_number == rig.axis.command_counter == 2
    assert rig.axis.set_command_state == CommandState.ACTIVE
    rig.until_rest()
    assert rig.axis.set_command_state == CommandState.DONE


def test_an_emergency_stop_is_no_weaker_than_the_move(rig: Any) -> None:
    commands.start(rig.axis, 3, 0.0, V)
    rig.seconds(1.0)
    for data in ((1000.0, 3000.0), (3000.0, 2000.0), (0.0, 3000.0), (3000.0, nan)):
        rig.refuses(NcError.EMERGENCY_STOP_DATA, commands.emergency_stop, *data)
    begin = rig.axis.set_position
    assert commands.emergency_stop(rig.axis, 4000.0, 80000.0) == 0
    rig.until_rest()
    time = V / 4000.0 + 4000.0 / 80000.0
    assert rig.axis.set_position - begin == pytest.approx(V * time / 2.0)


def test_a_parameterized_stop_has_its_own_ramp(rig: Any) -> None:
    commands.start(rig.axis, 3, 0.0, V)
    rig.seconds(1.0)
    zero = commands.parameterized_stop(rig.axis, 0.0, 1.0)
    refused(rig, zero, NcError.DECELERATION_NOT_POSITIVE)
    begin = rig.axis.set_position
    assert commands.parameterized_stop(rig.axis, 100.0, 1000.0) == 0
    rig.until_rest()
    time = V / 100.0 + 100.0 / 1000.0
    assert rig.axis.set_position - begin == pytest.approx(V * time / 2.0)


def test_a_running_stop_is_not_weakened(rig: Any) -> None:
    commands.start(rig.axis, 3, 0.0, V)
    rig.seconds(1.0)
    begin = rig.axis.set_position
    commands.emergency_stop(rig.axis, 4000.0, 80000.0)
    rig.run(1)
    commands.parameterized_stop(rig.axis, 10.0, 10.0)
    rig.until_rest()
    assert rig.axis.set_position - begin == pytest.approx(V * 0.1 / 2.0)


def stopping_way(v: float, d: float, j: float) -> float:
    """v * T / 2 with T = v / d + d / j, or 2 sqrt(v / j) where d is not reached."""
    return 0.5 * v * (v / d + d / j if v * j >= d * d else 2.0 * sqrt(v / j))


@pytest.mark.parametrize("kind", [3, 4])
@pytest.mark.parametrize("wanted", [0.0, 90.0, 359.0, 400.0])
def test_an_oriented_stop_ends_at_the_next_such_position_in_reach(
    rig: Any, kind: int, wanted: float
) -> None:
    sign = 1.0 if kind == 3 else -1.0
    v = 200.0
    commands.universal_start(rig.axis, kind, 0.0, v)
    rig.seconds(1.3)
    assert rig.axis.set_velocity == sign * v
    begin = rig.axis.set_position
    least = stopping_way(v, rig.axis.job.deceleration, rig.axis.job.jerk)
    assert commands.oriented_stop(rig.axis, wanted, 100.0, 1000.0) == 0
    rig.run(1)
    assert rig.has(StateBit.HAS_BEEN_STOPPED)
    assert rig.has(StateBit.HAS_JOB)
    trace = rig.trace(5000)
    end, last, _ = trace[-1]
    assert last == 0.0
    assert (end - wanted) % 360.0 == pytest.approx(0.0, abs=1e-9) or (
        end - wanted
    ) % 360.0 == pytest.approx(360.0, abs=1e-9)
    assert least - 1e-9 <= sign * (end - begin) < least + 360.0
    assert max(sign * speed for _, speed, _ in trace) <= v * (1.0 + 1e-9)
    assert not rig.has(StateBit.HAS_JOB)


def test_an_oriented_stop_takes_the_running_ramp_in_any_case(rig: Any) -> None:
    for ramp in ((100.0, 1000.0), (9000.0, 90_000.0)):
        commands.universal_start(rig.axis, 3, 0.0, 200.0)
        rig.seconds(2.0)
        commands.oriented_stop(rig.axis, 10.0, *ramp)
        lowest = min(a for _, _, a in rig.trace(4000))
        # the running jerk allows sqrt(v j) where the deceleration is not reached
        d, j = rig.axis.default_deceleration, rig.axis.default_jerk
        assert -lowest == pytest.approx(min(d, sqrt(200.0 * j)), rel=0.01)


def test_an_oriented_stop_ends_reversing(rig: Any) -> None:
    commands.start_reversing(rig.axis, 1, 100.0, 0.0, 100.0, 0.05)
    rig.seconds(0.5)
    assert commands.oriented_stop(rig.axis, 90.0, 1500.0, 2250.0) == 0
    rig.until_rest()
    assert rig.axis.set_position == pytest.approx(90.0)
    rig.seconds(1.0)
    assert rig.axis.set_position == pytest.approx(90.0)
    assert rig.axis.set_motion_phase == 0


def test_an_oriented_stop_at_override_zero_waits(rig: Any) -> None:
    commands.universal_start(rig.axis, 4, 0.0, 200.0)
    rig.seconds(1.0)
    rig.axis.velocity_override = 0
    rig.until(lambda axis: axis.set_velocity == 0.0)
    stands = rig.axis.set_position
    assert commands.oriented_stop(rig.axis, 0.0, 100.0, 1000.0) == 0
    rig.seconds(1.0)
    assert rig.axis.set_position == stands
    rig.axis.velocity_override = 1_000_000
    rig.until_rest()
    assert rig.axis.set_position % 360.0 == pytest.approx(0.0, abs=1e-9)
    assert stands - 360.0 < rig.axis.set_position <= stands


def test_what_an_oriented_stop_refuses(make_rig: Any) -> None:
    rig = make_rig(encoder_soft_limit_max_enable=1, encoder_soft_limit_max=300.0)
    rig.refuses(NcError.NO_MOTION, commands.oriented_stop, 10.0, 100.0, 1000.0)
    commands.universal_start(rig.axis, 3, 0.0, 100.0)
    rig.seconds(1.0)
    rig.refuses(NcError.MODULO_START_RANGE, commands.oriented_stop, -1.0, 100.0, 1000.0)
    rig.refuses(NcError.MODULO_START_RANGE, commands.oriented_stop, inf, 100.0, 1000.0)
    rig.refuses(NcError.DECELERATION_NOT_POSITIVE, commands.oriented_stop, 1.0, 0.0, 1000.0)
    rig.refuses(NcError.JERK_NOT_POSITIVE, commands.oriented_stop, 1.0, 100.0, 0.0)
    rig.refuses(NcError.SOFT_LIMIT_MAX_AT_START, commands.oriented_stop, 359.0, 100.0, 1000.0)


def test_clear_takes_job_and_waiting_commands_away(rig: Any) -> None:
    commands.universal_start(rig.axis, 1, 1000.0, 200.0)
    commands.universal_start(rig.axis, 1, 2000.0, 200.0, buffer_mode=1)
    rig.seconds(1.0)
    begin, v = rig.axis.set_position, rig.axis.set_velocity
    assert commands.clear(rig.axis) == 0
    rig.run(1)
    assert not rig.has(StateBit.COMMAND_BUFFERED)
    assert not rig.has(StateBit.HAS_BEEN_STOPPED)
    rig.until_rest()
    way = stopping_way(v, rig.axis.job.deceleration, rig.axis.job.jerk)
    assert rig.axis.set_position == pytest.approx(begin + way)
    assert rig.axis.set_command_state == CommandState.ABORTED
    rig.run(1)
    assert not rig.has(StateBit.HAS_JOB)


def test_clear_keeps_an_error(rig: Any) -> None:
    commands.set_external_error(rig.axis, 0x4466)
    rig.run(1)
    assert commands.clear(rig.axis) == 0
    rig.run(1)
    assert rig.axis.error_code == 0x4466


def test_stop_and_lock_brakes_with_its_own_ramp_to_the_cycle(rig: Any) -> None:
    commands.universal_start(rig.axis, 4, 0.0, V)
    rig.seconds(0.7)
    assert rig.axis.set_velocity == -V
    begin = rig.axis.set_position
    kind = StartType.STOP_AND_LOCK
    assert commands.universal_start(rig.axis, kind, 0.0, 0.0, 0.0, 500.0, 4000.0) == 0
    time = V / 500.0 + 500.0 / 4000.0
    cycles = rig.until_rest()
    assert abs(cycles - time / rig.dt) < 1.001
    assert rig.axis.set_position == pytest.approx(begin - 0.5 * V * time)
    for bit in (StateBit.HAS_BEEN_STOPPED, StateBit.NOT_MOVING, StateBit.MOTION_COMMANDS_LOCKED):
        assert rig.has(bit)
    assert not rig.has(StateBit.HAS_JOB)


def test_a_buffered_halt_waits_for_the_commands_before(rig: Any) -> None:
    commands.universal_start(rig.axis, 3, 0.0, V)
    halt = StartType.HALT
    assert commands.universal_start(rig.axis, halt, 0.0, 0.0, 0.0, 500.0, 4000.0, 1) == 0
    assert commands.universal_start(rig.axis, 1, 0.0, V, buffer_mode=1) == 0
    rig.until(lambda axis: axis.set_command_number == 2)
    assert rig.axis.set_velocity == pytest.approx(V, rel=1e-2)
    assert rig.axis.set_command_state == CommandState.ACTIVE
    begin = rig.axis.set_position
    rig.until(lambda axis: axis.set_command_number == 3)
    assert rig.axis.set_position == pytest.approx(begin + stopping_way(V, 500.0, 4000.0), abs=0.5)
    rig.until(lambda axis: axis.set_motion_phase == 0)
    assert rig.axis.set_position == 0.0


def test_a_buffered_halt_behind_a_move_changes_nothing(rig: Any) -> None:
    commands.universal_start(rig.axis, 1, 100.0, V)
    assert commands.universal_start(rig.axis, StartType.HALT, 0.0, 0.0, buffer_mode=1) == 0
    assert commands.universal_start(rig.axis, 2, 50.0, V, buffer_mode=1) == 0
    rig.until(lambda axis: not axis.set_motion_phase and not axis.buffer_count)
    assert rig.axis.set_position == 150.0
    for mode in (18, 21):
        code = commands.universal_start(rig.axis, StartType.HALT, 0.0, 0.0, buffer_mode=mode)
        refused(rig, code, NcError.FUNCTION_NOT_AVAILABLE)


def test_emergency_stop_needs_deceleration_and_jerk(rig: Any) -> None:
    for deceleration, jerk in ((0.0, 1000.0), (1000.0, 0.0)):
        code = commands.emergency_stop(rig.axis, deceleration, jerk)
        assert code == NcError.EMERGENCY_STOP_DATA
    assert commands.emergency_stop(rig.axis, 1000.0, 1000.0) == 0


def running(rig: Any, deceleration: float = 1000.0, jerk: float = 10_000.0) -> Any:
    """An axis in an endless move at V, as if it had these dynamics."""
    axis = rig.axis
    axis.set_motion_phase, axis.set_velocity = MotionPhase.ENDLESS, V
    axis.job.deceleration, axis.job.jerk = deceleration, jerk
    axis.set_command_state = CommandState.ACTIVE
    return axis


@pytest.mark.parametrize(
    ("deceleration", "jerk", "phase", "error"),
    [
        (1500.0, STEEPEST_JERK, MotionPhase.NONE, None),
        (nextafter(1500.0, inf), 10_000.0, MotionPhase.NONE, NcError.EMERGENCY_STOP_DATA),
        (1500.0, nextafter(STEEPEST_JERK, inf), MotionPhase.NONE, NcError.EMERGENCY_STOP_DATA),
        (5e-324, 5e-324, MotionPhase.NONE, None),
        (0.0, 10_000.0, MotionPhase.NONE, NcError.EMERGENCY_STOP_DATA),
        (1000.0, 0.0, MotionPhase.NONE, NcError.EMERGENCY_STOP_DATA),
        (1000.0, 10_000.0, MotionPhase.ENDLESS, None),
        (nextafter(1000.0, 0.0), 10_000.0, MotionPhase.ENDLESS, NcError.EMERGENCY_STOP_DATA),
        (1000.0, nextafter(10_000.0, 0.0), MotionPhase.ENDLESS, NcError.EMERGENCY_STOP_DATA),
    ],
)
def test_emergency_stop_has_bounds(
    rig: Any, deceleration: float, jerk: float, phase: MotionPhase, error: NcError | None
) -> None:
    axis = running(rig)
    axis.set_motion_phase, axis.max_deceleration = phase, 1500.0
    code = commands.emergency_stop(axis, deceleration, jerk)
    assert code == (0 if error is None else error.number)


@pytest.mark.parametrize("coupled", [False, True])
def test_stops_of_its_own_are_not_for_slaves(rig: Any, coupled: bool) -> None:
    axis = running(rig)
    axis.coupling.law = int(coupled)
    for stop, arguments in (
        (commands.stop, ()),
        (commands.parameterized_stop, (1000.0, 10_000.0)),
        (commands.emergency_stop, (1500.0, 10_000.0)),
        (commands.oriented_stop, (0.0, 1000.0, 10_000.0)),
        (commands.clear, ()),
    ):
        running(rig)
        code = stop(axis, *arguments)
        assert code == (NcError.FUNCTION_FOR_SLAVE.number if coupled else 0)
        goes_on = MotionPhase.ENDLESS if coupled else MotionPhase.STOPPING
        if stop is commands.oriented_stop and not coupled:
            goes_on = MotionPhase.POSITIONING
        assert axis.set_motion_phase == goes_on


@pytest.mark.parametrize(
    ("state", "kind", "mode", "error"),
    [
        ({}, StartType.HALT, BufferMode.ABORTING, None),
        ({}, StartType.HALT, BufferMode.BUFFERED, None),
        ({}, StartType.STOP_AND_LOCK, BufferMode.ABORTING, None),
        ({}, StartType.STOP_AND_LOCK, BufferMode.BUFFERED, NcError.FUNCTION_NOT_AVAILABLE),
        ({}, StartType.HALT, BufferMode.BLENDING_LOW, NcError.FUNCTION_NOT_AVAILABLE),
        ({"axis_disabled": 1}, StartType.HALT, BufferMode.ABORTING, NcError.AXIS_NOT_READY),
        ({"error_code": 0x4550}, StartType.HALT, BufferMode.ABORTING, NcError.of(0x4550)),
        ({"motion_locked": 1}, StartType.HALT, BufferMode.ABORTING, NcError.AXIS_LOCKED_BY_STOP),
        ({"motion_locked": 1}, StartType.STOP_AND_LOCK, BufferMode.ABORTING, None),
    ],
)
@pytest.mark.parametrize("phase", [MotionPhase.NONE, MotionPhase.ENDLESS])
def test_halt_is_a_command_that_may_lock(
    rig: Any,
    state: dict[str, int],
    kind: StartType,
    mode: BufferMode,
    error: NcError | None,
    phase: MotionPhase,
) -> None:
    axis = running(rig)
    for name, value in ({"set_motion_phase": phase} | state).items():
        setattr(axis, name, value)
    counted = axis.command_counter
    code = halt(axis, kind, 500.0, 4000.0, mode)
    assert code == (0 if error is None else error.number)
    if error is not None:
        assert (axis.command_counter, axis.set_motion_phase) == (counted, phase)
        return
    assert axis.set_command_number == axis.command_counter == counted + 1
    moves = phase != MotionPhase.NONE
    assert axis.set_command_state == (CommandState.ACTIVE if moves else CommandState.DONE)
    assert rig.has(StateBit.HAS_BEEN_STOPPED)
    locks = kind == StartType.STOP_AND_LOCK
    assert axis.motion_locked == int(locks)
    assert rig.has(StateBit.MOTION_COMMANDS_LOCKED) == locks
    if moves:
        assert (axis.job.deceleration, axis.job.jerk) == (500.0, 4000.0)
    assert commands.release_lock(axis) == 0
    assert (axis.motion_locked, rig.has(StateBit.MOTION_COMMANDS_LOCKED)) == (0, False)


def test_halt_has_dynamics(rig: Any) -> None:
    axis = running(rig)
    for ramp, error in (
        ((0.0, 4000.0), NcError.DECELERATION_NOT_POSITIVE),
        ((500.0, 0.0), NcError.JERK_NOT_POSITIVE),
    ):
        code = halt(axis, StartType.HALT, *ramp, BufferMode.ABORTING)
        assert (code, axis.set_motion_phase) == (error.number, MotionPhase.ENDLESS)


@pytest.mark.parametrize(
    ("ramp", "stronger"),
    [((500.0, 20_000.0), (1000.0, 20_000.0)), ((2000.0, 4000.0), (2000.0, 10_000.0))],
)
def test_stop_keeps_what_is_stronger_of_the_one_that_runs(
    rig: Any, ramp: tuple[float, float], stronger: tuple[float, float]
) -> None:
    axis = running(rig)
    axis.max_deceleration = 5000.0
    assert commands.parameterized_stop(axis, *ramp) == 0
    assert (axis.job.deceleration, axis.job.jerk) == ramp
    running(rig).set_motion_phase = MotionPhase.STOPPING
    assert commands.parameterized_stop(axis, *ramp) == 0
    assert (axis.job.deceleration, axis.job.jerk) == stronger


@pytest.mark.parametrize(
    ("place", "error"),
    [(0.0, None), (-5e-324, NcError.MODULO_START_RANGE), (nan, NcError.MODULO_START_RANGE)],
)
def test_oriented_stop_becomes_a_move_that_ends_at_rest(
    rig: Any, place: float, error: NcError | None
) -> None:
    axis = running(rig)
    axis.job.end_velocity = axis.job.peak_velocity = 7.0
    axis.buffer_count = axis.switch.armed = axis.reversing.number = 1
    axis.profile.replan = axis.has_been_stopped = 0
    code = commands.oriented_stop(axis, place, 1000.0, 10_000.0)
    assert code == (0 if error is None else error.number)
    if error is not None:
        return
    assert axis.set_motion_phase == MotionPhase.POSITIONING
    assert (axis.job.end_velocity, axis.job.peak_velocity) == (0.0, 0.0)
    assert (axis.buffer_count, axis.switch.armed, axis.reversing.number) == (0, 0, 0)
    assert (axis.profile.replan, axis.has_been_stopped) == (1, 1)
    assert rig.has(StateBit.HAS_BEEN_STOPPED)


@pytest.mark.parametrize(
    ("velocity", "acceleration", "direction", "target"),
    [(V, 0.0, 1.0, 360.0), (-V, 0.0, -1.0, -360.0), (0.0, -500.0, 1.0, -360.0)],
)
def test_oriented_stop_counts_from_where_the_ramp_ends(
    rig: Any, velocity: float, acceleration: float, direction: float, target: float
) -> None:
    """In the direction of the ramp, which an acceleration alone has too."""
    axis = running(rig)
    axis.set_velocity, axis.set_acceleration = velocity, acceleration
    axis.job.direction, axis.set_position, axis.compensating = direction, 0.0, 1
    assert commands.oriented_stop(axis, 0.0, 1000.0, 10_000.0) == 0
    assert (axis.target_position, axis.compensating) == (target, 0)


def test_clear_is_no_stop(rig: Any) -> None:
    for stopped in (0, 1):
        axis = running(rig)
        axis.has_been_stopped, axis.got_new_target = stopped, 1
        assert commands.clear(axis) == 0
        assert (axis.has_been_stopped, axis.got_new_target) == (stopped, 0)
        assert axis.set_motion_phase == MotionPhase.STOPPING


@pytest.mark.parametrize("phase", [MotionPhase.NONE, MotionPhase.ENDLESS])
def test_stop_information_has_the_ramp_that_a_stop_would_take(rig: Any, phase: MotionPhase) -> None:
    axis = running(rig)
    axis.set_motion_phase, axis.set_acceleration = phase, 50.0
    axis.default_deceleration, axis.default_jerk = 700.0, 7000.0
    moves = phase != MotionPhase.NONE
    for values in ((0.0, 0.0), (900.0, 0.0), (0.0, 9000.0), (5e-3, 5e-3), (nan, nan)):
        usual = (1000.0, 10_000.0) if moves else (700.0, 7000.0)
        ramp = [a if a > 0.0 else b for a, b in zip(values, usual, strict=True)]
        expected = stopping_distance(V, 50.0, *ramp), stopping_time(V, 50.0, *ramp)
        assert commands.stop_information(axis, *values) == expected
