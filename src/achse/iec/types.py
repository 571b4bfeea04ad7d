"""The root of all IEC types: a name, a size, and values as bytes.

Source: IEC 61131-3 (2013) table 10 and 11.
"""

import hashlib
from collections.abc import Iterable, Mapping
from enum import IntEnum
from functools import cached_property
from types import MappingProxyType
from typing import Any, Generic, TypeAlias, TypeVar

from achse.iec.errors import DeclarationError, IecDecodeError, IecValueError

V = TypeVar("V")

Buffer: TypeAlias = bytearray | memoryview
"""Memory of variables."""

DEEPEST_TYPE = 64
"""Levels of a type: members of members, elements of elements, aliases of aliases."""

no_attributes: Mapping[str, str] = MappingProxyType({})


class Adst(IntEnum):
    """The ADST data type ids of symbol and type entries."""

    VOID = 0
    INT16 = 2
    INT32 = 3
    REAL32 = 4
    REAL64 = 5
    INT8 = 16
    UINT8 = 17
    UINT16 = 18
    UINT32 = 19
    INT64 = 20
    UINT64 = 21
    STRING = 30
    WSTRING = 31
    REAL80 = 32
    BIT = 33
    """BIT, and BOOL in its byte."""
    MAXTYPES = 34
    BIGTYPE = 65
    """Structures, function blocks, unions, pointers."""


def derived_guid(description: str) -> bytes:
    """16 bytes that are the same for the same description, in any process."""
    return hashlib.blake2b(description.encode(), digest_size=16).digest()


CHUNK = 1 << 16
"""Bytes of a type up to which its default is written as a whole."""

_ZEROS = bytes(CHUNK)


def put_zeros(buffer: Buffer, offset: int, size: int) -> None:
    """Write `size` zeros at `offset`, without as many in memory."""
    for start in range(offset, offset + size, CHUNK):
        length = min(CHUNK, offset + size - start)
        buffer[start : start + length] = _ZEROS[:length]


class IecType(Generic[V]):
    """A type: how many bytes a value takes, and which Python value they are.

    `encode` and `decode` take whole values; `read` and `write` work in place in a buffer. What
    `decode` gives stands alone; `read` of a structure or array gives a view of the buffer.
    """

    is_bit: bool = False
    """True if a member of this type takes one bit."""
    is_view: bool = False
    """True if `read` returns a view of the memory instead of a value."""
    depth: int = 1
    """Number of levels of the type, itself included; pointers count as one level."""

    def __init__(
        self,
        name: str,
        size: int,
        alignment: int,
        adst: int,
        *,
        comment: str = "",
        attributes: Mapping[str, str] = no_attributes,
    ) -> None:
        self.name = name
        self.size = size
        """Bytes of one value."""
        self.alignment = alignment
        """Natural alignment in bytes, before any packing."""
        self.adst = adst
        """ADST id; of the element for arrays, of the base for enumerations and aliases."""
        self.comment = comment
        self.attributes = attributes

    def rest_on(self, parts: "Iterable[IecType[Any]]") -> None:
        """Note what the type is made of. Raises `DeclarationError` if that nests too deep."""
        self.depth = 1 + max((part.depth for part in parts), default=0)
        if self.depth > DEEPEST_TYPE:
            raise DeclarationError(f"type {self.name[:80]} nests deeper than {DEEPEST_TYPE} levels")

    @cached_property
    def guid(self) -> bytes:
        """The 16 bytes that identify the type in the tables."""
        return derived_guid(self.describe())

    @cached_property
    def default(self) -> bytes:
        """The bytes of a variable declared without an initial value."""
        return bytes(self.size)

    @cached_property
    def starts_at_zero(self) -> bool:
        """True only if all bytes of `default` are zero."""
        return not any(self.default)

    def put_default(self, buffer: Buffer, offset: int) -> None:
        """Write `default` at `offset`; large types do so without a copy of it in memory."""
        data = self.default
        buffer[offset : offset + len(data)] = data

    def describe(self) -> str:
        """Return the whole definition in words: equal for equal types, and what the GUID is made
        of."""
        return f"{self.name} {self.size}"

    def encode(self, value: object) -> bytes:
        """Return the bytes of `value`, `size` of them. Raises `IecValueError`."""
        memory = bytearray(self.size)
        self.write(memory, 0, value)
        return bytes(memory)

    def decode(self, data: bytes | Buffer) -> V:
        """Return the value of the first `size` bytes. Raises `IecDecodeError` if there are
        fewer."""
        if len(data) < self.size:
            raise IecDecodeError(f"{self.name} has {self.size} bytes, got {len(data)}")
        return self.read(bytearray(data[: self.size]), 0)

    def read(self, buffer: Buffer, offset: int) -> V:
        """Return the value at `offset`; a live view if it is a structure or an array."""
        raise NotImplementedError

    def write(self, buffer: Buffer, offset: int, value: object) -> None:
        """Put `value` at `offset`, whole or not at all. Raises `IecValueError`."""
        buffer[offset : offset + self.size] = self.encode(value)

    def initialise(self, buffer: Buffer, offset: int, value: object) -> None:
        """Put an initial value over what is said already: parts it leaves out stay as they are."""
        self.write(buffer, offset, value)

    def reject(self, value: object, expected: str = "") -> IecValueError:
        """Return the error that says `value` is none of this type."""
        return IecValueError(self.name, expected or self.expected, value)

    @property
    def expected(self) -> str:
        """The values this type takes, in words."""
        return "a value of its type"

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name}>"
