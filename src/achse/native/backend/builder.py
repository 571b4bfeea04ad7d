"""One function while it is written: typed instructions in, LLVM assembly out.

Operands of one instruction have one type; nothing is converted unasked. Whole numbers wrap around.
No instruction harms the process, whatever its operands: what a processor would trap or LLVM leave
undefined (a divisor of 0, a shift by more than the width, a float beyond the integers) has a result
that the instruction's description names. Only loads and stores trust the address that they get.
"""

import struct
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from enum import Enum
from typing import TYPE_CHECKING

from achse.native.backend.faults import BUDGET, DEPTH, FAULT, RAISE, OwnFault
from achse.native.backend.types import (
    ADDRESS,
    BOOL,
    F32,
    F64,
    I8,
    I64,
    U8,
    Function,
    InstructionError,
    MachineType,
    Operand,
    Signature,
)

if TYPE_CHECKING:
    from achse.native.backend.module import ModuleBuilder

__all__ = ["FunctionBuilder", "Label", "Relation", "Rounding", "Variable"]

Label = str
"""Where a function can go on."""


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


class Variable(Operand):
    """A local variable: the address of its stack slot."""

    __slots__ = ()


class FunctionBuilder:
    """Writes one function. `parameters` are its operands; `function` is how others call it."""

    def __init__(
        self, module: "ModuleBuilder", function: Function, names: Sequence[str], exported: bool
    ) -> None:
        self.module = module
        self.function = function
        signature = function.signature
        names = names or [f"p{n}" for n in range(len(signature.parameters))]
        self.parameters = tuple(
            Operand(each, f"%{name}")
            for each, name in zip(signature.parameters, names, strict=True)
        )
        self._exported = exported
        self._lines: list[str] = []
        self._slots: list[str] = []
        self._count = 0
        self._ended = False
        self._deep = False

    # -- single instructions -----------------------------------------------------------------

    def emit(self, type: MachineType, instruction: str) -> Operand:
        """Add an instruction of LLVM; its result."""
        self._count += 1
        register = f"%v{self._count}"
        self._add(f"{register} = {instruction}")
        return Operand(type, register)

    def _add(self, line: str) -> None:
        if self._ended:  # nothing comes here, but LLVM wants it whole
            self.begin(self.label())
        self._lines.append(f"  {line}")

    @contextmanager
    def draft(self) -> Iterator[None]:
        """What is written within is thrown away: to learn the type of what it would give."""
        lines, slots, ended = len(self._lines), len(self._slots), self._ended
        yield
        del self._lines[lines:], self._slots[slots:]
        self._ended = ended

    def constant(self, type: MachineType, number: float) -> Operand:
        """A number; InstructionError if the type cannot hold it."""
        if type.is_real:
            return Operand(type, _real(number, type))
        if type is BOOL and number in (False, True):
            return Operand(type, "true" if number else "false")
        if type.is_whole and isinstance(number, int) and type.least <= number <= type.most:
            return Operand(type, str(int(number)))
        raise InstructionError(f"{number!r} where a number of type {type} is expected")

    # -- local variables ---------------------------------------------------------------------

    def variable(self, type: MachineType) -> Variable:
        """A local variable, without a value until it is set."""
        return Variable(type, self._slot(type.llvm))

    def get(self, variable: Variable) -> Operand:
        """The present value of a local variable."""
        type = variable.type
        return self.emit(type, f"load {type.llvm}, ptr {variable.text}")

    def set(self, variable: Variable, value: Operand) -> None:
        """Give a local variable its value."""
        self._expect(value, variable.type)
        self._add(f"store {value.typed}, ptr {variable.text}")

    def buffer(self, size: int) -> Operand:
        """The address of `size` bytes that last as long as the call; what they hold is open."""
        return Operand(ADDRESS, self._slot(f"[{size} x i8], align 8"))

    def _slot(self, what: str) -> str:
        self._count += 1
        self._slots.append(f"  %s{self._count} = alloca {what}")
        return f"%s{self._count}"

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
        """What `divide` leaves over, with the sign of a; of floats as `fmod`; 0 if b is 0."""
        if self._alike(a, b).is_real:
            return self.math("fmod", a, b)
        operation = "srem" if a.type.signed else "urem"
        return self.emit(a.type, f"{operation} {a.typed}, {self._divisor(b).text}")

    def _divisor(self, b: Operand) -> Operand:
        """A divisor that no processor traps: 1 instead of 0, and of -1 that overflows."""
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
        """The size of a; that of the least whole number is itself."""
        if a.type.is_real:
            return self.intrinsic("fabs", a)
        if not a.type.signed:
            return a
        below = self.compare(Relation.LESS, a, self.constant(a.type, 0))
        return self.select(below, self.negate(a), a)

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
        """All bits of a inverted, also of a bool."""
        ones = self.constant(BOOL, True) if a.type is BOOL else Operand(a.type, "-1")
        return self._bitwise("xor", a, ones)

    def shift_left(self, a: Operand, count: Operand) -> Operand:
        """a shifted towards the high bits; 0 if the count is the width or more."""
        return self._shift("shl", a, count)

    def shift_right(self, a: Operand, count: Operand) -> Operand:
        """a shifted towards the low bits, filled with the sign; by the width or more: only that."""
        return self._shift("ashr" if a.type.signed else "lshr", a, count)

    def rotate_left(self, a: Operand, count: Operand) -> Operand:
        """The bits of a turned towards the high end, by count modulo the width."""
        return self._rotate("fshl", a, count)

    def rotate_right(self, a: Operand, count: Operand) -> Operand:
        """The bits of a turned towards the low end, by count modulo the width."""
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
        self.module.external(Function(symbol, Signature((type,) * 3, (type,))))
        return self.emit(type, f"call {machine} {symbol}({a.typed}, {a.typed}, {count.typed})")

    def _bitwise_only(self, a: Operand) -> None:
        if not a.type.is_whole:
            raise InstructionError(f"bits of {a.type}: a whole number expected")

    # -- comparisons and choices -------------------------------------------------------------

    def compare(self, relation: Relation, a: Operand, b: Operand) -> Operand:
        """Whether the relation holds, by the type's own order; with a NaN only NOT_EQUAL does."""
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
        """The value as another type.

        Whole numbers are cut to the low bits, or filled by the sign of their old type. A float
        loses its fraction and is held at the ends of the new type, NaN becomes 0; for a wrap
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

    def reinterpret(self, value: Operand, type: MachineType) -> Operand:
        """The same bits as another type of the same size."""
        if value.type.bits != type.bits or ADDRESS in (value.type, type):
            raise InstructionError(f"the bits of {value.type} are not those of {type}")
        if value.type.is_real == type.is_real:
            return self.convert(value, type)
        return self.emit(type, f"bitcast {value.typed} to {type.llvm}")

    def round(self, value: Operand, way: Rounding) -> Operand:
        """A float without fraction, as a float."""
        return self.intrinsic(way.value, value)

    # -- functions of floats -----------------------------------------------------------------

    def math(self, name: str, *operands: Operand) -> Operand:
        """A function of the C library, as `sin` or `pow`; F32 is computed as F64."""
        wide = [self.convert(each, F64) for each in operands]
        function = self.module.c_function(name, (F64,) * len(wide))
        (result,) = self.call(function, *wide)
        return self.convert(result, operands[0].type)

    def intrinsic(self, name: str, *operands: Operand) -> Operand:
        """A function of floats that LLVM knows: `sqrt`, `fabs`, `copysign` and roundings."""
        type = operands[0].type
        if not type.is_real:
            raise InstructionError(f"{name} of {type}: a float expected")
        return self._outside(f"@llvm.{name}.{_suffix(type)}", type, *operands)

    def _outside(self, symbol: str, result: MachineType, *operands: Operand) -> Operand:
        signature = Signature(tuple(each.type for each in operands), (result,))
        self.module.external(Function(symbol, signature), "readnone nounwind")
        arguments = ", ".join(each.typed for each in operands)
        return self.emit(result, f"call {result.llvm} {symbol}({arguments})")

    # -- memory ------------------------------------------------------------------------------

    def address(
        self, base: Operand, offset: Operand | int = 0, step: int = 1, *, within: int = 0
    ) -> Operand:
        """`base` and `offset` times `step` bytes, then `within` bytes more."""
        self._expect(base, ADDRESS)
        if isinstance(offset, Operand):
            index = self.convert(offset, I64)
            if step not in (1, 8):
                index = self.multiply(index, Operand(I64, str(step)))
            machine = "i64" if step == 8 else "i8"
            base = self.emit(ADDRESS, f"getelementptr {machine}, {base.typed}, {index.typed}")
            offset = 0
        offset = offset * step + within
        if not offset:
            return base
        return self.emit(ADDRESS, f"getelementptr i8, {base.typed}, i64 {offset}")

    def load(
        self, type: MachineType, base: Operand, offset: Operand | int = 0, *, aligned: bool = False
    ) -> Operand:
        """The value at `base` and `offset` bytes, low byte first; a byte other than 0 is true.

        `aligned` says that the address is a multiple of the size.
        """
        place = self.address(base, offset)
        if type is BOOL:
            return self.convert(self.load(U8, place), BOOL)
        end = "" if aligned else ", align 1"
        return self.emit(type, f"load {type.llvm}, {place.typed}{end}")

    def store(
        self, value: Operand, base: Operand, offset: Operand | int = 0, *, aligned: bool = False
    ) -> None:
        """Write the value at `base` and `offset` bytes, low byte first; a bool as a byte 0 or 1."""
        place = self.address(base, offset)
        if value.type is BOOL:
            value = self.convert(value, U8)
        end = "" if aligned else ", align 1"
        self._add(f"store {value.typed}, {place.typed}{end}")

    def copy(self, to: Operand, source: Operand, size: Operand | int) -> None:
        """Copy `size` bytes; the places may overlap."""
        self._move("memmove", "ptr", to, source, size)

    def fill(self, to: Operand, byte: Operand, size: Operand | int) -> None:
        """Write the same byte `size` times."""
        self._move("memset", "i8", to, self.convert(byte, I8), size)

    def _move(self, name: str, kind: str, to: Operand, what: Operand, size: Operand | int) -> None:
        self._expect(to, ADDRESS)
        size = Operand(I64, str(size)) if isinstance(size, int) else self.convert(size, I64)
        dots = "p0.p0.i64" if kind == "ptr" else "p0.i64"
        signature = Signature((ADDRESS, what.type, I64, BOOL))
        symbol = f"@llvm.{name}.{dots}"
        self.module.external(Function(symbol, signature))
        self._add(f"call void {symbol}({to.typed}, {what.typed}, {size.typed}, i1 false)")

    # -- control -----------------------------------------------------------------------------

    @property
    def ended(self) -> bool:
        """Whether nothing comes to the present place: after a jump, before the next `begin`."""
        return self._ended

    def label(self) -> Label:
        """A fresh label, for `begin` and for jumps to it before or after that."""
        self._count += 1
        return f"b{self._count}"

    def begin(self, label: Label) -> None:
        """What follows is at this label; what came before goes on here."""
        if not self._ended:
            self.jump(label)
        self._lines.append(f"{label}:")
        self._ended = False

    def jump(self, label: Label) -> None:
        """Go on at a label."""
        self._end(f"br label %{label}")

    def branch(self, condition: Operand, yes: Label, no: Label) -> None:
        """Go on at one label or the other."""
        self._expect(condition, BOOL)
        self._end(f"br {condition.typed}, label %{yes}, label %{no}")

    def switch(self, value: Operand, cases: Mapping[int, Label], otherwise: Label) -> None:
        """Go on at the label of the value, as a CASE does."""
        self._bitwise_only(value)
        ways = " ".join(
            f"{self.constant(value.type, number).typed}, label %{label}"
            for number, label in cases.items()
        )
        self._end(f"switch {value.typed}, label %{otherwise} [ {ways} ]")

    def return_(self, *results: Operand) -> None:
        """Leave the function with its results."""
        signature = self.function.signature
        if len(results) != len(signature.results):
            raise InstructionError(f"results {signature.results} expected, got {len(results)}")
        for value, type in zip(results, signature.results, strict=True):
            self._expect(value, type)
        if self._deep:
            self._count_depth(1)
        if len(results) < 2:
            self._end("ret " + (results[0].typed if results else "void"))
            return
        whole, text = signature.llvm_result, "undef"
        for n, value in enumerate(results):
            pair = f"insertvalue {whole} {text}, {value.typed}, {n}"
            text = self.emit(value.type, pair).text
        self._end(f"ret {whole} {text}")

    def _end(self, line: str) -> None:
        self._add(line)
        self._ended = True

    # -- calls -------------------------------------------------------------------------------

    def call(self, function: Function, *arguments: Operand) -> tuple[Operand, ...]:
        """Call a function; its results. A fault in it leaves this function too."""
        target = function.symbol
        if function.pointer:
            target = self.emit(ADDRESS, f"load ptr, ptr {target}").text
        return self._call(target, function, arguments)

    def function_address(self, function: Function) -> Operand:
        """Where a function of the module is, for a table of methods."""
        return Operand(ADDRESS, function.symbol)

    def call_at(self, address: Operand, like: Function, *arguments: Operand) -> tuple[Operand, ...]:
        """Call the function at an address, which has signature and faults of `like`."""
        self._expect(address, ADDRESS)
        return self._call(address.text, like, arguments)

    def _call(
        self, target: str, function: Function, arguments: Sequence[Operand]
    ) -> tuple[Operand, ...]:
        signature = function.signature
        if len(arguments) != len(signature.parameters):
            raise InstructionError(
                f"{function.symbol} takes {signature.parameters}, got {len(arguments)} arguments"
            )
        for value, type in zip(arguments, signature.parameters, strict=True):
            self._expect(value, type)
        texts = [each.typed for each in arguments]
        result = whole = signature.llvm_result
        if function.convention:
            texts = [f"{e.type.llvm} {e.type.extension}{e.text}" for e in arguments]
            result = "".join(each.extension for each in signature.results) + result
        text = f"call {result} {target}({', '.join(texts)})"
        results: tuple[Operand, ...] = ()
        if not signature.results:
            self._add(text)
        elif len(signature.results) == 1:
            results = (self.emit(signature.results[0], text),)
        else:
            all_of_it = self.emit(ADDRESS, text).text
            results = tuple(
                self.emit(type, f"extractvalue {whole} {all_of_it}, {n}")
                for n, type in enumerate(signature.results)
            )
        if function.faults:
            self._pass_on()
        return results

    # -- faults and budgets ------------------------------------------------------------------

    def require(
        self, condition: Operand, fault: int, first: Operand | None = None,
        second: Operand | None = None,
    ) -> None:  # fmt: skip
        """Leave with a fault, and two values that say more, unless the condition holds."""
        bad, good = self.label(), self.label()
        self.branch(condition, good, bad)
        self.begin(bad)
        self.leave(fault, first, second)
        self.begin(good)

    def leave(
        self, fault: int, first: Operand | None = None, second: Operand | None = None
    ) -> None:
        """Leave this function and all that called it with a fault."""
        if not self.function.faults:
            raise InstructionError(f"{self.function.symbol} is declared as one without faults")
        values = [
            "i64 0" if each is None else self.convert(each, I64).typed for each in (first, second)
        ]
        self._add(f"call void {RAISE}(i64 {int(fault)}, {', '.join(values)})")
        self._give_up()

    def _give_up(self) -> None:
        if self._deep:
            self._count_depth(1)
        result = self.function.signature.llvm_result
        self._end("ret void" if result == "void" else f"ret {result} zeroinitializer")

    def _pass_on(self) -> None:
        """After a call: leave as well if it left with a fault."""
        if not self.function.faults:
            raise InstructionError(f"{self.function.symbol} calls what faults, so it faults too")
        bad, good = self.label(), self.label()
        fault = self.emit(I64, f"load i64, ptr {FAULT}")
        self.branch(self.compare(Relation.EQUAL, fault, Operand(I64, "0")), good, bad)
        self.begin(bad)
        self._give_up()
        self.begin(good)

    def spend(self, amount: int = 1) -> None:
        """Take from the budget that the host sets; OwnFault.BUDGET_SPENT if it is not enough."""
        budget = self.emit(I64, f"load i64, ptr {BUDGET}")
        left = self.subtract(budget, Operand(I64, str(amount)))
        self._add(f"store {left.typed}, ptr {BUDGET}")
        enough = self.compare(Relation.GREATER_EQUAL, left, Operand(I64, "0"))
        self.require(enough, OwnFault.BUDGET_SPENT)

    def descend(self) -> None:
        """At the begin of a function that may call itself: OwnFault.TOO_DEEP instead of a crash."""
        self._deep = True
        left = self._count_depth(-1)
        enough = self.compare(Relation.GREATER_EQUAL, left, Operand(I64, "0"))
        self.require(enough, OwnFault.TOO_DEEP)

    def _count_depth(self, by: int) -> Operand:
        depth = self.emit(I64, f"load i64, ptr {DEPTH}")
        depth = self.add(depth, Operand(I64, str(by)))
        self._add(f"store {depth.typed}, ptr {DEPTH}")
        return depth

    # -- the text ----------------------------------------------------------------------------

    def text(self) -> str:
        """The function as LLVM assembly."""
        signature, result = self.function.signature, self.function.signature.llvm_result
        parameters = [each.typed for each in self.parameters]
        linkage = "internal "
        if self._exported:
            linkage = "".join(each.extension for each in signature.results)
            parameters = [f"{e.type.llvm} {e.type.extension}{e.text}" for e in self.parameters]
        head = f"define {linkage}{result} {self.function.symbol}({', '.join(parameters)}) nounwind"
        end = [] if self._ended else ["  unreachable" if signature.results else "  ret void"]
        return "\n".join([head + " {", "begin:", *self._slots, *self._lines, *end, "}"])

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
    """A number cut to the bits of a type."""
    low = number & (1 << type.bits) - 1
    return Operand(type, str(low if low <= type.most else low - (1 << type.bits)))
