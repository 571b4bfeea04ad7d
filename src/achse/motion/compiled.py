"""The kernel in machine code: `cycles` of `achse.motion.kernel` and whatever it calls."""

from achse.motion import curves
from achse.motion.kernel import cycles
from achse.motion.machine.record import AMPLIFIER, MACHINE, SENSOR, Amplifier, Machine, Sensor
from achse.motion.record import (
    CONTROLLER,
    DRIVE,
    ENCODER,
    LAYOUT,
    AxisDriveFields,
    AxisFields,
    ControllerFields,
    EncoderFields,
)
from achse.native.compiled import Kernel

__all__ = ["KERNEL"]

KERNEL = Kernel(
    "motion",
    cycles,
    {
        AxisFields: LAYOUT,
        EncoderFields: ENCODER,
        ControllerFields: CONTROLLER,
        AxisDriveFields: DRIVE,
        Sensor: SENSOR,
        Amplifier: AMPLIFIER,
        Machine: MACHINE,
        curves.Piece: curves.LAYOUT,
    },
)
"""Called with address and number of the axes, of their encoders, sensors and amplifiers and of the
pieces of curves, the cycle time in seconds, how many cycles."""
