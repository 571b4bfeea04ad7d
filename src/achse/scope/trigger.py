"""Triggers: what a channel has to do for a recording to be about that moment.

Each kind is a row: a band of values, whether being in it or out of it counts, and whether it must
come about (an edge) or be so (a level). In words: `MAIN.bStart rising`, `MAIN.fLevel rising 80`,
`MAIN.fLevel above 80`, `MAIN.fLevel leaves 20 80`.
"""

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from achse.scope.channel import LONGEST_NAME
from achse.scope.types import ScopeError, ScopeType


class TriggerEvent(IntEnum):
    """Sample in which a condition fires."""

    HOLDS = 0
    """In each sample in which it is true."""
    BEGINS = 1
    """In the sample in which it is true and was false in the one before."""
    CHANGES = 2
    """In the sample in which it is other than in the one before."""


@dataclass(frozen=True, slots=True)
class TriggerKind:
    """One kind of trigger."""

    bounds: int
    """Number of bounds: 1 for a level, 2 for a window."""
    from_first: bool
    """True if the band begins at the first bound; else the band ends there."""
    inverted: bool
    """True if the condition is true for values outside the band."""
    event: TriggerEvent
    meaning: str


TRIGGER_KINDS: dict[str, TriggerKind] = {
    "rising": TriggerKind(1, True, False, TriggerEvent.BEGINS, "was below LEVEL, reaches it"),
    "falling": TriggerKind(1, False, False, TriggerEvent.BEGINS, "was above LEVEL, reaches it"),
    "edge": TriggerKind(1, True, False, TriggerEvent.CHANGES, "crosses LEVEL, up or down"),
    "above": TriggerKind(1, False, True, TriggerEvent.HOLDS, "is above LEVEL"),
    "below": TriggerKind(1, True, True, TriggerEvent.HOLDS, "is below LEVEL"),
    "enters": TriggerKind(2, True, False, TriggerEvent.BEGINS, "comes into LOW … HIGH"),
    "leaves": TriggerKind(2, True, True, TriggerEvent.BEGINS, "goes out of LOW … HIGH"),
    "inside": TriggerKind(2, True, False, TriggerEvent.HOLDS, "is in LOW … HIGH"),
    "outside": TriggerKind(2, True, True, TriggerEvent.HOLDS, "is not in LOW … HIGH"),
}
"""Kinds of triggers by name; bounds belong to the window."""

_BOOL_LEVEL = 0.5
"""The level where none is given: an edge of a BOOL."""

_NAMES = (("level",), ("low", "high"))


_NO_KEYS = 0, -1
"""A band without any."""


@dataclass(frozen=True, slots=True)
class TriggerBand:
    """A trigger for the values of one type: keys are those of `ScopeType.key`."""

    low: int
    high: int
    inverted: bool
    event: TriggerEvent


@dataclass(frozen=True, slots=True)
class ScopeTrigger:
    """One trigger on a channel of the same scope; `bounds` are raw values, not scaled."""

    channel: str
    kind: str
    bounds: tuple[float, ...] = (_BOOL_LEVEL,)

    def __str__(self) -> str:
        return " ".join((self.channel, self.kind, *(f"{bound:g}" for bound in self.bounds)))

    def band(self, type: ScopeType) -> TriggerBand:
        """Return the band of the trigger for values of this type."""
        kind = TRIGGER_KINDS[self.kind]
        low, high = type.keys
        if kind.from_first:
            low = type.key_from(self.bounds[0])
        if kind.bounds == 2 or not kind.from_first:
            high = type.key_up_to(self.bounds[-1])
        if low > high or low > type.keys[1] or high < type.keys[0]:
            low, high = _NO_KEYS
        return TriggerBand(low, high, kind.inverted, kind.event)

    def document(self) -> dict[str, Any]:
        """Return the trigger as JSON has it."""
        names = _NAMES[TRIGGER_KINDS[self.kind].bounds - 1]
        return {
            "channel": self.channel,
            "kind": self.kind,
            **dict(zip(names, self.bounds, strict=True)),
        }


def trigger_of(document: Any, key: str = "trigger") -> ScopeTrigger:
    """Return a trigger from words or from JSON; `key` names it in errors. Raises ScopeError."""
    if isinstance(document, ScopeTrigger):
        return document
    if isinstance(document, str):
        words = document.split()
        at = next((n for n, word in enumerate(words) if n and word.lower() in TRIGGER_KINDS), 0)
        if not at:
            raise ScopeError(
                f"{key}: expected CHANNEL KIND [LEVEL | LOW HIGH] with one of"
                f" {', '.join(TRIGGER_KINDS)}, got {document!r:.80}"
            )
        bounds = tuple(_bound(word, key) for word in words[at + 1 :])
        return _checked(" ".join(words[:at]), words[at].lower(), bounds, key)
    if not isinstance(document, dict):
        raise ScopeError(f"{key}: expected words or an object, got {document!r:.80}")
    name, word = document.get("channel"), document.get("kind")
    if not isinstance(name, str) or not 0 < len(name) <= LONGEST_NAME:
        raise ScopeError(f"{key}.channel: expected the name of a channel, got {name!r:.80}")
    if not isinstance(word, str) or word not in TRIGGER_KINDS:
        raise ScopeError(f"{key}.kind: expected {', '.join(TRIGGER_KINDS)}, got {word!r:.80}")
    names = _NAMES[TRIGGER_KINDS[word].bounds - 1]
    unknown = sorted(set(document) - {"channel", "kind", *names})
    if unknown:
        raise ScopeError(f"{key}.{unknown[0]:.80}: {word} takes {', '.join(names)}")
    return _checked(
        name, word, tuple(_bound(document[each], key) for each in names if each in document), key
    )


def _checked(channel: str, word: str, bounds: tuple[float, ...], key: str) -> ScopeTrigger:
    count = TRIGGER_KINDS[word].bounds
    if not bounds and count == 1:
        bounds = (_BOOL_LEVEL,)
    if len(bounds) != count:
        names = " and ".join(_NAMES[count - 1])
        raise ScopeError(f"{key}: {word} takes {names}, got {len(bounds)} numbers")
    if bounds[0] > bounds[-1]:
        raise ScopeError(f"{key}: expected low up to high, got {bounds[0]:g} and {bounds[-1]:g}")
    return ScopeTrigger(channel, word, bounds)


def _bound(value: Any, key: str) -> float:
    try:
        number = float(value) if not isinstance(value, bool) else float(int(value))
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise ScopeError(f"{key}: expected a finite number, got {value!r:.80}")
    return number
