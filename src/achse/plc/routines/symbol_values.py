"""Parts of the values of PLC variables, and real numbers as text."""

import math
from struct import pack, unpack
from typing import Any

from achse.iec.structs import StructType
from achse.iec.variables import Variable


def members(type: StructType[Any]) -> list[Variable[Any, Any]]:
    """Return the members that clients see, those of its bases first."""
    inherited = [] if type.shown_base is None else members(type.shown_base)
    known = {member.name.lower() for member in inherited}
    own = (member for member in type.shown if member.in_memory and not member.apart)
    return [*inherited, *(member for member in own if member.name.lower() not in known)]


def real_text(value: float, size: int) -> str:
    """Return a number with the fewest digits that bring it back. `size`: bytes of the number."""
    if size == 4 and math.isfinite(value):
        for digits in range(1, 10):
            text = f"{value:.{digits}g}"
            if unpack("<f", pack("<f", float(text)))[0] == value:
                return text
    return repr(value).removesuffix(".0")
