"""Instructions that compute: arithmetic, bits, comparisons, conversions, functions of floats.

Operands of one instruction have one type; nothing is converted unasked. Whole numbers wrap around.
No instruction harms the process, whatever its operands: what a processor would trap or LLVM leave
undefined (a divisor of 0, a shift by more than the width, a float beyond the integers) has a result
that the instruction's description names.
"""

import struct
from enum import Enum
from typing import TYPE_CHECKING

from achse.native.backend.types import (
    ADDRESS,
    BOOL,
    F32,
    F64,
    I64,
    CallTarget,
    FunctionSignature,
    InstructionError,
    MachineType,
    Operand,
)

if TYPE_CHECKING:
    from achse.native.backend.module import ModuleBuilder


class Relation(Enum):
    """Comparisons: LLVM's words for floats, for signed and for unsigned numbers."""

    EQUAL = "oeq", "eq", "eq"
    NOT_EQUAL = "une", "ne", "ne"
    LESS = "olt", "slt", "ult"
    LESS_EQUAL = "ole", "sle", "ule"
    GREATER = "ogt", "sgt", "ugt"
    GREATER_EQUAL = "oge", "sge", "uge"


class Rounding(Enum):
    """Ways to a float without fraction: LLVM's names."""

    DOWN = "floor"
    UP = "ceil"
    TO_ZERO = "trunc"
    HALF_TO_EVEN = "roundeven"
    HALF_AWAY = "round"


class Instructions:
    """Instructions one after the other, of a function of `module`."""

    def __init__(self, module: "ModuleBuilder") -> None:
        self.module = module
        self._lines: list[str] = []
        self._count = 0
        self._ended = False

    def emit(self, type: MachineType, instruction: str) -> Operand:
        """Add an instruction of LLVM; its result."""
        self._count += 1
        register = f"%v{self._count}"
        self._add(f"{register} = {instruction}")
        return Operand(type, register)

    def _add(self, line: str) -> None:
        if self._ended:  # nothing comes here, but LLVM wants it whole
            self._lines.append(f"{self.label()}:")
            self._ended = False
        self._lines.append(f"  {line}")

    def label(self) -> str:
        """Return a fresh label, for `begin` and for jumps to it before or after that."""
        self._count += 1
        return f"b{self._count}"

    def constant(self, type: MachineType, number: float) -> Operand:
        """Return a number; InstructionError if the type cannot hold it."""
        if type.is_real:
            return Operand(type, _real(number, type))
        if type is BOOL and number in (False, True):
            return Operand(type, "true" if number else "false")
        if type.is_whole and isinstance(number, int) and type.least <= number <= type.most:
            return Operand(type, str(int(number)))
        raise InstructionError(f"{number!r} where a number of type {type} is expected")

    # -- arithmetic --------------------------------------------------------------------------

    def add(self, a: Operand, b: Operand) -> Operand:
        """a + b"""
        return self._arithmetic("add", a, b)

    def subtract(self, a: Operand, b: Operand) -> Operand:
        """a - b"""
        return self._arithmetic("sub", a, b)

    def multiply(self, a: Operand, b: Operand) -> Operand:
        """a * b"""
        return self._arithmetic("mul", a, b)

    def divide(self, a: Operand, b: Operand) -> Operand:
        """a / b; of whole numbers the part before the point, a itself if b is 0."""
        if self._alike(a, b).is_real:
            return self.emit(a.type, f"fdiv {a.typed}, {b.text}")
        if not a.type.signed:
            return self.emit(a.type, f"udiv {a.typed}, {self._divisor(b).text}")
        quotient = self.emit(a.type, f"sdiv {a.typed}, {self._divisor(b).text}")
        if b.is_constant and b.text != "-1":
            return quotient
        minus_one = self.compare(Relation.EQUAL, b, self.constant(b.type, -1))
        return self.select(minus_one, self.negate(a), quotient)

    def remainder(self, a: Operand, b: Operand) -> Operand:
        """Return the remainder of `divide` with the sign of a; of floats as `fmod`; 0 if b is 0."""
        if self._alike(a, b).is_real:
            return self.math("fmod", a, b)
        operation = "srem" if a.type.signed else "urem"
        return self.emit(a.type, f"{operation} {a.typed}, {self._divisor(b).text}")

    def _divisor(self, b: Operand) -> Operand:
        """Return a divisor that no processor traps: 1 instead of 0, and of -1 that overflows."""
        if b.is_constant and b.text not in ("0", "-1"):
            return b
        one = self.constant(b.type, 1)
        bad = self.compare(Relation.EQUAL, b, self.constant(b.type, 0))
        if b.type.signed:
            minus = self.compare(Relation.EQUAL, b, self.constant(b.type, -1))
            bad = self.bit_or(bad, minus)
        return self.select(bad, one, b)

    def negate(self, a: Operand) -> Operand:
        """-a"""
        if a.type.is_real:
            return self.emit(a.type, f"fneg {a.typed}")
        return self.subtract(self.constant(a.type, 0), a)

    def absolute(self, a: Operand) -> Operand:
        """Return the size of a; that of the least whole number is itself."""
        if a.type.is_real:
            return self.intrinsic("fabs", a)
        if not a.type.signed:
            return a
        below = self.compare(Relation.LESS, a, self.constant(a.type, 0))
        return self.select(below, self.negate(a), a)

    def with_overflow(self, operation: str, a: Operand, b: Operand) -> tuple[Operand, Operand]:
        """`add`, `sub` or `mul` of whole numbers, and whether it went beyond the type."""
        self._bitwise_only(a)
        type = self._alike(a, b)
        symbol = f"@llvm.{'s' if type.signed else 'u'}{operation}.with.overflow.{type.llvm}"
        signature = FunctionSignature((type, type), (type, BOOL))
        self.module.external(CallTarget(symbol, signature))
        whole = signature.llvm_result
        both = self.emit(type, f"call {whole} {symbol}({a.typed}, {b.typed})").text
        result = self.emit(type, f"extractvalue {whole} {both}, 0")
        return result, self.emit(BOOL, f"extractvalue {whole} {both}, 1")

    def _arithmetic(self, operation: str, a: Operand, b: Operand) -> Operand:
        type = self._alike(a, b)
        if not type.is_real and not type.is_whole:
            raise InstructionError(f"{operation} of {type}: numbers expected")
        prefix = "f" if type.is_real else ""
        return self.emit(type, f"{prefix}{operation} {a.typed}, {b.text}")

    # -- bits --------------------------------------------------------------------------------

    def bit_and(self, a: Operand, b: Operand) -> Operand:
        """a & b, also of bools"""
        return self._bitwise("and", a, b)

    def bit_or(self, a: Operand, b: Operand) -> Operand:
        """a | b, also of bools"""
        return self._bitwise("or", a, b)

    def bit_xor(self, a: Operand, b: Operand) -> Operand:
        """a ^ b, also of bools"""
        return self._bitwise("xor", a, b)

    def bit_not(self, a: Operand) -> Operand:
        """Return all bits of a inverted, also of a bool."""
        ones = self.constant(BOOL, True) if a.type is BOOL else Operand(a.type, "-1")
        return self._bitwise("xor", a, ones)

    def shift_left(self, a: Operand, count: Operand) -> Operand:
        """a shifted towards the high bits; 0 if the count is the width or more."""
        return self._shift("shl", a, count)

    def shift_right(self, a: Operand, count: Operand) -> Operand:
        """a shifted towards the low bits, filled with the sign; by the width or more: only that."""
        return self._shift("ashr" if a.type.signed else "lshr", a, count)

    def rotate_left(self, a: Operand, count: Operand) -> Operand:
        """Return the bits of a turned towards the high end, by count modulo the width."""
        return self._rotate("fshl", a, count)

    def rotate_right(self, a: Operand, count: Operand) -> Operand:
        """Return the bits of a turned towards the low end, by count modulo the width."""
        return self._rotate("fshr", a, count)

    def _bitwise(self, operation: str, a: Operand, b: Operand) -> Operand:
        type = self._alike(a, b)
        if type is not BOOL and not type.is_whole:
            raise InstructionError(f"{operation} of {type}: whole numbers or bools expected")
        return self.emit(type, f"{operation} {a.typed}, {b.text}")

    def _shift(self, operation: str, a: Operand, count: Operand) -> Operand:
        self._bitwise_only(a)
        type, bits = self._alike(a, count), a.type.bits
        if count.is_constant and 0 <= int(count.text) < bits:
            return self._bitwise(operation, a, count)
        limit = Operand(type, str(bits - 1))
        beyond = self.emit(BOOL, f"icmp ugt {count.typed}, {limit.text}")
        shifted = self._bitwise(operation, a, self.select(beyond, limit, count))
        if operation == "ashr":
            return shifted
        return self.select(beyond, self.constant(type, 0), shifted)

    def _rotate(self, name: str, a: Operand, count: Operand) -> Operand:
        self._bitwise_only(a)
        type, machine = self._alike(a, count), a.type.llvm
        symbol = f"@llvm.{name}.{machine}"
        self.module.external(CallTarget(symbol, FunctionSignature((type,) * 3, (type,))))
        return self.emit(type, f"call {machine} {symbol}({a.typed}, {a.typed}, {count.typed})")

    def _bitwise_only(self, a: Operand) -> None:
        if not a.type.is_whole:
            raise InstructionError(f"bits of {a.type}: a whole number expected")

    # -- comparisons and choices -------------------------------------------------------------

    def compare(self, relation: Relation, a: Operand, b: Operand) -> Operand:
        """Return a bool that is true if the relation holds; with a NaN only NOT_EQUAL does."""
        type = self._alike(a, b)
        real, signed, unsigned = relation.value
        if type.is_real:
            return self.emit(BOOL, f"fcmp {real} {a.typed}, {b.text}")
        return self.emit(BOOL, f"icmp {signed if type.signed else unsigned} {a.typed}, {b.text}")

    def select(self, condition: Operand, a: Operand, b: Operand) -> Operand:
        """a if the condition holds, else b; both are there already."""
        self._expect(condition, BOOL)
        type = self._alike(a, b)
        return self.emit(type, f"select {condition.typed}, {a.typed}, {b.typed}")

    # -- conversions -------------------------------------------------------------------------

    def convert(self, value: Operand, type: MachineType) -> Operand:
        """Return the value as another type.

        Whole numbers are cut to the low bits, or filled by the sign of their old type. A float
        loses its fraction and is clamped to the range of the new type, NaN becomes 0; for a wrap
        around, convert it to I64 first. Anything but 0 is true. An address is a number of 64 bits.
        """
        old = value.type
        if old is type:
            return value
        if value.is_constant and old.is_whole and type.is_whole:
            return _known(int(value.text), type)
        if type is BOOL:
            zero = Operand(old, "null") if old is ADDRESS else self.constant(old, 0)
            return self.compare(Relation.NOT_EQUAL, value, zero)
        if ADDRESS in (old, type):
            if old.is_real or type.is_real:
                raise InstructionError(f"{old} to {type}: no address is a float")
            operation = "ptrtoint" if old is ADDRESS else "inttoptr"
            if operation == "inttoptr" and old.bits < 64:
                value = self.convert(value, I64)
        elif type.is_real:
            if old.is_real:
                operation = "fpext" if type is F64 else "fptrunc"
            else:
                operation = "sitofp" if old.signed else "uitofp"
        elif old.is_real:
            symbol = f"llvm.fpto{'si' if type.signed else 'ui'}.sat.{type.llvm}.{_suffix(old)}"
            return self._outside(f"@{symbol}", type, value)
        elif old.bits == type.bits:
            return Operand(type, value.text)
        else:
            operation = "trunc" if old.bits > type.bits else "sext" if old.signed else "zext"
        return self.emit(type, f"{operation} {value.typed} to {type.llvm}")

    def truncate(self, value: Operand, type: MachineType) -> Operand:
        """Return a float without its fraction as a whole number; if the type cannot hold it, some
        number.

        One instruction, where `convert` takes eight.
        """
        if not value.type.is_real or not type.is_whole:
            raise InstructionError(f"{value.type} to {type}: a float to a whole number expected")
        sign = "s" if type.signed else "u"
        number = self.emit(type, f"fpto{sign}i {value.typed} to {type.llvm}")
        return self.emit(type, f"freeze {number.typed}")

    def reinterpret(self, value: Operand, type: MachineType) -> Operand:
        """Return the same bits as another type of the same size."""
        if value.type.bits != type.bits or ADDRESS in (value.type, type):
            raise InstructionError(f"the bits of {value.type} are not those of {type}")
        if value.type.is_real == type.is_real:
            return self.convert(value, type)
        return self.emit(type, f"bitcast {value.typed} to {type.llvm}")

    def round(self, value: Operand, way: Rounding) -> Operand:
        """Return a float without fraction, as a float."""
        return self.intrinsic(way.value, value)

    # -- functions of floats -----------------------------------------------------------------

    def math(self, name: str, *operands: Operand) -> Operand:
        """Return a function of the C library, as `sin` or `pow`; F32 is computed as F64."""
        wide = [self.convert(each, F64) for each in operands]
        function = self.module.c_function(name, (F64,) * len(wide))
        arguments = ", ".join(each.typed for each in wide)
        result = self.emit(F64, f"call double {function.symbol}({arguments})")
        return self.convert(result, operands[0].type)

    def intrinsic(self, name: str, *operands: Operand) -> Operand:
        """Return a function of floats that LLVM knows: `sqrt`, `fabs`, `copysign` and roundings."""
        type = operands[0].type
        if not type.is_real:
            raise InstructionError(f"{name} of {type}: a float expected")
        return self._outside(f"@llvm.{name}.{_suffix(type)}", type, *operands)

    def _outside(self, symbol: str, result: MachineType, *operands: Operand) -> Operand:
        signature = FunctionSignature(tuple(each.type for each in operands), (result,))
        self.module.external(CallTarget(symbol, signature), "readnone nounwind")
        arguments = ", ".join(each.typed for each in operands)
        return self.emit(result, f"call {result.llvm} {symbol}({arguments})")

    # -- checks ------------------------------------------------------------------------------

    def _alike(self, a: Operand, b: Operand) -> MachineType:
        if a.type is not b.type:
            raise InstructionError(f"operands of one type expected, got {a.type} and {b.type}")
        return a.type

    def _expect(self, value: Operand, type: MachineType) -> None:
        if value.type is not type:
            raise InstructionError(f"{type} expected, got {value.type}")


def _real(number: float, type: MachineType) -> str:
    """Bit by bit; LLVM writes a float of 32 bits as the one of 64 bits that is equal."""
    if type is F32:
        number = struct.unpack("<f", struct.pack("<f", number))[0]
    return f"0x{struct.unpack('>Q', struct.pack('>d', number))[0]:016X}"


def _suffix(type: MachineType) -> str:
    return "f64" if type is F64 else "f32"


def _known(number: int, type: MachineType) -> Operand:
    """Return a number cut to the bits of a type."""
    low = number & (1 << type.bits) - 1
    return Operand(type, str(low if low <= type.most else low - (1 << type.bits)))
