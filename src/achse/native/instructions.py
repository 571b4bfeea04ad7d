"""Instructions of a kernel function: what is done with values, as LLVM assembly.

Operands are text: registers, numbers, addresses. Local names live in stack slots, which LLVM turns
into registers.
"""

import ast
import math
import struct
from collections.abc import Callable, Mapping, Sequence
from types import FunctionType
from typing import Any, Protocol

from achse.native.kinds import (
    BOOL,
    BYTE,
    INT,
    REAL,
    Kind,
    Record,
    Row,
    Scalar,
    Several,
    Value,
    joined,
    machine_types,
)

__all__ = ["OURS", "Instructions", "Signature", "TranslationError", "Unit", "real_constant"]

OURS = "achse_"
"""C functions get names of their own, so that LLVM does not know better what they give."""

_ARITHMETIC: dict[type[ast.operator], tuple[str, str]] = {
    ast.Add: ("add", "fadd"),
    ast.Sub: ("sub", "fsub"),
    ast.Mult: ("mul", "fmul"),
}

_BITWISE: dict[type[ast.operator], str] = {
    ast.BitAnd: "and",
    ast.BitOr: "or",
    ast.BitXor: "xor",
    ast.LShift: "shl",
    ast.RShift: "ashr",
}

_COMPARISONS: dict[type[ast.cmpop], tuple[str, str]] = {
    ast.Eq: ("eq", "oeq"),
    ast.NotEq: ("ne", "une"),
    ast.Lt: ("slt", "olt"),
    ast.LtE: ("sle", "ole"),
    ast.Gt: ("sgt", "ogt"),
    ast.GtE: ("sge", "oge"),
}


class TranslationError(Exception):
    """A function is outside the kernel's language; the text names file, line and what it is."""


class Signature(Protocol):
    """What a caller has to know of a function."""

    symbol: str
    names: Sequence[str]
    kinds: Sequence[Kind]
    defaults: Mapping[str, object]
    result: Kind


class Unit(Protocol):
    """The translation that a function is part of."""

    def signature(self, function: FunctionType) -> Signature: ...
    def table(self, numbers: tuple[Any, ...], kind: Scalar) -> str: ...
    def external(self, symbol: str, count: int) -> None: ...


class Instructions:
    """Writes the instructions of one function, `lines`, with stack slots `slots`."""

    def __init__(self, unit: Unit, function: FunctionType) -> None:
        self.unit = unit
        self.function = function
        self.lines: list[str] = []
        self.slots: list[str] = []
        self._count = 0

    def refusal(self, node: ast.AST, what: str) -> TranslationError:
        """Where the source leaves the kernel's language."""
        code = self.function.__code__
        line = getattr(node, "lineno", code.co_firstlineno)
        return TranslationError(f"{code.co_filename}:{line}: {code.co_name}: {what}")

    # -- single instructions

    def emit(self, instruction: str) -> str:
        """Add an instruction; the register of its result."""
        self._count += 1
        register = f"%v{self._count}"
        self.lines.append(f"  {register} = {instruction}")
        return register

    def block(self) -> str:
        """A fresh label."""
        self._count += 1
        return f"b{self._count}"

    def begin(self, label: str) -> None:
        self.lines.append(f"{label}:")

    def jump(self, label: str) -> None:
        self.lines.append(f"  br label %{label}")

    def slot(self, kind: Kind) -> Value:
        """Stack slots for a value of this kind: their addresses."""
        addresses = []
        for machine in machine_types(kind):
            self._count += 1
            self.slots.append(f"  %s{self._count} = alloca {machine}")
            addresses.append(f"%s{self._count}")
        return Value(kind, tuple(addresses))

    def load(self, slot: Value) -> Value:
        if slot.kind == BYTE:
            byte = self.emit(f"load i8, ptr {slot.operands[0]}")
            return Value(INT, (self.emit(f"zext i8 {byte} to i64"),))
        machines = machine_types(slot.kind)
        return Value(
            slot.kind,
            tuple(
                self.emit(f"load {machine}, ptr {address}")
                for machine, address in zip(machines, slot.operands, strict=True)
            ),
        )

    def store(self, value: Value, slot: Value) -> None:
        machines = machine_types(slot.kind)
        for machine, operand, address in zip(machines, value.operands, slot.operands, strict=True):
            self.lines.append(f"  store {machine} {operand}, ptr {address}")

    # -- kinds

    def convert(self, value: Value, kind: Kind, node: ast.AST) -> Value:
        """The same value as a wider kind."""
        if value.kind == kind:
            return value
        if isinstance(kind, Several) and isinstance(value.kind, Several):
            if len(kind.kinds) == len(value.kind.kinds):
                parts = zip(self.parts(value), kind.kinds, strict=True)
                return self.several([self.convert(part, wide, node) for part, wide in parts])
        elif isinstance(kind, Scalar) and joined(value.kind, kind) == kind:
            operand = value.operands[0]
            if kind is REAL:
                operation = "uitofp" if value.kind == BOOL else "sitofp"
            else:
                operation = "zext"
            source = machine_types(value.kind)[0]
            return Value(kind, (self.emit(f"{operation} {source} {operand} to {kind.machine}"),))
        raise self.refusal(node, f"{_describe(value.kind)} where {_describe(kind)} belongs")

    def truth(self, value: Value, node: ast.AST) -> str:
        """Whether a number is not 0, as i1."""
        if not isinstance(value.kind, Scalar):
            raise self.refusal(node, "only numbers are true or false")
        (operand,) = value.operands
        if value.kind == BOOL:
            return operand
        if value.kind == INT:
            return self.emit(f"icmp ne i64 {operand}, 0")
        return self.emit(f"fcmp une double {operand}, {real_constant(0.0)}")

    def parts(self, value: Value) -> list[Value]:
        """The members of a tuple."""
        assert isinstance(value.kind, Several)
        members, first = [], 0
        for kind in value.kind.kinds:
            size = len(machine_types(kind))
            members.append(Value(kind, value.operands[first : first + size]))
            first += size
        return members

    def several(self, members: Sequence[Value]) -> Value:
        kind = Several(tuple(member.kind for member in members))
        return Value(kind, tuple(part for member in members for part in member.operands))

    # -- arithmetic

    def combine(self, op: ast.operator, left: Value, right: Value, node: ast.AST) -> Value:
        """The result of an operator with two operands."""
        kind = joined(left.kind, right.kind)
        bits = _BITWISE.get(type(op))
        if kind is None or (bits and kind is REAL):
            raise self.refusal(node, f"no {type(op).__name__} of {_describe(left.kind)}")
        if kind is BOOL and (bits is None or isinstance(op, ast.LShift | ast.RShift)):
            kind = INT
        if isinstance(op, ast.Div):
            kind = REAL
        assert isinstance(kind, Scalar)
        (a,) = self.convert(left, kind, node).operands
        (b,) = self.convert(right, kind, node).operands
        if bits:
            return Value(kind, (self.emit(f"{bits} {kind.machine} {a}, {b}"),))
        if isinstance(op, ast.Div):
            return Value(REAL, (self.emit(f"fdiv double {a}, {b}"),))
        if type(op) in _ARITHMETIC:
            operation = _ARITHMETIC[type(op)][kind is REAL]
            return Value(kind, (self.emit(f"{operation} {kind.machine} {a}, {b}"),))
        if isinstance(op, ast.Pow) and kind is REAL:
            return Value(REAL, (self.library("pow", a, b),))
        if isinstance(op, ast.Mod | ast.FloorDiv):
            if kind is INT:
                return Value(INT, (self.whole_division(a, b, isinstance(op, ast.Mod)),))
            if isinstance(op, ast.Mod):
                return Value(REAL, (self.modulo(a, b),))
        raise self.refusal(node, f"no {type(op).__name__} of {_describe(kind)}")

    def whole_division(self, a: str, b: str, remainder: bool) -> str:
        """`//` and `%` of whole numbers, which round down; kernels divide by 0 nowhere."""
        if not b.isdecimal():  # the machine would trap
            zero = self.emit(f"icmp eq i64 {b}, 0")
            b = self.emit(f"select i1 {zero}, i64 1, i64 {b}")
        rest = self.emit(f"srem i64 {a}, {b}")
        mixed = self.emit(f"xor i64 {rest}, {b}")
        opposite = self.emit(f"icmp slt i64 {mixed}, 0")
        uneven = self.emit(f"icmp ne i64 {rest}, 0")
        adjust = self.emit(f"and i1 {opposite}, {uneven}")
        if remainder:
            more = self.emit(f"select i1 {adjust}, i64 {b}, i64 0")
            return self.emit(f"add i64 {rest}, {more}")
        quotient = self.emit(f"sdiv i64 {a}, {b}")
        less = self.emit(f"sext i1 {adjust} to i64")
        return self.emit(f"add i64 {quotient}, {less}")

    def modulo(self, a: str, b: str) -> str:
        """`%` of floats: the remainder has the sign of the divisor, also if it is 0."""
        zero = real_constant(0.0)
        rest = self.library("fmod", a, b)
        below = self.emit(f"fcmp olt double {rest}, {zero}")
        negative = self.emit(f"fcmp olt double {b}, {zero}")
        opposite = self.emit(f"xor i1 {below}, {negative}")
        lifted = self.emit(f"fadd double {rest}, {b}")
        adjusted = self.emit(f"select i1 {opposite}, double {lifted}, double {rest}")
        nothing = self.emit(f"fcmp oeq double {rest}, {zero}")
        signed = self.intrinsic("copysign", zero, b)
        return self.emit(f"select i1 {nothing}, double {signed}, double {adjusted}")

    def relation(self, op: ast.cmpop, left: Value, right: Value, node: ast.AST) -> str:
        if type(op) not in _COMPARISONS:
            raise self.refusal(node, f"no comparison {type(op).__name__}")
        kind = joined(joined(left.kind, right.kind) or INT, INT)
        assert isinstance(kind, Scalar)
        (a,) = self.convert(left, kind, node).operands
        (b,) = self.convert(right, kind, node).operands
        whole, real = _COMPARISONS[type(op)]
        if kind is REAL:
            return self.emit(f"fcmp {real} double {a}, {b}")
        return self.emit(f"icmp {whole} i64 {a}, {b}")

    def library(self, name: str, *operands: str) -> str:
        """A function of the C library."""
        return self._outside(f"@{OURS}{name}", *operands)

    def intrinsic(self, name: str, *operands: str) -> str:
        """A function of the machine."""
        return self._outside(f"@llvm.{name}.f64", *operands)

    def _outside(self, symbol: str, *operands: str) -> str:
        self.unit.external(symbol, len(operands))
        arguments = ", ".join(f"double {operand}" for operand in operands)
        return self.emit(f"call double {symbol}({arguments})")

    def whole(self, operand: str) -> str:
        """A float without fraction as a whole number; beyond 64 bits the nearest one."""
        return self.emit(f"call i64 @llvm.fptosi.sat.i64.f64(double {operand})")

    def classify(self, callee: Callable[..., Any], operand: str) -> str:
        if callee is math.isnan:
            return self.emit(f"fcmp uno double {operand}, {operand}")
        size = self.intrinsic("fabs", operand)
        condition = "one" if callee is math.isfinite else "oeq"
        return self.emit(f"fcmp {condition} double {size}, {real_constant(math.inf)}")


def real_constant(number: float) -> str:
    return f"0x{struct.unpack('>Q', struct.pack('>d', number))[0]:016X}"


def _describe(kind: Kind) -> str:
    if isinstance(kind, Scalar):
        return ("a bool", "a whole number", "a float")[kind.order]
    if isinstance(kind, Record):
        return f"a {kind.layout.name}"
    return "a sequence" if isinstance(kind, Row) else "a tuple"
