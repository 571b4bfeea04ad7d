"""Targets: where a start leads, and how fast the axis may pass the border to the next command.

The border between two commands is the target of the first, or the blending position of the second
before it. The second says how fast it is passed: at rest if it is just buffered, at the velocity of
the one or the other command if it is blended, or at the segment velocity given for that very place.
No border is passed faster than the commands behind it can brake.

Kernel source, in the language of `achse.native`.
"""

from math import floor, inf

from achse.codes.axis import BufferMode, StartType
from achse.motion.fields.setpoint import COMMAND_BUFFER
from achse.motion.profiles.ramps import highest_velocity
from achse.motion.record import AxisFields, JobFields
from achse.motion.setpoints.limits import highest_rest, lowest_rest

_FAR = 1e15
"""Way of an endless command: farther than any axis goes."""


def modulo_part(position: float, period: float) -> float:
    """Return the position within its period: 0 <= part < period."""
    part = position - floor(position / period) * period
    if part < 0.0 or part >= period:
        return 0.0
    return part


def resolve_target(ax: AxisFields, start_type: int, position: float, start: float) -> float:
    """Return the absolute target of a start from `start`.

    Type 5 (old form): the sign gives the direction, whole periods in the value are extra turns.
    Types 517 and 773 go straight back when the target is behind within the tolerance window.
    """
    encoder = ax.encoder
    if start_type == StartType.RELATIVE:
        return start + position
    period = encoder.modulo_factor
    if start_type == StartType.MODULO:
        turns = floor(abs(position) / period) * period
        if position < 0.0:
            return start - modulo_part(start + position, period) - turns
        return start + modulo_part(position - start, period) + turns
    if start_type == StartType.MODULO_SHORTEST:
        way = modulo_part(position - start, period)
        if way > 0.5 * period:
            way -= period
        return start + way
    if start_type == StartType.MODULO_POSITIVE:
        way = modulo_part(position - start, period)
        if period - way <= encoder.modulo_tolerance_window:
            way -= period
        return start + way
    if start_type == StartType.MODULO_NEGATIVE:
        way = modulo_part(start - position, period)
        if period - way <= encoder.modulo_tolerance_window:
            way -= period
        return start - way
    return position


def _wanted_velocity(job: JobFields, before: float, end: float) -> float:
    """Return the velocity at which a waiting command wants the border to it passed.

    The command before it has the velocity `before` and the segment end velocity `end`.
    """
    if job.start_velocity > 0.0:
        return job.start_velocity
    if end > 0.0:
        return end
    own = job.velocity
    mode = job.mode
    if mode == BufferMode.BLENDING_PREVIOUS:
        return before
    if mode == BufferMode.BLENDING_NEXT:
        return own
    if mode == BufferMode.BLENDING_LOW:
        return own if own < before else before
    if mode == BufferMode.BLENDING_HIGH:
        return own if own > before else before
    return 0.0


def _end_of_endless(
    ax: AxisFields, here: float, forth: bool, velocity: float
) -> tuple[float, float]:
    """Return the farthest end of an endless command from `here`, and its velocity there.

    That is a soft limit, at rest; without one far away.
    """
    if forth:
        limit = highest_rest(ax)
        if limit < inf:
            return (limit if limit > here else here), 0.0
        return here + _FAR, velocity
    limit = lowest_rest(ax)
    if limit > -inf:
        return (limit if limit < here else here), 0.0
    return here - _FAR, velocity


def look_ahead(ax: AxisFields) -> None:
    """Compute where the active job, a positioning, ends and how fast it may be there at most.

    `border.position` is its target unless the next command blends earlier, `border.velocity` its
    segment end velocity unless a next command follows. Forwards through the waiting commands for
    their ways and velocities at their starts; then backwards for what can be braked.
    """
    here = ax.set.position
    target = ax.target_position
    direction = ax.job.direction
    before = ax.job.velocity
    end_velocity = ax.job.end_velocity
    ax.border.position = target
    border = target
    count = ax.buffer.count
    for n in range(count):
        job = ax.waiting[(ax.buffer.first + n) % COMMAND_BUFFER]
        blending = job.blending_position
        if (blending - here) * direction > 0.0 and (border - blending) * direction > 0.0:
            border = blending
        if n == 0:
            ax.border.position = border
        else:
            ax.waiting[(ax.buffer.first + n - 1) % COMMAND_BUFFER].way = abs(border - here)
        here = border
        job.border_velocity = _wanted_velocity(job, before, end_velocity)
        before = job.velocity
        end_velocity = job.end_velocity
        start_type = job.start_type
        if start_type in (StartType.ENDLESS_POSITIVE, StartType.ENDLESS_NEGATIVE):
            forth = start_type == StartType.ENDLESS_POSITIVE
            border, end_velocity = _end_of_endless(ax, here, forth, before)
        elif start_type == StartType.HALT:
            forth = direction > 0.0
            border, end_velocity = _end_of_endless(ax, here, forth, 0.0)
        else:
            target = resolve_target(ax, start_type, job.position, target)
            border = target
            forth = border > here
        job.way = abs(border - here)
        if forth != (direction > 0.0):
            job.border_velocity = 0.0
            direction = -direction
    velocity = end_velocity
    if velocity > 0.0:  # goes on beyond the last border, but not across a soft limit
        end, slow = _end_of_endless(ax, border, direction > 0.0, velocity)
        if slow == 0.0:
            last = ax.job
            if count > 0:
                last = ax.waiting[(ax.buffer.first + count - 1) % COMMAND_BUFFER]
            way = (end - border) * direction
            highest = 0.0
            if way > 0.0:
                highest = highest_velocity(way, 0.0, last.deceleration, last.jerk)
            if velocity > highest:
                velocity = highest
    for back in range(count):
        job = ax.waiting[(ax.buffer.first + count - 1 - back) % COMMAND_BUFFER]
        highest = highest_velocity(job.way, velocity, job.deceleration, job.jerk)
        velocity = job.border_velocity
        if velocity > highest:
            velocity = highest
    ax.border.velocity = velocity
    if velocity == 0.0:
        ax.border.position = ax.target_position


def overrun(ax: AxisFields) -> None:
    """Loop movement: a target ahead in the direction of the loop distance is passed by it first.

    So targets are always reached from the same side. A new target is decided again; switched off
    meanwhile, the axis goes straight to its target.
    """
    if ax.loop_enable == 0:
        ax.loop.outward = 0
        return
    if ax.loop.undecided or ax.target_position != ax.loop.target:
        ax.loop.undecided = 0
        ax.loop.target = ax.target_position
        way = ax.target_position - ax.set.position
        ax.loop.outward = 1 if way * ax.loop_distance > 0.0 else 0
    if ax.loop.outward:
        ax.border.position = ax.target_position + ax.loop_distance
        ax.border.velocity = 0.0
