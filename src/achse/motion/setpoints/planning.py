"""Planning: the table of constant-jerk segments that leads the active job on from here.

It is planned from the present set point, so every change of job, target or override is smooth in
position, velocity and acceleration. Once braking towards a target has begun, the override no longer
changes the table. Where it is too late for the velocity of a border, the axis brakes on and passes
the border as it comes.

A table that would lead across a soft limit ends at it. Where the ramp of the job is too weak for
that, the axis first comes to rest with the strongest ramp that it has; where that is too weak as
well, the limit is reported at once.

Kernel source, in the language of `achse.native`.
"""

from math import inf

from achse.codes.nc.choices import MotionPhase
from achse.motion.profiles.profile import (
    END_VELOCITY_UNREACHABLE,
    plan_to_position,
    plan_to_velocity,
    stopping_distance,
)
from achse.motion.profiles.ramps import reachable_velocity
from achse.motion.profiles.segments import (
    duration,
    segment_acceleration,
    segment_position,
    segment_velocity,
)
from achse.motion.record import AxisFields
from achse.motion.rounding import JUST_ABOVE, JUST_BELOW
from achse.motion.setpoints.dynamics import (
    STEEPEST,
    fastest,
    fault_deceleration,
    fault_jerk,
    release,
)
from achse.motion.setpoints.limits import goes_alone, highest_rest, lowest_rest, passes
from achse.motion.setpoints.targets import look_ahead, overrun

TO_REST = 0
TO_TARGET = 1
TO_CONSTANT_VELOCITY = 2
TO_LIMIT = 3
TO_PAUSE = 4
"""End of a profile, `MotionProfile.end`."""

_FULL_OVERRIDE = 1_000_000

_HALVINGS = 60
"""Of a row's duration, until the time within it is exact."""

_SLOWEST = 1e-6
"""Velocity that any override above zero leaves, whatever the job."""


def _peak_velocity(ax: AxisFields, v: float, a: float, count: int) -> float:
    """Largest speed in the table from (v, a), at the ends of its rows, up to the job's own."""
    peak = 0.0
    for i in range(count):
        t = ax.profile.time[i]
        j = ax.profile.jerk[i]
        v += t * (a + t * (0.5 * j))
        a += t * j
        if abs(v) > peak:
            peak = abs(v)
    return peak if 0.0 < peak < ax.job.velocity else ax.job.velocity


def _plan_to_target(ax: AxisFields, limit: float, end_velocity: float) -> int:
    """Rows of the table to the border, negative if there is no such table."""
    count = plan_to_position(
        ax.profile.time,
        ax.profile.jerk,
        ax.profile.plan_position,
        ax.profile.plan_velocity,
        ax.profile.plan_acceleration,
        ax.border.position,
        end_velocity,
        limit,
        ax.job.acceleration,
        ax.profile.deceleration,
        ax.profile.jerk_limit,
    )
    ax.profile.end_velocity = end_velocity
    return count


def _plan_to_border(ax: AxisFields, limit: float, end_velocity: float) -> int:
    """Rows to the border at `end_velocity`, or as near to it as the way allows.

    The way begins here or, as long as the axis still moves the other way, where it turns.
    """
    count = _plan_to_target(ax, limit, end_velocity)
    if count != END_VELOCITY_UNREACHABLE:
        return count
    way = ax.border.position - ax.profile.plan_position
    sign = 1.0 if way > 0.0 else -1.0
    v = sign * ax.profile.plan_velocity
    a = sign * ax.profile.plan_acceleration
    if v < 0.0:
        way -= sign * stopping_distance(v, a, ax.profile.deceleration, ax.profile.jerk_limit)
        v = 0.0
        a = 0.0
    reachable = JUST_BELOW * reachable_velocity(
        sign * way, v, a, ax.job.acceleration, ax.profile.jerk_limit
    )
    if 0.0 < reachable < end_velocity:
        return _plan_to_target(ax, limit, reachable)
    return count


def _way_back(ax: AxisFields, limit: float) -> float:
    """Time of a loop's second part, from beyond the target to it."""
    count = plan_to_position(
        ax.profile.time,
        ax.profile.jerk,
        ax.border.position,
        0.0,
        0.0,
        ax.target_position,
        0.0,
        limit,
        ax.job.acceleration,
        ax.profile.deceleration,
        ax.profile.jerk_limit,
    )
    return duration(ax.profile.time, count)


def _plan_to_speed(ax: AxisFields, velocity: float) -> int:
    """Rows of the table to a signed velocity."""
    ax.profile.end_velocity = velocity
    ax.profile.end = TO_CONSTANT_VELOCITY if velocity != 0.0 else TO_REST
    return plan_to_velocity(
        ax.profile.time,
        ax.profile.jerk,
        ax.profile.plan_velocity,
        ax.profile.plan_acceleration,
        velocity,
        ax.job.acceleration,
        ax.profile.deceleration,
        ax.profile.jerk_limit,
    )


def _time_to_border(ax: AxisFields, count: int) -> float:
    """Return the time when the profile or its end passes the border, -1 if it does not."""
    p = ax.set.position
    v = ax.set.velocity
    a = ax.set.acceleration
    direction = ax.job.direction
    begin = 0.0
    for i in range(count):
        step = ax.profile.time[i]
        j = ax.profile.jerk[i]
        after = segment_position(step, j, p, v, a)
        if (after - ax.border.position) * direction >= 0.0:
            low = 0.0
            high = step
            for _ in range(_HALVINGS):
                t = 0.5 * (low + high)
                if (segment_position(t, j, p, v, a) - ax.border.position) * direction < 0.0:
                    low = t
                else:
                    high = t
            return begin + high
        p = after
        v = segment_velocity(step, j, v, a)
        a = segment_acceleration(step, j, a)
        begin += step
    if ax.profile.end_velocity * direction > 0.0:
        return begin + (ax.border.position - p) / ax.profile.end_velocity
    return -1.0


def _is_past_border(ax: AxisFields) -> int:
    """Return 1 if the border to the next command was reached before planning, else 0."""
    if ax.border.velocity == 0.0 or ax.set.velocity * ax.job.direction <= 0.0:
        return 0
    if ax.loop.outward:  # on its way around the border
        return 0
    return 1 if (ax.set.position - ax.border.position) * ax.job.direction >= 0.0 else 0


def _find_limit(ax: AxisFields) -> int:
    """Put the border at the soft limit that the job leads to; 1 if it does, -1 if it is passed."""
    forth = ax.job.direction > 0.0
    limit = highest_rest(ax) if forth else lowest_rest(ax)
    if abs(limit) == inf or ax.job.direction == 0.0:
        return 0
    if ax.set_motion_phase == MotionPhase.POSITIONING:
        border = ax.border.position
        if (border <= limit) if forth else (border >= limit):
            return 0
    elif ax.set_motion_phase not in (MotionPhase.ENDLESS, MotionPhase.HOMING):
        return 0
    ax.border.position = limit
    ax.border.velocity = 0.0
    ax.loop.outward = 0
    return 1 if (limit - ax.set.position) * ax.job.direction > 0.0 else -1


def _put_release_before(ax: AxisFields, count: int, time: float) -> int:
    """Make room for the release in front of the rows; their number with it."""
    for n in range(count):
        i = count - n
        ax.profile.time[i] = ax.profile.time[i - 1]
        ax.profile.jerk[i] = ax.profile.jerk[i - 1]
    ax.profile.time[0] = time
    ax.profile.jerk[0] = (
        -ax.profile.running_jerk if ax.set.acceleration > 0.0 else ax.profile.running_jerk
    )
    return count + 1


def _fill(ax: AxisFields, limit: float, share: float, bounded: int) -> int:
    """Compute the segments of the profile; return their number, or an error below 0.

    The profile has its deceleration and its jerk limit.
    `limit` is the velocity, `share` the override, `bounded` whether the border is a soft limit.
    """
    phase = ax.set_motion_phase
    time = release(ax, ax.profile.jerk_limit)
    ax.border.time = -1.0
    ax.remaining_time = 0.0
    count = END_VELOCITY_UNREACHABLE
    back = 0.0
    velocity = ax.job.direction * limit
    if phase == MotionPhase.STOPPING or bounded < 0:
        limit = 0.0
        velocity = 0.0
    if limit > 0.0 and (phase == MotionPhase.POSITIONING or bounded > 0):
        if ax.loop.outward:
            back = _way_back(ax, limit)
        end_velocity = ax.border.velocity * share
        top = fastest(ax)
        if end_velocity > top:
            end_velocity = top
        count = _plan_to_border(ax, limit, end_velocity)
        ax.profile.end = TO_LIMIT if bounded else TO_TARGET
    blended = phase == MotionPhase.POSITIONING and ax.border.velocity > 0.0
    to_speed = count == END_VELOCITY_UNREACHABLE
    if to_speed:
        if phase == MotionPhase.POSITIONING and limit > 0.0:  # near the border, and too fast for it
            limit = ax.border.velocity * share
            if limit > abs(ax.profile.plan_velocity):
                limit = abs(ax.profile.plan_velocity)
            if limit < _SLOWEST:
                limit = _SLOWEST
            velocity = ax.job.direction * limit
        count = _plan_to_speed(ax, velocity)
    if count < 0:
        return count
    if time > 0.0:
        count = _put_release_before(ax, count, time)
        ax.profile.begins_with_release = 1
    else:
        ax.profile.begins_with_release = 0
    if to_speed and blended:
        ax.border.time = _time_to_border(ax, count)
    if phase == MotionPhase.POSITIONING:
        ax.remaining_time = duration(ax.profile.time, count) + back
    return count


def _holds_the_sum(ax: AxisFields) -> bool:
    """Return True if the remaining ramps stop main motion and compensation before a soft limit."""
    if ax.compensating == 0:
        return True
    v = ax.set.velocity + ax.superposed.set_velocity
    room = ax.limits.high - ax.set.position if v > 0.0 else ax.set.position - ax.limits.low
    return v * v <= 2.0 * room * fault_deceleration(ax)


def _fill_within_limits(ax: AxisFields, limit: float, share: float, bounded: int) -> int:
    """`_fill`, but where the ramp of the job would lead across a soft limit, a stop before it.

    The stop has the strongest ramp of the axis, and no jerk limit where there was none; from rest
    the job goes on with its own.
    """
    strongest = fault_deceleration(ax)
    steepest = fault_jerk(ax)
    p = ax.set.position
    v = ax.set.velocity
    a = ax.set.acceleration
    ax.profile.deceleration = ax.job.deceleration
    ax.profile.jerk_limit = ax.job.jerk
    if bounded >= 0:
        count = _fill(ax, limit, share, bounded)
        rests = v == 0.0 and a == 0.0
        if count < 0 or rests or (passes(ax, 0, count, p, v, a) == 0 and _holds_the_sum(ax)):
            return count
    ax.profile.deceleration = strongest
    ax.profile.jerk_limit = steepest
    count = _fill(ax, limit, share, -1)
    ax.limits.reached = passes(ax, 0, count, p, v, a)
    if ax.limits.reached and ax.profile.abrupt:
        steepest = STEEPEST
        ax.profile.jerk_limit = steepest
        count = _fill(ax, limit, share, -1)
        ax.limits.reached = passes(ax, 0, count, p, v, a)
    if bounded < 0:
        ax.limits.reached = 1 if ax.job.direction > 0.0 else -1
    elif ax.set_motion_phase == MotionPhase.STOPPING:  # and is never weakened again
        ax.job.deceleration = strongest
        ax.job.jerk = steepest
    elif share > 0.0:
        ax.profile.end = TO_PAUSE
    return count


def plan(ax: AxisFields) -> int:
    """Compute the table of the active job from the present set point; negative if there is none.

    Put off for the next command if this one is done.
    """
    if ax.set_motion_phase == MotionPhase.POSITIONING:
        look_ahead(ax)
        if _is_past_border(ax):
            ax.border.time = 0.0
            return 0
    ax.profile.replan = 0
    if ax.set.acceleration == 0.0:
        ax.profile.running_jerk = 0.0
    elif ax.profile.begins_with_release and ax.profile.index > 0:
        ax.profile.running_jerk = ax.profile.jerk_limit
    override = ax.velocity_override
    ax.profile.override = override
    if override > _FULL_OVERRIDE:
        override = _FULL_OVERRIDE
    if override < 0:
        override = 0
    share = override / 1e6
    phase = ax.set_motion_phase
    ax.profile.fastest = fastest(ax)
    commanded = ax.job.velocity
    if commanded > ax.profile.fastest:
        commanded = ax.profile.fastest
    limit = commanded * share
    bounded = 0
    limited = ax.limits.active == 1 and goes_alone(ax)
    if phase == MotionPhase.POSITIONING:
        overrun(ax)
        ax.job.direction = 1.0 if ax.border.position >= ax.set.position else -1.0
    if limited:
        bounded = _find_limit(ax)
    if phase == MotionPhase.POSITIONING and ax.override_type % 2 == 1 and override < _FULL_OVERRIDE:
        if ax.job.peak_velocity == 0.0:
            strongest = ax.profile.deceleration
            steepest = ax.profile.jerk_limit
            ax.profile.deceleration = ax.job.deceleration
            ax.profile.jerk_limit = ax.job.jerk
            release(ax, ax.job.jerk)
            count = _plan_to_border(ax, commanded, ax.border.velocity)
            ax.job.peak_velocity = _peak_velocity(
                ax, ax.profile.plan_velocity, ax.profile.plan_acceleration, count
            )
            ax.profile.deceleration = strongest
            ax.profile.jerk_limit = steepest
        if ax.job.peak_velocity < commanded:
            limit = ax.job.peak_velocity * share
    if limit < _SLOWEST:
        limit = _SLOWEST
    if override == 0 and not _braking(ax, ax.job.deceleration, ax.job.jerk):
        limit = 0.0
    if limited:
        count = _fill_within_limits(ax, limit, share, bounded)
    else:
        ax.profile.deceleration = ax.job.deceleration
        ax.profile.jerk_limit = ax.job.jerk
        count = _fill(ax, limit, share, 0)
    if count < 0:
        return count
    pauses = ax.profile.end == TO_PAUSE  # the move to the target is planned behind the pause
    if phase == MotionPhase.POSITIONING and ax.job.peak_velocity == 0.0 and not pauses:
        ax.job.peak_velocity = _peak_velocity(ax, ax.set.velocity, ax.set.acceleration, count)
    ax.profile.abrupt = 0
    if ax.profile.begins_with_release == 0:
        ax.profile.running_jerk = ax.profile.jerk_limit
    ax.profile.count = count
    ax.profile.index = 0
    ax.profile.elapsed = 0.0
    ax.profile.position = ax.set.position
    ax.profile.velocity = ax.set.velocity
    ax.profile.acceleration = ax.set.acceleration
    return count


def _braking(ax: AxisFields, deceleration: float, jerk: float) -> int:
    """Return 1 if a positioning to standstill is in its last ramp, with this deceleration."""
    if ax.set_motion_phase != MotionPhase.POSITIONING or ax.border.velocity > 0.0:
        return 0
    way = ax.border.position - ax.set.position
    if way * ax.set.velocity <= 0.0:
        return 0
    way = abs(way)
    v = ax.set.velocity
    a = ax.set.acceleration
    brake = abs(stopping_distance(v, a, deceleration, jerk))
    return 1 if way * JUST_BELOW <= brake <= way * JUST_ABOVE + 1e-9 else 0


def follow_override(ax: AxisFields) -> None:
    """Ask for a new table after a change of the override, unless braking has begun."""
    phase = ax.set_motion_phase
    if phase in (MotionPhase.ENDLESS, MotionPhase.HOMING) or (
        phase == MotionPhase.POSITIONING
        and not _braking(ax, ax.profile.deceleration, ax.profile.jerk_limit)
    ):
        ax.profile.replan = 1
    else:
        ax.profile.override = ax.velocity_override
