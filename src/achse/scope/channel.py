"""A channel of a scope: which value of which device it records, and how often.

In words: `MAIN.fLevel`, `500:Axes.X.SetPos`, `500:0x4101:0x0A`, `500:0x4101:0x0A:REAL64`; behind
an `@` the sample time, `MAIN.fLevel@2ms`. In JSON: an object with the names of the fields here.
"""

import math
import re
from dataclasses import dataclass
from typing import Any

from achse.scope.types import ScopeError, type_of_words

LONGEST_NAME = 255
"""Characters of a channel's name, and of a symbol's."""

_PLACE = re.compile(r"(0x[0-9a-f]+|\d+):(0x[0-9a-f]+|\d+)(?::(\w+))?", re.IGNORECASE)
_TIME = re.compile(r"([0-9.eE+-]+)\s*(ns|us|µs|ms|s)")
_UNITS_NS = {"ns": 1, "us": 1_000, "µs": 1_000, "ms": 1_000_000, "s": 1_000_000_000}
_LONGEST_NS = 3_600_000_000_000


@dataclass(frozen=True, slots=True)
class ScopeChannel:
    """One channel. Without `symbol`, `index_group` and `index_offset` say where the value is."""

    name: str
    """Name of the channel in exports; unique within a scope."""
    symbol: str = ""
    index_group: int = 0
    index_offset: int = 0
    port: int = 0
    """AMS port of the device; 0: the default port of the scope."""
    type: str = ""
    """A name of `SCOPE_TYPES`; empty: as the symbol or the row says."""
    sample_time_ns: int = 0
    """0: the cycle of the task that has the value."""
    scale: float = 1.0
    offset: float = 0.0
    """Offset of the displayed value, which is `raw * scale + offset`."""
    unit: str = ""
    comment: str = ""

    @property
    def scaled(self) -> bool:
        return self.scale != 1.0 or self.offset != 0.0

    def document(self) -> dict[str, Any]:
        """Return the channel as JSON has it."""
        place: dict[str, Any] = {"symbol": self.symbol}
        if not self.symbol:
            place = {"index_group": self.index_group, "index_offset": self.index_offset}
        optional = {
            "type": self.type,
            "sample_time": self.sample_time_ns / 1e9,
            "unit": self.unit,
            "comment": self.comment,
        }
        if self.scaled:
            optional |= {"scale": self.scale, "offset": self.offset}
        document = {"name": self.name, "port": self.port, **place}
        return document | {
            key: value for key, value in optional.items() if value or key == "offset"
        }


def channel_of(document: Any, key: str = "channel") -> ScopeChannel:
    """Return a channel from words or from JSON; `key` names it in errors. Raises ScopeError."""
    if isinstance(document, ScopeChannel):
        return document
    if isinstance(document, str):
        return _of_words(document, key)
    if not isinstance(document, dict):
        raise ScopeError(f"{key}: expected words or an object, got {document!r:.80}")
    return _of_document(document, key)


def _of_words(words: str, key: str) -> ScopeChannel:
    text, _, time = words.strip().partition("@")
    port, sample_time_ns = 0, 0
    if time:
        sample_time_ns = nanoseconds(time, f"{key} {words!r:.80}")
    head, colon, rest = text.partition(":")
    if colon and head.strip().isdecimal():
        port = _whole(int(head[:20]), 1, 0xFFFF, f"{key} {words!r:.80}: port")
        text = rest
    text = text.strip()
    if not text or len(text) > LONGEST_NAME:
        raise ScopeError(
            f"{key}: expected a symbol, PORT:SYMBOL or PORT:GROUP:OFFSET[:TYPE], got {words!r:.80}"
        )
    place = _PLACE.fullmatch(text)
    if place is None:
        return ScopeChannel(_shown(text), symbol=text, port=port, sample_time_ns=sample_time_ns)
    group, offset = (
        _whole(int(number, 0), 0, 0xFFFF_FFFF, f"{key} {words!r:.80}: {what}")
        for number, what in ((place[1], "index group"), (place[2], "index offset"))
    )
    return ScopeChannel(
        f"{port}:0x{group:X}:0x{offset:X}",
        index_group=group,
        index_offset=offset,
        port=port,
        type=_type_name(place[3] or "", key),
        sample_time_ns=sample_time_ns,
    )


_KEYS = {
    "name", "symbol", "index_group", "index_offset", "port", "type", "sample_time", "scale",
    "offset", "unit", "comment",
}  # fmt: skip


def _of_document(document: dict[str, Any], key: str) -> ScopeChannel:
    unknown = sorted(set(document) - _KEYS)
    if unknown:
        raise ScopeError(
            f"{key}.{unknown[0]:.80}: no such key, there are {', '.join(sorted(_KEYS))}"
        )
    symbol = _text(document, "symbol", key)
    if bool(symbol) == ("index_group" in document):
        raise ScopeError(f"{key}: expected either a symbol or index_group and index_offset")
    group = _whole(document.get("index_group", 0), 0, 0xFFFF_FFFF, f"{key}.index_group")
    offset = _whole(document.get("index_offset", 0), 0, 0xFFFF_FFFF, f"{key}.index_offset")
    port = _whole(document.get("port", 0), 0, 0xFFFF, f"{key}.port")
    time = document.get("sample_time", 0)
    if isinstance(time, str):
        sample_time_ns = nanoseconds(time, f"{key}.sample_time")
    else:
        seconds = _number(time, f"{key}.sample_time")
        if not 0 <= seconds <= _LONGEST_NS / 1e9:
            raise ScopeError(f"{key}.sample_time: expected seconds up to 3600, got {time!r:.80}")
        sample_time_ns = round(seconds * 1e9)
    return ScopeChannel(
        name=_shown(_text(document, "name", key) or symbol or f"{port}:0x{group:X}:0x{offset:X}"),
        symbol=symbol,
        index_group=group,
        index_offset=offset,
        port=port,
        type=_type_name(_text(document, "type", key), key),
        sample_time_ns=sample_time_ns,
        scale=_number(document.get("scale", 1.0), f"{key}.scale"),
        offset=_number(document.get("offset", 0.0), f"{key}.offset"),
        unit=_shown(_text(document, "unit", key)),
        comment=_shown(_text(document, "comment", key)),
    )


def _text(document: dict[str, Any], name: str, key: str) -> str:
    text = document.get(name, "")
    if not isinstance(text, str) or len(text) > LONGEST_NAME:
        raise ScopeError(f"{key}.{name}: expected a text of up to {LONGEST_NAME}, got {text!r:.80}")
    return text.strip()


def _shown(text: str) -> str:
    """Return a text in one line: exports have a channel per column."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def _whole(value: Any, low: int, high: int, key: str) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
        raise ScopeError(f"{key}: expected a whole number {low}..{high}, got {value!r:.80}")
    return value


def _number(value: Any, key: str) -> float:
    try:
        if not isinstance(value, bool) and isinstance(value, int | float) and math.isfinite(value):
            return float(value)
    except OverflowError:
        pass
    raise ScopeError(f"{key}: expected a number, got {value!r:.80}")


def _type_name(text: str, key: str) -> str:
    if not text:
        return ""
    scope_type = type_of_words(text)
    if scope_type is None:
        raise ScopeError(
            f"{key}.type: expected BIT, INT8 … UINT64, REAL32 or REAL64, got {text!r:.80}"
        )
    return scope_type.name


def nanoseconds(text: str, key: str) -> int:
    """`2ms` and the like. Raises ScopeError."""
    match = _TIME.fullmatch(text.strip())
    try:
        value = float(match[1]) * _UNITS_NS[match[2]] if match else math.nan
    except ValueError:
        value = math.nan
    if not 1 <= value <= _LONGEST_NS:
        raise ScopeError(f"{key}: expected a time such as 2ms, up to 3600s, got {text!r:.80}")
    return round(value)
