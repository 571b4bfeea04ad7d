"""The kernel in machine code: `cycles` of `achse.motion.kernel` and whatever it calls."""

from achse.motion.control import curves
from achse.motion.fields.cams import CamChange, CamLaw
from achse.motion.kernel import cycles
from achse.motion.machine.record import AMPLIFIER, MACHINE, SENSOR, Amplifier, Machine, Sensor
from achse.motion.record import (
    CAM,
    CAM_CHANGE,
    CAM_LAW,
    CONTROLLER,
    DRIVE,
    ENCODER,
    JOB,
    LAYOUT,
    PART_LAYOUTS,
    AxisDriveFields,
    AxisFields,
    CamFields,
    ControllerFields,
    EncoderFields,
    JobFields,
)
from achse.native.compiled import Kernel

KERNEL = Kernel(
    "motion",
    cycles,
    {
        AxisFields: LAYOUT,
        EncoderFields: ENCODER,
        ControllerFields: CONTROLLER,
        AxisDriveFields: DRIVE,
        JobFields: JOB,
        CamFields: CAM,
        **PART_LAYOUTS,
        CamLaw: CAM_LAW,
        CamChange: CAM_CHANGE,
        Sensor: SENSOR,
        Amplifier: AMPLIFIER,
        Machine: MACHINE,
        curves.CurveSpan: curves.LAYOUT,
    },
)
"""Called with address and number of all rows (`NcRows`), of sensors and of amplifiers, the cycle
time in seconds, how many cycles."""
