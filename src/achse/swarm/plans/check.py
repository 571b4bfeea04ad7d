"""Check of a plan: its segments are integrated and compared with the command.

Nothing here is computed by the formulas of the planner: a segment of constant jerk is walked by the
means of its ends, extremes lie where acceleration or velocity are 0.

Kernel source, in the language of `achse.native`.
"""

from achse.codes.nc.choices import MotionPhase
from achse.motion.fields.setpoint import SEGMENTS
from achse.motion.record import AxisFields
from achse.motion.setpoints.dynamics import STEEPEST
from achse.motion.setpoints.planning import TO_CONSTANT_VELOCITY, TO_LIMIT, TO_PAUSE, TO_TARGET
from achse.native.declare import Slot, lay_out

VERDICTS = (
    "holds", "refused", "time", "jerk", "velocity", "acceleration", "reversal", "stop", "end",
    "target", "limit", "start", "set-point", "number",
)  # fmt: skip
"""Invariants of a plan by number; the first is that all hold."""

REFUSED, TIME, JERK, VELOCITY, ACCELERATION, REVERSAL, STOP, END = range(1, 9)
TARGET, LIMIT, START, SET_POINT, NUMBER = range(9, 14)

_MORE = 1.0 + 1e-9
_LEAST = 1e-99
_TOLERANCE = 1e-6
"""Of a soft limit, in axis units, as the manual position tolerance of the axis allows."""


class CheckedPlan:
    """Limits and target of a command, and the state in which it came."""

    p0: float = 0.0
    v0: float = 0.0
    a0: float = 0.0
    highest: float = 0.0
    """Velocity that the command allows, with override and velocity at its end."""
    passing: float = 0.0
    """Velocity at which the next command may begin."""
    fastest: float = 0.0
    """Largest velocity of axis and drive."""
    rise: float = 0.0
    fall: float = 0.0
    jerk: float = 0.0
    """Largest jerk that the plan may have: that of the command, or of a stop for a soft limit."""
    own_jerk: float = 0.0
    """Jerk of the command."""
    running: float = 0.0
    """Jerk by which the plan before would take away the acceleration that the axis has."""
    low: float = 0.0
    high: float = 0.0
    target: float = 0.0
    has_target: int = 0
    """True if the command ends at rest at `target`, whatever happens on the way."""
    last: float = 0.0
    """Target of the last command that waits."""
    begin: float = 0.0
    """Position where it begins."""
    heading: float = 1.0
    """Direction of its way."""
    p: float = 0.0
    v: float = 0.0
    a: float = 0.0
    """State that `walk` has found."""
    total: float = 0.0
    """Duration of all segments."""
    known: int = 0
    """True while the start of the plan at work is known."""
    at: float = 0.0
    """Time since the start of the plan."""


PLAN = lay_out("checked plan", (CheckedPlan,), Slot)


def _step(plan: CheckedPlan, t: float, j: float) -> None:
    """Walk `t` seconds of jerk `j`: mean acceleration, mean velocity, and the bow between."""
    b = plan.a + j * t
    if abs(b) <= 1e-11 * abs(plan.a):
        b = 0.0
    w = plan.v + 0.5 * (plan.a + b) * t
    plan.p += 0.5 * (plan.v + w) * t - j * t * t * t / 12.0
    plan.v = w
    plan.a = b


def walk(plan: CheckedPlan, ax: AxisFields, time: float) -> None:
    """Walk the segments for so long from the start of the plan; the last state goes on."""
    profile = ax.profile
    plan.p = plan.p0
    plan.v = plan.v0
    plan.a = plan.a0
    remaining = time
    i = 0
    while i < profile.count and remaining > 0.0:
        t = profile.time[i]
        _step(plan, t if t < remaining else remaining, profile.jerk[i])
        if remaining < t:
            remaining = 0.0
            break
        remaining -= t
        i += 1
    _note_running(plan, ax, i)
    if remaining > 0.0:
        if profile.end == TO_CONSTANT_VELOCITY:
            plan.p += remaining * plan.v
        elif profile.end_velocity == 0.0:
            plan.v = 0.0
        plan.a = 0.0


def _note_running(plan: CheckedPlan, ax: AxisFields, first: int) -> None:
    """Note the jerk of the first segment from there on that has one, else of the last segment."""
    profile = ax.profile
    if profile.count == 0:
        return
    i = first
    while i < profile.count - 1 and profile.jerk[i] == 0.0:
        i += 1
    plan.running = abs(profile.jerk[i if i < profile.count else profile.count - 1])


def lose(plan: CheckedPlan, ax: AxisFields) -> None:
    """Forget the plan: the axis follows one made within a walk, whose start is not known."""
    plan.known = 0
    _note_running(plan, ax, ax.profile.index)


def _stops(ax: AxisFields) -> bool:
    return ax.set_motion_phase == MotionPhase.STOPPING


def check(plan: CheckedPlan, ax: AxisFields) -> int:
    """Return the first invariant that the segments of the axis break, 0 if all hold."""
    profile = ax.profile
    count = profile.count
    if count < 0 or count > SEGMENTS:
        return REFUSED
    if profile.position != plan.p0 or profile.velocity != plan.v0:
        return START
    if profile.acceleration != plan.a0 or profile.index != 0:
        return START
    code = _check_segments(plan, ax)
    if code != 0:
        return code
    return _check_end(plan, ax)


def _check_segments(plan: CheckedPlan, ax: AxisFields) -> int:
    profile = ax.profile
    if profile.end == TO_TARGET and profile.end_velocity > plan.highest:
        plan.highest = profile.end_velocity  # by a last ramp
        if not profile.end_velocity <= plan.passing:
            return VELOCITY
    if ax.border.time >= 0.0:  # too near to the next command: it goes on as fast as it is
        plan.highest = max(plan.highest, min(plan.passing, abs(plan.v0)))
    plan.p = plan.p0
    plan.v = plan.v0
    plan.a = plan.a0
    plan.total = 0.0
    plan.at = 0.0
    plan.known = 1
    over = abs(plan.v0)
    if plan.a0 * plan.v0 >= 0.0 and plan.running > 0.0:  # what the acceleration still adds
        over += plan.a0 * plan.a0 / (2.0 * plan.running)
    rounding = (
        2e-7 * over + 1e-14 * plan.fastest
    )  # an acceleration that bends the velocity by less is rounding
    scale = over if over > plan.highest else plan.highest
    still = 1e-9 * scale + 1e-14 * plan.fastest
    most_velocity = scale + still
    inside = False
    slow = False
    high = (plan.high if plan.high > plan.p0 else plan.p0) + _TOLERANCE + 1e-11 * abs(plan.p0)
    low = (plan.low if plan.low < plan.p0 else plan.p0) - _TOLERANCE - 1e-11 * abs(plan.p0)
    bounded = ax.limits.reached == 0 and ax.limits.active == 1
    stops = _stops(ax)
    side = 0.0
    leaving = 0.0
    for i in range(profile.count):
        t = profile.time[i]
        j = profile.jerk[i]
        if not (t > 0.0 and t < 1e30):
            return TIME
        releases = i == 0 and plan.a0 * j < 0.0
        most = plan.running if releases and plan.running > plan.jerk else plan.jerk
        residue = releases and abs(plan.a0) <= 1e-12 * plan.rise
        if most < STEEPEST and not abs(j) <= most * _MORE and not residue:
            return JERK
        v = plan.v
        a = plan.a
        p = plan.p
        _step(plan, t, j)
        plan.total += t
        w = plan.v
        b = plan.a
        top = v if v > w else w
        bottom = v if v < w else w
        if a * j < 0.0 and b * a < 0.0:  # the acceleration is 0 within
            extreme = v - a * a / (2.0 * j)
            top = extreme if extreme > top else top
            bottom = extreme if extreme < bottom else bottom
        speed = top if top > -bottom else -bottom
        if not (speed <= most_velocity and speed <= plan.fastest * (1.0 + 1e-6)):
            return VELOCITY
        # once slow, never above what the command allows
        settled = over
        if i > 0:
            settled = abs(v) + (a * a / (2.0 * plan.own_jerk) if a * v > 0.0 else 0.0)
        if settled <= plan.highest * _MORE:
            slow = True
        if slow and not speed <= plan.highest + still:
            return VELOCITY
        if bottom < -still and top > still:
            return REVERSAL
        travel = 1.0 if top > -bottom else -1.0
        if speed > still:
            if side * travel < 0.0 and leaving * leaving > rounding * plan.jerk:
                return REVERSAL
            side = travel
        else:
            side = 0.0
        leaving = abs(b)
        grows = travel * a
        after = travel * b
        if speed > still:
            if inside or (-plan.fall * _MORE <= grows <= plan.rise * _MORE):
                inside = True
                if not (after <= plan.rise * _MORE and after >= -plan.fall * _MORE):
                    return ACCELERATION
            elif a * j > 0.0:
                return ACCELERATION
            added = stops and after > 0.0 and after > grows
            if added and after * after > rounding * plan.jerk:
                return STOP
        if bounded:
            far = plan.p if plan.p > p else p
            near = plan.p if plan.p < p else p
            if far > high or near < low:
                return LIMIT
    return 0


def _check_end(plan: CheckedPlan, ax: AxisFields) -> int:
    profile = ax.profile
    scale = plan.highest
    speed = abs(plan.v0)
    scale = speed if speed > scale else scale
    strongest = plan.rise if plan.rise > plan.fall else plan.fall
    size = abs(plan.a0)
    strongest = size if size > strongest else strongest
    total = plan.p + plan.v + plan.a + plan.total
    if total - total != 0.0:
        return NUMBER
    still = 1e-7 * scale + 1e-14 * plan.fastest
    residue = 1e-9 * strongest
    if abs(plan.a) > residue and plan.a * plan.a > 1e-13 * plan.jerk * (scale + plan.fastest):
        return END
    ends = profile.end
    if ends in (TO_TARGET, TO_LIMIT):
        way = abs(plan.p0) + abs(ax.border.position) + scale * plan.total
        if abs(plan.p - ax.border.position) > 1e-9 * way + _LEAST:
            return TARGET
        if abs(abs(plan.v) - profile.end_velocity) > still:
            return END
    elif abs(plan.v - profile.end_velocity) > still:
        return END
    if plan.has_target:
        if ends == TO_PAUSE and ax.limits.active:  # the ramp of the command is too weak
            return 0
        if ends not in (TO_TARGET, TO_LIMIT) or profile.end_velocity != 0.0:
            return TARGET
        size = abs(plan.p0) + abs(plan.target)
        if abs(ax.border.position - plan.target) > 1e-11 * size + _LEAST:
            return TARGET
    return 0
