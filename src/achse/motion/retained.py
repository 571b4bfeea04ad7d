"""Retained state: the part of an axis that outlives a restart of the NC."""

from collections.abc import Sequence
from dataclasses import dataclass

from achse.motion.axis import Axis
from achse.motion.machine.hardware import place_machine
from achse.motion.setpoints.setpoint import shift_origin


@dataclass(frozen=True, slots=True)
class RetainedState:
    """Place of the machine of an axis, and the axis' knowledge of it."""

    zeros: Sequence[float]
    """Of each encoder: the count at the zero of the machine, were its count now 0."""
    position: float
    """In axis units."""
    homed: int

    @classmethod
    def of(cls, axis: Axis) -> "RetainedState":
        """Return the retained state of an axis now."""
        zeros = [-axis.machine.position / each.sensor.way for each in axis.encoders]
        return cls(zeros, axis.actual_position, axis.homed)

    def restore(self, axis: Axis) -> None:
        """Let a new axis begin there.

        With persistent data (0x4000:0x30) it knows its position and the homed flag; else it has
        forgotten both and counts from 0 at the present position of its machine.
        """
        if self.zeros:
            place_machine(axis.machine, -self.zeros[0] * axis.encoders[0].sensor.way)
        if axis.persistent_data_enable:
            axis.homed = self.homed
            shift_origin(axis, self.position - axis.actual_position)
