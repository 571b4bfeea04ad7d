"""Base of all faults: checked fields, a begin and an end; and families of kinds of faults."""

import inspect
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, Any, Generic, TypeVar, get_args

from pydantic import BaseModel, BeforeValidator, ConfigDict, PlainValidator, ValidationError

from achse.iec.nearest import did_you_mean

LONGEST_S = 1_000_000_000
"""Seconds; no test waits for thirty years."""

MOST_FAULTS = 256
"""Of one list: each frame and each cycle looks at all of them, and clients add them."""

Undo = Callable[[], None]
"""Function that ends a fault."""


class FaultError(ValueError):
    """A fault cannot be: says what was expected and what came."""


@dataclass(frozen=True, slots=True)
class FieldUnit:
    """The unit of a field, in brackets beside its check: `Annotated[float, FieldUnit("s")]`."""

    symbol: str


def seconds(text: str) -> float:
    """`2`, `2s`, `50ms`; raises ValueError."""
    for unit, factor in (("ms", 1e-3), ("us", 1e-6), ("s", 1.0)):
        if text.endswith(unit):
            return float(text.removesuffix(unit)) * factor
    return float(text)


def number(kind: type, least: float, most: float | None = None) -> PlainValidator:
    """Return a field's check: a number of `kind`, not a truth value, from `least` to `most`.

    The value is stored as it was written, and shown so.
    """

    def check(value: object) -> object:
        if isinstance(value, bool) or not isinstance(value, int if kind is int else int | float):
            raise ValueError(f"expected {kind.__name__}, got {value!r}")
        if not (least <= value < math.inf and (most is None or value <= most)):
            expected = f"{least} or more" if most is None else f"{least}..{most}"
            raise ValueError(f"expected {expected}, got {value}")
        return value

    return PlainValidator(check)


def text(*choices: str) -> PlainValidator:
    """Return a field's check: a text, one of `choices` if there are any."""

    def check(value: object) -> object:
        if not isinstance(value, str):
            raise ValueError(f"expected str, got {value!r}")
        if value and choices and value not in choices:
            if len(choices) == 2:
                raise ValueError(f"expected {' or '.join(choices)}, got {value!r}")
            raise ValueError(f"expected one of {', '.join(choices)}; got {value!r}")
        return value

    return PlainValidator(check)


def _as_seconds(value: object) -> object:
    """Convert a text such as `50ms`; leave what is a number."""
    if not isinstance(value, str):
        return value
    try:
        return seconds(value)
    except ValueError:
        raise ValueError(f"expected seconds, or a text such as '2s', got {value!r}") from None


Moment = Annotated[float, number(float, 0, LONGEST_S), BeforeValidator(_as_seconds), FieldUnit("s")]
"""Seconds, or a text with a unit: `"1s"`, `"50ms"`."""


class Fault(BaseModel):
    """One fault of some kind. A kind is a subclass: its name, its fields, what it does.

    The first paragraph of its docstring says what happens. `kind` comes first, `at` is the station
    time at which it begins, s; None: now.
    """

    model_config = ConfigDict(
        extra="forbid", frozen=True, arbitrary_types_allowed=True, defer_build=True
    )
    """Most stations have no fault of most kinds: its checks are built for the first one."""

    kind: str
    at: Moment | None = None
    """Station time at which it begins, s; empty: now."""

    def fields(self) -> dict[str, Any]:
        """Return the kind, and the fields that differ from their defaults, for JSON and TOML."""
        values = {
            name: value
            for name, field in type(self).model_fields.items()
            if (value := getattr(self, name)) != field.default
        }
        return {"kind": self.kind, **values}

    def format_value(self, name: str, value: Any) -> str:
        """Return a field's value in words."""
        return str(value)

    def __str__(self) -> str:
        values = self.fields().items()
        fields = [
            f"{name}={self.format_value(name, value)}" for name, value in values if name != "kind"
        ]
        return " ".join([self.kind, *fields])


class LastingFault(Fault):
    """A fault that has an end; others are over as soon as they have begun."""

    lasting: Moment | None = None
    """Seconds until it ends; None: until cleared, or `count` is reached."""


class CountedFault(LastingFault):
    """A fault that can end by itself after some hits."""

    count: Annotated[int, number(int, 1), FieldUnit("frames")] | None = None
    """It ends after so many frames."""
    every: Annotated[int, number(int, 1), FieldUnit("frames")] = 1
    """Only each n-th of the selected frames is hit."""


F = TypeVar("F", bound=Fault)


class FaultKinds(Generic[F]):
    """A family of kinds, which share a list: those of a station, those of drives.

    Fields are listed as the kinds have them, those that `last` names at the end.
    """

    def __init__(self, *kinds: type[F], last: tuple[str, ...] = ()) -> None:
        self.kinds: Mapping[str, type[F]] = {
            str(kind.model_fields["kind"].default): kind for kind in kinds
        }
        """By name."""
        fields = {name: field for kind in kinds for name, field in kind.model_fields.items()}
        names = [*(name for name in fields if name not in last), *last]
        defaults = {
            name: field.default
            for kind in kinds
            for name, field in kind.model_fields.items()
            if not field.is_required()
        }
        self._defaults = {name: defaults.get(name) for name in names}
        self._types = {name: _plain(field.annotation) for name, field in fields.items()}

    def __iter__(self) -> Iterator[str]:
        return iter(self.kinds)

    def description(self, kind: str) -> str:
        """Return the first paragraph of a kind's docstring, which describes its effect."""
        paragraph = (inspect.getdoc(self.kinds[kind]) or "").partition("\n\n")[0]
        return paragraph.replace("\n", " ")

    def parameters(self, kind: str) -> list[str]:
        """Everything a kind takes beside `kind` and `at`."""
        names = self.kinds[kind].model_fields.keys() - {"kind", "at"}
        return [name for name in self._defaults if name in names]

    def types(self, kind: str) -> dict[str, str]:
        """Return the same with what JSON calls their types."""
        names = {int: "integer", float: "number", str: "string"}
        return {name: names[self._types[name]] for name in self.parameters(kind)}

    def unit(self, kind: str, name: str) -> str:
        """Return the unit of a kind's field; empty for texts and numbers without one."""
        field = self.kinds[kind].model_fields[name]
        return _unit((*field.metadata, field.annotation))

    def of(self, fields: Mapping[str, Any]) -> F:
        """From a table of fields, as JSON and TOML have it; raises FaultError."""
        for name in fields:
            if name not in self._defaults:
                near = did_you_mean(name, self._defaults)
                raise FaultError(f"{name}: a fault has {', '.join(self._defaults)}{near}")
        kind = fields.get("kind")
        if kind is None:
            raise FaultError(f"kind: expected one of {', '.join(self.kinds)}")
        if not isinstance(kind, str):
            raise FaultError(f"kind: expected str, got {kind!r}")
        if kind not in self.kinds:
            raise FaultError(
                f"kind: expected one of {', '.join(self.kinds)}; got {kind!r}"
                f"{did_you_mean(kind, self.kinds)}"
            )
        values = {
            name: value
            for name, value in fields.items()
            if value is not None and (name == "kind" or value != self._defaults[name])
        }
        try:
            return self.kinds[kind].model_validate(values)
        except ValidationError as failure:
            raise FaultError(self._error_text(kind, failure)) from None

    def _error_text(self, kind: str, failure: ValidationError) -> str:
        """Return the first fault of all that is wrong: what is too much, what is missing, wrong
        values."""
        errors = failure.errors()
        names = {error["type"]: str(error["loc"][-1]) for error in reversed(errors) if error["loc"]}
        if "extra_forbidden" in names:
            surplus = min(
                str(each["loc"][-1]) for each in errors if each["type"] in "extra_forbidden"
            )
            return f"{surplus}: {kind} takes {', '.join(self.parameters(kind)) or 'nothing'}"
        if "missing" in names:
            return f"{names['missing']}: a fault of kind {kind} needs it"
        first = errors[0]
        where = f"{first['loc'][0]}: " if first["loc"] else ""
        return where + first["msg"].removeprefix("Value error, ")

    def of_table(self, table: Mapping[str, Any]) -> F:
        """From a table of a file, where times may be texts like "50ms"; raises FaultError."""
        fields = dict(table)
        for name, value in table.items():
            if isinstance(value, str) and self._types.get(name) is float:
                fields[name] = self._number(name, value)
        return self.of(fields)

    def parse(self, kind: str, fields: Iterable[str]) -> F:
        """From texts like `code=0x706`, `by=50ms`, `at=2`; raises FaultError."""
        values: dict[str, Any] = {"kind": kind}
        for field in fields:
            name, equals, value = field.partition("=")
            if not equals or name not in self._types:
                raise FaultError(
                    f"expected KEY=VALUE with a key of {', '.join(self._defaults)}; got {field!r}"
                    f"{did_you_mean(name, self._defaults)}"
                )
            values[name] = value if self._types[name] is str else self._number(name, value)
        return self.of(values)

    def _number(self, name: str, text: str) -> float:
        try:
            return seconds(text) if self._types[name] is float else int(text, 0)
        except ValueError:
            raise FaultError(f"{name}: expected a number, got {text!r}") from None


def _plain(annotation: Any) -> type:
    """`int`, `float` or `str`: what a field holds beside None."""
    if annotation in (int, float, str):
        return annotation  # type: ignore[no-any-return]
    for part in get_args(annotation):
        if isinstance(part, str):  # a Literal
            return str
        if part is not type(None):
            return _plain(part)
    raise TypeError(f"expected a field of int, float or str, got {annotation}")


def _unit(parts: Iterable[Any]) -> str:
    """Return the first unit among an annotation's parts, and the parts of those."""
    for part in parts:
        unit = part.symbol if isinstance(part, FieldUnit) else _unit(get_args(part))
        if unit:
            return str(unit)
    return ""


class FaultState(StrEnum):
    """State of a fault on demand, as JSON has it."""

    WAITING = "waiting"
    """Its time has not come."""
    ACTIVE = "active"
    OVER = "over"


class ActiveFault:
    """A fault that waits for its time or is at work."""

    def __init__(self, number: int, fault: Fault, begins_ns: int) -> None:
        self.number = number
        self.fault = fault
        self.begins_ns = begins_ns
        self.state = FaultState.WAITING
        self.hits = 0
        self._frame_count = 0
        counted = fault if isinstance(fault, CountedFault) else None
        self._every = 1 if counted is None else counted.every
        self._count = None if counted is None else counted.count
        self.undo: Undo | None = None
        self.planned: Callable[[], None] | None = None
        """Timer in the station's queue for the fault: its begin or its end."""

    def take(self) -> bool:
        """Count the frame that was selected now; True if the fault hits it."""
        if self.state is not FaultState.ACTIVE:
            return False
        self._frame_count += 1
        if self._frame_count % self._every:
            return False
        self.hits += 1
        return True

    @property
    def used_up(self) -> bool:
        return self._count is not None and self.hits >= self._count

    def facts(self) -> dict[str, Any]:
        """As JSON has it."""
        return {
            "number": self.number,
            "state": self.state,
            "hits": self.hits,
            "fault": self.fault.fields(),
        }
