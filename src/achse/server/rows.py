"""Service rows: each ADS service of a device as one line of data.

A row says what is served (offset, name, access, layout, unit, range, meaning) and where the value
lives: an attribute of the target object (`field`) or functions over it. Dispatch, range checks,
symbol names, docs, CLI and tests read the same rows.
"""

import dataclasses
import re
import struct
from collections.abc import Callable, Container, Iterable
from dataclasses import KW_ONLY, dataclass
from enum import Flag, IntEnum, auto
from math import isfinite
from operator import attrgetter
from typing import Any, Protocol

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.iec.errors import IecError


class Access(Flag):
    """ADS commands that a row answers."""

    READ = auto()
    WRITE = auto()
    READ_WRITE = auto()
    """One ReadWrite command: request data in, answer data out. R/W in a manual is READ | WRITE."""

    def __str__(self) -> str:
        words = {Access.READ: "R", Access.WRITE: "W", Access.READ_WRITE: "R&W"}
        return " ".join(word for access, word in words.items() if access in self)


READ = Access.READ
WRITE = Access.WRITE
READ_WRITE = Access.READ_WRITE


class Codec(Protocol):
    """Value to bytes and back; every `achse.iec` type is one.

    `size` is the number of bytes, None if it varies. `decode` gets exactly `size` bytes and
    raises ValueError for bytes that are not a value.
    """

    @property
    def size(self) -> int | None: ...

    def encode(self, value: Any, /) -> bytes: ...

    def decode(self, data: bytes, /) -> Any: ...


class Layout:
    """A packed structure, or one number, by its `struct` format.

    `Layout("<d")` is one REAL64, `Layout("<H")` one UINT16; with a NamedTuple class as `record`,
    values are of that class: `Layout("<I4xd", NewEndPosition)`. Several fields without a record
    are plain tuples.
    """

    __slots__ = ("decode", "encode", "name", "record", "size")

    def __init__(self, format: str, record: type[Any] | None = None) -> None:
        layout = struct.Struct(format)
        pack, unpack = layout.pack, layout.unpack
        self.size: int = layout.size
        self.record = record
        self.name = _layout_text(format, record._fields if record else ())
        fields = len(unpack(bytes(layout.size)))
        self.encode: Callable[[Any], bytes]
        self.decode: Callable[[bytes], Any]
        if record is not None:
            if len(record._fields) != fields:
                raise ValueError(
                    f"{record.__name__} has {len(record._fields)} fields, its format {format!r}"
                    f" has {fields}"
                )
            make = record._make
            self.encode = lambda value: pack(*value)
            self.decode = lambda data: make(unpack(data))
        elif fields == 1:
            self.encode = pack
            self.decode = lambda data: unpack(data)[0]
        else:
            self.encode = lambda value: pack(*value)
            self.decode = unpack

    def __repr__(self) -> str:
        return f"Layout({self.name!r})"


_TYPE_NAMES = {
    "b": "INT8", "B": "UINT8", "h": "INT16", "H": "UINT16", "i": "INT32", "I": "UINT32",
    "q": "INT64", "Q": "UINT64", "f": "REAL32", "d": "REAL64", "?": "BOOL",
}  # fmt: skip


def _layout_text(format: str, fields: Iterable[str]) -> str:
    """Return a layout as the manuals write it: `UINT32`, `{position:REAL64; 4 unused;
    jerk:REAL64}`."""
    names = iter(fields)
    parts: list[str] = []
    for count, code in re.findall(r"(\d*)([A-Za-z?])", format):
        if code == "x":
            parts.append(f"{count or 1} unused")
            continue
        types = [f"BYTE[{count or 1}]"] if code == "s" else [_TYPE_NAMES[code]] * int(count or 1)
        parts += (f"{name}:{kind}" if (name := next(names, "")) else kind for kind in types)
    return parts[0] if len(parts) == 1 else "{" + "; ".join(parts) + "}"


class Repeated:
    """Equal elements, one or more; values are tuples. Writes of a broken element are refused."""

    size = None

    def __init__(self, element: Codec) -> None:
        if not element.size:
            raise ValueError("repeated elements need a fixed size")
        self.element = element
        self._step = element.size
        self.name = f"{getattr(element, 'name', element)}[n]"

    def encode(self, value: Any) -> bytes:
        return b"".join(map(self.element.encode, value))

    def decode(self, data: bytes) -> tuple[Any, ...]:
        step = self._step
        if not data or len(data) % step:
            raise DeviceError(
                ReturnCode.INVALID_SIZE, f"elements of {step} bytes, got {len(data)} bytes"
            )
        return tuple(self.element.decode(data[i : i + step]) for i in range(0, len(data), step))


class _Bytes:
    name = "BYTE[n]"
    size = None

    def encode(self, value: bytes) -> bytes:
        return bytes(value)

    def decode(self, data: bytes) -> bytes:
        return data


class _Void:
    name = "VOID"
    size = 0

    def encode(self, value: Any) -> bytes:
        return b""

    def decode(self, data: bytes) -> None:
        return None


BYTES = _Bytes()
"""Data handed on as they are, any length."""

VOID = _Void()
"""No data: functions that are called by an empty Write."""

Codecs = Codec | tuple[Codec, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class RowFacts:
    """Printable fields of one row, for docs, CLI and tests; `last_*` close a range, inclusive."""

    index_group: int
    last_index_group: int
    index_offset: int
    last_index_offset: int
    access: Access
    name: str
    layout: str
    response_layout: str = ""
    unit: str = ""
    range: str = ""
    description: str = ""
    symbol: str = ""
    source: str = ""


@dataclass(frozen=True, slots=True, eq=False)  # by identity: groups share the index of rows
class Service:
    """One service of a device.

    The value lives in the attribute `field` of the target (a dotted path reaches into parts), or
    behind `read(target)`, `write(target, value)`, `exchange(target, request) -> response`. With
    `count` > 1 the row covers that many offsets and its functions get the index as second
    argument.

    - `codec`: layout of the value, or several. A Read is answered in the layout whose size was
      asked for, else in the largest, cut to the asked length. A Write is decoded by the layout of
      its size, any other size is 0x705. For READ_WRITE it is the request, `response` the answer.
    - `minimum`, `maximum`, `choices` (an IntEnum or any container) restrict written numbers;
      outside is answered `code`, by default 0x706. NaN and infinity are refused unless
      `non_finite`.
    - `element(target, n)`: the row is served per sub-element n, at 0x00n0_0000 + `offset`
      (000, 002: "0x00nK_oooo"); field and functions then see that sub-element.
    - `guard(target)`: raises DeviceError when a write or exchange is not possible now.
    - `sample(target, length)`: a quicker way to read the same again and again, for notifications;
      best the `Place` with the value as it travels; None if this target has none.
    - `symbol`: last part of the name for access by name.
    """

    offset: int
    name: str
    access: Access
    codec: Codecs
    description: str = ""
    unit: str = ""
    _: KW_ONLY
    field: str = ""
    read: Callable[..., Any] | None = None
    write: Callable[..., None] | None = None
    exchange: Callable[..., Any] | None = None
    response: Codecs = VOID
    minimum: float | None = None
    maximum: float | None = None
    choices: Container[Any] | type[IntEnum] | None = None
    code: ReturnCode | int = ReturnCode.INVALID_DATA
    non_finite: bool = False
    count: int = 1
    element: Callable[[Any, int], Any] | None = None
    guard: Callable[[Any], None] | None = None
    sample: Callable[[Any, int], Callable[[], bytes] | None] | None = None
    symbol: str = ""
    source: str = ""
    # compiled from the above, once
    get: Callable[..., Any] = dataclasses.field(init=False, repr=False, compare=False)
    set: Callable[..., None] = dataclasses.field(init=False, repr=False, compare=False)
    _answer: "_Layouts" = dataclasses.field(init=False, repr=False, compare=False)
    _allowed: Container[Any] | None = dataclasses.field(init=False, repr=False, compare=False)
    _request: "_Layouts" = dataclasses.field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not self.access:
            raise ValueError(f"row {self.name!r} answers no command")
        if self.count < 1 or (self.count > 1 and self.field):
            raise ValueError(f"row {self.name!r}: a range of offsets needs functions, no field")
        if self.count > 1 and self.element is not None:
            raise ValueError(f"row {self.name!r}: either a range of offsets or sub-elements")
        if READ_WRITE in self.access and self.access is not READ_WRITE:
            raise ValueError(f"row {self.name!r}: R&W is a row of its own at the same offset")
        for access, function in (
            (READ, self.read or self.field),
            (WRITE, self.write or self.field),
            (READ_WRITE, self.exchange),
        ):
            if access in self.access and not function:
                raise ValueError(f"row {self.name!r} refers to nothing for {access}")
        for function, access in (
            (self.read, READ),
            (self.write, WRITE),
            (self.exchange, READ_WRITE),
        ):
            if function and access not in self.access:
                raise ValueError(f"row {self.name!r} has a function for {access}, but no access")
        own = object.__setattr__
        own(self, "get", self.read or (attrgetter(self.field) if self.field else _nothing))
        own(self, "set", self.write or (_setter(self.field) if self.field else _nothing))
        choices = self.choices
        own(self, "_allowed", frozenset(choices) if isinstance(choices, type) else choices)
        own(self, "_request", _Layouts(self.codec))
        own(self, "_answer", _Layouts(self.response) if self.exchange else self._request)

    def encoder(self, length: int) -> Callable[[Any], bytes]:
        """Return the codec function that answers a request for `length` bytes."""
        return self._answer.encoder(length)

    def decode(self, data: bytes) -> Any:
        """Return the value in `data`, checked against the row's range; raises DeviceError."""
        value = self._request.decode(data)
        low, high = self.minimum, self.maximum
        if (
            (low is not None and not value >= low)
            or (high is not None and not value <= high)
            or (self._allowed is not None and value not in self._allowed)
            or not (self.non_finite or _finite(value))
        ):
            expected = self.range_text or "finite numbers"
            raise DeviceError(self.code, f"{self.name} = {value!r}, expected {expected}")
        return value

    @property
    def range_text(self) -> str:
        """The range in words for docs and messages, empty without one."""
        if self.choices is not None:
            if isinstance(self.choices, type):
                return ", ".join(f"{item.value}={item.name}" for item in self.choices)
            return str(self.choices)
        if self.minimum is None and self.maximum is None:
            return ""
        low = "" if self.minimum is None else f"{self.minimum:g}"
        high = "" if self.maximum is None else f"{self.maximum:g}"
        return f"{low}..{high}"

    def facts(self, first_group: int, last_group: int) -> RowFacts:
        """Return the printable fields of this row in the groups `first_group` … `last_group`."""
        return RowFacts(
            index_group=first_group,
            last_index_group=last_group,
            index_offset=self.offset,
            last_index_offset=self.offset + self.count - 1,
            access=self.access,
            name=self.name,
            layout=self._request.text,
            response_layout=self._answer.text if self.exchange else "",
            unit=self.unit,
            range=self.range_text if WRITE in self.access or self.exchange else "",
            description=self.description,
            symbol=self.symbol,
            source=self.source,
        )


class _Layouts:
    """The layouts of one value, chosen by length."""

    __slots__ = ("_by_size", "_largest", "_only", "text")

    def __init__(self, codecs: Codecs) -> None:
        every = codecs if isinstance(codecs, tuple) else (codecs,)
        self._by_size = {codec.size: codec for codec in every}
        if len(self._by_size) != len(every):
            raise ValueError("two layouts of one row have the same size")
        self._largest = max(every, key=lambda codec: -1 if codec.size is None else codec.size)
        self._only = self._largest.encode if len(every) == 1 else None
        self.text = " or ".join(str(getattr(codec, "name", codec)) for codec in every)

    def encoder(self, length: int) -> Callable[[Any], bytes]:
        return self._only or self._by_size.get(length, self._largest).encode

    def decode(self, data: bytes) -> Any:
        codec = self._by_size.get(len(data)) or self._by_size.get(None)
        if codec is None:
            sizes = " or ".join(str(size) for size in self._by_size)
            raise DeviceError(ReturnCode.INVALID_SIZE, f"{sizes} bytes, got {len(data)}")
        try:
            return codec.decode(data)
        except (ValueError, TypeError, OverflowError, struct.error, IecError) as failure:
            raise DeviceError(ReturnCode.INVALID_DATA, str(failure)) from failure


def _nothing(*_: Any) -> None:
    raise AssertionError("access was checked before")


def _setter(field: str) -> Callable[[Any, Any], None]:
    path, _, name = field.rpartition(".")
    if not path:
        return lambda target, value: setattr(target, field, value)
    owner = attrgetter(path)
    return lambda target, value: setattr(owner(target), name, value)


def _finite(value: Any) -> bool:
    if isinstance(value, float):
        return isfinite(value)
    if isinstance(value, (tuple, list)):
        return all(map(_finite, value))
    return not isinstance(value, dict) or all(map(_finite, value.values()))
