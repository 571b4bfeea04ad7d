"""Places as Python source: reading, writing and addressing them."""

from typing import TYPE_CHECKING, Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import resolved
from achse.iec.elementary import BoolType, IntegerType, RealType
from achse.iec.strings import StringType
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.iec.variables import Variable
from achse.plc.code.source import ATOM, CodeExpression, Precedence, exact, variable_name
from achse.plc.code.views import AREA_LETTERS
from achse.plc.lowering.nodes import Home, ResolvedPlace
from achse.plc.lowering.places import BYTES_A_PASS
from achse.plc.retention.layout import parts_without_headers
from achse.st.check.kinds import counted, is_whole

if TYPE_CHECKING:
    from achse.plc.code.expressions import ExpressionWriter

_POINTER_MASK = (1 << 64) - 1
_SIZES = {"b": 1, "h": 2, "i": 4, "q": 8, "f": 4, "d": 8}


def local_name(variable: Variable[Any, Any]) -> str:
    """Return the Python variable that a variable of the frame is."""
    return variable_name(variable.name)


def format_of(type: IecType[Any]) -> str:
    """Return the format of a number in memory: of a BOOL that of its byte."""
    if isinstance(type, BoolType):
        return "B"
    return type.code if isinstance(type, RealType) else counted(type).code


class Storages:
    """Reads, writes and addresses places for one routine."""

    def __init__(self, expressions: "ExpressionWriter") -> None:
        self._of = expressions

    # where it is -----------------------------------------------------------------------------

    def _terms(self, place: ResolvedPlace) -> list[tuple[CodeExpression, int]]:
        """Indexes and the bytes that each counts."""
        of = self._of
        terms: list[tuple[CodeExpression, int]] = []
        for term in place.terms:
            index = of.exact_value(term.index)
            if term.low is not None and term.high is not None:
                first, last = of.exact_value(term.low), of.exact_value(term.high)
                if not (first.high <= index.low and index.high <= last.low):
                    name = of.temporary()
                    text = (
                        f"({name} if {first.at(51)} <= ({name} := {index.text}) <= {last.at(51)}"
                        f" else out_of_bounds({name}, {first.text}, {last.text}))"
                    )
                    low, high = max(index.low, first.low), min(index.high, last.high)
                    index = CodeExpression(text, ATOM, low, high)
            terms.append((index, term.stride))
        return terms

    def _view(self, place: ResolvedPlace, code: str) -> tuple[str, str] | None:
        """View and index for numbers of a format, if all of them are at multiples of its size."""
        size = _SIZES[code.lower()]
        if not place.is_aligned(size):
            return None
        parts: list[str] = []
        if place.home is Home.INSTANCE:
            letter = "t"
            self._of.instance_formats.add(code)
            parts.append(self._of.base_index("t", size))
        else:
            assert place.area is not None
            letter = AREA_LETTERS[place.area]
            if place.home is Home.FRAME:
                parts.append(self._of.base_index("f", size))
        for piece, stride in self._terms(place):
            count = stride // size
            parts.append(piece.at(51) if count == 1 else f"{piece.at(60)} * {count}")
        number = place.offset // size
        if number or not parts:
            parts.append(str(number))
        return f"{letter}_{code}", " + ".join(parts)

    def address(self, place: ResolvedPlace) -> CodeExpression:
        parts: list[str] = []
        offset, is_fixed = place.offset, False
        if place.home is Home.ADDRESS:
            assert place.address is not None
            parts.append(self._of.exact_value(place.address).at(51))
        elif place.home is Home.INSTANCE:
            parts.append("this")
        else:
            if place.area is None:
                raise AssertionError("a Python variable has no address")
            offset += self._of.linker.project.placement.memory.address(place.area, 0)
            if place.home is Home.FRAME:
                parts.append("f")
            is_fixed = not parts and not place.terms
        parts += [f"{piece.at(60)} * {stride}" for piece, stride in self._terms(place)]
        if offset or not parts:
            parts.append(str(offset))
        if len(parts) == 1:
            fixed = offset if is_fixed else 0
            level = ATOM if parts[0].isalnum() else 0
            return CodeExpression(parts[0], level, fixed, fixed or _POINTER_MASK)
        text = " + ".join(parts)
        if not place.is_bounded or place.offset < 0:
            return CodeExpression(f"{text} & {_POINTER_MASK}", Precedence.BIT_AND, 0, _POINTER_MASK)
        return CodeExpression(text, Precedence.ADD, 0, _POINTER_MASK)

    # reading ---------------------------------------------------------------------------------

    def read(self, place: ResolvedPlace, *, spends: bool = False) -> CodeExpression:
        """Return the expression that reads a place; `spends`: it takes from the budget."""
        type = place.type
        if place.home is Home.LOCAL:
            return self._read_local(place)
        if isinstance(type, BoolType):
            text = self._number(place, "B")
            if place.bit is None:
                return CodeExpression(f"{text} != 0", Precedence.COMPARE)
            return CodeExpression(f"{text} & {1 << place.bit} != 0", Precedence.COMPARE)
        if isinstance(type, StringType):
            name = "load_text" if type.unit == 1 else "load_wide"
            text = f"{name}({self.address(place).text}, {type.length * type.unit})"
            return CodeExpression(f"spent_for({text})" if spends else text)
        if isinstance(type, StructType | ArrayType):
            text = f"load_bytes({self.address(place).text}, {type.size})"
            return CodeExpression(f"spent({type.size // BYTES_A_PASS}, {text})" if spends else text)
        return ranged(self._number(place, format_of(type)), type)

    def _number(self, place: ResolvedPlace, code: str) -> str:
        view = self._view(place, code)
        if view is not None:
            return f"{view[0]}[{view[1]}]"
        return f"load_{code}({self.address(place).text})"

    def _read_local(self, place: ResolvedPlace) -> CodeExpression:
        assert place.variable is not None
        name = local_name(place.variable)
        if place.bit is not None and not isinstance(resolved(place.variable.type), BoolType):
            number = place.offset * 8 + place.bit
            return CodeExpression(f"{name} >> {number} & 1 != 0", Precedence.COMPARE)
        return ranged(name, place.type)

    # writing ---------------------------------------------------------------------------------

    def store_statement(self, place: ResolvedPlace, value: CodeExpression) -> str:
        """Return a line that puts a value into a place; the value is evaluated before the
        indexes."""
        type = place.type
        if place.bit is None:
            if place.home is Home.LOCAL:
                assert place.variable is not None
                return f"{local_name(place.variable)} = {_as_stored(type, value).text}"
            if not isinstance(type, StringType | StructType | ArrayType):
                code, stored = _for_memory(type, value)
                view = self._view(place, code)
                if view is not None:
                    return f"{view[0]}[{view[1]}] = {stored}"
        return self.store_expression(place, value).text

    def store_expression(self, place: ResolvedPlace, value: CodeExpression) -> CodeExpression:
        """Return an expression that does it, place first, and is the value."""
        type = place.type
        if place.home is Home.LOCAL:
            return self._store_local(place, value)
        if place.bit is not None:
            address = self.address(place).text
            return CodeExpression(f"store_bit({address}, {1 << place.bit}, {value.text})")
        if isinstance(type, StringType):
            name = "store_text" if type.unit == 1 else "store_wide"
            return CodeExpression(f"{name}({self.address(place).text}, {value.text})")
        if isinstance(type, StructType | ArrayType):
            address = self.address(place).text
            parts = parts_without_headers(type)
            if parts == ((0, type.size),):
                return CodeExpression(f"store_bytes({address}, {value.text})")
            return CodeExpression(
                f"store_parts({address}, {value.text}, {self._of.linker.constant(parts)})"
            )
        # The value goes on to the next link of a chain, so it must be what a read would give.
        value, code = _as_stored(type, value), format_of(type)
        view = self._view(place, code)
        text = (
            f"put({view[0]}, {view[1]}, {value.text})"
            if view is not None
            else f"store_{code}({self.address(place).text}, {value.text})"
        )
        return CodeExpression(text, ATOM, value.low, value.high)

    def _store_local(self, place: ResolvedPlace, value: CodeExpression) -> CodeExpression:
        assert place.variable is not None
        name, whole_type = local_name(place.variable), resolved(place.variable.type)
        if place.bit is None or isinstance(whole_type, BoolType):
            value = _as_stored(place.type, value)
            return CodeExpression(f"({name} := {value.text})", ATOM, value.low, value.high)
        mask = 1 << place.offset * 8 + place.bit
        temporary = self._of.temporary()
        piece = CodeExpression(
            f"{name} | {mask} if ({temporary} := {value.text}) else {name} & {~mask}",
            Precedence.CHOICE,
            -(1 << 64),
            1 << 64,
        )
        return CodeExpression(
            f"({name} := {exact(piece, counted(whole_type)).text}, {temporary})[-1]"
        )


def ranged(text: str, type: IecType[Any] | None) -> CodeExpression:
    """Return a text that is a value of a type."""
    whole = _counted_or_none(type)
    if whole is None:
        return CodeExpression(text)
    return CodeExpression(text, ATOM, whole.low, whole.high)


def _counted_or_none(type: IecType[Any] | None) -> IntegerType | None:
    """Return the integer type that a value counts in; None for what is not a whole number."""
    return counted(type) if type is not None and is_whole(type) else None


def _as_stored(type: IecType[Any], value: CodeExpression) -> CodeExpression:
    """Return a value as its type holds it."""
    whole = _counted_or_none(type)
    if whole is not None:
        return exact(value, whole)
    if value.loose and isinstance(type, RealType) and type.size == 4:
        return CodeExpression(f"single({value.text})")
    return value


def _for_memory(type: IecType[Any], value: CodeExpression) -> tuple[str, str]:
    """Return the format to store a number with, and the number: cut in the unsigned view, where a
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


def encoded_from(value: Any, type: IecType[Any]) -> bytes:
    """Return the bytes in memory of a value that emitted code made, of a flat type."""
    if isinstance(type, StringType):
        return bytes(value[: type.length * type.unit]).ljust(type.size, b"\0")
    if isinstance(type, BoolType):
        return b"\1" if value else b"\0"
    if isinstance(type, RealType):
        return type.codec.pack(value)
    if is_whole(type):
        whole = counted(type)
        return int(value).to_bytes(whole.size, "little", signed=whole.low < 0)
    return bytes(value)
