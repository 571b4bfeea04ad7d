"""Oscillations: reversing operation, velocity steps, sine and frequency sequence."""

from math import isfinite, pi

from achse.codes import NcError
from achse.codes.axis import StartType
from achse.codes.nc.choices import MotionPhase
from achse.motion.axis import Axis
from achse.motion.checks import OK, check_target, check_velocity
from achse.motion.commands.queue import dynamics, next_number, show_accepted
from achse.motion.commands.special_generators.generators import begin_generator, check_generator
from achse.motion.rounding import JUST_ABOVE
from achse.motion.setpoints.jobs import set_request
from achse.motion.setpoints.setpoint import begin_job

FASTEST_BASE = 10.0
"""Highest base frequency of a sine, Hz."""

SLOWEST_START = 1.0
"""Lowest first frequency of a frequency sequence, Hz."""

MOST_MEASUREMENTS = 200


def start_reversing(
    axis: Axis,
    start_type: int,
    end_position_1: float,
    end_position_2: float,
    velocity: float,
    idle_time: float,
) -> int:
    """Move to and fro between two targets with a pause of `idle_time` at each (0x25).

    The move has the dynamics of the axis and lasts until another command or a stop.
    """
    code = check_generator(axis, 1.0, -1.0) or check_velocity(axis, velocity)
    if code:
        return code
    if start_type != StartType.ABSOLUTE:
        return NcError.START_TYPE
    if not (isfinite(end_position_1) and isfinite(end_position_2) and 0.0 <= idle_time < 1e10):
        return NcError.START_AXIS_DATA
    if end_position_1 == end_position_2:
        return NcError.COMMAND_SAME_TARGET
    code = (
        check_target(axis, end_position_1)
        or check_target(axis, end_position_2, end_position_1)
        or check_target(axis, end_position_1, end_position_2)
    )
    if code:
        return code
    set_request(
        axis.job,
        next_number(axis),
        StartType.ABSOLUTE,
        end_position_1,
        velocity,
        *dynamics(axis, 0.0, 0.0, 0.0),
        0.0,
    )
    begin_job(axis)
    axis.reversing.number = axis.command_counter
    axis.reversing.target = end_position_2
    axis.sequence.pause = idle_time
    show_accepted(axis)
    return OK


def start_velocity_steps(
    axis: Axis,
    start_type: int,
    velocity_1: float,
    velocity_2: float,
    move_time: float,
    idle_time: float,
    repeat_count: int,
) -> int:
    """Jump between two signed velocities, each for `move_time`, with pauses at rest (0x32).

    `repeat_count` pairs of steps, 0 without end. There are no ramps: the answer of the axis to a
    velocity step is what this is for. The override scales the velocities.
    """
    velocities = (velocity_1, velocity_2)
    code = check_generator(axis, *velocities)
    for velocity in velocities:
        if velocity != 0.0 or velocity_1 == velocity_2:
            code = code or check_velocity(axis, abs(velocity))
    if code:
        return code
    if start_type != StartType.ABSOLUTE:
        return NcError.START_TYPE
    if not (0.0 < move_time < 1e10 and 0.0 <= idle_time < 1e10):
        return NcError.START_AXIS_DATA
    own = dynamics(axis, 0.0, 0.0, 0.0)[1]
    twice = 2.0 * max(own, axis.fast_axis_stop_deceleration)
    first = axis.set.position + velocity_1 * move_time
    second = first + velocity_2 * move_time
    code = check_target(axis, first) or check_target(axis, second)
    for end, velocity in (
        (first, velocity_1),
        (second, velocity_2),
    ):  # stopped at the end of a step
        code = code or check_target(axis, end + velocity * abs(velocity) / twice)
    if code:
        return code
    begin_generator(axis, MotionPhase.VELOCITY_STEPS)
    axis.sequence.velocity_1, axis.sequence.velocity_2 = velocities
    axis.sequence.duration = max(move_time, axis.owner.cycle_ns * 1e-9)
    axis.sequence.pause = idle_time
    axis.sequence.rounds = repeat_count
    return OK


def start_sine_oscillation(
    axis: Axis,
    start_type: int,
    base_amplitude: float,
    base_frequency: float,
    start_amplitude: float,
    feed_constant: float,
    start_frequency: float,
    stop_frequency: float,
    step_duration: float,
    measurement_count: int,
    parallel_measurement_count: int,
) -> int:
    """Oscillate by a sine of the velocity, or by a sequence of frequencies (0x33).

    The base oscillation runs all the time. On top of it an oscillation of the start amplitude goes
    through `measurement_count` frequencies in equal ratios, `step_duration` seconds each; with
    start amplitude 0 there is the base alone.
    """
    code = check_generator(axis, 1.0, -1.0)
    if code:
        return code
    if start_type != StartType.ABSOLUTE:
        return NcError.START_TYPE
    cycle = axis.owner.cycle_ns * 1e-9
    highest = 0.5 / cycle * JUST_ABOVE
    if not (
        base_amplitude > 0.0
        and 0.0 <= base_frequency <= FASTEST_BASE
        and start_amplitude >= 0.0
        and feed_constant > 0.0
        and SLOWEST_START <= start_frequency <= highest
        and SLOWEST_START <= stop_frequency <= highest
        and cycle <= step_duration < 1e10
        and 1 <= measurement_count <= MOST_MEASUREMENTS
    ):
        return NcError.START_AXIS_DATA
    base, fast = 2.0 * pi * base_frequency, 2.0 * pi * max(start_frequency, stop_frequency)
    acceleration = base_amplitude * base + start_amplitude * fast
    if acceleration > axis.max_acceleration:
        return NcError.ACCELERATION_NOT_PERMITTED
    slow = 2.0 * pi * min(start_frequency, stop_frequency)
    way = (2.0 * base_amplitude / base if base else 0.0) + 2.0 * start_amplitude / slow
    code = check_velocity(axis, base_amplitude + start_amplitude)
    code = code or check_target(axis, axis.set.position + way)
    if code:
        return code
    begin_generator(axis, MotionPhase.SINE)
    axis.job.deceleration = max(axis.job.deceleration, acceleration)
    axis.job.jerk = max(axis.job.jerk, base_amplitude * base**2 + start_amplitude * fast**2)
    axis.profile.deceleration = axis.job.deceleration
    axis.profile.running_jerk = axis.profile.jerk_limit = axis.job.jerk
    axis.sine.base_velocity = base_amplitude
    axis.sine.base_frequency = base_frequency
    axis.sine.base_angle = 0.0
    axis.sine.velocity = start_amplitude
    axis.sine.frequency = start_frequency
    steps = measurement_count - 1
    axis.sine.frequency_ratio = (stop_frequency / start_frequency) ** (1.0 / steps) if steps else 1
    axis.sine.angle = 0.0
    axis.sine.share = min(axis.velocity_override, 1_000_000) / 1e6
    axis.sequence.duration = step_duration
    axis.sequence.rounds = measurement_count
    return OK
