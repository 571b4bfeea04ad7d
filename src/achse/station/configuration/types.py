"""Types for the tables of a station.toml: durations, addresses, the base of all tables."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from decimal import Decimal
from typing import Annotated, ClassVar, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainSerializer,
    WithJsonSchema,
)

from achse.ams import NetId
from achse.router.access import PasswordHash

STATION_FILE = "station.toml"
"""Name of the file that a folder of a station has."""


class ConfigError(ValueError):
    """A configuration cannot be used. One line per fault: file, key, expectation, what came."""


@contextmanager
def without_plugins() -> Iterator[None]:
    """Let pydantic make validators without its plug-ins: none has to do with a station.toml, and
    the search for them reads about all packages that are installed."""
    before = os.environ.get(_PLUGINS)
    os.environ[_PLUGINS] = "__all__"
    try:
        yield
    finally:
        if before is None:
            del os.environ[_PLUGINS]
        else:
            os.environ[_PLUGINS] = before


_PLUGINS = "PYDANTIC_DISABLE_PLUGINS"

_LONGEST_NS = 3_600_000_000_000
"""An hour: no cycle is longer."""

_UNITS_NS = {"ns": 1, "us": 1_000, "µs": 1_000, "ms": 1_000_000, "s": 1_000_000_000}


def _duration_ns(value: object) -> object:
    """`"2ms"` and the like as integer nanoseconds."""
    if isinstance(value, str):
        for unit in sorted(_UNITS_NS, key=len, reverse=True):
            number = value.strip().removesuffix(unit)
            if number != value.strip():
                try:
                    nanoseconds = Decimal(number.strip()) * _UNITS_NS[unit]
                    if nanoseconds <= _LONGEST_NS and nanoseconds == int(nanoseconds):
                        return int(nanoseconds)
                except (ArithmeticError, ValueError):  # no number, or none that is finite
                    pass
                break
    units = '"2ms", "250us" or "1s"'
    raise ValueError(f"expected a duration such as {units}, whole nanoseconds, up to 3600s")


def _net_id(value: object) -> object:
    if isinstance(value, NetId):
        return value
    if isinstance(value, str):
        return NetId(value)
    raise ValueError("a NetId is six numbers 0..255 with dots")


_SCHEMA_OF_DURATION = WithJsonSchema(
    {
        "type": "string",
        "pattern": r"^\s*[0-9]+(\.[0-9]+)?([eE][+-]?[0-9]+)?\s*(ns|us|µs|ms|s)$",
        "examples": ["2ms", "250us", "1s"],
    },
    mode="validation",
)
"""JSON schema of a duration, for editors."""

DurationNs = Annotated[int, BeforeValidator(_duration_ns), Field(gt=0), _SCHEMA_OF_DURATION]
MomentNs = Annotated[int, BeforeValidator(_duration_ns), Field(ge=0), _SCHEMA_OF_DURATION]
ConfiguredNetId = Annotated[
    NetId,
    BeforeValidator(_net_id),
    PlainSerializer(str, return_type=str),
    WithJsonSchema({"type": "string", "pattern": r"^\d{1,3}(\.\d{1,3}){5}$"}, mode="validation"),
]


def _printable(value: str) -> str:
    if not value.isprintable():
        raise ValueError("a name without control characters")
    return value


LONGEST_NAME = 30
"""Characters of the name of an axis, a group, a bus …"""
LONGEST_UNIT = 10
"""Characters of the unit of an axis."""

DeviceName = Annotated[str, Field(max_length=LONGEST_NAME), AfterValidator(_printable)]
"""Name of an axis, a group, a bus …, of printable characters."""


def _password_hash(value: object) -> object:
    if isinstance(value, str):
        return PasswordHash.parse(value)
    return value


ConfiguredHash = Annotated[
    PasswordHash,
    BeforeValidator(_password_hash),
    PlainSerializer(str, return_type=str),
    WithJsonSchema({"type": "string"}, mode="validation"),
]


ConfiguredRights = Sequence[Literal["read", "write", "state", "files", "methods"]]
"""Names of rights; `rights_named` makes one of them."""

ALL_RIGHT_NAMES: ConfiguredRights = ("read", "write", "state", "files", "methods")


class ConfigTable(BaseModel):
    model_config = ConfigDict(
        extra="forbid", frozen=True, arbitrary_types_allowed=True, defer_build=True
    )

    described_by: ClassVar[tuple[type, ...]] = ()
    """Classes whose fields describe the keys of the same names."""
