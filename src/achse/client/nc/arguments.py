"""Arguments of motion methods, checked before they are sent: a NaN never reaches a controller."""

from collections.abc import Mapping
from math import isfinite
from typing import SupportsFloat, SupportsIndex, TypeVar

from achse.codes.axis import BufferMode

V = TypeVar("V")

_LONGEST = 1e9
"""Seconds, some thirty years; a limit beyond is as good as none."""


def real(name: str, value: SupportsFloat | SupportsIndex) -> float:
    """Return a finite number. ValueError if it is not one."""
    try:
        number = float(value) if not isinstance(value, str | bytes) else None
    except (TypeError, ValueError, OverflowError):
        number = None
    if number is None or not isfinite(number):
        raise ValueError(f"{name}: expected a finite number, got {value!r:.60}")
    return number


def seconds(name: str, value: float | None) -> float | None:
    """Return a time limit of 0 s or more, None for none. ValueError if it is not one."""
    if value is None or value == float("inf"):
        return None
    number = real(name, value)
    if number < 0.0:
        raise ValueError(f"{name}: expected 0 s or more, got {value!r:.60}")
    return number if number < _LONGEST else None


def choice(name: str, value: str, choices: Mapping[str, V]) -> V:
    """Return the value for a word. ValueError with the known words."""
    try:
        return choices[value]
    except (KeyError, TypeError):
        words = ", ".join(map(repr, choices))
        raise ValueError(f"{name}: expected {words}, got {value!r:.60}") from None


_BUFFER_MODES = {mode.name.lower().replace("_", " "): mode for mode in BufferMode}


def buffer_mode(value: BufferMode | str) -> BufferMode:
    """Return a buffer mode, or one by its name: `"buffered"`, `"blending low"`. ValueError."""
    if isinstance(value, BufferMode):
        return value
    words = value.strip().lower().replace("_", " ") if isinstance(value, str) else value
    return choice("buffer", words, _BUFFER_MODES)
