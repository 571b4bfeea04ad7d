"""Shown values of an axis made by machine code, for clients that sample them (see `shown`).

A test compares them with the plain form, which gives the bytes for all others.
"""

from collections.abc import Sequence

from achse.motion.readout.cyclic_image import modulo_of, modulo_turns_of
from achse.motion.record import ENCODER, LAYOUT, AxisFields, EncoderFields
from achse.native.compiled import Kernel
from achse.native.declare import Slot, lay_out, reference
from achse.native.memory import ComputedCell, ComputedFields, RowView


class ShownValues:
    """Values of `achse.motion.readout.shown.SHOWN` with the names that they have at the axis."""

    set_velocity_override: float = 0.0
    set_direction: float = 0.0
    set_position_modulo: float = 0.0
    set_modulo_turns: int = 0
    actual_position_modulo: float = 0.0
    actual_modulo_turns: int = 0
    axis: AxisFields = reference(LAYOUT)


VALUES = lay_out("ShownValues", [ShownValues], Slot)


def show_values(values: Sequence[ShownValues]) -> None:
    """Compute the values of all axes."""
    for n in range(len(values)):
        ax = values[n].axis
        _show(values[n], ax, ax.encoder)


def _show(shown: ShownValues, ax: AxisFields, encoder: EncoderFields) -> None:
    velocity = ax.set.velocity
    if velocity == 0.0 and ax.external_setpoint_active:
        velocity = float(ax.external_set.direction)
    direction = 0.0
    if ax.set_motion_phase != 0:
        if velocity > 0.0:
            direction = 1.0
        elif velocity < 0.0:
            direction = -1.0
    period = encoder.modulo_factor
    shown.set_velocity_override = ax.velocity_override / 1e6
    shown.set_direction = direction
    shown.set_position_modulo = modulo_of(ax.set.position, period)
    shown.set_modulo_turns = modulo_turns_of(ax.set.position, period)
    shown.actual_position_modulo = modulo_of(encoder.actual_position, period)
    shown.actual_modulo_turns = modulo_turns_of(encoder.actual_position, period)


KERNEL = Kernel(
    "shown-values", show_values, {ShownValues: VALUES, AxisFields: LAYOUT, EncoderFields: ENCODER}
)
"""Called with address and number of the values."""

SHOWN_VALUES = ComputedFields(VALUES, KERNEL, "axis")


def shown_cell(axis: object, name: str, size: int) -> ComputedCell | None:
    """Return the first `size` bytes of a value; None if no machine code computes it."""
    if name not in VALUES.fields or not isinstance(axis, RowView) or not KERNEL.available:
        return None
    return SHOWN_VALUES.cell(axis, name, size)
