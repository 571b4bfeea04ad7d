"""The table of couplings: what makes the set point of an axis that follows others.

The way of a set point is: command, generator, coupling, controller, hardware port. A coupling comes
after the axis' own generator, whose set point it takes over, adds to or leaves. What comes behind
it (following error, soft limits, outputs, status) knows nothing of it. Its masters had their turns
before (`achse.motion.order`), so their set values are those of this cycle.

A law is a module beside this one with a row here:

- `step` makes position, velocity, acceleration and jerk of this cycle in closed form, from what
  masters show (`rows.axes[ax.master[n]].leading_value`) and from the law's own memory.
- `base` lets it count from where slave and masters are now. It is called at the end of coupling,
  when parameters change (unless the law says how), and when the slave's open loop is closed again.
- Its memory is a part of the axis (a class in `achse.motion.fields`, named in `record.AxisFields`).
  `base` sets all of it, and `end_coupling` clears `ax.coupling`. The parameters of the service are
  `ax.coupling.parameters`.
- What it demands before it is coupled by parameters (0x40), and how it changes while it runs
  (0x42), is in its row as well, outside the kernel. Laws with services of their own (tables,
  synchronising) demand things there.
- It ends by `end_coupling` of `masters`, called in the kernel for errors and motions of a slave's
  own, outside by `Axis.release`. A law that ends by itself calls it too. Set values stay; a caller
  says what comes then (`set_motion_phase`).

A superposition is on top of what the law makes (`ax.coupling.offset`); a law does not see it.

What masters show does not jump when they are renamed: a position of the master's own is
`leading_value.position + leading_value.offset`. `masters.leading_position` has the phase shift of
the slave in it.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

from achse.codes.nc.choices import MotionPhase
from achse.motion.couplings import (
    bilinear,
    cams,
    cyclic_gear,
    linear,
    multi_master,
    surface_speed,
)
from achse.motion.couplings.flying_saws import flying_saw, modulo_flying_saw, synchronising
from achse.motion.couplings.flying_saws.approach import BY_POSITION
from achse.motion.couplings.guard import check_step
from achse.motion.couplings.masters import end_coupling, update_leading_value
from achse.motion.record import AxisFields
from achse.motion.rows import NcRows
from achse.motion.setpoints.dynamics import drop_foreign
from achse.motion.setpoints.setpoint import fail, generate
from achse.motion.setpoints.superposition import superpose
from achse.motion.states import SlaveType

if TYPE_CHECKING:
    from achse.motion.axis import Axis


def _anywhere(ax: AxisFields, rows: NcRows) -> None:
    """Do nothing: the law counts from nowhere."""


def _by_the_next_cycle(ax: AxisFields, rows: NcRows) -> None:
    """Do nothing: the law reads its parameters in each cycle."""


def _any(ax: AxisFields, masters: Sequence[AxisFields], parameters: Sequence[float]) -> int:
    """Any parameters will do."""
    return 0


def _none_besides(parameters: Sequence[float]) -> tuple[float, ...]:
    """No further masters."""
    return ()


class Coupling(NamedTuple):
    """A law by which an axis follows others: its row, all that there is to say of it."""

    name: str
    number: int
    """Number of the law in the field `coupling.law`, not 0: the slave type that requests it."""
    step: Callable[[AxisFields, NcRows, float], None]
    """Set point of this cycle; masters are `rows.axes[ax.master[n]]`, n < `ax.master_count`."""
    base: Callable[[AxisFields, NcRows], None] = _anywhere
    """Begin to count where slave and masters are now: at coupling, and after the slave's loop was
    open."""
    by_parameters: bool = True
    """True if four parameters couple by it (0x40), False if a service of its own does."""
    check: Callable[["Axis", Sequence["Axis"], Sequence[float]], int] | None = _any
    """Code that refuses these four parameters for a slave and its masters, or 0; they are finite
    and not above a million. Checked at coupling and at changes. None: it has no parameters."""
    others: Callable[[Sequence[float]], tuple[float, ...]] = _none_besides
    """Ids of the masters that are named by parameters."""
    moving: bool = False
    """True if masters may move at coupling by parameters."""
    change: Callable[[AxisFields, NcRows], None] | None = None
    """New parameters while it runs; without it the law counts from here (`base`)."""
    check_change: Callable[[AxisFields, NcRows, Sequence[float], float], int] | None = None
    """Code that refuses new parameters while it runs, or 0, for a law whose velocity jumps to
    theirs; the last argument is the cycle, s."""
    stops: bool = False
    """True if its slave has a motion of its own that can be stopped (0x44)."""
    guarded: bool = False
    """True if a set point that the slave can only jump to stops it (`couplings.guard`)."""
    approaches: bool = False
    """True if that holds on its way over the master, until it runs with it."""


COUPLINGS: tuple[Coupling, ...] = (
    Coupling(
        "linear",
        SlaveType.LINEAR.value,
        linear.step,
        linear.base,
        check=linear.check,
        check_change=linear.check_change,
    ),
    Coupling(
        "cam",
        SlaveType.TABULAR.value,
        cams.step,
        cams.base,
        by_parameters=False,
        check=None,
        guarded=True,
    ),
    Coupling(
        "several cams",
        SlaveType.MULTI_TABULAR.value,
        cams.step,
        cams.base,
        by_parameters=False,
        check=None,
        guarded=True,
    ),
    Coupling(
        "motion function",
        SlaveType.MOTION_FUNCTION.value,
        cams.step,
        cams.base,
        by_parameters=False,
        check=None,
        guarded=True,
    ),
    Coupling(
        "cyclic gear",
        SlaveType.CYCLIC_GEAR.value,
        cyclic_gear.step,
        cyclic_gear.base,
        check=cyclic_gear.check,
        moving=True,
        change=_by_the_next_cycle,
    ),
    Coupling(
        "bi-linear",
        SlaveType.BILINEAR.value,
        bilinear.step,
        bilinear.base,
        check=bilinear.check,
        others=bilinear.others,
        check_change=bilinear.check_change,
    ),
    Coupling(
        "constant surface speed",
        SlaveType.SURFACE_SPEED.value,
        surface_speed.step,
        surface_speed.base,
        check=surface_speed.check,
        moving=True,
        change=_by_the_next_cycle,
    ),
    Coupling(
        "multi-master",
        SlaveType.MULTI_MASTER.value,
        multi_master.step,
        multi_master.base,
        by_parameters=False,
        change=multi_master.change,
    ),
    Coupling(
        "flying saw, velocity",
        SlaveType.FLYING_SAW_VELOCITY.value,
        flying_saw.step,
        flying_saw.base,
        check=flying_saw.check_velocity,
        moving=True,
        change=flying_saw.change,
        check_change=flying_saw.check_change,
        stops=True,
        approaches=True,
    ),
    Coupling(
        "flying saw, position",
        SlaveType.FLYING_SAW_POSITION.value,
        flying_saw.step,
        flying_saw.base,
        check=flying_saw.check_position,
        moving=True,
        change=flying_saw.change,
        check_change=flying_saw.check_change,
        stops=True,
        approaches=True,
    ),
    Coupling(
        "synchronising, velocity",
        SlaveType.SYNCHRONISING_VELOCITY.value,
        flying_saw.step,
        synchronising.base,
        by_parameters=False,
        check=synchronising.check,
        change=synchronising.change,
        check_change=synchronising.check_change,
        stops=True,
    ),
    Coupling(
        "synchronising, position",
        SlaveType.SYNCHRONISING_POSITION.value,
        flying_saw.step,
        synchronising.base,
        by_parameters=False,
        check=synchronising.check,
        change=synchronising.change,
        check_change=synchronising.check_change,
        stops=True,
        approaches=True,
    ),
    Coupling(
        "modulo flying saw",
        SlaveType.MODULO_FLYING_SAW.value,
        modulo_flying_saw.step,
        modulo_flying_saw.base,
        check=modulo_flying_saw.check,
        others=modulo_flying_saw.others,
        moving=True,
        stops=True,
    ),
)
"""Each law once, by its slave type."""


def law_of(number: int) -> Coupling | None:
    """Return the law of a slave type; None: there is none."""
    return next((row for row in COUPLINGS if row.number == number), None)


def couple(ax: AxisFields, rows: NcRows, dt: float) -> None:
    """Run one cycle of an axis that follows others or has followers."""
    if ax.coupling.law:
        _follow(ax, rows, dt)
    if ax.followers:
        update_leading_value(ax, dt)


def _follow(ax: AxisFields, rows: NcRows, dt: float) -> None:
    """Set point of this cycle by the law.

    A motion of its own, or an error, ends the coupling. While its loop is open the axis stays
    coupled; once it is closed the law counts from where both are then.
    """
    phase = ax.set_motion_phase
    if ax.error_code != 0 or (phase != MotionPhase.COUPLED and phase != MotionPhase.NONE):
        end_coupling(ax, rows)
        return
    if ax.loop_closed == 0:
        return
    if phase == MotionPhase.NONE:
        ax.set_motion_phase = MotionPhase.COUPLED
        count_from_here(ax, rows)
    begin = ax.set.position
    velocity = ax.set.velocity
    acceleration = ax.set.acceleration
    fault = 0
    approaching = ax.sync.method == BY_POSITION
    ax.set.position -= ax.coupling.offset
    ax.set.velocity -= ax.superposed.set_velocity
    ax.set.acceleration -= ax.superposed.set_acceleration
    for row in COUPLINGS:
        if ax.coupling.law == row.number:
            row.step(ax, rows, dt)
            if row.guarded or (row.approaches and approaching):
                fault = _fault(ax, begin, dt)
            break
    if fault:
        ax.set.position = begin
        ax.set.velocity = velocity
        ax.set.acceleration = acceleration
        _brake(ax, rows, fault, dt)
        return
    ax.set.position += ax.coupling.offset
    if ax.compensating:
        ax.superposed.set_velocity = 0.0
        ax.superposed.set_acceleration = 0.0
        before = ax.set.position
        superpose(ax, begin, dt)
        ax.coupling.offset += ax.set.position - before
    ax.target_position = ax.set.position
    v = ax.set.velocity
    a = ax.set.acceleration
    ax.profile.abrupt = 1  # whatever the law does, no jerk limits it
    ax.profile.running_jerk = a * a / abs(v) if a * v < 0.0 else 0.0


def _fault(ax: AxisFields, begin: float, dt: float) -> int:
    """Code that refuses the set point of a law, without what is superposed; 0 = it can be taken."""
    position = ax.set.position + ax.coupling.offset
    return check_step(ax, position - begin, position, ax.set.velocity, ax.set.acceleration, dt)


def _brake(ax: AxisFields, rows: NcRows, code: int, dt: float) -> None:
    """Let go with an axis error, and brake from the set point of the last cycle on.

    In the first cycle the slave still has an acceleration of its own, which its jerk takes away.
    """
    if ax.profile.abrupt:
        drop_foreign(ax, ax.set.acceleration)
    fail(ax, code, 0)
    end_coupling(ax, rows)
    generate(ax, dt)


def count_from_here(ax: AxisFields, rows: NcRows) -> None:
    """Let the law count from where slave and masters are now, without what is superposed."""
    ax.set.position -= ax.coupling.offset
    ax.set.velocity -= ax.superposed.set_velocity
    ax.set.acceleration -= ax.superposed.set_acceleration
    for row in COUPLINGS:
        if ax.coupling.law == row.number:
            row.base(ax, rows)
            break
    ax.set.position += ax.coupling.offset
    ax.set.velocity += ax.superposed.set_velocity
    ax.set.acceleration += ax.superposed.set_acceleration


def has_moving_master(ax: AxisFields, rows: NcRows) -> bool:
    """Return True if one of its masters does not rest: then the axis does not rest either."""
    awake = 0
    for n in range(ax.coupling.master_count):
        awake += 1 - rows.axes[ax.coupling.masters[n]].resting
    return awake > 0
