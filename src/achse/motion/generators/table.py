"""The table of generators: their step, the commands that begin them, their effect on the axis.

A new way of making set points is a module with a `step` and a row here. The kernel goes through the
rows; machine code has one branch for each.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from collections.abc import Callable
from typing import NamedTuple

from achse.codes.nc.choices import MotionPhase
from achse.motion.generators import (
    coupled,
    direct_output,
    external,
    grouped,
    homing,
    moves,
    reversing,
    sine,
    torque,
    velocity_steps,
)
from achse.motion.record import AxisFields


def _by_phase_alone(ax: AxisFields) -> bool:
    """It is active in its phases only."""
    return False


def _stays(ax: AxisFields) -> None:
    """Do nothing: such a generator never hands back the set point."""


def along_the_set_point(ax: AxisFields) -> float:
    """Return the sign of the set velocity; an external set point may have it without one."""
    if ax.set.velocity == 0.0 and ax.external_setpoint_active:
        return float(ax.external_set.direction)
    return ax.set.velocity


class Generator(NamedTuple):
    """A way of making set points."""

    name: str
    phases: tuple[int, ...]
    """`MotionPhase` in which it makes the set point."""
    begin: tuple[str, ...]
    """The functions of `achse.motion.commands` that begin it."""
    step: Callable[[AxisFields, float], None]
    """Position, velocity and acceleration of this cycle."""
    end: Callable[[AxisFields], None] = _stays
    """Before each cycle of an active generator: hand back the set point if the motion is over."""
    is_active: Callable[[AxisFields], bool] = _by_phase_alone
    """True if it generates the set point in any phase."""
    heading: Callable[[AxisFields], float] = along_the_set_point
    """Direction in which it drives the axis, by its sign."""
    is_planned: bool = True
    """True if profiles of limited jerk make it, which end before soft limits."""
    travelling: tuple[int, ...] = ()
    """Phases in which no target is waited for."""
    continuous: tuple[int, ...] = ()
    """Phases that StateDWord shows as continuous motion."""


GENERATORS = (
    Generator(
        "move",
        (
            MotionPhase.NONE,
            MotionPhase.POSITIONING,
            MotionPhase.ENDLESS,
            MotionPhase.STOPPING,
        ),
        ("start", "universal_start", "start_special", "stop"),
        moves.step,
        travelling=(MotionPhase.ENDLESS, MotionPhase.STOPPING),
        continuous=(MotionPhase.ENDLESS,),
    ),
    Generator("homing", (MotionPhase.HOMING,), ("home",), homing.step),
    Generator("reversing", (MotionPhase.REVERSING,), ("start_reversing",), reversing.step),
    Generator(
        "torque",
        (MotionPhase.TORQUE,),
        ("start_torque_control",),
        torque.step,
        torque.end,
        torque.is_active,
        torque.heading,
        is_planned=False,
        travelling=(MotionPhase.TORQUE,),
        continuous=(MotionPhase.TORQUE,),
    ),
    Generator(
        "external set points",
        (MotionPhase.EXTERNAL,),
        ("start_external_setpoint",),
        external.step,
        external.end,
        external.is_active,
        is_planned=False,
        continuous=(MotionPhase.EXTERNAL,),
    ),
    Generator(
        "velocity steps",
        (MotionPhase.VELOCITY_STEPS,),
        ("start_velocity_steps",),
        velocity_steps.step,
        is_planned=False,
        travelling=(MotionPhase.VELOCITY_STEPS,),
        continuous=(MotionPhase.VELOCITY_STEPS,),
    ),
    Generator(
        "sine",
        (MotionPhase.SINE,),
        ("start_sine_oscillation",),
        sine.step,
        is_planned=False,
        travelling=(MotionPhase.SINE,),
        continuous=(MotionPhase.SINE,),
    ),
    Generator(
        "direct output",
        (MotionPhase.DRIVE_OUTPUT,),
        ("start_drive_output",),
        direct_output.step,
        heading=direct_output.heading,
        is_planned=False,
        travelling=(MotionPhase.DRIVE_OUTPUT,),
        continuous=(MotionPhase.DRIVE_OUTPUT,),
    ),
    Generator(
        "group",
        (MotionPhase.GROUPED,),
        ("begin_group_motion",),
        grouped.step,
        is_planned=False,
        travelling=(MotionPhase.GROUPED,),
    ),
    Generator("coupling", (MotionPhase.COUPLED,), ("couple",), coupled.step, is_planned=False),
)
"""Each phase belongs to one row; of the rows for any phase the first one generates."""

_OF_ANY_PHASE = tuple(row for row in GENERATORS if row.is_active is not _by_phase_alone)


def _by_phase(phases: set[int]) -> tuple[int, ...]:
    """1 for the phases that are in the set, at their numbers."""
    return tuple(int(number in phases) for number in range(max(MotionPhase) + 1))


UNPLANNED = _by_phase({phase for row in GENERATORS if not row.is_planned for phase in row.phases})
"""By phase: no table knows its end."""

TRAVELLING = _by_phase({phase for row in GENERATORS for phase in row.travelling})
"""By phase: no target is waited for."""

CONTINUOUS = _by_phase({phase for row in GENERATORS for phase in row.continuous})
"""By phase: StateDWord shows a continuous motion."""


BY_FAST_PATH = _by_phase(
    {phase for row in GENERATORS if row.name in ("move", "coupling") for phase in row.phases}
)
"""True by phase if the fast path of the cycle generates the set point."""


def hand_over(ax: AxisFields) -> None:
    """Hand the set point back, before the cycle, where a generator of any phase is over."""
    for row in _OF_ANY_PHASE:
        if row.is_active(ax):
            row.end(ax)


def generate_set_point(ax: AxisFields, dt: float) -> None:
    """Set point of this cycle, by the generator whose turn it is."""
    if ax.external_setpoint_active or ax.drive_operation_mode:
        for row in _OF_ANY_PHASE:
            if row.is_active(ax):
                row.step(ax, dt)
                return
    phase = ax.set_motion_phase
    for row in GENERATORS:
        if phase in row.phases:
            row.step(ax, dt)
            return


def heading(ax: AxisFields) -> float:
    """Return the direction in which the axis is to move, by its sign."""
    phase = ax.set_motion_phase
    for row in GENERATORS:
        if phase in row.phases:
            return row.heading(ax)
    return 0.0
