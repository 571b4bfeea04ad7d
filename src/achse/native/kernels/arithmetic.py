"""Arithmetic of Python in instructions of the back end: conversions, operators, functions.

Before each operation that raises in Python, a checked translation tests if it would; an
unchecked one has some result then.
"""

import ast
import math
from collections.abc import Callable, Sequence
from types import FunctionType
from typing import Any, Protocol, TypeAlias

from achse.native.backend.builder import FunctionBuilder
from achse.native.backend.instructions import Relation
from achse.native.backend.module import MATH
from achse.native.backend.types import F64, I64, CallTarget, Operand
from achse.native.declare import RecordLayout
from achse.native.kernels.kinds import (
    BOOL,
    INT,
    REAL,
    KernelValue,
    Scalar,
    Several,
    ValueKind,
    described,
    joined,
    machine_types,
)

LIBRARY: dict[Callable[..., Any], str] = {getattr(math, name): name for name in MATH}
"""Functions that are those of the C library."""

_ARITHMETIC: dict[type[ast.operator], tuple[str, str]] = {
    ast.Add: ("add", "add"),
    ast.Sub: ("subtract", "sub"),
    ast.Mult: ("multiply", "mul"),
}
"""Names in the back end: that which wraps around, that which says whether it did."""

_BITWISE: dict[type[ast.operator], str] = {
    ast.BitAnd: "bit_and",
    ast.BitOr: "bit_or",
    ast.BitXor: "bit_xor",
    ast.LShift: "shift_left",
    ast.RShift: "shift_right",
}

_COMPARISONS: dict[type[ast.cmpop], Relation] = {
    ast.Eq: Relation.EQUAL,
    ast.NotEq: Relation.NOT_EQUAL,
    ast.Lt: Relation.LESS,
    ast.LtE: Relation.LESS_EQUAL,
    ast.Gt: Relation.GREATER,
    ast.GtE: Relation.GREATER_EQUAL,
}

_BEYOND = OverflowError, "a whole number beyond 64 bits"
_BY_ZERO = ZeroDivisionError, "division by zero"
_TO_INT = OverflowError, "cannot convert float infinity, or beyond 64 bits, to integer"

_OF_DOMAIN = ValueError, "math domain error"
_OF_RANGE = OverflowError, "math range error"
_GROWING = {"cosh", "exp", "expm1", "pow", "sinh"}
"""Functions whose infinity is one of size; that of others is a pole."""

_ZERO = Operand(I64, "0")
_MINUS_ONE = Operand(I64, "-1")
_LEAST = Operand(I64, str(I64.least))


class TranslationError(Exception):
    """A function is outside the kernel's language; the text names file, line and what it is."""


class KernelSignature(Protocol):
    """Signature of a function of the kernel for its callers."""

    machine: CallTarget
    names: Sequence[str]
    kinds: Sequence[ValueKind]
    defaults: dict[str, object]
    result: ValueKind
    ways: "Ways"


Ways: TypeAlias = tuple[tuple[str, bool], ...]
"""Parameters of a function that a call gives as True or False, by name, sorted."""


class TranslationUnit(Protocol):
    """The translation that a function is part of."""

    checked: bool

    def callee(self, function: FunctionType, ways: Ways = ()) -> KernelSignature: ...
    def table(self, numbers: tuple[Any, ...], kind: Scalar) -> Operand: ...
    def fresh(self, layout: RecordLayout[Any]) -> Operand: ...
    def site(self, error: type[Exception], text: str, function: FunctionType, line: int) -> int: ...


class Arithmetic:
    """Writes what is done with numbers of `function` into `code`."""

    def __init__(
        self, unit: TranslationUnit, function: FunctionType, code: FunctionBuilder
    ) -> None:
        self.unit = unit
        self.function = function
        self.code = code

    def refusal(self, node: ast.AST, what: str) -> TranslationError:
        """Return the error for source outside the kernel's language."""
        code = self.function.__code__
        return TranslationError(f"{code.co_filename}:{self._line(node)}: {code.co_name}: {what}")

    def _line(self, node: ast.AST) -> int:
        return getattr(node, "lineno", self.function.__code__.co_firstlineno)

    # -- checks ------------------------------------------------------------------------------

    def check(
        self, what: tuple[type[Exception], str], node: ast.AST, holds: Operand, *more: Operand
    ) -> None:
        """Leave with what Python raises here unless something holds; only for checked code.

        The text may show two operands, as {0} and {1}.
        """
        site = self.unit.site(*what, self.function, self._line(node))
        self.code.require(holds, site, *more)

    def differs(self, a: Operand, b: Operand) -> Operand:
        return self.code.compare(Relation.NOT_EQUAL, a, b)

    # -- kinds -------------------------------------------------------------------------------

    def convert(self, value: KernelValue, kind: ValueKind, node: ast.AST) -> KernelValue:
        """Return the same value as a wider kind."""
        if value.kind == kind:
            return value
        if isinstance(kind, Several) and isinstance(value.kind, Several):
            if len(kind.kinds) == len(value.kind.kinds):
                parts = zip(self.parts(value), kind.kinds, strict=True)
                return self.several([self.convert(part, wide, node) for part, wide in parts])
        elif isinstance(kind, Scalar) and joined(value.kind, kind) == kind:
            return KernelValue(kind, (self.code.convert(value.operands[0], kind.machine),))
        raise self.refusal(node, f"{described(value.kind)} where {described(kind)} belongs")

    def truth(self, value: KernelValue, node: ast.AST) -> Operand:
        """Return a bool that is true if a number is not 0."""
        if not isinstance(value.kind, Scalar):
            raise self.refusal(node, "only numbers are true or false")
        return self.code.convert(value.operands[0], BOOL.machine)

    def parts(self, value: KernelValue) -> list[KernelValue]:
        """Return the members of a tuple."""
        assert isinstance(value.kind, Several)
        members, first = [], 0
        for kind in value.kind.kinds:
            size = len(machine_types(kind))
            members.append(KernelValue(kind, value.operands[first : first + size]))
            first += size
        return members

    def several(self, members: Sequence[KernelValue]) -> KernelValue:
        kind = Several(tuple(member.kind for member in members))
        return KernelValue(kind, tuple(part for member in members for part in member.operands))

    # -- operators ---------------------------------------------------------------------------

    def combine(
        self, op: ast.operator, left: KernelValue, right: KernelValue, node: ast.AST
    ) -> KernelValue:
        """Return the result of an operator with two operands."""
        kind = joined(left.kind, right.kind)
        bits = _BITWISE.get(type(op))
        if kind is None or (bits and kind is REAL):
            raise self.refusal(node, f"no {type(op).__name__} of {described(left.kind)}")
        if kind is BOOL and (bits is None or isinstance(op, ast.LShift | ast.RShift)):
            kind = INT
        if isinstance(op, ast.Div):
            kind = REAL
        (a,) = self.convert(left, kind, node).operands
        (b,) = self.convert(right, kind, node).operands
        if bits:
            if self.unit.checked and isinstance(op, ast.LShift | ast.RShift):
                self._check_shift(op, a, b, node)
            return KernelValue(kind, (getattr(self.code, bits)(a, b),))
        if isinstance(op, ast.Div):
            self._check_divisor(b, node)
            return KernelValue(REAL, (self.code.divide(a, b),))
        if type(op) in _ARITHMETIC:
            return KernelValue(kind, (self._sum(op, a, b, node),))
        if isinstance(op, ast.Pow) and kind is REAL:
            return KernelValue(REAL, (self._power(a, b, node),))
        if isinstance(op, ast.Mod | ast.FloorDiv):
            if kind is INT:
                return KernelValue(INT, (self.whole_division(a, b, isinstance(op, ast.Mod), node),))
            if isinstance(op, ast.Mod):
                return KernelValue(REAL, (self.modulo(a, b, node),))
        raise self.refusal(node, f"no {type(op).__name__} of {described(kind)}")

    def _sum(self, op: ast.operator, a: Operand, b: Operand, node: ast.AST) -> Operand:
        """`+`, `-` and `*`, of whole numbers within 64 bits."""
        wrapping, telling = _ARITHMETIC[type(op)]
        if not self.unit.checked or a.type is F64:
            result: Operand = getattr(self.code, wrapping)(a, b)
            return result
        result, beyond = self.code.with_overflow(telling, a, b)
        self.check(_BEYOND, node, self.code.bit_not(beyond))
        return result

    def _check_shift(self, op: ast.operator, a: Operand, count: Operand, node: ast.AST) -> None:
        negative = ValueError, "negative shift count"
        self.check(negative, node, self.code.compare(Relation.GREATER_EQUAL, count, _ZERO))
        if isinstance(op, ast.LShift):
            back = self.code.shift_right(self.code.shift_left(a, count), count)
            self.check(_BEYOND, node, self.code.compare(Relation.EQUAL, back, a))

    def _power(self, a: Operand, b: Operand, node: ast.AST) -> Operand:
        if self.unit.checked:
            zero = self.code.constant(F64, 0.0)
            positive = self.code.compare(Relation.GREATER_EQUAL, b, zero)
            self.check(_BY_ZERO, node, self.code.bit_or(self.differs(a, zero), positive))
        return self.library("pow", node, a, b)

    def _check_divisor(self, b: Operand, node: ast.AST) -> None:
        if self.unit.checked:
            self.check(_BY_ZERO, node, self.differs(b, self.code.constant(b.type, 0)))

    def whole_division(self, a: Operand, b: Operand, remainder: bool, node: ast.AST) -> Operand:
        """`//` and `%` of whole numbers, which round down."""
        code = self.code
        self._check_divisor(b, node)
        if self.unit.checked and not remainder:
            fits = code.bit_or(self.differs(a, _LEAST), self.differs(b, _MINUS_ONE))
            self.check(_BEYOND, node, fits)
        rest = code.remainder(a, b)
        opposite = code.compare(Relation.LESS, code.bit_xor(rest, b), _ZERO)
        adjust = code.bit_and(opposite, self.differs(rest, _ZERO))
        if remainder:
            return code.add(rest, code.select(adjust, b, _ZERO))
        return code.subtract(code.divide(a, b), code.convert(adjust, I64))

    def modulo(self, a: Operand, b: Operand, node: ast.AST) -> Operand:
        """`%` of floats: the remainder has the sign of the divisor, also if it is 0."""
        code, zero = self.code, self.code.constant(F64, 0.0)
        self._check_divisor(b, node)
        rest = code.math("fmod", a, b)
        below = code.compare(Relation.LESS, rest, zero)
        negative = code.compare(Relation.LESS, b, zero)
        opposite = code.bit_xor(below, negative)
        adjusted = code.select(opposite, code.add(rest, b), rest)
        nothing = code.compare(Relation.EQUAL, rest, zero)
        return code.select(nothing, code.intrinsic("copysign", zero, b), adjusted)

    def negated(self, value: KernelValue, node: ast.AST) -> KernelValue:
        """-a"""
        (operand,) = value.operands
        if self.unit.checked and value.kind is INT:
            self.check(_BEYOND, node, self.differs(operand, _LEAST))
        return KernelValue(value.kind, (self.code.negate(operand),))

    def magnitude(self, value: KernelValue, node: ast.AST) -> KernelValue:
        """`abs`"""
        if value.kind is not REAL:
            value = self.convert(value, INT, node)
            if self.unit.checked:
                self.check(_BEYOND, node, self.differs(value.operands[0], _LEAST))
        return KernelValue(value.kind, (self.code.absolute(value.operands[0]),))

    def relation(
        self, op: ast.cmpop, left: KernelValue, right: KernelValue, node: ast.AST
    ) -> Operand:
        if type(op) not in _COMPARISONS:
            raise self.refusal(node, f"no comparison {type(op).__name__}")
        kind = joined(joined(left.kind, right.kind) or INT, INT)
        assert kind is not None
        (a,) = self.convert(left, kind, node).operands
        (b,) = self.convert(right, kind, node).operands
        return self.code.compare(_COMPARISONS[type(op)], a, b)

    # -- functions ---------------------------------------------------------------------------

    def library(self, name: str, node: ast.AST, *operands: Operand) -> Operand:
        """Return a function of the C library; checked, it raises what those of `math` raise."""
        result = self.code.math(name, *operands)
        if self.unit.checked:
            self._check_result(name, result, operands, node)
        return result

    def _check_result(
        self, name: str, result: Operand, operands: Sequence[Operand], node: ast.AST
    ) -> None:
        """Check that NaN comes only of NaN, infinity only of infinity."""
        code, infinite = self.code, self.code.constant(F64, math.inf)
        any_nan = any_infinite = code.constant(BOOL.machine, False)
        for each in operands:
            any_nan = code.bit_or(any_nan, self.differs(each, each))
            beyond = code.compare(Relation.EQUAL, code.absolute(each), infinite)
            any_infinite = code.bit_or(any_infinite, beyond)
        is_number = code.compare(Relation.EQUAL, result, result)
        self.check(_OF_DOMAIN, node, code.bit_or(is_number, any_nan))
        finite = self.differs(code.absolute(result), infinite)
        wrong = _OF_RANGE if name in _GROWING else _OF_DOMAIN
        self.check(wrong, node, code.bit_or(finite, any_infinite))

    def root(self, operand: Operand, node: ast.AST) -> Operand:
        """`math.sqrt`"""
        if self.unit.checked:
            below = self.code.compare(Relation.LESS, operand, self.code.constant(F64, 0.0))
            self.check(_OF_DOMAIN, node, self.code.bit_not(below))
        return self.code.intrinsic("sqrt", operand)

    def whole(self, operand: Operand, node: ast.AST) -> Operand:
        """Return a float without its fraction as a whole number; beyond 64 bits some number."""
        if self.unit.checked:
            code = self.code
            number = code.compare(Relation.EQUAL, operand, operand)
            self.check((ValueError, "cannot convert float NaN to integer"), node, number)
            low = code.compare(Relation.GREATER_EQUAL, operand, code.constant(F64, -(2.0**63)))
            high = code.compare(Relation.LESS, operand, code.constant(F64, 2.0**63))
            self.check(_TO_INT, node, code.bit_and(low, high))
        return self.code.truncate(operand, I64)

    def classify(self, callee: Callable[..., Any], operand: Operand) -> Operand:
        """`isnan`, `isinf` and `isfinite`."""
        if callee is math.isnan:
            return self.differs(operand, operand)
        relation = Relation.LESS if callee is math.isfinite else Relation.EQUAL
        infinite = self.code.constant(F64, math.inf)
        return self.code.compare(relation, self.code.absolute(operand), infinite)
