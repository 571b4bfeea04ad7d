"""Storages as Python source: reading, writing and addressing what a name or path means."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import resolved
from achse.iec.elementary import BoolType, IntegerType, RealType
from achse.iec.strings import StringType
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.iec.variables import Variable
from achse.plc.code.source import ATOM, CodeExpression, Precedence, exact
from achse.plc.code.views import AREA_LETTERS
from achse.plc.layout import parts_without_headers
from achse.st.check.kinds import counted
from achse.st.typed.places import (
    CalleeBase,
    FrameBase,
    ImageBase,
    InstanceBase,
    PointerBase,
    StaticBase,
    Storage,
    TemporaryBase,
    UnitBase,
)

if TYPE_CHECKING:
    from achse.plc.code.expressions import ExpressionWriter

__all__ = ["BYTES_A_PASS", "Storages", "format_of", "local_name"]

_POINTER_MASK = (1 << 64) - 1


def local_name(variable: Variable[Any, Any]) -> str:
    """The Python variable that a variable of the frame is."""
    return f"v_{variable.name.lower()}"


def format_of(type: IecType[Any]) -> str:
    """The format of a number in memory: of a BOOL that of its byte."""
    if isinstance(type, BoolType):
        return "B"
    return type.code if isinstance(type, RealType) else counted(type).code


BYTES_A_PASS = 1024
"""Bytes that are copied as long as a loop passes once: so many take one from the budget."""


def _spending(size: int, text: str) -> CodeExpression:
    """A value of so many bytes; a large one takes from the budget."""
    passes = size // BYTES_A_PASS
    return CodeExpression(f"spent({passes}, {text})" if passes else text)


@dataclass(slots=True)
class _Where:
    """Location of a storage: a Python variable, a place in a view, or an address."""

    offset: int = 0
    bit: int | None = None
    local: Variable[Any, Any] | None = None
    view: str = ""
    """Letter of the views: an area, or `t` of the instance."""
    base: str = ""
    """Letter of what is added to indexes: `t` or `f`; empty for an area itself."""
    alignment: int = 8
    address: CodeExpression | None = None
    """Of PointerBase."""
    area: int = 0
    """Address of the area, if `view` is one."""
    terms: tuple[tuple[CodeExpression, int], ...] = ()
    """Offsets of index steps: numbers and the bytes that each counts."""
    unbounded: bool = False


class Storages:
    """Reads, writes and addresses storages for one routine."""

    def __init__(self, expressions: "ExpressionWriter") -> None:
        self._of = expressions

    # what a storage is -----------------------------------------------------------------------

    def _where(self, storage: Storage) -> _Where:
        of = self._of
        base = storage.base
        where = _Where(storage.offset, storage.bit)
        match base:
            case UnitBase() | StaticBase() | ImageBase():
                spot = of.linker.placement.spot(base)
                where.view = AREA_LETTERS[spot.area]
                where.area = of.linker.placement.memory.address(spot.area, 0)
                where.offset += spot.offset
                if spot.bit is not None:
                    where.bit = spot.bit
            case InstanceBase():
                assert of.routine.this is not None
                where.view = where.base = "t"
                where.alignment = of.routine.this.alignment
            case FrameBase():
                self._in_frame(where, storage)
            case TemporaryBase(variable, value):
                where.local = variable
                if variable.name.lower() in of.routine.addressed:
                    where.local = None
                    frame = Storage(FrameBase(), variable.offset, value.type or storage.type)
                    stored = self.store_expression(frame, of.value(value))
                    address = self.address(frame)
                    text = f"({stored.text}, {address.text})[-1]"
                    where.address = CodeExpression(text, ATOM, 0, _POINTER_MASK)
            case PointerBase(address):
                where.address = exact(of.value(address), counted(address.type))  # type: ignore[arg-type]
            case CalleeBase():
                return self._where(of.callee_storage(storage))
        where.terms, where.unbounded = self._terms(storage)
        for piece, stride in where.terms:
            if piece.low == piece.high and piece.text.lstrip("-").isdigit():
                where.offset += piece.low * stride
        where.terms = tuple(
            (piece, stride)
            for piece, stride in where.terms
            if not (piece.low == piece.high and piece.text.lstrip("-").isdigit())
        )
        return where

    def _in_frame(self, where: _Where, storage: Storage) -> None:
        routine = self._of.routine
        variable = self._of.frame_variable(storage.offset)
        if variable.name.lower() in routine.addressed:
            where.view, where.base = AREA_LETTERS[self._of.linker.stack], "f"
            where.area = self._of.linker.placement.memory.address(self._of.linker.stack, 0)
            self._of.needs_frame = True
        else:
            where.local = variable
            where.offset = storage.offset - variable.offset

    def _terms(self, storage: Storage) -> tuple[tuple[tuple[CodeExpression, int], ...], bool]:
        terms: list[tuple[CodeExpression, int]] = []
        unbounded = False
        for step in storage.steps:
            index = self._of.exact_value(step.index)
            first = self._of.exact_value(step.first)
            if step.last is None:
                unbounded = True
            else:
                last = self._of.exact_value(step.last)
                if not (first.high <= index.low and index.high <= last.low):
                    name = self._of.temporary()
                    text = (
                        f"({name} if {first.at(51)} <= ({name} := {index.text}) <= {last.at(51)}"
                        f" else out_of_bounds({name}, {first.text}, {last.text}))"
                    )
                    index = CodeExpression(
                        text, ATOM, max(index.low, first.low), min(index.high, last.high)
                    )
            terms.append((index, step.stride))
            if first.text != "0":
                terms.append((first, -step.stride))
        return tuple(terms), unbounded

    # source ----------------------------------------------------------------------------------

    def _place(self, where: _Where, code: str) -> tuple[str, str] | None:
        """View and index for numbers of a format, if all of them are at multiples of its size."""
        if not where.view or where.unbounded:
            return None
        size = {"b": 1, "h": 2, "i": 4, "q": 8, "f": 4, "d": 8}[code.lower()]
        aligned = where.offset % size == 0 and (not where.base or where.alignment % size == 0)
        if not aligned or any(stride % size for _, stride in where.terms):
            return None
        parts = [self._of.base_index(where.base, size)] if where.base else []
        for piece, stride in where.terms:
            count = stride // size
            parts.append(piece.at(51) if count == 1 else f"{piece.at(60)} * {count}")
        number = where.offset // size
        if number or not parts:
            parts.append(str(number))
        if where.base == "t":
            self._of.instance_formats.add(code)
        return f"{where.view}_{code}", " + ".join(parts)

    def _address(self, where: _Where) -> CodeExpression:
        parts: list[str] = []
        offset = where.offset
        if where.address is not None:
            parts.append(where.address.at(51))
        elif where.base == "t":
            self._of.uses_instance = True
            parts.append("this")
        elif where.base == "f":
            parts.append("f")
            offset += where.area
        elif where.view:
            offset += where.area
        else:
            raise AssertionError("a Python variable has no address")
        for piece, stride in where.terms:
            parts.append(f"{piece.at(60)} * {stride}")
        if offset or not parts:
            parts.append(str(offset))
        if len(parts) == 1:
            fixed = offset if not where.terms and where.view and not where.base else 0
            high = fixed or _POINTER_MASK
            return CodeExpression(parts[0], ATOM if parts[0].isalnum() else 0, fixed, high)
        text = " + ".join(parts)
        if where.unbounded or where.offset < 0:
            return CodeExpression(f"{text} & {_POINTER_MASK}", Precedence.BIT_AND, 0, _POINTER_MASK)
        return CodeExpression(text, Precedence.ADD, 0, _POINTER_MASK)

    def address(self, storage: Storage) -> CodeExpression:
        """The address of a storage."""
        return self._address(self._where(storage))

    def read(self, storage: Storage) -> CodeExpression:
        """Return the expression that reads a storage."""
        type = storage.type
        where = self._where(storage)
        if where.local is not None:
            return self._read_local(where, type)
        if isinstance(type, BoolType):
            text = self._number(where, "B")
            if where.bit is None:
                return CodeExpression(f"{text} != 0", Precedence.COMPARE)
            return CodeExpression(f"{text} & {1 << where.bit} != 0", Precedence.COMPARE)
        if isinstance(type, StringType):
            name = "load_text" if type.unit == 1 else "load_wide"
            size = type.length * type.unit
            text = f"{name}({self._address(where).text}, {size})"
            return CodeExpression(text if size < BYTES_A_PASS else f"spent_for({text})")
        if isinstance(type, StructType | ArrayType):
            return _spending(type.size, f"load_bytes({self._address(where).text}, {type.size})")
        text = self._number(where, format_of(type))
        if isinstance(type, RealType):
            return CodeExpression(text)
        whole = counted(type)
        return CodeExpression(text, ATOM, whole.low, whole.high)

    def _number(self, where: _Where, code: str) -> str:
        place = self._place(where, code)
        if place is not None:
            return f"{place[0]}[{place[1]}]"
        return f"load_{code}({self._address(where).text})"

    def _read_local(self, where: _Where, type: IecType[Any]) -> CodeExpression:
        assert where.local is not None
        name = local_name(where.local)
        if where.bit is not None:
            number = where.offset * 8 + where.bit
            if isinstance(resolved(where.local.type), BoolType):
                return CodeExpression(name)
            return CodeExpression(f"{name} >> {number} & 1 != 0", Precedence.COMPARE)
        if isinstance(type, BoolType | RealType | StringType | StructType | ArrayType):
            return CodeExpression(name)
        whole = counted(type)
        return CodeExpression(name, ATOM, whole.low, whole.high)

    def store_statement(self, storage: Storage, value: CodeExpression) -> str:
        """A line that puts a value of the storage's type into it."""
        type = storage.type
        where = self._where(storage)
        if where.local is not None and where.bit is None:
            return f"{local_name(where.local)} = {self._for_local(type, value).text}"
        if (
            where.local is None
            and where.bit is None
            and isinstance(type, BoolType | RealType | IntegerType)
        ) or (where.local is None and _counted_or_none(type) is not None and where.bit is None):
            code, stored = self._for_memory(type, value)
            place = self._place(where, code)
            if place is not None:
                return f"{place[0]}[{place[1]}] = {stored}"
        return self._store(where, type, value).text

    def store_expression(self, storage: Storage, value: CodeExpression) -> CodeExpression:
        """An expression that does it, and is the value."""
        return self._store(self._where(storage), storage.type, value)

    def _store(self, where: _Where, type: IecType[Any], value: CodeExpression) -> CodeExpression:
        if where.local is not None:
            return self._store_local(where, type, value)
        if where.bit is not None:
            address = self._address(where).text
            return CodeExpression(f"store_bit({address}, {1 << where.bit}, {value.text})")
        if isinstance(type, StringType):
            name = "store_text" if type.unit == 1 else "store_wide"
            return CodeExpression(f"{name}({self._address(where).text}, {value.text})")
        if isinstance(type, StructType | ArrayType):
            address = self._address(where).text
            parts = parts_without_headers(type)
            if parts == ((0, type.size),):
                return CodeExpression(f"store_bytes({address}, {value.text})")
            return CodeExpression(
                f"store_parts({address}, {value.text}, {self._of.linker.constant(parts)})"
            )
        # The value goes on to the next link of a chain, so it must be what a read would give.
        whole = _counted_or_none(type)
        if whole is not None:
            value = exact(value, whole)
            code, stored = whole.code, value.text
        elif isinstance(type, BoolType):
            code, stored = "B", value.text
        else:
            value = _rounded(type, value)
            code, stored = format_of(type), value.text
        place = self._place(where, code)
        text = (
            f"put({place[0]}, {place[1]}, {stored})"
            if place is not None
            else f"store_{code}({self._address(where).text}, {stored})"
        )
        return CodeExpression(text, ATOM, value.low, value.high)

    def _for_memory(self, type: IecType[Any], value: CodeExpression) -> tuple[str, str]:
        """The format to store a number with, and the number: cut in the unsigned view, where a
        number outside its type needs no sign."""
        whole = _counted_or_none(type)
        if whole is None:
            return format_of(type), value.text
        if whole.low <= value.low and value.high <= whole.high:
            return whole.code, value.text
        mask = (1 << 8 * whole.size) - 1
        if value.low >= 0 and value.high <= mask:
            return whole.code.upper(), value.text
        return whole.code.upper(), f"{value.at(Precedence.BIT_AND)} & {mask}"

    def _for_local(self, type: IecType[Any], value: CodeExpression) -> CodeExpression:
        whole = _counted_or_none(type)
        return _rounded(type, value) if whole is None else exact(value, whole)

    def _store_local(
        self, where: _Where, type: IecType[Any], value: CodeExpression
    ) -> CodeExpression:
        assert where.local is not None
        name = local_name(where.local)
        if where.bit is None or isinstance(resolved(where.local.type), BoolType):
            value = self._for_local(type, value)
            return CodeExpression(f"({name} := {value.text})", ATOM, value.low, value.high)
        whole = counted(resolved(where.local.type))
        mask = 1 << where.offset * 8 + where.bit
        held = self._of.temporary()
        piece = CodeExpression(
            f"{name} | {mask} if ({held} := {value.text}) else {name} & {~mask}",
            Precedence.CHOICE,
            -(1 << 64),
            1 << 64,
        )
        return CodeExpression(f"({name} := {exact(piece, whole).text}, {held})[-1]")

    def latch(self, storage: Storage, value: CodeExpression, *, sets: bool) -> CodeExpression:
        """S= and R= of a BOOL."""
        where = self._where(storage)
        if where.local is not None:
            held = self._of.temporary()
            old = self._read_local(where, storage.type)
            new = CodeExpression(
                f"{old.at(5)} or {held}" if sets else f"{old.at(15)} and not {held}", 8
            )
            stored = self._store_local(where, storage.type, new)
            return CodeExpression(f"({held} := {value.text}, {stored.text}, {held})[0]")
        mask = 255 if where.bit is None else 1 << where.bit
        return CodeExpression(f"latch({self._address(where).text}, {mask}, {value.text}, {sets})")


def _counted_or_none(type: IecType[Any]) -> IntegerType | None:
    """The integer type that a value counts in; None for what is not a whole number."""
    if isinstance(type, BoolType | RealType | StringType | StructType | ArrayType):
        return None
    return counted(type)


def _rounded(type: IecType[Any], value: CodeExpression) -> CodeExpression:
    """A real as its type holds it."""
    if value.loose and isinstance(type, RealType) and type.size == 4:
        return CodeExpression(f"single({value.text})")
    return value
