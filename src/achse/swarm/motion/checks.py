"""Invariants of motion: functions that find a set point wrong, from one cycle to the next.

Each gets what was seen of an axis, and returns True if its invariant does not hold.

Kernel source, in the language of `achse.native`.
"""

from achse.codes.nc.choices import MotionPhase
from achse.swarm.motion.step import MotionStep

_MORE = 1.0 + 1e-6
"""Rounding of the planner and of the bound."""

_MORE_ON_A_PATH = 1.0 + 1e-4
"""Rounding of a path: that of `tests/motion/path/test_random_paths.py`."""

_LEAST = 1e-9
"""Rounding of a velocity or acceleration near 0, in axis units."""

_PLACED = (0, 1, 10, 11, 13)
"""Laws that have invariants of their own: none, gear, and cams."""

_JUMPING = (1, 2, 3, 5, 6, 16)
"""Laws whose velocity jumps to that of a new ratio: gear, saws, bi-linear."""


def _finite(step: MotionStep) -> bool:
    """Return True if the set point is not a number."""
    total = step.p1 + step.v1 + step.a1
    return total - total != 0.0


def _velocity(step: MotionStep) -> bool:
    """Return True beyond the maximum velocity."""
    if not step.smooth or step.beyond or step.coupled:
        return False
    more = _MORE_ON_A_PATH if step.grouped else _MORE
    limit = (step.top + step.swing) * more
    return not (-limit <= step.v1 <= limit)


def _acceleration(step: MotionStep) -> bool:
    """Return True beyond the largest acceleration.

    Left over from before a change of direction it may be more, while it is brought down.
    """
    if not step.smooth or step.beyond or step.coupled or step.bent:
        return False
    a1 = step.a1
    if step.grouped:
        strongest = max(step.rise, step.fall) * _MORE_ON_A_PATH
        return not (abs(a1) <= strongest)
    if abs(step.v1) <= 1e-6 * step.top or abs(a1) < abs(step.a0):
        return False
    limit = step.rise if a1 * step.v1 > 0.0 else step.fall
    return not (abs(a1) <= limit * _MORE)


def _jerk_limit(step: MotionStep) -> bool:
    """Return True if acceleration or velocity change by more than the jerk."""
    if not step.smooth or step.bent or step.abrupt:
        return False
    if step.was_superposed and step.at_limit:  # the limit goes before the jerk (decision 0218)
        return False
    if step.grouped:
        return _jerk_on_path(step)
    change = abs(step.a1 - step.a0)
    limit = step.jerk * step.dt * _MORE + _LEAST
    if change > limit:
        return True
    bend = abs(step.v1 - step.v0 - 0.5 * (step.a0 + step.a1) * step.dt)
    return bend > step.jerk * step.dt * step.dt / 4.0 * _MORE + _LEAST


def _jerk_on_path(step: MotionStep) -> bool:
    """Return True beyond the jerk; only a group that keeps it has a limit in bends (0123)."""
    if not step.keep_jerk or step.phase != step.phase0:
        return False
    limit = step.jerk * step.dt * _MORE_ON_A_PATH + 1e-6
    return abs(step.a1 - step.a0) > limit


def _position(step: MotionStep) -> bool:
    """Return True if an axis goes another way than its velocity says."""
    if not step.smooth or (step.coupled and step.law != 1) or step.gear != step.gear0:
        return False
    if step.bumpy:
        return False
    dt = step.dt
    way = abs(step.p1 - step.p0 - step.shift - 0.5 * (step.v0 + step.v1) * dt)
    if step.bent or step.abrupt or step.grouped or (step.was_superposed and step.at_limit):
        allowed = (abs(step.a0) + abs(step.a1) + step.rise + step.fall) * dt * dt
    else:
        allowed = step.jerk * dt * dt * dt / 12.0 * _MORE
    if step.coupled:  # its master may have accelerated anywhere in the cycle (decision 0186)
        allowed += 0.5 * abs(step.v1 - step.v0) * dt + step.pulled_jerk * dt * dt * dt / 12.0
    allowed += 1e-12 * (abs(step.p1) + abs(step.shift)) + 1e-9
    return way > allowed


def _coupled_way(step: MotionStep) -> bool:
    """Return True if a slave of another law goes a way that its velocity does not say."""
    if not step.coupled or step.law in _PLACED or not step.smooth or step.bumpy:
        return False
    if step.gear != step.gear0:  # the first cycle of a law, or of its parameters
        return False
    if step.over_master:
        return False
    dt = step.dt
    strength = abs(step.a0) + abs(step.a1) + step.rise + step.fall
    bend = abs(step.v1 - step.v0)
    if bend > strength * dt * _MORE + step.pull + _LEAST:
        return True
    way = abs(step.p1 - step.p0 - step.shift - 0.5 * (step.v0 + step.v1) * dt)
    allowed = 0.5 * bend * dt + strength * dt * dt + step.hidden
    allowed += 1e-12 * abs(step.p1) + 1e-9
    return way > allowed


def _new_ratio(step: MotionStep) -> bool:
    """Return True if a new ratio makes a slave faster than axis and drive may be."""
    if not step.coupled or step.law not in _JUMPING or not step.smooth or step.bent:
        return False
    if step.gear0 != step.gear0 or step.gear == step.gear0 or step.gear != step.gear:
        return False
    limit = max(abs(step.v0), step.speed) * _MORE + _LEAST
    limit += 2.0 * max(abs(step.a0), abs(step.a1)) * step.dt
    return not (abs(step.v1) <= limit)


def _stop(step: MotionStep) -> bool:
    """Return True if a stop adds acceleration."""
    stopping = MotionPhase.STOPPING
    if step.phase != stopping or step.phase0 != stopping or not step.smooth:
        return False
    if step.bent or step.coupled or step.v0 * step.v1 <= 0.0:
        return False
    sign = 1.0 if step.v1 > 0.0 else -1.0
    return step.a1 * sign > max(step.a0 * sign, 0.0) + _LEAST


def _rest(step: MotionStep) -> bool:
    """Return True if an axis without a motion leaves its set point."""
    if step.phase or step.phase0 or step.commanded or not step.smooth:
        return False
    if step.bent or step.coupled:
        return False
    moved = abs(step.p1 - step.p0 - step.shift)
    return step.v1 != 0.0 or not (moved <= 1e-14 * (abs(step.p1) + abs(step.zero)))


def _slave_step(step: MotionStep) -> bool:
    """Return True if the slave of a cam goes farther than axis and drive may (0124)."""
    if not step.coupled or step.law not in (10, 11) or not step.smooth:
        return False
    way = abs(step.p1 - step.p0 - step.shift)
    allowed = step.speed * step.dt * _MORE + 1e-9 + 1e-12 * abs(step.p1)
    return not (way <= allowed)


def _gear_law(step: MotionStep) -> bool:
    """Return True if the slave of a gear goes otherwise than its master, times the ratio.

    A new ratio counts from the cycle in which it comes: the velocity jumps, the position does not
    (004 §3.1.4).
    """
    if not step.coupled or step.law != 1 or not step.smooth or step.bent:
        return False
    if step.gear0 != step.gear0:  # the first cycle of the coupling
        return False
    way = step.p1 - step.p0 - step.shift
    law = step.gear * step.master
    if abs(way - law) > 1e-9 + 1e-11 * (abs(step.p1) + abs(step.gear * step.p0)):
        return True
    speed = step.gear * step.leading_speed
    return abs(step.v1 - speed) > _LEAST + 1e-9 * abs(speed)


CHECKS = (
    _finite, _velocity, _acceleration, _jerk_limit, _position, _stop, _rest, _slave_step,
    _gear_law, _coupled_way, _new_ratio,
)  # fmt: skip
"""All checks, in the order of the invariants."""

NAMES = (
    "finite", "velocity", "acceleration", "jerk", "position", "stop", "rest", "slave-step",
    "gear-law", "coupled-way", "new-ratio",
)  # fmt: skip
"""Names of their invariants."""


def describe(step: MotionStep) -> str:
    """Return what was seen, for people."""
    text = (
        f"position {step.p0} -> {step.p1}, velocity {step.v0} -> {step.v1},"
        f" acceleration {step.a0} -> {step.a1}; limits {step.top}, {step.rise}, {step.fall},"
        f" {step.jerk}; phase {step.phase0} -> {step.phase}, law {step.law}"
    )
    if step.coupled:
        text += f", ratio {step.gear0} -> {step.gear} times master {step.master}"
    return text
