"""Expressions at a stop: what a user writes as a condition, a watch, or the target of a change."""

import math
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any, NoReturn

from achse.iec import ArrayType, IecError, IecType, StructType, resolved
from achse.iec.derived import InterfaceType, PointerType
from achse.iec.elementary import BOOL, BoolType
from achse.iec.literals import format_value, parse_value
from achse.iec.times import TimeType
from achse.plc.debug.places import CallView, DebugNames, DebugSpot, NotThere, is_long
from achse.st.lexis.literals import literal_value
from achse.st.lexis.source import SourceError
from achse.st.syntax.parser import parse_expression
from achse.st.syntax.tree import (
    Binary,
    Dereference,
    Expression,
    GlobalName,
    Index,
    Literal,
    Member,
    Name,
    PartOf,
    This,
    Unary,
)

_LONGEST_EXPRESSION = 4000
_LONGEST_SHOWN = 400
_DEEPEST = 100


class EvaluationError(Exception):
    """An expression that has no value here; the message says why."""


Value = DebugSpot | int | float | bool | str


def evaluate(text: str, names: DebugNames, view: CallView | None) -> Value:
    """Return the value of an expression: a variable, or a value. Calls are not made.

    Raises `EvaluationError`.
    """
    if len(text) > _LONGEST_EXPRESSION:
        raise EvaluationError(f"the expression has {len(text)} characters")
    tree = _parsed(text)
    if isinstance(tree, str):
        raise EvaluationError(tree)
    try:
        return _Evaluation(names, view).value(tree)
    except (NotThere, IecError) as failure:
        raise EvaluationError(str(failure.args[0] if failure.args else failure)) from None
    except (ZeroDivisionError, OverflowError, ValueError, TypeError) as failure:
        raise EvaluationError(str(failure)) from None
    except (RecursionError, MemoryError):
        raise EvaluationError("too large or too deep") from None


@lru_cache(1000)
def _parsed(text: str) -> Expression | str:
    """Return the tree; or why there is none. A condition is evaluated often."""
    try:
        return parse_expression(text)
    except SourceError as fault:
        return fault.faults[0].message
    except RecursionError:
        return "the expression is too deep"


def assign(target: str, text: str, names: DebugNames, view: CallView | None) -> DebugSpot:
    """Give a variable the value of a literal or expression. Raises `EvaluationError`."""
    spot = evaluate(target, names, view)
    if not isinstance(spot, DebugSpot):
        raise EvaluationError(f"{target} is not a variable")
    try:
        spot.write(parse_value(spot.type, text.strip()))
    except (IecError, ValueError, RecursionError):
        value = evaluate(text, names, view)
        try:
            if isinstance(value, DebugSpot):
                data = bytes(value.data[value.offset : value.offset + value.type.size])
                same = value.type.name.lower() == spot.type.name.lower()
                if same and value.bit is None and spot.bit is None:
                    spot.data[spot.offset : spot.offset + len(data)] = data
                    return spot
                value = value.read()
            spot.write(_fitting(spot.type, value))
        except (IecError, ValueError, TypeError, OverflowError) as failure:
            raise EvaluationError(str(failure)) from None
    return spot


def _fitting(type: IecType[Any], value: Any) -> object:
    real = resolved(type)
    if isinstance(real, TimeType):
        return real.decode(int(value).to_bytes(real.size, "little"))
    if isinstance(real, BoolType):
        return bool(value)
    return value


def text_of(value: Value) -> str:
    """Return a value as a literal."""
    if isinstance(value, DebugSpot):
        return shown(value)
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    return f"'{value}'" if isinstance(value, str) else repr(value)


def shown(spot: DebugSpot) -> str:
    """Return the value of a variable as a literal; of large ones what they are."""
    if spot.bit is not None:
        return "TRUE" if spot.read() else "FALSE"
    real = resolved(spot.type)
    if is_long(real):
        return spot.type.name
    data = bytes(spot.data[spot.offset : spot.offset + real.size])
    try:
        text = format_value(spot.type, real.decode(data))
    except IecError as failure:
        return f"<{failure}>"
    return text if len(text) <= _LONGEST_SHOWN else text[: _LONGEST_SHOWN - 1] + "…"


class _Evaluation:
    def __init__(self, names: DebugNames, view: CallView | None) -> None:
        self._names = names
        self._view = view
        self._depth = 0

    def value(self, tree: Expression) -> Value:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise EvaluationError("the expression is too deep")
        try:
            return self._value(tree)
        finally:
            self._depth -= 1

    def _value(self, tree: Expression) -> Value:
        names = self._names
        match tree:
            case Literal(_, text):
                literal = literal_value(text)
                if not literal.enum:
                    return literal.value
                return self._spot_or_number(
                    names.member_of(literal.enum.lower(), str(literal.value))
                )
            case Name(name):
                return self._variable(names.find(name, self._view), name)
            case GlobalName(name):
                return self._variable(names.find(name, None), name)
            case This():
                return names.this(self._view)
            case Dereference(This()):
                return names.this(self._view)
            case Dereference(of):
                return names.follow(self._spot(of))
            case Member(of, name):
                owner = self._owner(of)
                if isinstance(owner, str):
                    return self._spot_or_number(names.member_of(owner, name))
                return names.member(owner, name)
            case Index(of, indices):
                return names.element(
                    self._spot(of), [self._whole(self._plain(one)) for one in indices]
                )
            case PartOf(of, width, number):
                return self._part(self._spot(of), width, number)
            case Unary(operator, operand):
                return self._unary(operator.upper(), operand)
            case Binary(operator, left, right):
                return self._binary(operator.upper(), left, right)
        raise EvaluationError(f"{type(tree).__name__.lower()} is not evaluated here")

    def _variable(self, owner: DebugSpot | str, name: str) -> DebugSpot:
        if isinstance(owner, str):
            raise EvaluationError(f"{name} is not a variable")
        return owner

    def _spot_or_number(self, member: DebugSpot | int) -> Value:
        return member

    def _owner(self, tree: Expression) -> DebugSpot | str:
        """Return a variable, or the name of a unit or enumeration, also behind a name space."""
        if isinstance(tree, Name):
            return self._names.find(tree.name, self._view)
        if isinstance(tree, Member) and isinstance(tree.of, Name):
            try:
                owner = self._names.find(tree.of.name, self._view)
            except NotThere:
                return self._names.find(tree.name, None)
            if isinstance(owner, DebugSpot):
                return self._names.member(owner, tree.name)
            member = self._names.member_of(owner, tree.name)
            if isinstance(member, DebugSpot):
                return member
            raise EvaluationError(f"{tree.name} has no members")
        return self._spot(tree)

    def _spot(self, tree: Expression) -> DebugSpot:
        value = self.value(tree)
        if not isinstance(value, DebugSpot):
            raise EvaluationError("a variable is expected here")
        return value

    def _part(self, spot: DebugSpot, width: str, number: int) -> Value:
        bits = {"": 1, "X": 1, "B": 8, "W": 16, "D": 32}.get(width.upper(), 1)
        value = self._whole(self._number(spot))
        if not 0 <= number * bits < 8 * resolved(spot.type).size:
            raise EvaluationError(f"{spot.name} has no bit {number * bits}")
        if bits == 1:
            return DebugSpot(
                f"{spot.name}.{number}",
                BOOL,
                spot.data,
                spot.offset + number // 8,
                number % 8,
            )
        return value >> number * bits & (1 << bits) - 1

    # values ----------------------------------------------------------------------------------

    def _plain(self, tree: Expression) -> int | float | bool | str:
        value = self.value(tree)
        return self._number(value) if isinstance(value, DebugSpot) else value

    def _number(self, spot: DebugSpot) -> int | float | bool | str:
        real = resolved(spot.type)
        if isinstance(real, StructType) or not isinstance(
            value := spot.read(), int | float | bool | str
        ):
            raise EvaluationError(f"{spot.name} is {spot.type.name}: name a part of it")
        return value

    def _whole(self, value: object) -> int:
        if isinstance(value, bool) or not isinstance(value, int):
            raise EvaluationError(f"a whole number is expected, got {value!r}")
        return value

    def _unary(self, operator: str, operand: Expression) -> Value:
        value = self._plain(operand)
        if operator == "NOT":
            if isinstance(value, bool):
                return not value
            spot = self.value(operand)
            size = resolved(spot.type).size if isinstance(spot, DebugSpot) else 4
            return ~self._whole(value) & (1 << 8 * size) - 1
        if isinstance(value, str | bool):
            _refuse(operator, value)
        return -value if operator == "-" else value

    def _binary(self, operator: str, left: Expression, right: Expression) -> Value:
        first = self._plain(left)
        if operator in ("AND_THEN", "OR_ELSE") and isinstance(first, bool):
            if first is (operator == "OR_ELSE"):
                return first
            return bool(self._plain(right))
        second = self._plain(right)
        compare = _COMPARISONS.get(operator)
        if compare is not None:
            if isinstance(first, str) is not isinstance(second, str):
                _refuse(operator, second)
            return compare(first, second)
        if operator in _LOGIC:
            if isinstance(first, bool) and isinstance(second, bool):
                return bool(_LOGIC[operator](first, second))
            return _LOGIC[operator](int(first), int(second))
        for value in (first, second):
            if isinstance(value, str | bool):
                _refuse(operator, value)
        assert not isinstance(first, str)
        assert not isinstance(second, str)
        return _arithmetic(operator, first, second)


_COMPARISONS: Mapping[str, Callable[[Any, Any], bool]] = {
    "=": lambda a, b: bool(a == b),
    "<>": lambda a, b: bool(a != b),
    "<": lambda a, b: bool(a < b),
    "<=": lambda a, b: bool(a <= b),
    ">": lambda a, b: bool(a > b),
    ">=": lambda a, b: bool(a >= b),
}

_LOGIC: Mapping[str, Callable[[int, int], int]] = {
    "AND": lambda a, b: a & b,
    "&": lambda a, b: a & b,
    "OR": lambda a, b: a | b,
    "XOR": lambda a, b: a ^ b,
}


def _arithmetic(operator: str, first: float, second: float) -> int | float:
    if operator == "+":
        return first + second
    if operator == "-":
        return first - second
    if operator == "*":
        return first * second
    if operator == "/":
        if isinstance(first, int) and isinstance(second, int):
            quotient = abs(first) // abs(second)
            return quotient if (first < 0) is (second < 0) else -quotient
        return first / second
    if operator == "MOD" and isinstance(first, int) and isinstance(second, int):
        return int(math.fmod(first, second)) if second else 0
    if operator == "**":
        return math.pow(first, second)
    raise EvaluationError(f"{operator} is not evaluated here")


def _refuse(operator: str, value: object) -> NoReturn:
    raise EvaluationError(f"{operator} does not take {value!r}")


def is_expandable(spot: DebugSpot) -> bool:
    """Return True if a variable has parts."""
    real = resolved(spot.type)
    if isinstance(real, InterfaceType):
        return False
    return isinstance(real, StructType | ArrayType | PointerType)
