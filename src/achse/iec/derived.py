"""Types made of one other type: aliases, sub-ranges, pointers, references, interfaces.

Source: IEC 61131-3 (2013) table 11, no. 3 and 8; pointers and interfaces as in TwinCAT 3.
"""

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, TypeVar

from achse.iec.elementary import DWORD, LWORD, IntegerType
from achse.iec.errors import DeclarationError, IecValueError
from achse.iec.types import CHUNK, Adst, Buffer, IecType, no_attributes

V = TypeVar("V")


class AliasType(IecType[V]):
    """Another name of a type, with its values."""

    def __init__(
        self,
        name: str,
        base: IecType[V],
        *,
        guid: bytes | None = None,
        comment: str = "",
        attributes: Mapping[str, str] = no_attributes,
    ) -> None:
        super().__init__(
            name, base.size, base.alignment, base.adst, comment=comment, attributes=attributes
        )
        self.rest_on((base,))
        self.base = base
        self.is_bit = base.is_bit
        self.is_view = base.is_view
        if guid is not None:
            self.guid = guid

    def describe(self) -> str:
        return f"{self.name} = {self.base.guid.hex()}"

    @cached_property
    def default(self) -> bytes:
        return self.base.default

    @cached_property
    def starts_at_zero(self) -> bool:
        if self.size <= CHUNK or "default" in self.__dict__:  # a declaration has initial values
            return not any(self.default)
        return self.base.starts_at_zero

    def put_default(self, buffer: Buffer, offset: int) -> None:
        if self.size <= CHUNK or "default" in self.__dict__:
            super().put_default(buffer, offset)
        else:
            self.base.put_default(buffer, offset)

    def encode(self, value: object) -> bytes:
        return self.base.encode(value)

    def decode(self, data: bytes | Buffer) -> V:
        return self.base.decode(data)

    def read(self, buffer: Buffer, offset: int) -> V:
        return self.base.read(buffer, offset)

    def write(self, buffer: Buffer, offset: int, value: object) -> None:
        self.base.write(buffer, offset, value)

    def initialise(self, buffer: Buffer, offset: int, value: object) -> None:
        self.base.initialise(buffer, offset, value)

    @property
    def expected(self) -> str:
        return self.base.expected


class SubrangeType(AliasType[int]):
    """`INT (low..high)`: an integer type whose writes are checked against its limits."""

    def __init__(
        self,
        base: IntegerType,
        low: int,
        high: int,
        *,
        name: str = "",
        comment: str = "",
        attributes: Mapping[str, str] = no_attributes,
    ) -> None:
        if not base.low <= low <= high <= base.high:
            raise DeclarationError(f"{low}..{high} is not a sub-range of {base.name}")
        super().__init__(
            name or f"{base.name} ({low}..{high})", base, comment=comment, attributes=attributes
        )
        self.integer = base
        self.low = low
        self.high = high

    def describe(self) -> str:
        return f"{self.name} = {self.base.name} {self.low} {self.high}"

    @property
    def base_type(self) -> IecType[int]:
        """Type that its entry names as its base: the nameless sub-range, or for a nameless one the
        integer type."""
        nameless = SubrangeType(self.integer, self.low, self.high)
        return self.integer if self.name == nameless.name else nameless

    @cached_property
    def default(self) -> bytes:
        """0 if the range has it, else the limit nearest to it."""
        return self.base.encode(min(max(0, self.low), self.high))

    def encode(self, value: object) -> bytes:
        try:
            data = self.base.encode(value)
        except IecValueError:
            raise self.reject(value) from None
        if not self.low <= self.base.decode(data) <= self.high:
            raise self.reject(value)
        return data

    def write(self, buffer: Buffer, offset: int, value: object) -> None:
        buffer[offset : offset + self.size] = self.encode(value)

    @property
    def expected(self) -> str:
        return f"an integer in {self.low}..{self.high}"


class OpaqueType(IecType[bytes]):
    """A type whose definition the target does not give: its value is its bytes."""

    def encode(self, value: object) -> bytes:
        if not isinstance(value, bytes | bytearray) or len(value) != self.size:
            raise self.reject(value)
        return bytes(value)

    def read(self, buffer: Buffer, offset: int) -> bytes:
        return bytes(buffer[offset : offset + self.size])

    @property
    def expected(self) -> str:
        return f"{self.size} bytes"


class PointerType(IecType[int]):
    """`POINTER TO target`: an address of 8 bytes (4 on a 32-bit target), an int in Python.

    `target` may be a function giving the type, for a structure that points to its own kind;
    `target_name` is its name then.
    """

    phrase = "POINTER TO"

    def __init__(
        self,
        target: IecType[Any] | Callable[[], IecType[Any]],
        pointer_size: int = 8,
        *,
        target_name: str = "",
    ) -> None:
        if pointer_size not in (4, 8):
            raise DeclarationError(f"a pointer has 4 or 8 bytes, got {pointer_size}")
        self.codec = (LWORD if pointer_size == 8 else DWORD).codec
        self.target_name = target.name if isinstance(target, IecType) else target_name
        super().__init__(
            f"{self.phrase} {self.target_name}", pointer_size, pointer_size, Adst.BIGTYPE
        )
        self._target = target

    @cached_property
    def target(self) -> IecType[Any]:
        """The type pointed at."""
        return self._target if isinstance(self._target, IecType) else self._target()

    def encode(self, value: object) -> bytes:
        try:
            return self.codec.pack(value)
        except Exception:
            raise self.reject(value) from None

    def read(self, buffer: Buffer, offset: int) -> int:
        address: int = self.codec.unpack_from(buffer, offset)[0]
        return address

    @property
    def expected(self) -> str:
        return f"an address of {8 * self.size} bits"


class ReferenceType(PointerType):
    """`REFERENCE TO target`: a pointer that is followed without `^`."""

    phrase = "REFERENCE TO"


class InterfaceType(PointerType):
    """A variable of an interface: a pointer to some function block that implements it."""

    def __init__(self, name: str, pointer_size: int = 8) -> None:
        super().__init__(LWORD, pointer_size)
        self.name = name


def resolved(type: IecType[Any]) -> IecType[Any]:
    """Return the type behind aliases and sub-ranges."""
    while isinstance(type, AliasType):
        type = type.base
    return type
