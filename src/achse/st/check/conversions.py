"""Conversions: how an operand becomes what a variable, an operator or a call takes."""

from collections.abc import Callable
from typing import Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import InterfaceType, PointerType, resolved
from achse.iec.elementary import BoolType, IntegerType, RealType
from achse.iec.enums import EnumType
from achse.iec.strings import StringType
from achse.iec.structs import RecordKind, StructType
from achse.iec.times import TimeType
from achse.iec.types import IecType
from achse.st.check.folding import cut, folded, real
from achse.st.check.kinds import counted, is_signed, is_whole, same_shape
from achse.st.check.operands import TypedOperand, address_of, coded
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.typed.expressions import Conversion, Converted, Known, TypedValue
from achse.st.typed.places import flat

Warn = Callable[[int, str, Code], None]
Implements = Callable[[StructType[Any], InterfaceType], bool | None]


def converted(value: TypedValue, target: IecType[Any], at: int) -> TypedValue:
    """Return a value at another flat type, however much of it is lost. Folds constants.

    Types that differ in name only need no conversion: BYTE and USINT, POINTER and LWORD.
    """
    source = value.type
    assert source is not None
    if source is target:
        return value
    rule = _rule(source, target)
    if rule is None:
        return Known(value.value, target, value.at) if isinstance(value, Known) else value
    # A constant stays where it is written.
    return folded(Converted(value, target, rule, value.at if isinstance(value, Known) else at))


def _rule(source: IecType[Any], target: IecType[Any]) -> Conversion | None:
    if isinstance(target, StringType):
        return _to_text(source, target)
    if isinstance(source, StringType):
        return Conversion.READ_TEXT
    if isinstance(target, BoolType):
        return None if isinstance(source, BoolType) else Conversion.TO_BOOL
    if isinstance(source, BoolType):
        return Conversion.FROM_BOOL
    if isinstance(source, RealType):
        if isinstance(target, RealType):
            return None if source.size == target.size else Conversion.RESIZE_REAL
        return Conversion.ROUND
    if isinstance(target, RealType):
        return Conversion.TO_REAL
    if isinstance(source, TimeType) and isinstance(target, TimeType):
        return None if _unit(source) == _unit(target) else Conversion.RESCALE
    if not (is_whole(source) and is_whole(target)):
        return None
    have, want = counted(source), counted(target)
    if have.size == want.size and is_signed(have) == is_signed(want):
        return None
    if want.low <= have.low and have.high <= want.high:
        return Conversion.EXTEND
    return Conversion.CUT


_SAME_TIMES = {"TIME_OF_DAY": "TOD", "DATE_AND_TIME": "DT"}


def _unit(type: TimeType[Any]) -> str:
    return _SAME_TIMES.get(type.name, type.name)


def _to_text(source: IecType[Any], target: StringType) -> Conversion | None:
    if not isinstance(source, StringType):
        return Conversion.WRITE_TEXT
    if source.unit != target.unit:
        return Conversion.RECODE_TEXT
    # The bytes stay, whether one is said to be UTF-8 or not.
    return Conversion.CUT_TEXT if source.length > target.length else None


class Converter:
    """Converts operands where the source says nothing of it, and warns of what may be lost.

    `implements` is True if a function block has an interface; None if it cannot be known.
    """

    def __init__(self, warn: Warn, implements: Implements) -> None:
        self._warn = warn
        self._implements = implements

    def implicit(self, operand: TypedOperand, target: IecType[Any], at: int) -> TypedValue:
        """Return the operand as a variable of `target` takes it. Raises `Unexpected` if none
        does."""
        to = flat(target)
        value = operand.value
        if operand.loose and isinstance(value, Known):
            if to is not target:
                self._check_value(operand, target, at)
            return self._constant(operand, target, to, at)
        if value.type is target and to is target:
            return value  # neither an enumeration nor an alias: nothing to convert or check
        source = operand.flat
        if isinstance(to, InterfaceType):
            return self._interface(operand, to, at)
        if isinstance(to, StructType | ArrayType) or isinstance(source, StructType | ArrayType):
            if not same_shape(source, to):
                raise self._misfit(operand, target, at)
            return value
        if isinstance(to, BoolType) != isinstance(source, BoolType):
            raise self._misfit(operand, target, at)
        if isinstance(to, StringType) != isinstance(source, StringType):
            raise self._misfit(operand, target, at)
        if isinstance(to, StringType) and isinstance(source, StringType):
            if to.unit != source.unit:
                raise self._misfit(operand, target, at)
        elif isinstance(resolved(target), EnumType):
            self._check_enum(operand, target, at)
        elif source is not to:
            self._check_loss(operand, target, to, at)
        return converted(value, to, at)

    def _misfit(self, operand: TypedOperand, target: IecType[Any], at: int) -> Unexpected:
        return Unexpected(
            at, f"a {operand.type.name} does not go into a {target.name}", Code.INCOMPATIBLE_TYPES
        )

    def _interface(self, operand: TypedOperand, to: InterfaceType, at: int) -> TypedValue:
        source = operand.flat
        if isinstance(source, StructType) and source.kind is RecordKind.FUNCTION_BLOCK:
            if self._implements(source, to) is False:
                raise Unexpected(
                    at,
                    f"{source.name} does not implement {to.name}",
                    Code.INTERFACE_NOT_IMPLEMENTED,
                )
            if operand.storage is None:
                raise Unexpected(
                    at, f"a {source.name} that is not a variable has no address", Code.NO_ADDRESS
                )
            return address_of(operand.storage, to, at)
        if isinstance(source, PointerType) or (is_whole(source) and source.size == to.size):
            return operand.value
        raise self._misfit(operand, to, at)

    # constants -------------------------------------------------------------------------------

    def _constant(
        self, operand: TypedOperand, target: IecType[Any], to: IecType[Any], at: int
    ) -> TypedValue:
        """Return a constant of no certain type takes the type it goes into, if that holds it."""
        value = operand.constant
        if operand.text is not None:
            source = operand.flat
            if (
                isinstance(to, StringType)
                and isinstance(source, StringType)
                and (to.unit == source.unit)
            ):
                return Known(coded(operand.text, to), to, at)
            raise self._misfit(operand, target, at)
        assert isinstance(value, int | float)
        if isinstance(to, BoolType):
            if isinstance(value, bool) or value in (0, 1):
                return Known(bool(value), to, at)
            raise self._misfit(operand, target, at)
        if isinstance(value, bool):
            raise self._misfit(operand, target, at)
        if isinstance(to, RealType):
            return Known(real(float(value), to), to, at)
        if not is_whole(to):
            raise self._misfit(operand, target, at)
        if isinstance(value, float):
            self._warn(
                at, f"{value:g} is rounded: a {target.name} has no fraction", Code.VALUE_ROUNDED
            )
            return converted(operand.value, to, at)
        if isinstance(to, TimeType) and value != 0:
            self._warn(
                at,
                f"{value} goes into a {target.name} as a count; write a unit",
                Code.NUMBER_TO_TIME,
            )
        whole = counted(to)
        if not whole.low <= value <= whole.high:
            width = 8 * whole.size
            fits = operand.is_bits and -(1 << width) <= value < 1 << width
            if not fits:
                self._warn(
                    at, f"{value} does not fit into a {target.name}: it is cut", Code.VALUE_CUT
                )
            return Known(cut(value, to), to, at)
        return Known(value, to, at)

    # what may be lost ------------------------------------------------------------------------

    def _check_enum(self, operand: TypedOperand, target: IecType[Any], at: int) -> None:
        enum, source = resolved(target), resolved(operand.type)
        if source is enum or not isinstance(enum, EnumType):
            return
        names = {name.lower() for name in enum.attributes}
        if isinstance(source, EnumType):
            alike = source.numbers == enum.numbers
            if alike and _simple(source.name) == _simple(enum.name):
                return  # once of a library, once of a symbol file
            self._warn(at, f"a value of {source.name} goes into a {enum.name}", Code.NUMBER_TO_ENUM)
        elif "strict" in names and operand.constant not in enum.numbers.values():
            raise Unexpected(
                at, f"{enum.name} is strict: it takes its values only", Code.STRICT_ENUM
            )
        if isinstance(operand.flat, RealType):
            self._warn(
                at,
                f"a {operand.type.name} is rounded to go into a {target.name}",
                Code.VALUE_ROUNDED,
            )

    def _check_value(self, operand: TypedOperand, target: IecType[Any], at: int) -> None:
        """Check that a number assigned to a strict enumeration is one of its values."""
        enum = resolved(target)
        if not isinstance(enum, EnumType):
            return
        is_strict = "strict" in {name.lower() for name in enum.attributes}
        if is_strict and operand.constant not in enum.numbers.values():
            raise Unexpected(
                at, f"{enum.name} is strict: it takes its values only", Code.STRICT_ENUM
            )

    def _check_loss(
        self, operand: TypedOperand, target: IecType[Any], to: IecType[Any], at: int
    ) -> None:
        source = flat(operand.type)
        if isinstance(source, RealType):
            if isinstance(to, RealType):
                if to.size < source.size and not operand.soft:
                    self._warn(at, f"an LREAL loses digits as a {target.name}", Code.DIGITS_LOST)
            else:
                self._warn(
                    at,
                    f"a {operand.type.name} is rounded to go into a {target.name}",
                    Code.VALUE_ROUNDED,
                )
            return
        if isinstance(to, RealType) or isinstance(source, BoolType | StringType):
            return
        if not (is_whole(source) and is_whole(to)):
            return
        if isinstance(source, TimeType) and isinstance(to, TimeType):
            return
        have, want = counted(source), counted(to)
        value = operand.constant
        if isinstance(value, int) and want.low <= value <= want.high:
            return
        if want.size < have.size:
            self._warn(
                at, f"a {operand.type.name} is cut to go into a {target.name}", Code.VALUE_CUT
            )
            return
        loses_sign = is_signed(have) and not is_signed(want)
        turns = want.size == have.size and is_signed(have) != is_signed(want)
        is_both = isinstance(source, IntegerType) and isinstance(to, IntegerType)
        if is_both and (loses_sign or turns):
            self._warn(
                at,
                f"a {operand.type.name} may change its sign as a {target.name}",
                Code.SIGN_MAY_CHANGE,
            )


def _simple(name: str) -> str:
    """Return a name without its name space, to compare."""
    return name.rpartition(".")[2].casefold()
