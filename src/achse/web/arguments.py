"""The arguments of a call, read with their types."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from achse.web.messages import CallError

_LONGEST = 4096
_MOST_NAMES = 1000


class Arguments:
    """The fields of a call; what is missing or of another type is a CallError that names it."""

    def __init__(self, fields: Mapping[str, Any]) -> None:
        self.fields = fields

    def __contains__(self, name: str) -> bool:
        return self.fields.get(name) is not None

    def text(self, name: str, default: str | None = None) -> str:
        """Return a text of up to 4096 characters."""
        value = self.fields.get(name)
        if value is None and default is not None:
            return default
        if not isinstance(value, str) or len(value) > _LONGEST:
            raise CallError(f"{name}: expected a text of up to {_LONGEST} signs, got {value!r:.60}")
        return value

    def choice(self, name: str, choices: Sequence[str], default: str | None = None) -> str:
        """One of some words."""
        value = self.text(name, default)
        if value not in choices:
            raise CallError(f"{name}: expected {', '.join(choices)}, got {value!r:.60}")
        return value

    def number(
        self,
        name: str,
        default: float | None = None,
        least: float = -math.inf,
        most: float = math.inf,
    ) -> float:
        """Return a finite number within a range."""
        value = self.fields.get(name)
        if value is None and default is not None:
            return default
        try:
            whole_or_real = isinstance(value, int | float) and not isinstance(value, bool)
            number = float(value) if whole_or_real and value is not None else math.nan
        except OverflowError:
            number = math.nan
        if not (math.isfinite(number) and least <= number <= most):
            raise CallError(
                f"{name}: expected {_range('a number', least, most)}, got {value!r:.60}"
            )
        return number

    def integer(
        self, name: str, default: int | None = None, least: int = 0, most: int = 0xFFFF_FFFF
    ) -> int:
        """Return a whole number within a range."""
        value = self.fields.get(name)
        if value is None and default is not None:
            return default
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            expected = _range("a whole number", least, most)
            raise CallError(f"{name}: expected {expected}, got {value!r:.60}")
        return value

    def flag(self, name: str, default: bool = False) -> bool:
        """True or false."""
        value = self.fields.get(name, default)
        if not isinstance(value, bool):
            raise CallError(f"{name}: expected true or false, got {value!r:.60}")
        return value

    def names(self, name: str, most: int = _MOST_NAMES) -> list[str]:
        """Return a list of texts, each once."""
        value = self.fields.get(name)
        good = isinstance(value, list) and all(
            isinstance(each, str) and 0 < len(each) <= _LONGEST for each in value
        )
        if not good or not isinstance(value, list) or len(value) > most:
            raise CallError(f"{name}: expected a list of up to {most} names, got {value!r:.60}")
        return list(dict.fromkeys(value))

    def value(self, name: str) -> Any:
        """Return the value as it was sent, of any type. Raises CallError without it."""
        if name not in self.fields:
            raise CallError(f"{name}: expected a value")
        return self.fields[name]


def _range(what: str, least: float, most: float) -> str:
    low = "" if least == -math.inf else f"{least:g}"
    high = "" if most == math.inf else f"{most:g}"
    return what if not low and not high else f"{what} {low}..{high}"
