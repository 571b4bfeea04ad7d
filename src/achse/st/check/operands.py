"""Operands: what an expression is while it is being checked."""

from dataclasses import dataclass, replace
from typing import Any

from achse.iec.derived import PointerType, ReferenceType, resolved
from achse.iec.elementary import BOOL, DWORD, LREAL, BoolType, RealType
from achse.iec.strings import STRING, StringType
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.st.check.kinds import natural
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.typed.expressions import AddressOf, Known, Read, TypedValue
from achse.st.typed.places import PointerBase, Storage, flat
from achse.st.values.values import Constant


@dataclass(slots=True, eq=False)
class TypedOperand:
    """A value with the type it is declared with, and the storage it is read from, if any."""

    value: TypedValue
    type: IecType[Any]
    """As declared: an enumeration or sub-range is still one. An INT + INT is an INT here, though
    the value is computed as DINT."""
    storage: Storage | None = None
    loose: bool = False
    """A constant without a certain type: it takes that of what it meets."""
    soft: bool = False
    """An LREAL only because of literals in it: it goes into a REAL without a word."""
    text: str | None = None
    """Content of a text constant, for another coding."""
    reference: Storage | None = None
    """The REFERENCE (or VAR_IN_OUT) variable itself, if the storage is its target."""
    bounds: tuple[TypedValue, ...] = ()
    """Lower and upper bound of each dimension of an ARRAY [*]; the storage is of an element."""
    outside: str = ""
    """The variable of another block, by its name, if it is not an input of that."""
    is_bits: bool = False
    """A constant written as bits: 16#FF, 2#1010."""
    bits_of: StructType[Any] | None = None
    """The structure of its bits, if programs know a value of that type as a DWORD."""

    @property
    def flat(self) -> IecType[Any]:
        """The type of the value. Raises `Unexpected` for a call that gives none."""
        type = self.value.type
        if type is None:
            raise Unexpected(self.value.at, "this call gives no value", Code.NOT_A_VALUE)
        return type

    @property
    def constant(self) -> int | float | bool | bytes | None:
        """The value, if it is known."""
        return self.value.value if isinstance(self.value, Known) else None

    @property
    def is_constant(self) -> bool:
        """True if the value is known."""
        return isinstance(self.value, Known)


_WORD = "as_dword"
"""Attribute of structures that clients see, and programs may use as a DWORD, too."""


def read(storage: Storage, type: IecType[Any], at: int) -> TypedOperand:
    """Return the value in a storage; for a reference, the value that it refers to."""
    real = resolved(type)
    if isinstance(real, ReferenceType):
        return _followed(storage, real, at)
    if isinstance(real, StructType) and _WORD in real.attributes:
        word = replace(storage, type=DWORD)
        return TypedOperand(Read(word, DWORD, at), DWORD, word, bits_of=real)
    return TypedOperand(Read(storage, storage.type, at), type, storage)


def _followed(storage: Storage, type: PointerType, at: int) -> TypedOperand:
    """Return the value that the reference in a storage refers to."""
    target = type.target
    there = Storage(
        PointerBase(Read(storage, storage.type, at)), 0, flat(target), name=storage.name, at=at
    )
    operand = read(there, target, at)
    if operand.reference is None:
        operand.reference = storage
    return operand


def followed_value(value: TypedValue, type: PointerType, at: int) -> TypedOperand:
    """Return the value behind a reference that is itself a value (of a method, of a property)."""
    target = type.target
    return read(Storage(PointerBase(value), 0, flat(target), at=at), target, at)


def address_of(storage: Storage, type: IecType[Any], at: int) -> TypedValue:
    """Return the address of a storage; of the target of a pointer, the pointer's value."""
    if isinstance(storage.base, PointerBase) and not storage.offset and not storage.steps:
        return storage.base.address
    pointer = PointerType(storage.type, type.size) if not isinstance(type, PointerType) else type
    return AddressOf(storage, pointer, at)


def known(
    value: int | float | bool, type: IecType[Any], at: int, *, loose: bool = False
) -> TypedOperand:
    """Return a constant."""
    return TypedOperand(Known(value, flat(type), at), type, loose=loose)


def texted(text: str, type: StringType, at: int) -> TypedOperand:
    """Return a text constant, in the shortest type that holds it."""
    type_of_text = _type_of_text(text, type)
    return TypedOperand(
        Known(coded(text, type_of_text), type_of_text, at), type_of_text, loose=True, text=text
    )


def _type_of_text(text: str, type: StringType) -> StringType:
    """Return the type of a text constant."""
    if type.unit == 1:
        try:
            return STRING(len(text.encode("cp1252")))
        except UnicodeEncodeError:
            return STRING(len(text.encode()), "utf-8")
    return type.__class__(len(text))


def coded(text: str, type: StringType) -> bytes:
    """Return the bytes of a text in a type, cut to its length."""
    if type.unit == 2:
        return text.encode("utf-16-le", "surrogatepass")[: 2 * type.length]
    data = text.encode("utf-8" if type.coding == "utf-8" else "cp1252", "replace")
    return data[: type.length]


def constant_operand(constant: Constant, at: int, *, is_bits: bool = False) -> TypedOperand:
    """Return a constant from the evaluator as an operand."""
    value, type = constant
    if isinstance(value, str):
        real = None if type is None else flat(type)
        operand = texted(value, real if isinstance(real, StringType) else STRING(), at)
        if type is not None and not is_bits:
            operand.loose = True
        return operand
    if isinstance(value, bool):
        return known(value, BOOL if type is None else type, at)
    if isinstance(value, float):
        if type is None:
            return TypedOperand(Known(value, LREAL, at), LREAL, loose=True, soft=True)
        return known(value, type, at)
    if type is None or is_bits:
        operand = known(value, natural(value) if type is None else type, at, loose=True)
        operand.is_bits = is_bits
        return operand
    real = flat(type)
    if isinstance(real, RealType):
        return known(float(value), type, at)
    if isinstance(real, BoolType):
        return known(bool(value), type, at)
    return known(int(value), type, at)
