"""Checks of cams: refuse a change of a slave that it could only follow by a jump.

Commands and writes to tables use them between two cycles; the cycle itself has the same guard
(`achse.motion.couplings.guard`), because what masters do until a change is due is not known.
A change that is due already is carried out here (`carry_out_now`), before the command is answered.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from math import copysign
from typing import TYPE_CHECKING

from achse.codes import NcError
from achse.motion.couplings.cams import (
    CHANGE_BEGIN,
    change,
    check_jump,
    due,
    jump_of,
    law_after,
    master_position_of,
)
from achse.motion.couplings.guard import check_step
from achse.motion.couplings.masters import leading_value_of_row
from achse.motion.record import CamFields
from achse.motion.rows import NcRows
from achse.motion.states import CamActivation

if TYPE_CHECKING:
    from achse.motion.axis import Axis

_FARTHEST = 1e12
"""Way in which a master comes to each place at which a cam can change."""

_REFUSALS: dict[int, int] = {
    NcError.SOFT_LIMIT_MAX_PASSED: NcError.SLAVE_TARGET_BEYOND_SOFT_LIMITS,
    NcError.SOFT_LIMIT_MIN_PASSED: NcError.SLAVE_TARGET_BEYOND_SOFT_LIMITS,
    NcError.SET_VELOCITY_TOO_HIGH: NcError.TABLE_SLAVE_RANGE,
}
"""Code that answers a request, by the code with which an axis fails."""


def check_follow(slave: "Axis", position: float, velocity: float, acceleration: float) -> int:
    """Return the code that refuses these values of the law for the next cycle, or 0.

    They are those at the present positions of the masters, which go on with their velocities.
    0x4A18: a jump beyond the position window, farther or faster than the axis may go; 0x4229: no
    rest before a soft limit.
    """
    with _without_superposition(slave):
        return _check_values(slave, position, velocity, acceleration)


@contextmanager
def _without_superposition(slave: "Axis") -> Iterator[None]:
    """Let the set position be what the law makes, as it is for the law in the cycle."""
    position = slave.set.position
    slave.set.position = position - slave.coupling.offset
    try:
        yield
    finally:
        slave.set.position = position


def _check_values(slave: "Axis", position: float, velocity: float, acceleration: float) -> int:
    jump = position - slave.set.position
    code = check_jump(slave, jump)
    if code:
        return code
    dt = slave.cycle_ns * 1e-9
    way = velocity * dt
    place = position + slave.coupling.offset + way
    code = check_step(slave, jump + way, place, velocity, acceleration, dt)
    return _REFUSALS[code] if code else 0


def check_change(slave: "Axis", rows: NcRows, number: int, layer: CamFields) -> int:
    """Return the code that refuses what a layer is to wait for, or 0, as `check_follow`.

    The layer may be a copy; its number is -1 as long as the slave does not have it. A change that
    comes later is refused if the slave would jump at its place.
    """
    begins = layer.change.kind == CHANGE_BEGIN
    if layer.change.when == CamActivation.AS_SOON_AS_POSSIBLE or not (begins or slave.loop_closed):
        return 0
    with _without_superposition(slave):
        return _check_change(slave, rows, number, layer)


def carry_out_now(slave: "Axis", rows: NcRows, layer: CamFields) -> None:
    """Carry out what a layer waits for if it is due and the slave can follow; else it waits on.

    While its loop is open a slave only begins cams, other changes wait until it is closed.
    """
    if not (slave.loop_closed or layer.change.kind == CHANGE_BEGIN):
        return
    now = master_position_of(slave, rows, layer)
    is_due, at = due(rows, layer, now, now)
    with _without_superposition(slave):
        number = slave.cams.index(layer)
        if is_due and not _check_now(slave, rows, number, layer, at):
            change(slave, rows, layer, at)


def _check_now(slave: "Axis", rows: NcRows, number: int, layer: CamFields, at: float) -> int:
    code = check_jump(slave, jump_of(slave, rows, layer, at))
    if code or not slave.loop_closed:
        return code
    return _check_values(slave, *law_after(slave, rows, number, layer, at))


def _check_change(slave: "Axis", rows: NcRows, number: int, layer: CamFields) -> int:
    now = master_position_of(slave, rows, layer)
    is_due, at = due(rows, layer, now, now)
    if is_due:
        return _check_now(slave, rows, number, layer, at)
    moves = leading_value_of_row(slave, rows, layer.master)[1]
    ways = (copysign(_FARTHEST, moves),) if moves else (_FARTHEST, -_FARTHEST)
    places = [due(rows, layer, now, now + way) for way in ways]
    codes = [check_jump(slave, jump_of(slave, rows, layer, at)) for is_due, at in places if is_due]
    return codes[0] if codes and all(codes) else 0
