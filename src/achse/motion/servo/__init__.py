"""Servo drives on a bus: what is behind the hardware port instead of the simulated machine.

A `Servo` is between the structures of an axis and the process data of a CiA 402 drive, seen
from the master: it takes the drive through its power states, sends set values in csp, csv or cst,
and makes of what the drive answers the inputs that the NC reads. It knows bytes and objects, no bus
and no frame; a station copies the bytes.
"""

from achse.motion.servo.objects import (
    INPUT_OBJECTS,
    OUTPUT_OBJECTS,
    ProcessEntry,
    ServoError,
    ServoMode,
)
from achse.motion.servo.servos import ServoLink, ServoOptions, Servos, ServoView

__all__ = [
    "INPUT_OBJECTS",
    "OUTPUT_OBJECTS",
    "ProcessEntry",
    "ServoError",
    "ServoLink",
    "ServoMode",
    "ServoOptions",
    "ServoView",
    "Servos",
]
