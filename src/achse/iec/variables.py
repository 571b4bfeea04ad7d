"""Declared variables: type, initial value and address, and access to the value in memory.

Source: IEC 61131-3 (2013) tables 13, 14 and 16.
"""

import re
import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any, Generic, NamedTuple, Protocol, Self, TypeVar, overload

from achse.iec.elementary import IntegerType, RealType
from achse.iec.errors import DeclarationError, IecValueError, UnboundError
from achse.iec.strings import StringType
from achse.iec.types import Buffer, IecType, no_attributes

G = TypeVar("G")
S = TypeVar("S")

LARGEST_IMAGE = 1 << 24
"""Bytes that inputs, outputs and flags have at most: a mistyped address shall not take the memory
of the machine."""

_ADDRESS = re.compile(
    r"%([IQM])(?:\*|([XBWDL]?)([0-9]{1,10})(?:\.([0-7]))?)", re.ASCII | re.IGNORECASE
)


_NO_SYMBOL = "tcnosymbol"


class Section(Enum):
    """The VAR section a variable is declared in."""

    LOCAL = "VAR"
    INPUT = "VAR_INPUT"
    OUTPUT = "VAR_OUTPUT"
    IN_OUT = "VAR_IN_OUT"
    GLOBAL = "VAR_GLOBAL"
    STATIC = "VAR_STAT"


class Address(NamedTuple):
    """Location of a variable by `AT`: `%MD4`, `%IX0.3`, `%Q*`. The number is a byte offset."""

    area: str
    """I inputs, Q outputs, M flags; in symbol files also R retain, D data."""
    width: str = ""
    """X bit, B byte, W word, D double word, L long word, or nothing."""
    byte: int | None = None
    """None for `*`: the station chooses."""
    bit: int | None = None

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read `%` area [width] byte [`.` bit], or `%` area `*`. Raises `DeclarationError`."""
        match = _ADDRESS.fullmatch(text.strip())
        if match is None:
            raise DeclarationError(f"an address is like %MD4, %IX0.3 or %Q*, got {text[:40]!r}")
        area, width, byte, bit = match.groups()
        if byte is None:
            return cls(area.upper())
        width = width.upper()
        if (bit is not None and width not in ("", "X")) or (bit is None and width == "X"):
            raise DeclarationError(f"%{area}X has a bit and no other width has, got {text!r}")
        if int(byte) >= LARGEST_IMAGE:
            raise DeclarationError(f"an address is below byte {LARGEST_IMAGE}, got {text!r}")
        return cls(area.upper(), width, int(byte), None if bit is None else int(bit))

    def __str__(self) -> str:
        if self.byte is None:
            return f"%{self.area}*"
        bit = "" if self.bit is None else f".{self.bit}"
        return f"%{self.area}{self.width}{self.byte}{bit}"


class Image(bytes):
    """An initial value as the bytes it is in memory, whatever the type."""


class Place(NamedTuple):
    """Memory of one variable that is stored apart from its record: in an image or retained."""

    buffer: Buffer
    offset: int
    bit: int | None = None


class PointedValue(NamedTuple):
    """A value in the address space of pointers."""

    type: IecType[Any]
    address: int
    bit: int | None = None


class StartContext(Protocol):
    """Context of start values: a PLC whose variables all have their place and static values."""

    def variable(self, name: str) -> PointedValue:
        """Return the variable `MAIN.nCount` or, of VAR_STAT, `FB_Motor.nCount`. KeyError without
        one."""
        ...

    def read(self, address: int, size: int) -> bytes:
        """Return the bytes at an address. LookupError if there are none."""
        ...


@dataclass(frozen=True, slots=True)
class StartValue:
    """A value, or a part of one, that shows when memory is laid out: `ADR(x)`, another variable's.

    `value` gives its bytes from the surroundings and the record that the variable is in; it
    raises `DeclarationError` with file, line and column if that takes a running program.
    """

    type: IecType[Any]
    offset: int
    """From the start of the variable."""
    bit: int | None
    value: Callable[[StartContext, PointedValue], bytes]


class Variable(Generic[G, S]):
    """A variable of a record: a member of a structure, a program or a global variable list.

    As an attribute of a bound record it reads and writes the record's memory in place; of the
    class it is this declaration.
    """

    __slots__ = (
        "_is_placed",
        "_pack",
        "_pack_into",
        "_shared",
        "_unpack",
        "address",
        "apart",
        "attributes",
        "bit",
        "comment",
        "constant",
        "hidden",
        "in_memory",
        "initial",
        "name",
        "offset",
        "persistent",
        "retain",
        "section",
        "start_values",
        "type",
    )

    def __init__(
        self,
        type: IecType[Any],
        initial: object = None,
        *,
        name: str = "",
        section: Section = Section.LOCAL,
        at: str | Address = "",
        retain: bool = False,
        persistent: bool = False,
        constant: bool = False,
        comment: str = "",
        attributes: Mapping[str, str] = no_attributes,
        offset: int = 0,
        bit: int | None = None,
        start_values: Sequence[StartValue] = (),
    ) -> None:
        self.type = type
        self.initial = initial
        """The declared initial value; None for that of the type."""
        self.start_values = start_values
        """Start values written over the initial value as soon as memory is laid out."""
        self.name = name
        self.section = section
        self.in_memory = section is not Section.STATIC
        """True if each instance of the record has its own value (VAR_STAT has one for all)."""
        self.address = Address.parse(at) if isinstance(at, str) and at else at or None
        self.retain = retain
        self.persistent = persistent
        self.constant = constant
        self.comment = comment
        self.attributes = attributes
        self.hidden = bool(attributes) and _NO_SYMBOL in map(str.lower, attributes)
        """True if clients see neither the variable nor its type."""
        self.offset = offset
        """Bytes from the start of the record."""
        self.bit = bit
        """Bit in that byte, if the type is BIT."""
        self.apart = False
        """True if the variable has its own `Place` (`AT`, RETAIN of a unit, VAR_STAT)."""
        self._is_placed = False
        self._shared: Place | None = None
        if isinstance(type, StringType) and type.unit == 1 and type.coding == "utf-8":
            self.attributes = {**attributes, "TcEncoding": "UTF-8"}
        self._unpack: Callable[..., tuple[Any, ...]] | None = None
        if isinstance(type, IntegerType | RealType):
            self._unpack = type.codec.unpack_from
            self._pack = type.codec.pack
            self._pack_into = type.codec.pack_into

    def placed(self, name: str, offset: int, bit: int | None, *, apart: bool = False) -> Self:
        """This declaration under a name at a spot: itself the first time, then copies."""
        own = self.copy() if self._is_placed else self
        own._is_placed = True
        own.name = self.name or name
        own.offset, own.bit, own.apart = offset, bit, apart
        return own

    def copy(self) -> Self:
        """Return the same declaration for another record."""
        copy = object.__new__(type(self))
        copy.type, copy.initial, copy.start_values = self.type, self.initial, self.start_values
        copy.name, copy.section, copy.in_memory = self.name, self.section, self.in_memory
        copy.address, copy.retain, copy.persistent = self.address, self.retain, self.persistent
        copy.constant, copy.comment, copy.attributes = self.constant, self.comment, self.attributes
        copy.hidden, copy.offset, copy.bit, copy.apart = (
            self.hidden,
            self.offset,
            self.bit,
            self.apart,
        )
        copy._unpack = self._unpack
        if self._unpack is not None:
            copy._pack, copy._pack_into = self._pack, self._pack_into
        copy._is_placed = False
        copy._shared = None
        return copy

    def initial_bytes(self) -> bytes:
        """Return the bytes the variable starts with. Raises `DeclarationError`."""
        if self.initial is None:
            return self.type.default
        if isinstance(self.initial, Image):
            if len(self.initial) == self.type.size:
                return bytes(self.initial)
            raise DeclarationError(
                f"initial value of {self.name}: {self.type.size} bytes, got {len(self.initial)}"
            )
        try:
            if not isinstance(self.initial, Mapping | list | tuple):
                return self.type.encode(self.initial)
            memory = bytearray(self.type.default)
            self.type.initialise(memory, 0, self.initial)
            return bytes(memory)
        except IecValueError as error:
            raise DeclarationError(f"initial value of {self.name}: {error}") from None

    def put_initial(self, buffer: Buffer, offset: int) -> None:
        """Write the bytes the variable starts with. Raises `DeclarationError`."""
        if self.initial is None:
            self.type.put_default(buffer, offset)
        else:
            data = self.initial_bytes()
            buffer[offset : offset + len(data)] = data

    def fetch(self, buffer: Buffer, base: int) -> Any:
        """Return the value in the record that starts at `base`."""
        if self.bit is not None:
            return bool(buffer[base + self.offset] >> self.bit & 1)
        return self.type.read(buffer, base + self.offset)

    def store(self, buffer: Buffer, base: int, value: object) -> None:
        """Put the value into the record that starts at `base`."""
        if self.bit is None:
            self.type.write(buffer, base + self.offset, value)
        else:
            _put_bit(buffer, base + self.offset, self.bit, self.type.encode(value) != b"\0")

    @overload
    def __get__(self, instance: None, owner: type[Any]) -> Self: ...
    @overload
    def __get__(self, instance: object, owner: type[Any]) -> G: ...
    def __get__(self, instance: Any, owner: type[Any]) -> Any:
        if instance is None:
            return self
        try:
            buffer = instance.__iec_buffer__
        except AttributeError:
            raise self._unbound(instance) from None
        if self.apart:
            return self._fetch_apart(instance)
        if self._unpack is not None:
            return self._unpack(buffer, instance.__iec_offset__ + self.offset)[0]
        if self.type.is_view:
            views = instance.__iec_views__
            view = views.get(self.name)
            if view is None:
                view = views[self.name] = self.fetch(buffer, instance.__iec_offset__)
            return view
        return self.fetch(buffer, instance.__iec_offset__)

    def __set__(self, instance: Any, value: S) -> None:
        try:
            buffer = instance.__iec_buffer__
        except AttributeError:
            raise self._unbound(instance) from None
        if self.apart:
            self._store_apart(instance, value)
        elif self._unpack is not None:
            # A value that pack_into refuses leaves zeros behind, so pack goes first.
            try:
                self._pack(value)
            except (struct.error, OverflowError, TypeError, ValueError):
                raise self.type.reject(value) from None
            self._pack_into(buffer, instance.__iec_offset__ + self.offset, value)
        else:
            self.store(buffer, instance.__iec_offset__, value)

    def _place(self, instance: Any) -> Place:
        place: Place | None
        if self.in_memory:
            place = instance.__iec_places__.get(self.name)
        else:
            place = self._static_place(instance.__iec_buffer__)
        if place is None:
            raise self._unbound(instance)
        return place

    def _static_place(self, buffer: Buffer) -> Place:
        """Return the one value of a VAR_STAT variable: of the PLC whose memory `buffer` is.

        Records in memory of their own, for trying out, share one beside every PLC.
        """
        statics: Mapping[Any, Place] = getattr(buffer, "statics", {})
        place = statics.get(self) or self._shared
        if place is None:
            place = self._shared = Place(bytearray(self.initial_bytes()), 0)
        return place

    def _fetch_apart(self, instance: Any) -> Any:
        buffer, offset, bit = self._place(instance)
        if bit is not None:
            return bool(buffer[offset] >> bit & 1)
        if not self.type.is_view:
            return self.type.read(buffer, offset)
        views = instance.__iec_views__
        view = views.get(self.name)
        if view is None:
            view = views[self.name] = self.type.read(buffer, offset)
        return view

    def _store_apart(self, instance: Any, value: object) -> None:
        buffer, offset, bit = self._place(instance)
        if bit is None:
            self.type.write(buffer, offset, value)
        else:
            _put_bit(buffer, offset, bit, self.type.encode(value) != b"\0")

    def _unbound(self, instance: object) -> UnboundError:
        return UnboundError(
            f"{type(instance).__name__}.{self.name} has no memory yet: bind the record first"
        )

    def __repr__(self) -> str:
        at = f" AT {self.address}" if self.address else ""
        return f"<Variable {self.name}{at} : {self.type.name}>"


def _put_bit(buffer: Buffer, offset: int, bit: int, state: bool) -> None:
    if state:
        buffer[offset] |= 1 << bit
    else:
        buffer[offset] &= ~(1 << bit) & 0xFF
