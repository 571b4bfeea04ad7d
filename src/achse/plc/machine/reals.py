"""REAL and LREAL in machine code: what is undefined stops the program or is an infinity or NaN.

REAL is computed in single precision where that is the same as in double precision rounded once,
and in double precision else.
"""

import math
import struct
from functools import reduce
from typing import TYPE_CHECKING

from achse.native.backend import BOOL, F32, F64, U32, U64, MachineType, Operand, Relation
from achse.plc.lowering.nodes import Check, Compute
from achse.plc.machine.fault_places import FaultKind
from achse.plc.machine.values import machine_type
from achse.st.typed.expressions import Known, Operator

if TYPE_CHECKING:
    from achse.plc.machine.expressions import ExpressionTranslator

_C_NAMES = {
    Operator.LN: "log",
    Operator.LOG: "log10",
    Operator.EXP: "exp",
    Operator.SIN: "sin",
    Operator.COS: "cos",
    Operator.TAN: "tan",
    Operator.ASIN: "asin",
    Operator.ACOS: "acos",
    Operator.ATAN: "atan",
}


class RealTranslator:
    """Operators of reals, for one routine."""

    def __init__(self, expressions: "ExpressionTranslator") -> None:
        self._of = expressions

    def computed(self, value: Compute) -> Operand:
        of = self._of
        b, operator = of.builder, value.operator
        type = machine_type(value.type)
        values = [of.at_type(of.number(one), type) for one in value.operands]
        first = values[0]
        match operator:
            case Operator.ADD:
                return reduce(b.add, values)
            case Operator.SUB:
                return reduce(b.subtract, values)
            case Operator.MUL:
                return reduce(b.multiply, values)
            case Operator.MIN | Operator.MAX:
                return of.best(operator, values)
            case Operator.DIV:
                divisor = value.operands[1]
                known = isinstance(divisor, Known) and bool(divisor.value)
                return self._divided(*values, known=known)
            case Operator.NEG:
                return b.negate(first)
            case Operator.ABS:
                return b.absolute(first)
        wide = [b.convert(one, F64) for one in values]
        result = self._power(*wide) if operator is Operator.EXPT else self._of_one(operator, *wide)
        return b.convert(result, type)

    def check(self, value: Check) -> Operand:
        """Return a real; if it is NaN although no operand is, that stops the program."""
        of = self._of
        b = of.builder
        type = machine_type(value.type)
        number = of.number(value.value)
        result = b.variable(type)
        b.set(result, number)
        odd, good = b.label(), b.label()
        b.branch(b.compare(Relation.EQUAL, number, number), good, odd)
        with b.aside(odd):
            self._required_nan([of.at_type(of.number(one), type) for one in value.operands])
            b.set(result, self._nan(type))
            b.jump(good)
        b.begin(good)
        return b.get(result)

    def _required_nan(self, values: list[Operand]) -> None:
        """Raise FPU_INVALID_OPERATION unless one of the values is NaN."""
        of = self._of
        b = of.builder
        known = b.constant(BOOL, False)
        for one in values:
            known = b.bit_or(known, b.compare(Relation.NOT_EQUAL, one, one))
        b.require(known, of.site(FaultKind.REAL_INVALID))

    def _nan(self, type: MachineType) -> Operand:
        """Return the NaN of plain code."""
        b = self._of.builder
        kind = U32 if type is F32 else U64
        bits = struct.unpack(*(("<I", _SINGLE) if kind is U32 else ("<Q", _DOUBLE)))[0]
        return b.reinterpret(b.constant(kind, bits), type)

    def _loudly_divided(self, left: Operand, right: Operand) -> Operand:
        """Divide with exceptions on: only infinity may be divided by 0."""
        of = self._of
        b = of.builder
        zero = b.constant(right.type, 0.0)
        quotient = b.divide(left, right)
        result = b.variable(left.type)
        b.set(result, quotient)
        is_zero = b.compare(Relation.EQUAL, right, zero)
        is_nan = b.compare(Relation.NOT_EQUAL, quotient, quotient)
        odd, nan, number, good = (b.label() for _ in range(4))
        b.branch(b.bit_or(is_zero, is_nan), odd, good)
        with b.aside(odd):
            b.branch(is_nan, nan, number)
            b.begin(nan)
            self._required_nan([left, right])
            b.set(result, self._nan(left.type))
            b.jump(good)
            b.begin(number)
            endless = b.constant(left.type, math.inf)
            is_endless = b.compare(Relation.EQUAL, b.absolute(left), endless)
            b.require(is_endless, of.site(FaultKind.REAL_DIVIDE))
            b.jump(good)
        b.begin(good)
        return b.get(result)

    def _divided(self, left: Operand, right: Operand, *, known: bool) -> Operand:
        of = self._of
        b = of.builder
        if known:
            return b.divide(left, right)
        zero = b.constant(right.type, 0.0)
        if of.module.exceptions:
            return self._loudly_divided(left, right)
        nothing = b.compare(Relation.EQUAL, left, zero)
        undefined = b.bit_or(nothing, b.compare(Relation.NOT_EQUAL, left, left))
        undefined = b.bit_and(undefined, b.compare(Relation.EQUAL, right, zero))
        return self._not_a_number(undefined, b.divide(left, right))

    def _of_one(self, operator: Operator, value: Operand) -> Operand:
        """Return a function of one number, of 64 bits."""
        b = self._of.builder
        if operator is Operator.SQRT:
            bad = b.compare(Relation.LESS, value, b.constant(F64, 0.0))
            return self._checked(b.intrinsic("sqrt", value), invalid=bad)
        result = b.math(_C_NAMES[operator], value)
        match operator:
            case Operator.LN | Operator.LOG:
                zero = b.constant(F64, 0.0)
                pole = b.compare(Relation.EQUAL, value, zero)
                bad = b.compare(Relation.LESS, value, zero)
                return self._checked(result, invalid=bad, pole=pole, at_pole=-math.inf)
            case Operator.SIN | Operator.COS | Operator.TAN:
                endless = b.constant(F64, math.inf)
                bad = b.compare(Relation.EQUAL, b.absolute(value), endless)
                return self._checked(result, invalid=bad)
            case Operator.ASIN | Operator.ACOS:
                bad = b.compare(Relation.GREATER, b.absolute(value), b.constant(F64, 1.0))
                return self._checked(result, invalid=bad)
        return result

    def _power(self, base: Operand, power: Operand) -> Operand:
        b = self._of.builder
        result = b.math("pow", base, power)
        lowest, highest = b.constant(F64, -math.inf), b.constant(F64, math.inf)
        negative = b.bit_and(
            b.compare(Relation.EQUAL, result, lowest), b.compare(Relation.NOT_EQUAL, base, lowest)
        )
        result = b.select(negative, highest, result)  # too large is +inf, as plain code has it
        zero = b.constant(F64, 0.0)
        pole = b.bit_and(
            b.compare(Relation.EQUAL, base, zero),
            b.bit_and(
                b.compare(Relation.LESS, power, zero), b.compare(Relation.GREATER, power, lowest)
            ),
        )
        number = b.compare(Relation.EQUAL, base, base)
        numbers = b.bit_and(number, b.compare(Relation.EQUAL, power, power))
        bad = b.bit_and(numbers, b.compare(Relation.NOT_EQUAL, result, result))
        result = self._checked(result, invalid=bad, pole=pole, at_pole=math.inf)
        # A NaN comes through as it is, where the result is one.
        is_nan = b.compare(Relation.NOT_EQUAL, result, result)
        nan_in = b.bit_and(is_nan, b.compare(Relation.NOT_EQUAL, base, base))
        result = self._as_bits(nan_in, base, result)
        nan_in = b.bit_and(b.bit_and(is_nan, number), b.compare(Relation.NOT_EQUAL, power, power))
        return self._as_bits(nan_in, power, result)

    def _checked(
        self,
        result: Operand,
        *,
        invalid: Operand,
        pole: Operand | None = None,
        at_pole: float = 0.0,
    ) -> Operand:
        """Return the result, unless the function is not defined there."""
        of = self._of
        b = of.builder
        yes = b.constant(BOOL, True)
        if of.module.exceptions:
            if pole is not None:
                b.require(b.bit_xor(pole, yes), of.site(FaultKind.REAL_DIVIDE))
            b.require(b.bit_xor(invalid, yes), of.site(FaultKind.REAL_INVALID))
            return result
        if pole is not None:
            result = b.select(pole, b.constant(F64, at_pole), result)
        return self._not_a_number(invalid, result)

    def _not_a_number(self, condition: Operand, value: Operand) -> Operand:
        """Return the NaN of plain code if the condition holds, else the value."""
        b = self._of.builder
        kind = U32 if value.type is F32 else U64
        nan = b.reinterpret(self._nan(value.type), kind)
        return b.reinterpret(b.select(condition, nan, b.reinterpret(value, kind)), value.type)

    def _as_bits(self, condition: Operand, yes: Operand, no: Operand) -> Operand:
        """One of two reals of 64 bits, as bits: to LLVM one NaN is as good as another."""
        b = self._of.builder
        chosen = b.select(condition, b.reinterpret(yes, U64), b.reinterpret(no, U64))
        return b.reinterpret(chosen, F64)


_SINGLE, _DOUBLE = struct.pack("<f", math.nan), struct.pack("<d", math.nan)
