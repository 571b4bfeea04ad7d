"""Discrete motors: two speeds with a brake, and steppers, as their control bytes say.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from achse.motion.machine.amplifier import move
from achse.motion.machine.record import Amplifier
from achse.motion.machine.signals import outward

_MINUS_HIGH = 1 << 0
_MINUS_LOW = 1 << 1
_PLUS_LOW = 1 << 2
_PLUS_HIGH = 1 << 3
_BRAKE = 1 << 7

_FREQUENCY = 1 << 0
_FORWARD = 1 << 1


def run_two_speeds(a: Amplifier, dt: float) -> None:
    """Move a two-speed motor at the speed it is switched to; its brake holds at once."""
    m = a.machine
    control = a.io.ctrl1
    velocity = 0.0
    if control & (_PLUS_HIGH | _MINUS_HIGH):
        velocity = a.full_velocity
    elif control & (_PLUS_LOW | _MINUS_LOW):
        velocity = a.full_velocity * a.creep_velocity
    if control & (_MINUS_HIGH | _MINUS_LOW):
        velocity = -velocity
    if a.motor_inverted:
        velocity = -velocity
    if m.limit_switch != 0 and outward(m, velocity):
        velocity = 0.0
    moved = m.velocity
    moved += (velocity - moved) * (dt / (a.time_constant + dt))
    if control & _BRAKE or m.blocked:
        moved = 0.0
    move(m, moved, moved * dt, 2)


def _turned(a: Amplifier) -> int:
    """By how many steps the field has turned: -1, 0 or 1.

    An excitation that is not the next one of the motor, or the one before, does not turn it.
    """
    control = a.io.ctrl1
    if a.mask_count == 0:
        level = a.io.ctrl2 & _FREQUENCY
        if level == a.step_index:
            return 0
        a.step_index = level
        return 1 if a.io.ctrl2 & _FORWARD else -1
    count = a.mask_count
    index = a.step_index
    excited = control & a.mask_bits
    if excited == a.masks[index]:
        return 0
    for direction in range(1, -2, -2):
        next_index = (index + direction) % count
        if excited == a.masks[next_index]:
            a.step_index = next_index
            return direction
    return 0


def run_stepper(a: Amplifier, dt: float) -> None:
    """Move a stepper motor by the step that its outputs command."""
    m = a.machine
    direction = _turned(a)
    a.step_cycles += 1
    if a.motor_inverted:
        direction = -direction
    if direction == 0 or m.blocked or outward(m, float(direction)):
        velocity = m.velocity
        if a.step_cycles > 2 * a.step_interval or m.blocked:
            velocity = 0.0
        move(m, velocity, 0.0, 2)
        return
    a.step_interval = a.step_cycles
    a.step_cycles = 0
    move(m, direction * a.step / (a.step_interval * dt), direction * a.step, 2)
