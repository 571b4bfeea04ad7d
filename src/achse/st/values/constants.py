"""Constant expressions: their value.

Source: IEC 61131-3 (2013) tables 5 and 71.
"""

import math
import operator
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from typing import Any, TypeAlias

from achse.iec.arrays import ArrayType
from achse.iec.derived import resolved
from achse.iec.elementary import BOOL, BYTE, DINT, DWORD, LWORD, WORD, IntegerType
from achse.iec.enums import EnumType
from achse.iec.errors import IecError
from achse.iec.times import TimeType
from achse.iec.types import IecType
from achse.st.lexis.codes import Code
from achse.st.lexis.literals import literal_value
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import (
    Assign,
    Binary,
    Call,
    Dereference,
    DirectAddress,
    Expression,
    GlobalName,
    Index,
    Literal,
    Member,
    Name,
    PartOf,
    Super,
    This,
    TypeOperand,
    Unary,
)
from achse.st.values.functions import UTF8_LITERALS, called, is_standard
from achse.st.values.values import Constant, NotConstant, checked

Path: TypeAlias = tuple[str, ...]
Lookup: TypeAlias = Callable[[Path, int], Constant]
"""Gives the constant of a name; raises `NotConstant` for other names, `Unexpected` for none."""


def path_of(tree: object) -> Path | None:
    """Return the names of `a.b.c`; None if the expression is anything else."""
    names: list[str] = []
    while isinstance(tree, Member):
        names.append(tree.name)
        tree = tree.of
    if not isinstance(tree, Name | GlobalName):
        return None
    return (tree.name, *reversed(names))


def _unknown(tree: Expression) -> Constant:
    raise NotConstant(tree.at)


class Evaluator:
    """Finds the value of expressions.

    `type_of` knows types by name and the types of variables, `otherwise` the values of operands
    that are not constants, where there are any.
    """

    def __init__(
        self,
        lookup: Lookup,
        type_of: Callable[[Expression], IecType[Any]],
        otherwise: Callable[[Expression], Constant] = _unknown,
    ) -> None:
        self._lookup = lookup
        self._type_of = type_of
        self._otherwise = otherwise

    def value(self, tree: Expression) -> Constant:
        """Return the value of an expression. Raises `NotConstant` and `Unexpected`."""
        # Long sums lean to the left: that side is walked, not descended.
        chain: list[Binary] = []
        while isinstance(tree, Binary):
            chain.append(tree)
            tree = tree.left
        left = self._operand(tree)
        for node in reversed(chain):
            left = _binary(node.operator, left, self.value(node.right), node.at)
        return left

    def integer(self, tree: Expression, what: str, at: int) -> int:
        """Return the value of an expression that must be a constant whole number, for example
        `what`."""
        try:
            constant = self.value(tree)
        except NotConstant as fault:
            raise Unexpected(
                fault.at, f"{what} is a constant, not known before run time", Code.CONSTANT_EXPECTED
            ) from None
        if isinstance(constant.value, bool) or not isinstance(constant.value, int):
            raise Unexpected(
                at, f"{what} is a whole number, got {constant.value!r}", Code.BAD_OPERAND
            )
        return constant.value

    def _operand(self, tree: Expression) -> Constant:
        try:
            return self._constant(tree)
        except NotConstant:
            return self._otherwise(tree)

    def _constant(self, tree: Expression) -> Constant:
        match tree:
            case Literal():
                return self._literal(tree)
            case Name() | Member() | GlobalName():
                path = path_of(tree)
                if path is None:
                    raise NotConstant(tree.at)
                return self._lookup(path, tree.at)
            case Unary():
                return _unary(tree.operator, self.value(tree.operand), tree.at)
            case PartOf():
                return self._part(tree)
            case Call():
                return self._call(tree)
            case (
                DirectAddress()
                | Assign()
                | Dereference()
                | Index()
                | This()
                | Super()
                | TypeOperand()
            ):
                raise NotConstant(tree.at)
            case Binary():
                raise AssertionError("walked by value")

    def _literal(self, tree: Literal) -> Constant:
        try:
            type, value, enum = literal_value(tree.text)
        except IecError as error:
            raise Unexpected(tree.at, str(error), Code.BAD_LITERAL) from None
        if enum:
            if isinstance(value, str):
                return self._lookup((enum, value), tree.at)
            return Constant(value, self._enumeration(enum, tree.at))
        if type is None and isinstance(value, int) and "#" in tree.text:
            # 16#FF is bits as much as a number: it fills the smallest bit string that holds it.
            type = next((bits for bits in (BYTE, WORD, DWORD, LWORD) if value <= bits.high), None)
        return Constant(value, type)

    def _enumeration(self, name: str, at: int) -> IecType[Any]:
        """Return the type that `E_State#3` names."""
        try:
            type = resolved(self._type_of(Name(name, at)))
        except NotConstant:
            raise Unexpected(at, f"no type is named '{name[:80]}'", Code.UNKNOWN_TYPE) from None
        if not isinstance(type, EnumType | IntegerType):
            raise Unexpected(
                at,
                f"{name}#… is the value of an enumeration, not of a {type.name}",
                Code.UNKNOWN_ENUM_VALUE,
            )
        return type

    def _part(self, tree: PartOf) -> Constant:
        whole = self.value(tree.of)
        if isinstance(whole.value, bool) or not isinstance(whole.value, int):
            raise Unexpected(
                tree.at, f"a bit of a whole number, got {whole.value!r}", Code.BAD_PART
            )
        bits = {"X": 1, "B": 8, "W": 16, "D": 32, "L": 64}[tree.width]
        part = whole.value >> bits * tree.number & (1 << bits) - 1
        return Constant(bool(part), BOOL) if bits == 1 else Constant(part)

    def _call(self, tree: Call) -> Constant:
        path = path_of(tree.of)
        if path is None:
            raise NotConstant(tree.at)
        name = path[-1].upper()
        operands = [argument.value for argument in tree.arguments if argument.value is not None]
        if name in UTF8_LITERALS and all(isinstance(item, Literal) for item in operands):
            return called(name, [self.value(item) for item in operands], tree.at)
        if len(path) == 1 and self._is_declared(path, tree.at):
            raise NotConstant(tree.at)
        if name in _OF_TYPES:
            return self._of_type(name, operands, tree.at)
        if name == "ADR":
            self._check_names(operands)
        if not is_standard(name):
            raise NotConstant(tree.at)
        if any(argument.name for argument in tree.arguments):
            raise NotConstant(tree.at)
        return called(name, [self._operand_value(operand) for operand in operands], tree.at)

    def _is_declared(self, path: Path, at: int) -> bool:
        """Return True if the user declares that name; its value is not known before run time."""
        try:
            self._lookup(path, at)
        except NotConstant:
            return True
        except Unexpected:
            pass
        return False

    def _operand_value(self, tree: Expression) -> Constant:
        value = self.value(tree)
        # The bits of 16#FF are as many as the function makes of it.
        return value._replace(type=None) if _is_plain_number(tree) else value

    def _of_type(self, name: str, operands: Sequence[Expression], at: int) -> Constant:
        """SIZEOF, LOWER_BOUND and UPPER_BOUND: what the type of a variable says."""
        if len(operands) != _OF_TYPES[name]:
            raise Unexpected(
                at,
                f"{name} takes {_OF_TYPES[name]} arguments, got {len(operands)}",
                Code.ARGUMENT_COUNT,
            )
        type = self._type_of(operands[0])
        if len(operands) == 1:
            return Constant(type.size)
        array = resolved(type)
        if not isinstance(array, ArrayType):
            raise Unexpected(
                operands[0].at, f"{name} takes an array, got {type.name}", Code.ARGUMENT_TYPE
            )
        number = self.integer(operands[1], "a dimension", at)
        if not 1 <= number <= len(array.dimensions):
            raise Unexpected(
                operands[1].at,
                f"{type.name} has {len(array.dimensions)} dimensions",
                Code.BAD_INDEX,
            )
        bounds = array.dimensions[number - 1]
        return Constant(bounds.first if name == "LOWER_BOUND" else bounds.last, DINT)

    def _check_names(self, operands: Iterable[Expression]) -> None:
        """Raise `Unexpected` for a name of nothing."""
        for operand in operands:
            path = path_of(operand)
            if path is not None:
                with suppress(NotConstant):
                    self._lookup(path, operand.at)


_OF_TYPES = {"SIZEOF": 1, "XSIZEOF": 1, "LOWER_BOUND": 2, "UPPER_BOUND": 2}
"""Operators that look at the type of their first operand, and how many they have."""


def _is_plain_number(tree: Expression) -> bool:
    return isinstance(tree, Literal) and tree.text[0].isdecimal()


def _quotient(left: Any, right: Any) -> Any:
    if isinstance(left, int) and isinstance(right, int):
        quotient = abs(left) // abs(right)
        return quotient if (left < 0) == (right < 0) else -quotient
    return left / right


def _remainder(left: Any, right: Any) -> Any:
    return left - right * _quotient(left, right)


def _power(left: Any, right: Any) -> Any:
    return float(left) ** right


_NUMBERS: dict[str, Callable[[Any, Any], Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": _quotient,
    "MOD": _remainder,
    "**": _power,
}
_COMPARISONS: dict[str, Callable[[Any, Any], bool]] = {
    "=": operator.eq,
    "<>": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
_BITS: dict[str, Callable[[Any, Any], Any]] = {
    "AND": operator.and_,
    "AND_THEN": operator.and_,
    "OR": operator.or_,
    "OR_ELSE": operator.or_,
    "XOR": operator.xor,
}


def _binary(sign: str, left: Constant, right: Constant, at: int) -> Constant:
    text = isinstance(left.value, str) or isinstance(right.value, str)
    if sign in _COMPARISONS:
        if text and not (isinstance(left.value, str) and isinstance(right.value, str)):
            raise Unexpected(at, f"'{sign}' compares values of one kind", Code.BAD_OPERAND)
        return Constant(_COMPARISONS[sign](left.value, right.value), BOOL)
    truths = isinstance(left.value, bool) + isinstance(right.value, bool)
    if sign in _BITS:
        if truths == 1 or text or isinstance(left.value, float) or isinstance(right.value, float):
            raise Unexpected(at, f"{sign} takes two truths or two whole numbers", Code.BAD_OPERAND)
        result = checked(_BITS[sign], [left.value, right.value], at)
        return Constant(result.value, left.type if left.type is right.type else result.type)
    if truths or text:
        raise Unexpected(at, f"'{sign}' takes numbers", Code.BAD_OPERAND)
    result = checked(_NUMBERS[sign], [left.value, right.value], at)
    return _timed(sign, left, right, result, at)


def _timed(sign: str, left: Constant, right: Constant, result: Constant, at: int) -> Constant:
    """Return the result of arithmetic, as a time if it is one."""
    times = [item.type for item in (left, right) if isinstance(item.type, TimeType)]
    if not times or (len(times) == 2 and sign in ("/", "MOD")):
        return result
    if len(times) == 2 and times[0] is not times[1]:
        raise Unexpected(at, f"'{sign}' takes times of one type", Code.BAD_OPERAND)
    return Constant(
        math.trunc(result.value) if isinstance(result.value, float) else result.value, times[0]
    )


def _unary(sign: str, operand: Constant, at: int) -> Constant:
    value = operand.value
    if sign == "NOT":
        if isinstance(value, bool):
            return Constant(not value, BOOL)
        if isinstance(value, int):
            kind = operand.type
            unsigned = isinstance(kind, IntegerType) and kind.low == 0
            return Constant(~value & kind.high, kind) if unsigned else Constant(~value)  # type: ignore[union-attr]
    elif not isinstance(value, bool | str):
        if sign == "+":
            return operand
        # -16#80 is a number, and no bits any more.
        return Constant(-value, None if isinstance(operand.type, IntegerType) else operand.type)
    raise Unexpected(at, f"{sign} takes a number, got {value!r}", Code.BAD_OPERAND)
