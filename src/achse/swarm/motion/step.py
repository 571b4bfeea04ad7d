"""Set points of an axis in a cycle and the one before, with the limits that hold: what is checked.

`look` takes the values of a cycle in. Excused are the moments in which the manuals themselves are
abrupt: a reset in motion, a new actual position, a control loop that opens or closes.

Kernel source, in the language of `achse.native`.
"""

from math import nan

from achse.codes import NcError
from achse.codes.nc.choices import MotionPhase
from achse.motion.couplings.flying_saws.approach import BY_POSITION, INACTIVE
from achse.motion.fields.coupling import COUPLING_PARAMETERS, MASTERS
from achse.motion.record import AxisFields
from achse.motion.rows import NcRows
from achse.motion.states import SynchronisingBit
from achse.native.declare import Slot, lay_out

_ROUGH = (
    MotionPhase.EXTERNAL.value,
    MotionPhase.VELOCITY_STEPS.value,
    MotionPhase.SINE.value,
    MotionPhase.DRIVE_OUTPUT.value,
    MotionPhase.TORQUE.value,
)
"""Set points that come from outside, from the axis itself or by steps."""

_SPEEDS = MASTERS + 1


class MotionStep:
    """Set point of an axis in a cycle and the one before, with the limits that hold."""

    top: float = 0.0
    """Largest velocity of a command."""
    rise: float = 0.0
    fall: float = 0.0
    jerk: float = 0.0
    swing: float = 0.0
    """Velocity above it, while an acceleration is taken away by a command with less jerk."""
    dt: float = 0.0
    p0: float = 0.0
    p1: float = 0.0
    v0: float = 0.0
    v1: float = 0.0
    a0: float = 0.0
    a1: float = 0.0
    shift: float = 0.0
    """Change of the zero point in this cycle."""
    phase: int = 0
    phase0: int = 0
    law: int = 0
    gear: float = 0.0
    gear0: float = 0.0
    speed: float = 0.0
    """Largest velocity of axis and drive."""
    master: float = 0.0
    """Way of the master in this cycle."""
    pull: float = 0.0
    """Velocity by which masters change the slave's in this cycle."""
    over_master: int = 0
    """True for a slave on a curve over its master, which has no limit of its own (0037), and behind
    one that its mask stopped at once."""
    smooth: int = 0
    bent: int = 0
    beyond: int = 0
    coupled: int = 0
    bumpy: int = 0
    """True for a slave of a slave whose velocity may jump: that of a cam or of a new ratio."""
    grouped: int = 0
    keep_jerk: int = 0
    """True on the path of a group that keeps the jerk of axes everywhere."""
    commanded: int = 0
    """True if a command came: a small move may be done within the cycle."""
    abrupt: int = 0
    """True if a coupling gave an acceleration that no jerk limits, until the axis rests."""
    pulled_jerk: float = 0.0
    """Jerk of the masters of a gear, times the ratio: they may do a small way within a cycle."""
    was_superposed: int = 0
    """True if a section compensation, a trapezoid, was part of the motion until the axis rests."""
    at_limit: int = 0
    """True if a soft limit ends the motion."""
    active: int = 0
    """True unless the axis rests and waits for nothing."""
    moves: int = 0
    """Commands that the axis took."""
    abrupt_cycles: int = 0
    """Cycles in which the manuals are abrupt: most is not checked."""
    was_closed: int = 0
    was_driven: int = 0
    """True if an external set point moved: its position and velocity may contradict each other."""
    outer: float = 0.0
    """Position of the external set point."""
    ratio: float = 0.0
    """Largest ratio of the coupling to a master."""
    hidden: float = 0.0
    """Way of the master, times the ratio, that its velocities do not say: done within the cycle."""
    was_bent: int = 0
    last_law: int = 0
    first_master: int = 0
    """Row of the first master."""
    resets: int = 0
    zero: float = 0.0
    superposed_distance: float = 0.0
    superposed_end: float = 0.0
    superposed_acceleration: float = 0.0
    leading: float = 0.0
    """Position of the master, as the slave saw it."""
    leading_speed: float = 0.0
    """Its velocity, with that of a shift of the phase."""
    turned: float = 0.0
    """Gear of the last cycle: that of cyclic gears changes by its slope, whatever the axis may."""
    speeds: list[float] = [0.0] * _SPEEDS  # a declaration
    speed_count: int = 0
    number: int = 0
    active_number: int = 0


STEP = lay_out("motion step", (MotionStep,), Slot)


def set_limits(
    step: MotionStep, top: float, rise: float, fall: float, jerk: float, gentlest: float
) -> None:
    """Set the limits of an axis; `gentlest` is the least part of the jerk that commands have."""
    step.top = top
    step.rise = rise
    step.fall = fall
    step.jerk = jerk
    strongest = max(rise, fall)
    step.swing = (1.0 / gentlest - 1.0) * strongest * strongest / (2.0 * jerk)


def look(step: MotionStep, ax: AxisFields, rows: NcRows) -> None:
    """Take the values of this cycle in."""
    step.p0 = step.p1
    step.v0 = step.v1
    step.a0 = step.a1
    step.p1 = ax.set.position
    step.v1 = ax.set.velocity
    step.a1 = ax.set.acceleration
    step.phase0 = step.phase
    step.phase = ax.set_motion_phase
    grouped = MotionPhase.GROUPED
    step.grouped = int(step.phase == grouped or step.phase0 == grouped)
    zero = ax.encoder.set_position_offset
    step.shift = zero - step.zero
    step.zero = zero
    outer = ax.external_set.position
    driven = ax.external_setpoint_active != 0 and (
        ax.external_set.velocity != 0.0 or outer != step.outer
    )
    step.outer = outer
    rough = step.phase in _ROUGH or step.phase0 in _ROUGH or driven or step.was_driven != 0
    step.was_driven = int(driven)
    closed = ax.loop_closed != 0
    step.smooth = int(
        closed
        and step.was_closed != 0
        and ax.reset_command_counter == step.resets
        and step.shift == 0.0
        and not rough
    )
    step.was_closed = int(closed)
    step.resets = ax.reset_command_counter
    _look_at_superposition(step, ax)
    law = ax.coupling.law
    step.law = law
    step.coupled = int(law != 0 or step.last_law != 0)
    _look_at_gear(step, ax, law)
    step.last_law = law
    if law:
        _look_at_masters(step, ax, rows)
    moving = step.phase != 0 or step.v1 != 0.0 or step.v0 != 0.0 or law != 0
    step.abrupt = int(moving and (step.abrupt != 0 or step.coupled != 0))
    step.beyond = int(
        moving
        and (step.beyond != 0 or rough or step.bent != 0 or step.coupled != 0 or step.smooth == 0)
    )
    step.was_superposed = int(moving and (step.was_superposed != 0 or step.bent != 0))
    step.at_limit = int(
        ax.error_code == NcError.SOFT_LIMIT_MIN_PASSED
        or ax.error_code == NcError.SOFT_LIMIT_MAX_PASSED
    )
    step.active = int(
        step.phase != 0
        or step.v1 != 0.0
        or law != 0
        or step.was_bent != 0
        or ax.buffer.count != 0  # a command that waits for the arrival of an axis at rest
        or not closed
    )
    number = ax.command_counter
    active_number = ax.set_command_number
    if number != step.number:
        step.moves += 1
    step.commanded = int(number != step.number or active_number != step.active_number)
    step.number = number
    step.active_number = active_number


def _look_at_superposition(step: MotionStep, ax: AxisFields) -> None:
    """Note a superposition that may end within the cycle."""
    superposed = ax.superposed
    bent = (
        ax.compensating != 0
        or superposed.distance != step.superposed_distance
        or superposed.end != step.superposed_end
        or superposed.acceleration != step.superposed_acceleration
    )
    step.superposed_distance = superposed.distance
    step.superposed_end = superposed.end
    step.superposed_acceleration = superposed.acceleration
    step.bent = int(bent or step.was_bent != 0)
    step.was_bent = int(bent)


def _look_at_gear(step: MotionStep, ax: AxisFields, law: int) -> None:
    step.gear0 = step.gear
    gear = 0.0
    if law == 1:
        gear = ax.coupling.gear
    else:
        for i in range(COUPLING_PARAMETERS):
            gear += ax.coupling.parameters[i]
    step.gear = gear if law == step.last_law else nan


def _look_at_masters(step: MotionStep, ax: AxisFields, rows: NcRows) -> None:
    coupling = ax.coupling
    step.first_master = coupling.masters[0]
    # with the shift of what the slave sees of its master
    master = rows.axes[step.first_master].leading_value.position + ax.phasing.position
    step.master = master - step.leading
    step.leading = master
    step.leading_speed = rows.axes[step.first_master].leading_value.velocity + ax.phasing.velocity
    change = 0.0
    count = coupling.master_count
    for i in range(count + 1):
        if i < count:
            speed = rows.axes[coupling.masters[i]].leading_value.velocity
        else:
            speed = ax.phasing.velocity
        if i < step.speed_count:
            change += abs(speed - step.speeds[i])
        step.speeds[i] = speed
    step.speed_count = count + 1
    ratio = max(abs(coupling.gear), abs(coupling.parameters[0]), abs(coupling.parameters[1]))
    step.ratio = ratio
    turn = abs(coupling.gear - step.turned) * abs(step.speeds[0])
    step.turned = coupling.gear
    step.pull = ratio * change + turn
    at_once = SynchronisingBit.INSTANT_STOP_ON_ROLLBACK
    step.over_master = int(
        ax.sync.method == BY_POSITION
        or (ax.sync.mask & at_once != 0 and ax.sync.method == INACTIVE)
    )
