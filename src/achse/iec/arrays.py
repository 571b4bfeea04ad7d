"""Arrays of any dimensions and bounds: plain lists as values, indexed views in memory.

Source: IEC 61131-3 (2013) table 11, no. 4; table 15.
"""

import struct
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from math import prod
from typing import Any, Generic, NamedTuple, TypeVar

from achse.iec.elementary import BYTE, IntegerType, RealType
from achse.iec.errors import (
    DeclarationError,
    IecDecodeError,
    IecIndexError,
    IecPathError,
    IecValueError,
    shown,
)
from achse.iec.types import CHUNK, Buffer, IecType, put_zeros

V = TypeVar("V")


class Bounds(NamedTuple):
    """First and last index of one dimension; `last` is `first - 1` if it is empty."""

    first: int
    last: int

    @property
    def length(self) -> int:
        return self.last - self.first + 1

    def __str__(self) -> str:
        return f"{self.first}..{self.last}"


class ArrayType(IecType[list[Any]], Generic[V]):
    """`ARRAY [first..last, …] OF element`, the last dimension running fastest.

    A value is a list in declared order, nested for several dimensions: the list's index 0 is the
    element at the lower bound. In memory it is an `Array`, indexed by the declared bounds.
    """

    is_view = True

    def __init__(self, element: IecType[V], dimensions: Sequence[Bounds]) -> None:
        if not dimensions:
            raise DeclarationError("an array has at least one dimension")
        if element.is_bit:
            raise DeclarationError("a BIT cannot be the element of an array")
        if element.size == 0:
            raise DeclarationError(f"{element.name} has no size: its array would have no layout")
        for bounds in dimensions:
            if bounds.first < -(1 << 31) or bounds.last >= 1 << 31 or bounds.length < 0:
                raise DeclarationError(f"array bounds {bounds} are none: first..last in 32 bits")
        self.element = element
        self.dimensions = tuple(dimensions)
        self.counts = tuple(bounds.length for bounds in dimensions)
        self.count = prod(self.counts)
        self.strides = tuple(
            prod(self.counts[index + 1 :]) * element.size for index in range(len(self.counts))
        )
        """Bytes from one index to the next, per dimension."""
        self.is_numeric = isinstance(element, IntegerType | RealType)
        """True if one `struct` format packs all elements."""
        super().__init__(
            f"ARRAY [{','.join(map(str, self.dimensions))}] OF {element.name}",
            self.count * element.size,
            element.alignment,
            element.adst,
        )
        self.rest_on((element,))

    def describe(self) -> str:
        return f"{self.name} {self.element.guid.hex()}"

    @cached_property
    def default(self) -> bytes:
        return self.element.default * self.count

    @cached_property
    def starts_at_zero(self) -> bool:
        if "default" in self.__dict__:  # its declaration may have an initial value
            return not any(self.default)
        return not self.count or self.element.starts_at_zero

    def put_default(self, buffer: Buffer, offset: int) -> None:
        if self.size <= CHUNK or "default" in self.__dict__:
            super().put_default(buffer, offset)
        elif self.starts_at_zero:
            put_zeros(buffer, offset, self.size)
        elif self.element.size > CHUNK:
            for place in range(offset, offset + self.size, self.element.size):
                self.element.put_default(buffer, place)
        else:
            several = CHUNK // self.element.size
            image = self.element.default * several
            for number in range(0, self.count, several):
                part = image[: (self.count - number) * self.element.size]
                start = offset + number * self.element.size
                buffer[start : start + len(part)] = part

    @cached_property
    def _codec(self) -> struct.Struct:
        assert isinstance(self.element, IntegerType | RealType)
        return struct.Struct(f"<{self.count}{self.element.code}")

    def encode(self, value: object) -> bytes:
        if isinstance(value, Array) and value.type is self:
            return value.tobytes()
        if isinstance(value, bytes | bytearray) and self.element is BYTE:
            if len(value) != self.size:
                raise self.reject(value)
            return bytes(value)
        flat: list[object] = []
        if self.count or _items(value):
            self._flatten(value, 0, flat)
        if self.is_numeric:
            try:
                return self._codec.pack(*flat)
            except (struct.error, OverflowError, TypeError, ValueError):
                pass
        encode = self.element.encode
        index = 0
        try:
            parts = []
            for index, item in enumerate(flat):  # noqa: B007
                parts.append(encode(item))
        except IecValueError as error:
            raise self._of_element(index, error) from None
        return b"".join(parts)

    def _flatten(self, value: object, dimension: int, flat: list[object]) -> None:
        count = self.counts[dimension]
        items = _items(value)
        if items is None or len(items) != count:
            where = f" in dimension {dimension + 1}" if len(self.counts) > 1 else ""
            raise self.reject(value, f"a list of {count} values{where}")
        if dimension + 1 == len(self.counts):
            flat.extend(items)
        else:
            for item in items:
                self._flatten(item, dimension + 1, flat)

    def _index_text(self, index: int) -> str:
        parts = []
        for bounds in reversed(self.dimensions):
            index, rest = divmod(index, bounds.length)
            parts.append(str(bounds.first + rest))
        return ",".join(reversed(parts))

    def decode(self, data: bytes | Buffer) -> list[Any]:
        if len(data) < self.size:
            raise IecDecodeError(f"{self.name} has {self.size} bytes, got {len(data)}")
        if self.is_numeric:
            flat = list(self._codec.unpack_from(data))
        else:
            size = self.element.size
            decode = self.element.decode
            flat = [decode(data[index * size : (index + 1) * size]) for index in range(self.count)]
        for length in reversed(self.counts[1:]):
            flat = [flat[i : i + length] for i in range(0, len(flat), length)] if length else []
        return flat

    def read(self, buffer: Buffer, offset: int) -> Any:
        """Return an `Array` view of the memory at `offset`."""
        return Array(self, buffer, offset)

    def initialise(self, buffer: Buffer, offset: int, value: object) -> None:
        """Encode the elements; the rest of those described in part is as the outer type has it."""
        flat: list[object] = []
        if not (self.count and self.element.is_view and isinstance(value, list | tuple)):
            self.write(buffer, offset, value)
            return
        self._flatten(value, 0, flat)
        size = self.element.size
        for index, item in enumerate(flat):
            try:
                self.element.initialise(buffer, offset + index * size, item)
            except IecValueError as error:
                raise self._of_element(index, error) from None

    def _of_element(self, index: int, error: IecValueError) -> IecValueError:
        return IecValueError(
            f"{self.name} element [{self._index_text(index)}]: {error.type_name}",
            error.expected,
            error.value,
        )

    def position(self, indices: Sequence[int]) -> int:
        """Return bytes from the start of the array to the element (or the row) at `indices`.

        Raises `IecIndexError` if an index is out of bounds, `IecPathError` if there are too many.
        """
        if len(indices) > len(self.dimensions):
            raise IecPathError(
                f"{self.name} has {len(self.dimensions)} dimensions, got {len(indices)} indices"
            )
        offset = 0
        for index, bounds, stride in zip(indices, self.dimensions, self.strides, strict=False):
            if not bounds.first <= index <= bounds.last:
                raise IecIndexError(f"index {shown(index)} is outside {bounds} of {self.name}")
            offset += (index - bounds.first) * stride
        return offset

    def row(self, dimensions: int) -> "ArrayType[V]":
        """Return the array that is left after the first `dimensions` indices."""
        return self._rows[dimensions]

    @cached_property
    def _rows(self) -> tuple["ArrayType[V]", ...]:
        tails = range(1, len(self.dimensions))
        return (self, *(ArrayType(self.element, self.dimensions[tail:]) for tail in tails))

    @property
    def expected(self) -> str:
        return f"lists of {' x '.join(map(str, self.counts))} values"


def _items(value: object) -> Sequence[object] | None:
    if isinstance(value, list | tuple):
        return value
    if isinstance(value, str | bytes | bytearray | Mapping) or not hasattr(value, "__len__"):
        return None
    try:
        return list(value)  # type: ignore[call-overload, no-any-return]
    except TypeError:
        return None


class Array(Generic[V]):
    """An array in memory: `a[3]`, `a[1, 2]` or `a[1][2]`, by the declared bounds.

    Reads and writes in place. Iterates, compares and prints like the list of its values.
    """

    __slots__ = ("_buffer", "_codec", "_first", "_last", "_offset", "_views", "type")
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, type: ArrayType[V], buffer: Buffer, offset: int = 0) -> None:
        self.type = type
        self._buffer = buffer
        self._offset = offset
        self._views: dict[object, Any] = {}
        self._first, self._last = type.dimensions[0]
        # One index into numbers is the common case in a task cycle, and has a short way.
        self._codec: struct.Struct | None = None
        if isinstance(type.element, IntegerType | RealType) and len(type.dimensions) == 1:
            self._codec = type.element.codec

    def __getitem__(self, index: int | tuple[int, ...]) -> V:
        codec = self._codec
        value: Any
        if codec is not None and index.__class__ is int and self._first <= index <= self._last:
            value = codec.unpack_from(
                self._buffer, self._offset + (index - self._first) * codec.size
            )[0]
            return value  # type: ignore[no-any-return]
        value = self._views.get(index)
        if value is None:
            indices, part = self._part(index)
            value = part.read(self._buffer, self._offset + self.type.position(indices))
            # A function block keeps Python state, so the same element is the same object.
            if part.is_view:
                self._views[index] = value
        result: V = value
        return result

    def __setitem__(self, index: int | tuple[int, ...], value: object) -> None:
        codec = self._codec
        if codec is not None and index.__class__ is int and self._first <= index <= self._last:
            # A value that pack_into refuses leaves zeros behind, so pack goes first.
            try:
                codec.pack(value)
            except (struct.error, OverflowError, TypeError, ValueError):
                raise self.type.element.reject(value) from None
            position = self._offset + (index - self._first) * codec.size
            codec.pack_into(self._buffer, position, value)
            return
        indices, part = self._part(index)
        part.write(self._buffer, self._offset + self.type.position(indices), value)

    @property
    def views(self) -> Mapping[object, Any]:
        """The views of elements and rows that have been made so far, by index."""
        return self._views

    def _part(self, index: int | tuple[int, ...]) -> tuple[tuple[int, ...], IecType[Any]]:
        indices = index if isinstance(index, tuple) else (index,)
        if len(indices) < len(self.type.dimensions):
            return indices, self.type.row(len(indices))
        return indices, self.type.element

    def __len__(self) -> int:
        return self.type.counts[0]

    def __iter__(self) -> Iterator[V]:
        """Return the elements in order (the rows, for several dimensions)."""
        return (self[index] for index in range(self._first, self._last + 1))

    def __contains__(self, value: object) -> bool:
        return any(item == value for item in self)

    def tobytes(self) -> bytes:
        """Return a copy of the memory of the array."""
        return bytes(self._buffer[self._offset : self._offset + self.type.size])

    def tolist(self) -> list[Any]:
        """Return a copy of the values, as `ArrayType.decode` gives them."""
        return self.type.decode(self.tobytes())

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Array):
            return self.tolist() == other.tolist()
        return self.tolist() == list(other) if isinstance(other, list | tuple) else NotImplemented

    def __repr__(self) -> str:
        return f"Array[{','.join(map(str, self.type.dimensions))}]({self.tolist()!r})"
