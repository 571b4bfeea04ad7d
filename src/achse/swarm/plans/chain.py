"""Chains of commands: an axis is drawn, then each command comes at any moment of the one before.

Kernel source, in the language of `achse.native`.
"""

from math import floor, sqrt

from achse.codes.axis import BufferMode, StartType
from achse.codes.nc.choices import MotionPhase
from achse.motion.fields.setpoint import COMMAND_BUFFER
from achse.motion.profiles.profile import stopping_distance
from achse.motion.record import AxisFields, JobFields
from achse.motion.setpoints.dynamics import STEEPEST, fastest, fault_deceleration, fault_jerk
from achse.motion.setpoints.jobs import set_request
from achse.motion.setpoints.limits import adapt_limits
from achse.motion.setpoints.planning import follow_override
from achse.motion.setpoints.setpoint import begin_job, begin_stop, drop_job
from achse.motion.setpoints.targets import look_ahead
from achse.swarm.plans.check import CheckedPlan
from achse.swarm.plans.numbers import Draws, chance, decades, draw, one_of, uniform

_FULL = 1_000_000
_SLOWEST = 1e-6

_MODES = (
    BufferMode.BUFFERED.value,
    BufferMode.BLENDING_LOW.value,
    BufferMode.BLENDING_PREVIOUS.value,
    BufferMode.BLENDING_NEXT.value,
    BufferMode.BLENDING_HIGH.value,
)

_MODULO = (
    StartType.MODULO.value,
    StartType.MODULO_SHORTEST.value,
    StartType.MODULO_POSITIVE.value,
    StartType.MODULO_NEGATIVE.value,
)


def draw_axis(ax: AxisFields, draws: Draws) -> None:
    """Draw dynamics over decades, limits, modulo, and a state in motion or at rest."""
    wide = chance(draws, 0.1)
    top = decades(draws, -3.0, 6.0) if wide else decades(draws, 0.0, 3.3)
    rise = top * (decades(draws, -2.0, 3.0) if wide else decades(draws, 0.0, 2.0))
    fall = rise
    if chance(draws, 0.5):
        fall = rise * decades(draws, -0.5, 0.5)
    strongest = rise if rise > fall else fall
    jerk = strongest * (decades(draws, -1.0, 5.0) if wide else decades(draws, 0.0, 3.0))
    jerk = jerk if jerk < STEEPEST else STEEPEST
    ax.max_velocity = top
    ax.drive.reference_velocity = top * (1.1 if chance(draws, 0.9) else uniform(draws, 0.5, 1.0))
    ax.max_acceleration = rise
    ax.max_deceleration = fall
    ax.default_acceleration = rise
    ax.default_deceleration = fall
    ax.default_jerk = jerk
    ax.fast_axis_stop_deceleration = 0.0
    ax.fast_axis_stop_jerk = 0.0
    ax.override_type = 1 + one_of(draws, 4)
    ax.velocity_override = _FULL
    ax.encoder.modulo_factor = top * decades(draws, -1.0, 1.0)
    ax.encoder.modulo_tolerance_window = 0.0
    if chance(draws, 0.3):
        ax.encoder.modulo_tolerance_window = uniform(draws, 0.0, 0.2) * ax.encoder.modulo_factor
    ax.loop_enable = int(chance(draws, 0.05))
    ax.loop_distance = top * uniform(draws, -0.2, 0.2)
    place = 0.0
    if chance(draws, 0.3):
        place = top * uniform(draws, -100.0, 100.0)
    drop_job(ax)
    ax.buffer.first = 0
    ax.set.position = place
    ax.error_code = 0
    ax.command_counter = 0
    ax.border.velocity = 0.0
    ax.profile.begins_with_release = 0
    ax.profile.abrupt = 0
    ax.profile.replan = 0
    ax.profile.running_jerk = 0.0
    ax.profile.deceleration = 0.0
    ax.profile.jerk_limit = 0.0
    ax.profile.elapsed = 0.0
    ax.profile.end = 0
    ax.profile.end_velocity = 0.0
    ax.profile.override = _FULL
    ax.job.deceleration = fall
    ax.job.acceleration = rise
    ax.job.velocity = top
    ax.job.jerk = jerk
    ax.job.end_velocity = 0.0
    ax.job.direction = 0.0
    _draw_limits(ax, draws, 0.3)
    if chance(draws, 0.6):
        _draw_state(ax, draws, jerk)


def _draw_limits(ax: AxisFields, draws: Draws, share: float) -> None:
    """Draw soft limits around the place of the axis, or none."""
    ax.encoder.soft_limit_min_enable = 0
    ax.encoder.soft_limit_max_enable = 0
    if chance(draws, share):
        window = ax.max_velocity * decades(draws, -1.0, 1.5)
        part = draw(draws)
        ax.encoder.soft_limit_min = ax.set.position - part * window
        ax.encoder.soft_limit_max = ax.set.position + (1.0 - part) * window
        ax.encoder.soft_limit_min_enable = 1
        ax.encoder.soft_limit_max_enable = 1
    adapt_limits(ax)
    ax.limits.recheck = 0
    ax.limits.reached = 0


def _draw_state(ax: AxisFields, draws: Draws, jerk: float) -> None:
    """Let the axis move, by an acceleration that its jerk can take away within the limits."""
    top = fastest(ax)
    v = top * uniform(draws, -1.0, 1.0)
    if chance(draws, 0.2):
        v = top if v > 0.0 else -top
    a = 0.0
    if chance(draws, 0.7):
        away = v if chance(draws, 0.5) else -v
        room = top - abs(v) if away == v else abs(v)
        limit = ax.max_acceleration if away == v else ax.max_deceleration
        size = sqrt(2.0 * jerk * room) * (1.0 - 1e-9)
        size = size if size < limit else limit
        a = size * (draw(draws) if chance(draws, 0.8) else 1.0)
        a = a if away > 0.0 else -a
    ax.set.velocity = v
    ax.set.acceleration = a
    ax.set_motion_phase = MotionPhase.ENDLESS
    ax.job.direction = 1.0 if v > 0.0 else -1.0
    ax.profile.running_jerk = jerk if a != 0.0 else 0.0


def _sign(value: float) -> float:
    return 1.0 if value > 0.0 else -1.0 if value < 0.0 else 0.0


def _part(draws: Draws) -> float:
    """Return a part of a limit: all of it, or less by decades."""
    return 1.0 if chance(draws, 0.5) else decades(draws, -1.5, 0.0)


def _target(ax: AxisFields, draws: Draws, plan: CheckedPlan) -> float:
    """Draw a target: by decades, here, or next to where the axis would come to rest."""
    kind = draw(draws)
    here = ax.set.position
    if kind < 0.6:
        way = ax.max_velocity * decades(draws, -5.0, 2.0)
        target = here + (way if chance(draws, 0.5) else -way)
    elif kind < 0.95:
        ramp = stopping_distance(
            ax.set.velocity, ax.set.acceleration, ax.job.deceleration, ax.job.jerk
        )
        target = here + ramp * (1.0 + (draw(draws) - 0.5) * decades(draws, -14.0, 0.5))
    else:
        target = here
    if target > plan.high:
        target = plan.high
    if target < plan.low:
        target = plan.low
    return target


def command(ax: AxisFields, draws: Draws, plan: CheckedPlan) -> None:
    """Give the axis the next command; `plan` gets its target, if it has one."""
    kind = draw(draws)
    plan.low = ax.limits.low
    plan.high = ax.limits.high
    plan.has_target = 0
    if ax.limits.reached != 0:
        ax.limits.reached = 0
        drop_job(ax)
    if kind < 0.08 and ax.set_motion_phase != MotionPhase.NONE:
        fall = ax.max_deceleration * _part(draws)
        jerk = ax.default_jerk * _part(draws)
        if ax.set_motion_phase == MotionPhase.STOPPING:
            fall = fall if fall > ax.job.deceleration else ax.job.deceleration
            jerk = jerk if jerk > ax.job.jerk else ax.job.jerk
        begin_stop(ax, fall, jerk)
    elif kind < 0.2 and ax.set_motion_phase in (MotionPhase.POSITIONING, MotionPhase.ENDLESS):
        _disturb(ax, draws, plan)
    else:
        _start(ax, draws, plan)
    if ax.profile.replan == 0 and ax.velocity_override != ax.profile.override:
        follow_override(ax)


def _disturb(ax: AxisFields, draws: Draws, plan: CheckedPlan) -> None:
    """Change what holds for the command at work: override, soft limits, maximum velocity."""
    kind = draw(draws)
    if kind < 0.7:
        ax.velocity_override = int(_FULL * draw(draws)) if chance(draws, 0.8) else 0
        return
    if kind < 0.9:
        _draw_limits(ax, draws, 0.7)
        plan.low = ax.limits.low
        plan.high = ax.limits.high
        ax.profile.replan = 1
    else:
        ax.job.velocity *= uniform(draws, 0.1, 1.0)
        ax.job.peak_velocity = 0.0
        ax.profile.replan = 1


def _start(ax: AxisFields, draws: Draws, plan: CheckedPlan) -> None:
    if chance(draws, 0.7):
        ax.velocity_override = _FULL
    ax.command_counter = ax.command_counter + 1 & 0xFFFF
    velocity = fastest(ax) * _part(draws)
    rise = ax.max_acceleration * _part(draws)
    fall = ax.max_deceleration * _part(draws)
    jerk = ax.default_jerk * _part(draws)
    if chance(draws, 0.03):
        jerk = 1e30
    if (
        ax.set_motion_phase == MotionPhase.POSITIONING
        and ax.buffer.count < COMMAND_BUFFER
        and chance(draws, 0.3)
    ):
        _queue(ax, draws, plan, velocity, rise, fall, jerk)
        return
    ax.buffer.count = 0
    ax.job.deceleration = fall
    ax.job.jerk = jerk
    kind = draw(draws)
    start_type = int(StartType.ABSOLUTE)
    position = _target(ax, draws, plan)
    target = position
    if kind < 0.1:
        start_type = int(StartType.ENDLESS_POSITIVE)
    elif kind < 0.2:
        start_type = int(StartType.ENDLESS_NEGATIVE)
    elif kind < 0.35:
        way = target - ax.set.position
        if plan.low <= ax.set.position + way <= plan.high:  # else a command refuses it
            start_type = int(StartType.RELATIVE)
            position = way
    elif kind < 0.5 and ax.limits.active == 0:
        start_type = _MODULO[one_of(draws, 4)]
        position = ax.encoder.modulo_factor * draw(draws)
        if start_type == StartType.MODULO:
            position += ax.encoder.modulo_factor * one_of(draws, 3)
            position = position if chance(draws, 0.5) else -position
        target = _modulo_target(ax, start_type, position)
    end_velocity = 0.0
    if chance(draws, 0.05) and ax.limits.active == 0:
        end_velocity = velocity * draw(draws)
    set_request(
        ax.job, ax.command_counter, start_type, position, velocity, rise, fall, jerk, end_velocity
    )
    begin_job(ax)
    plan.target = target
    plan.last = ax.target_position
    plan.begin = ax.set.position
    plan.heading = _sign(ax.target_position - ax.set.position)
    plan.has_target = int(
        ax.set_motion_phase == MotionPhase.POSITIONING
        and ax.loop_enable == 0
        and ax.velocity_override > 0
    )


def _queue(
    ax: AxisFields,
    draws: Draws,
    plan: CheckedPlan,
    velocity: float,
    rise: float,
    fall: float,
    jerk: float,
) -> None:
    """Let a command wait behind the others, as `commands.starts` does with one it has checked."""
    mode = _MODES[one_of(draws, 5)]
    way = ax.max_velocity * decades(draws, -4.0, 1.0)
    heading = plan.heading
    if mode == BufferMode.BUFFERED and (chance(draws, 0.5) or heading == 0.0):
        heading = 1.0 if heading <= 0.0 else -1.0
    target = plan.last + heading * way
    if target > plan.high:
        target = plan.high
    if target < plan.low:
        target = plan.low
    if mode != BufferMode.BUFFERED and (target - plan.last) * heading <= 0.0:
        return
    job = ax.waiting[(ax.buffer.first + ax.buffer.count) % COMMAND_BUFFER]
    set_request(
        job, ax.command_counter, StartType.ABSOLUTE, target, velocity, rise, fall, jerk, 0.0
    )
    job.mode = mode
    if mode != BufferMode.BUFFERED and chance(draws, 0.3):
        job.blending_position = plan.last - heading * draw(draws) * abs(plan.last - plan.begin)
    if mode != BufferMode.BUFFERED and chance(draws, 0.2):
        job.start_velocity = velocity * draw(draws)
    plan.heading = _sign(target - plan.last)
    plan.begin = plan.last
    plan.last = target
    ax.buffer.count += 1
    border = ax.border.position
    speed = ax.border.velocity
    look_ahead(ax)
    if border != ax.border.position or speed != ax.border.velocity:
        ax.job.peak_velocity = 0.0
        ax.profile.replan = 1


def _modulo_target(ax: AxisFields, start_type: int, position: float) -> float:
    """Return the target of a modulo start: the first place of its kind in its direction."""
    period = ax.encoder.modulo_factor
    here = ax.set.position
    turns = 0.0
    if start_type == StartType.MODULO:
        turns = floor(abs(position) / period) * period
    part = abs(position) if start_type == StartType.MODULO and position < 0.0 else position
    if start_type == StartType.MODULO and position < 0.0:
        part = -part
    ahead = (part - here) - floor((part - here) / period) * period
    behind = ahead - period if ahead > 0.0 else 0.0
    if start_type == StartType.MODULO:
        if position >= 0.0:
            return here + ahead + turns
        back = (here + position) - floor((here + position) / period) * period
        return here - back - turns
    if start_type == StartType.MODULO_SHORTEST:
        return here + (behind if ahead > 0.5 * period else ahead)
    window = ax.encoder.modulo_tolerance_window
    if start_type == StartType.MODULO_POSITIVE:
        return here + (behind if -behind <= window and behind < 0.0 else ahead)
    if ahead <= window:
        return here + ahead
    return here + behind


def expect(ax: AxisFields, plan: CheckedPlan) -> None:
    """Note what the command allows, before it is planned, or of a table that was just begun."""
    job = ax.job
    if ax.profile.replan:
        plan.p0 = ax.set.position
        plan.v0 = ax.set.velocity
        plan.a0 = ax.set.acceleration
    else:
        plan.p0 = ax.profile.position
        plan.v0 = ax.profile.velocity
        plan.a0 = ax.profile.acceleration
    if ax.buffer.count or job.end_velocity > 0.0:
        plan.has_target = 0
    plan.fastest = fastest(ax)
    plan.rise = job.acceleration
    plan.fall = job.deceleration
    if plan.a0 == 0.0:
        plan.running = 0.0
    if plan.running > STEEPEST:
        plan.running = STEEPEST
    plan.jerk = job.jerk
    plan.own_jerk = min(job.jerk, STEEPEST)
    if ax.limits.active:
        strongest = fault_deceleration(ax)
        plan.fall = strongest if strongest > plan.fall else plan.fall
        steepest = fault_jerk(ax)
        plan.jerk = steepest if steepest > plan.jerk else plan.jerk
    override = ax.velocity_override
    override = override if override < _FULL else _FULL
    highest = job.velocity if job.velocity < plan.fastest else plan.fastest
    highest = highest * (override / 1e6)
    plan.highest = highest if highest > _SLOWEST else _SLOWEST
    plan.passing = job.end_velocity
    if ax.buffer.count:
        plan.passing = _passing(ax.job.velocity, ax.job.end_velocity, ax.waiting[ax.buffer.first])
    if plan.passing > plan.fastest:
        plan.passing = plan.fastest
    if ax.set_motion_phase == MotionPhase.STOPPING:
        plan.highest = 0.0


def _passing(before: float, end_velocity: float, job: JobFields) -> float:
    """Return the velocity at which a waiting command wants its border passed, at most."""
    if job.start_velocity > 0.0:
        return job.start_velocity
    if end_velocity > 0.0:
        return end_velocity
    if job.mode == BufferMode.BUFFERED:
        return 0.0
    if job.mode == BufferMode.BLENDING_PREVIOUS:
        return before
    if job.mode == BufferMode.BLENDING_NEXT:
        return job.velocity
    if job.mode == BufferMode.BLENDING_LOW:
        return min(before, job.velocity)
    return max(before, job.velocity)
