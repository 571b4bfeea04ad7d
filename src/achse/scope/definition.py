"""Definition of a scope: channels, record length, triggers; as an object, and as JSON.

A file with the ending `.scp` is such a document in UTF-8. Files of the vendor's tools have another
format that no manual describes; they are refused.
"""

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from achse.scope.channel import LONGEST_NAME, ScopeChannel, channel_of
from achse.scope.trigger import ScopeTrigger, trigger_of
from achse.scope.types import ScopeError

DEFAULT_LENGTH = 10.0
LONGEST_RECORD = 3600.0
"""Seconds. The manual prints no unit and no range (000 §5.2); ours are seconds, above 0 to 3600."""

MOST_CHANNELS = 1024
"""Of one scope."""
MOST_TRIGGERS = 64
"""Of one scope."""

_KEYS = ("name", "record_length", "pretrigger", "channels", "triggers", "combine")


@dataclass(frozen=True, slots=True)
class ScopeDefinition:
    """Everything a scope needs to know before it starts."""

    channels: tuple[ScopeChannel, ...] = ()
    triggers: tuple[ScopeTrigger, ...] = ()
    name: str = "scope"
    record_length: float = DEFAULT_LENGTH
    """Seconds that the ring of each channel holds."""
    pretrigger: float = 0.0
    """Share of the length that is before the trigger, 0 to below 1."""
    combine: str = field(default="any")
    """Combination of the triggers: `any` is enough, or `all` must fire in the same sample."""

    def with_length(self, seconds: float) -> "ScopeDefinition":
        """Return the same with another record length. Raises ScopeError."""
        return replace(self, record_length=_length(seconds, "record_length"))

    @property
    def length_ns(self) -> int:
        return max(round(self.record_length * 1e9), 1)

    def document(self) -> dict[str, Any]:
        """Return the definition as JSON has it."""
        return {
            "name": self.name,
            "record_length": self.record_length,
            "pretrigger": self.pretrigger,
            "combine": self.combine,
            "channels": [channel.document() for channel in self.channels],
            "triggers": [trigger.document() for trigger in self.triggers],
        }


def parse_definition(text: bytes) -> ScopeDefinition:
    """Return the definition in a file or a request. Raises ScopeError."""
    try:
        document = json.loads(text.rstrip(b"\0"))
    except (ValueError, RecursionError):
        raise ScopeError(
            "expected a JSON document with channels, triggers, record_length …"
        ) from None
    if not isinstance(document, dict):
        raise ScopeError(f"expected a JSON object, got {type(document).__name__}")
    return definition_of(document)


def definition_of(document: Mapping[str, Any]) -> ScopeDefinition:
    """Return a definition from its parts. Raises ScopeError."""
    unknown = sorted(set(document) - set(_KEYS))
    if unknown:
        raise ScopeError(f"{unknown[0]:.80}: no such key, there are {', '.join(_KEYS)}")
    name = document.get("name", "scope")
    if not isinstance(name, str) or not name.strip() or len(name) > LONGEST_NAME:
        raise ScopeError(f"name: expected a text of up to {LONGEST_NAME}, got {name!r:.80}")
    pretrigger = document.get("pretrigger", 0.0)
    if not _is_number(pretrigger) or not 0 <= pretrigger < 1:
        raise ScopeError(f"pretrigger: expected a share from 0 to below 1, got {pretrigger!r:.80}")
    combine = document.get("combine", "any")
    if combine not in ("any", "all"):
        raise ScopeError(f"combine: expected any or all, got {combine!r:.80}")
    channels = [
        channel_of(each, f"channels[{number}]")
        for number, each in enumerate(_items(document, "channels", MOST_CHANNELS), 1)
    ]
    triggers = [
        trigger_of(each, f"triggers[{number}]")
        for number, each in enumerate(_items(document, "triggers", MOST_TRIGGERS), 1)
    ]
    names = [channel.name for channel in channels]
    there = set(names)
    if len(there) < len(names):
        twice = next(each for each in names if names.count(each) > 1)
        raise ScopeError(f"channels: each name once, got {twice!r} more than once")
    for number, trigger in enumerate(triggers, 1):
        if trigger.channel not in there:
            raise ScopeError(
                f"triggers[{number}].channel: expected one of the channels, got {trigger.channel!r}"
            )
    return ScopeDefinition(
        tuple(channels),
        tuple(triggers),
        " ".join(name.split()),
        _length(document.get("record_length", DEFAULT_LENGTH), "record_length"),
        float(pretrigger),
        combine,
    )


def _items(document: Mapping[str, Any], key: str, most: int) -> Iterable[Any]:
    items = document.get(key, ())
    if not isinstance(items, list | tuple):
        raise ScopeError(f"{key}: expected a list, got {items!r:.80}")
    if len(items) > most:
        raise ScopeError(f"{key}: expected up to {most}, got {len(items)}")
    return items


def _length(value: Any, key: str) -> float:
    if not _is_number(value) or not 0 < value <= LONGEST_RECORD:
        raise ScopeError(f"{key}: expected seconds above 0, up to 3600, got {value!r:.80}")
    return float(value)


def _is_number(value: Any) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return isinstance(value, int) or math.isfinite(value)
