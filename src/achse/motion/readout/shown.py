"""Values that are only shown: computed from the record when they are read.

The kernel does not read them, so a cycle does not compute them. They are fields like others
(`achse.motion.record.FIELDS`), without a place in a record.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import floor
from typing import Any

from achse.motion.fields.declare import Field, Role
from achse.motion.states import CAM_COUPLINGS

_FULL_OVERRIDE = 1e6


@dataclass(slots=True)
class ShownField(Field):
    """A value that is computed when it is read; `read` takes the axis or the part that has it."""

    read: Callable[[Any], float] = float


def modulo_place(position: float, period: float) -> tuple[float, int]:
    """Return the position within its period, 0 <= part < period, and the number of that period."""
    turns = floor(position / period)
    part = position - turns * period
    if 0.0 <= part < period:
        return part, turns
    return 0.0, floor(position / period + 0.5)


def _percent(output: float, full: float) -> float:
    return 100.0 * output / full if full else 0.0


def _direction(axis: Any) -> float:
    """Sign of the set velocity; an external set point may have a direction without a velocity."""
    if axis.set_motion_phase == 0:
        return 0.0
    velocity = axis.set.velocity
    if velocity == 0.0 and axis.external_setpoint_active:
        velocity = axis.external_set.direction
    return float((velocity > 0.0) - (velocity < 0.0))


def _table(axis: Any) -> float:
    """Id of the table that a slave follows, of several that of the first."""
    if axis.coupling.law not in CAM_COUPLINGS:
        return 0
    return next(
        (layer.now.table for layer in axis.cams[: axis.camming.count] if layer.now.table), 0
    )


def _rows(*rows: ShownField) -> dict[str, ShownField]:
    return {row.name: row for row in rows}


def _real(name: str, unit: str, doc: str, read: Callable[[Any], float]) -> ShownField:
    return ShownField(0.0, name=name, unit=unit, doc=doc, role=Role.STATE, read=read)


def _whole(name: str, doc: str, read: Callable[[Any], float]) -> ShownField:
    return ShownField(0, name=name, unit="1", doc=doc, role=Role.STATE, read=read)


SHOWN: dict[str, dict[str, ShownField]] = {
    "": _rows(
        _real(
            "set_velocity_override", "1", "override in force, 1.0 = 100 %",
            lambda axis: axis.velocity_override / _FULL_OVERRIDE,
        ),
        _real("set_direction", "1", "-1, 0, 1: sign of the set velocity", _direction),
        _real(
            "set_position_modulo", "mm", "set position within its period",
            lambda axis: modulo_place(axis.set.position, axis.encoder.modulo_factor)[0],
        ),
        _whole(
            "set_modulo_turns", "period of the set position",
            lambda axis: modulo_place(axis.set.position, axis.encoder.modulo_factor)[1],
        ),
        _whole("coupling_table_index", "table of the coupling, 0 = none", _table),
    ),
    "encoder": _rows(
        _real(
            "actual_position_modulo", "mm", "actual position within its period",
            lambda encoder: modulo_place(encoder.actual_position, encoder.modulo_factor)[0],
        ),
        _whole(
            "actual_modulo_turns", "period of the actual position",
            lambda encoder: modulo_place(encoder.actual_position, encoder.modulo_factor)[1],
        ),
    ),
    "controller": _rows(
        _real(
            "output_percent", "%", "the same of full output",
            lambda controller: _percent(controller.output, controller.owner.drive.full),
        ),
    ),
    "drive": _rows(
        _real(
            "output_percent", "%", "the same of full output",
            lambda drive: _percent(drive.output, drive.full),
        ),
    ),
}  # fmt: skip
"""By the part that has them ("" is the axis itself) and by name."""
