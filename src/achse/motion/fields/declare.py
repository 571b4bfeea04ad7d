"""Declaration of a field of the axis record: default, unit, meaning, permitted range, role."""

import math
from dataclasses import dataclass
from enum import Enum
from typing import Any

from achse.native.declare import Slot


class Role(Enum):
    """Purpose of a field, and with it the right to write it."""

    PARAMETER = "configured, written by parameter services"
    INPUT = "written each PLC cycle or by functions, read by the kernel"
    STATE = "written by the kernel, read by all"
    INTERNAL = "the kernel's own memory"


class Parameters:
    """Base of classes whose fields are of `Role.PARAMETER`."""


class Inputs:
    """Base of classes whose fields are of `Role.INPUT`."""


class States:
    """Base of classes whose fields are of `Role.STATE`."""


class InternalFields:
    """Base of classes whose fields are of `Role.INTERNAL`."""


@dataclass(slots=True)
class Field(Slot):
    """One declared value of an axis; `least` and `most` bound what may be written to it."""

    unit: str = ""
    doc: str = ""
    least: float = -math.inf
    most: float = math.inf
    role: Role = Role.INTERNAL
    feature: int = 0
    """Bit of `achse.motion.features` that a value other than 0 sets when it is written."""


# Any: declarations are annotated with the type of the value, not of its description
def real(
    default: float, unit: str, doc: str, least: float = -math.inf, most: float = math.inf
) -> Any:
    return Field(default, unit=unit, doc=doc, least=least, most=most)


def whole(default: int, unit: str, doc: str, least: float = 0, most: float = 0xFFFF_FFFF) -> Any:
    return Field(default, unit=unit, doc=doc, least=least, most=most)


def flag(default: int, doc: str) -> Any:
    return Field(default, unit="0/1", doc=doc, least=0, most=1)


def floats(length: int, unit: str, doc: str) -> Any:
    return Field(0.0, length, unit=unit, doc=doc)


def ints(length: int, unit: str, doc: str) -> Any:
    return Field(0, length, unit=unit, doc=doc)
