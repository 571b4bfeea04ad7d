"""PLC: memory and process image, tasks, programs. No ADS, no loop, no clock in here."""

from achse.plc.memory import (
    DEFAULT_SIZES,
    Area,
    AreaFullError,
    Memory,
    MemoryRangeError,
    Region,
)
from achse.plc.program import PlacedUnit, PlacedVariable
from achse.plc.runtime import PlcRuntime, PlcState, PlcStateError
from achse.plc.task import Task

__all__ = [
    "DEFAULT_SIZES",
    "Area",
    "AreaFullError",
    "Memory",
    "MemoryRangeError",
    "PlacedUnit",
    "PlacedVariable",
    "PlcRuntime",
    "PlcState",
    "PlcStateError",
    "Region",
    "Task",
]
