"""What a fault is: its kind, whom it hits, when it begins and ends."""

import dataclasses
import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any, ClassVar, NamedTuple, Self

from achse.ams import AmsAddress, Command, NetId
from achse.codes import NcError, ReturnCode

__all__ = [
    "COMMANDS",
    "FAULT_KINDS",
    "ActiveFault",
    "Fault",
    "FaultError",
    "FaultFields",
    "FaultKind",
    "client_test",
    "seconds",
]


_LONGEST_S = 1_000_000_000
"""Seconds; no test waits for thirty years."""


class FaultError(ValueError):
    """A fault cannot be: says what was expected and what came."""


class FaultKind(NamedTuple):
    """One kind of fault: what it takes beside `at` and its end, and what happens."""

    name: str
    takes: frozenset[str]
    description: str
    needs: tuple[str, ...] = ()
    lasts: bool = True
    """False for an event, which is over as soon as it has begun."""


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class FaultFields:
    """What faults of all sorts have in common: a kind of a table, fields, times.

    A subclass adds the fields that its kinds take. Raises FaultError for what a kind does not take.
    """

    kinds: ClassVar[Mapping[str, FaultKind]] = {}

    kind: str
    at: float | None = None
    """Station time at which it begins, s; None: now."""
    lasting: float | None = None
    """Seconds until it ends; None: until cleared, or `count` is reached."""
    count: int | None = None
    """It ends after so many frames."""

    @classmethod
    def parameters(cls, kind: FaultKind) -> list[str]:
        """Everything a kind takes beside `kind` and `at`, in the order of the fields."""
        takes = kind.takes | {"lasting"} if kind.lasts else kind.takes
        return [field.name for field in dataclasses.fields(cls) if field.name in takes]

    def __post_init__(self) -> None:
        kind = self.kinds.get(self.kind)
        if kind is None:
            raise FaultError(f"kind: expected one of {', '.join(self.kinds)}; got {self.kind!r}")
        given = {
            field.name
            for field in dataclasses.fields(self)
            if field.name not in ("kind", "at") and getattr(self, field.name) != field.default
        }
        takes = self.parameters(kind)
        if surplus := sorted(given.difference(takes)):
            raise FaultError(f"{surplus[0]}: {self.kind} takes {', '.join(takes) or 'nothing'}")
        if missing := [name for name in kind.needs if name not in given]:
            raise FaultError(f"{missing[0]}: a fault of kind {self.kind} needs it")
        self.within(("at", 0, _LONGEST_S), ("lasting", 0, _LONGEST_S), ("count", 1, None))
        self.check_values()

    def check_values(self) -> None:
        """Raise FaultError for a value that a field of the subclass cannot have."""

    def within(self, *limits: tuple[str, float, float | None]) -> None:
        """Raise FaultError unless each field is None or between its limits."""
        for name, least, most in limits:
            value = getattr(self, name)
            if value is not None and not (
                least <= value < math.inf and (most is None or value <= most)
            ):
                expected = f"{least} or more" if most is None else f"{least}..{most}"
                raise FaultError(f"{name}: expected {expected}, got {value}")

    @classmethod
    def of(cls, fields: Mapping[str, Any]) -> Self:
        """From a table of fields, as JSON and TOML have it; raises FaultError."""
        known = {field.name: field.type for field in dataclasses.fields(cls)}
        for name, value in fields.items():
            if name not in known:
                raise FaultError(f"{name}: a fault has {', '.join(known)}")
            kind = str(known[name])
            right = (
                isinstance(value, str)
                if "str" in kind
                else isinstance(value, int | float if "float" in kind else int)
                and not isinstance(value, bool)
            )
            if not right and not (value is None and "None" in kind):
                raise FaultError(f"{name}: expected {kind.split(' ')[0]}, got {value!r}")
        if "kind" not in fields:
            raise FaultError(f"kind: expected one of {', '.join(cls.kinds)}")
        return cls(**fields)

    @classmethod
    def parse(cls, kind: str, fields: Iterable[str]) -> Self:
        """From texts like `code=0x706`, `by=50ms`, `at=2`; raises FaultError."""
        kinds = {field.name: str(field.type) for field in dataclasses.fields(cls)}
        values: dict[str, Any] = {"kind": kind}
        for text in fields:
            name, equals, value = text.partition("=")
            if not equals or name not in kinds:
                raise FaultError(
                    f"expected KEY=VALUE with a key of {', '.join(kinds)}; got {text!r}"
                )
            try:
                if "float" in kinds[name]:
                    values[name] = seconds(value)
                else:
                    values[name] = int(value, 0) if "int" in kinds[name] else value
            except ValueError:
                raise FaultError(f"{name}: expected a number, got {value!r}") from None
        return cls.of(values)

    def fields(self) -> dict[str, Any]:
        """What was given, as JSON and TOML have it."""
        return {
            field.name: value
            for field in dataclasses.fields(self)
            if (value := getattr(self, field.name)) != field.default
        }

    def __str__(self) -> str:
        return " ".join(
            [self.kind]
            + [
                f"{name}={self.told(name, value)}"
                for name, value in self.fields().items()
                if name != "kind"
            ]
        )

    def told(self, name: str, value: Any) -> str:
        """A field's value in words."""
        return str(value)


_WHOM = frozenset({"client", "port"})
_REQUESTS = _WHOM | {"command", "group", "offset", "symbol", "count", "every"}
_SIDES = _REQUESTS | {"side"}

FAULT_KINDS: Mapping[str, FaultKind] = {
    kind.name: kind
    for kind in (
        FaultKind("drop", _SIDES, "Frames vanish: the answer never comes."),
        FaultKind("delay", _SIDES | {"by"}, "Frames arrive `by` seconds late.", ("by",)),
        FaultKind("duplicate", _SIDES, "Frames arrive twice."),
        FaultKind(
            "reorder",
            _SIDES | {"by"},
            "Of two frames in a row the second arrives first; one that stays alone arrives"
            " `by` seconds late (0.1).",
        ),
        FaultKind(
            "cut", _REQUESTS, "Half of the answer is sent, then the connection ends (TCP only)."
        ),
        FaultKind(
            "truncate",
            _SIDES | {"size"},
            "The data of a frame lack their last `size` bytes (1); the header is right.",
        ),
        FaultKind("wrong_invoke_id", _REQUESTS, "The answer has an invoke id nobody asked with."),
        FaultKind(
            "error",
            _REQUESTS | {"code"},
            "The request is refused with `code` in the result; on a symbol or service also inside"
            " sums.",
            ("code",),
        ),
        FaultKind(
            "router_error",
            _REQUESTS | {"code"},
            "The request is refused with `code` in the AMS header, as a router does.",
            ("code",),
        ),
        FaultKind("drop_link", frozenset({"client"}), "TCP connections break off.", lasts=False),
        FaultKind("refuse_links", frozenset(), "New TCP connections are closed at once."),
        FaultKind(
            "one_connection",
            frozenset(),
            "One TCP connection per remote host: a second one closes the first.",
        ),
        FaultKind(
            "online_change",
            frozenset({"port"}),
            "The PLC has a new symbol version: handles are stale, values stay.",
            lasts=False,
        ),
        FaultKind(
            "download",
            frozenset({"port"}),
            "A new PLC program: initial values, new symbol version, all handles and"
            " notifications gone.",
            lasts=False,
        ),
        FaultKind("restart", frozenset(), "The whole station restarts in RUN.", lasts=False),
        FaultKind("config", frozenset(), "The station is in CONFIG: no PLC, no NC."),
        FaultKind(
            "slow_cycle",
            frozenset({"port", "factor"}),
            "PLC cycles take `factor` times their cycle time (2), those in between are lost.",
        ),
    )
}
"""Every kind of fault, for Python, station.toml and the command line alike."""

COMMANDS = {command.name.lower(): command for command in Command}
"""What `command` may name."""


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class Fault(FaultFields):
    """One fault of a station. Fields that are not given select everything."""

    kinds: ClassVar[Mapping[str, FaultKind]] = FAULT_KINDS

    every: int = 1
    """Only each n-th of the selected frames is hit."""
    side: str = "answer"
    """`answer` (the request was carried out) or `request`."""
    client: str = ""
    """A NetId, an AMS address or an IP address."""
    port: int | None = None
    """The AMS port of the device."""
    command: str = ""
    """An ADS command in lower case: read, write, read_write, notification, …"""
    group: int | None = None
    offset: int | None = None
    symbol: str = ""
    """Whatever reads or writes this variable: by name, handle or address."""
    code: int | None = None
    by: float | None = None
    size: int | None = None
    factor: int | None = None

    def check_values(self) -> None:
        """Raise FaultError for a value that a field cannot have."""
        self.within(
            ("every", 1, None),
            ("by", 0, _LONGEST_S),
            ("size", 1, None),
            ("factor", 2, 1000),
            ("port", 0, 0xFFFF),
            ("group", 0, 0xFFFF_FFFF),
            ("offset", 0, 0xFFFF_FFFF),
            ("code", 1, 0xFFFF_FFFF),
        )
        if self.side not in ("request", "answer"):
            raise FaultError(f"side: expected request or answer, got {self.side!r}")
        if self.command and self.command not in COMMANDS:
            raise FaultError(
                f"command: expected one of {', '.join(COMMANDS)}; got {self.command!r}"
            )
        if self.offset is not None and self.group is None:
            raise FaultError("offset: needs a group")

    def told(self, name: str, value: Any) -> str:
        """A field's value in words: codes with their names, groups and offsets in hexadecimal."""
        if name == "code":
            row = ReturnCode.of(value) or NcError.of(value)
            return f"0x{value:X}" + (f" ({row.name})" if row else "")
        return f"0x{value:X}" if name in ("group", "offset") else str(value)


def seconds(text: str) -> float:
    """`2`, `2s`, `50ms`; raises ValueError."""
    for unit, factor in (("ms", 1e-3), ("us", 1e-6), ("s", 1.0)):
        if text.endswith(unit):
            return float(text.removesuffix(unit)) * factor
    return float(text)


class ActiveFault:
    """A fault that waits for its time or is at work."""

    def __init__(self, number: int, fault: Fault, begins_ns: int) -> None:
        self.number = number
        self.fault = fault
        self.begins_ns = begins_ns
        self.state = "waiting"
        """`waiting`, `active`, `over`."""
        self.hits = 0
        self._seen = 0
        self.undo: Callable[[], None] | None = None

    def take(self) -> bool:
        """Whether the frame that was selected now is hit."""
        if self.state != "active":
            return False
        self._seen += 1
        if self._seen % self.fault.every:
            return False
        self.hits += 1
        return True

    @property
    def used_up(self) -> bool:
        return self.fault.count is not None and self.hits >= self.fault.count

    def facts(self) -> dict[str, Any]:
        """As JSON has it."""
        return {
            "number": self.number,
            "state": self.state,
            "hits": self.hits,
            "fault": self.fault.fields(),
        }


def client_test(client: str) -> Callable[[bytes, str], bool]:
    """Whether an AMS address and the host it came from are the client that a fault names."""
    if not client:
        return lambda address, host: True
    try:
        wanted = bytes(AmsAddress(client)) if ":" in client else bytes(NetId(client))
    except ValueError:
        if client.count(".") != 3:
            raise FaultError(
                f"client: expected a NetId, an AMS address or an IP address, got {client!r}"
            ) from None
        return lambda address, host: host == client
    return lambda address, host: address.startswith(wanted)
