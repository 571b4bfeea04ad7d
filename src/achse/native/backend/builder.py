"""One function while it is written: its variables, memory, ways, calls and faults."""

import platform
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from achse.native.backend.faults import BUDGET, DEPTH, FAULT, PASS, RAISE, OwnFault
from achse.native.backend.instructions import Instructions, Relation
from achse.native.backend.stack_checks import (
    STACK,
    STACK_POINTER,
    UNCHECKED,
    FrameGuard,
    here,
    whose_stack,
    zero_return,
)
from achse.native.backend.types import (
    ADDRESS,
    BOOL,
    EMPTY_NOTE,
    I8,
    I64,
    U8,
    U64,
    CallTarget,
    FunctionSignature,
    InstructionError,
    MachineType,
    Operand,
)

if TYPE_CHECKING:
    from achse.native.backend.module import ModuleBuilder

Label = str
"""Place where a function can continue."""

HAS_INCREMENT = platform.machine().lower() in ("x86_64", "amd64")
"""True if the processor adds to memory in one instruction."""

_DEPTH_BEFORE = "%depth.before"

_WORD = 8
_LINE = 16
"""Bytes of the frame that a line of assembly takes at most: a value and what a call gives it in."""
_USUAL_LINE = 2
"""Bytes that it takes in long functions, as measured."""
_FIXED = 1024
"""Bytes for registers that are saved."""


class LocalVariable(Operand):
    """A local variable: the address of its stack slot."""

    __slots__ = ()


class FunctionBuilder(Instructions):
    """Writes one function. `parameters` are its operands; `function` is how others call it."""

    def __init__(
        self, module: "ModuleBuilder", function: CallTarget, names: Sequence[str], exported: bool
    ) -> None:
        super().__init__(module)
        self.function = function
        signature = function.signature
        names = names or [f"p{n}" for n in range(len(signature.parameters))]
        self.parameters = tuple(
            Operand(each, f"%{name}")
            for each, name in zip(signature.parameters, names, strict=True)
        )
        self._exported = exported
        self._slots: list[str] = []
        self._slot_bytes = 0
        self._cold: list[str] = []
        self._deep = False
        self._too_deep = int(OwnFault.TOO_DEEP)
        self._handler: Label | None = None
        self._fault_counter: tuple[Operand, int] | None = None
        self.place: Callable[[], int] | None = None
        """Gives what is written down when a call from here on leaves with a fault: see
        `MachineCode.caught`."""

    def clear(self) -> None:
        """Begin again with an empty body."""
        self._lines.clear()
        self._slots.clear()
        self._slot_bytes = 0
        self._cold.clear()
        self._ended = False
        self._deep = False
        self._handler = None

    @property
    def frame_estimate(self) -> int:
        """Bytes of the stack that a call takes, about."""
        return self._slot_bytes + _USUAL_LINE * len(self._lines)

    @property
    def frame_bound(self) -> int:
        """Bytes of the stack that a call takes at most, without what it calls."""
        return self._slot_bytes + _LINE * (len(self._lines) + len(self._cold)) + _FIXED

    @property
    def guard(self) -> FrameGuard | None:
        """Check of the frame before it exists; None if `descend` alone checks."""
        if not self._deep or self.frame_bound <= UNCHECKED:
            return None
        function = self.function
        return FrameGuard(function.symbol, function.signature, self.frame_bound, self._too_deep)

    @contextmanager
    def opening(self) -> Iterator[None]:
        """Put the instructions written within before all that were written already."""
        lines, ended = self._lines, self._ended
        self._lines, self._ended = [], False
        yield
        self._lines, self._ended = self._lines + lines, ended

    @contextmanager
    def draft(self) -> Iterator[None]:
        """Discard the instructions written within: they show the type of a result."""
        lines, slots, ended = len(self._lines), len(self._slots), self._ended
        cold, slot_bytes = len(self._cold), self._slot_bytes
        yield
        del self._lines[lines:], self._slots[slots:], self._cold[cold:]
        self._ended, self._slot_bytes = ended, slot_bytes

    # -- local variables ---------------------------------------------------------------------

    def variable(self, type: MachineType) -> LocalVariable:
        """Return a local variable, without a value until it is set."""
        return LocalVariable(type, self._slot(type.llvm, _WORD))

    def get(self, variable: LocalVariable) -> Operand:
        """Return the present value of a local variable."""
        type = variable.type
        return self.emit(type, f"load {type.llvm}, ptr {variable.text}")

    def set(self, variable: LocalVariable, value: Operand) -> None:
        """Give a local variable its value."""
        self._expect(value, variable.type)
        self._add(f"store {value.typed}, ptr {variable.text}")

    def buffer(self, size: int) -> Operand:
        """Return the address of `size` bytes that last as long as the call; what they hold is
        open."""
        return Operand(ADDRESS, self._slot(f"[{size} x i8], align 8", size))

    def _slot(self, what: str, size: int) -> str:
        self._count += 1
        self._slot_bytes += size + _WORD - 1 & -_WORD
        self._slots.append(f"  %s{self._count} = alloca {what}")
        return f"%s{self._count}"

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
        self,
        type: MachineType,
        base: Operand,
        offset: Operand | int = 0,
        *,
        aligned: bool = False,
        lasting: bool = False,
    ) -> Operand:
        """Return the value at `base` and `offset` bytes, low byte first; a byte other than 0 is
        true.

        `aligned` says that the address is a multiple of the size, `lasting` that nothing is written
        there while the machine code runs: what was loaded once need not be loaded again.
        """
        place = self.address(base, offset)
        if type is BOOL:
            return self.convert(self.load(U8, place), BOOL)
        end = "" if aligned else ", align 1"
        if lasting:
            end += f", !invariant.load {EMPTY_NOTE}"
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

    def increment(self, base: Operand, offset: int = 0) -> None:
        """Add 1 to the word of 64 bits at `base` and `offset` bytes.

        LLVM without passes makes four instructions of it, x86-64 has one.
        """
        if not HAS_INCREMENT:
            place = self.address(base, offset)
            self.store(self.add(self.load(I64, place), Operand(I64, "1")), place)
            return
        if offset and base.text.startswith("@"):  # an address that the linker knows
            where = f"getelementptr (i8, ptr {base.text}, i64 {offset})"
        else:
            where = self.address(base, offset).text
        what = f'"incq $0", "=*m,~{{flags}}"(ptr elementtype(i64) {where})'
        self._add(f"call void asm sideeffect {what}")

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
        signature = FunctionSignature((ADDRESS, what.type, I64, BOOL))
        symbol = f"@llvm.{name}.{dots}"
        self.module.external(CallTarget(symbol, signature))
        self._add(f"call void {symbol}({to.typed}, {what.typed}, {size.typed}, i1 false)")

    # -- control -----------------------------------------------------------------------------

    @property
    def ended(self) -> bool:
        """True if no instruction reaches this place: after a jump, before the next `begin`."""
        return self._ended

    def begin(self, label: Label) -> None:
        """Begin a block at this label; the block before it continues there."""
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
        self._rise()
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

    def call(self, function: CallTarget, *arguments: Operand) -> tuple[Operand, ...]:
        """Call a function; its results. A fault in it leaves this function too."""
        target = function.symbol
        if function.pointer:
            target = self.emit(ADDRESS, f"load ptr, ptr {target}").text
        return self._call(target, function, arguments)

    def function_address(self, function: CallTarget) -> Operand:
        """Return the address of a function of the module, for a table of methods."""
        return Operand(ADDRESS, function.symbol)

    def call_at(
        self, address: Operand, like: CallTarget, *arguments: Operand
    ) -> tuple[Operand, ...]:
        """Call the function at an address, which has signature and faults of `like`."""
        self._expect(address, ADDRESS)
        return self._call(address.text, like, arguments)

    def _call(
        self, target: str, function: CallTarget, arguments: Sequence[Operand]
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
        with self.aside(bad):
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
        if self._fault_counter is not None:
            self.increment(*self._fault_counter)
        if self._handler is not None:
            self.jump(self._handler)
            return
        self._rise()
        self._end(zero_return(self.function.signature.llvm_result))

    def _pass_on(self) -> None:
        """Leave as well after a call that left with a fault."""
        if not self.function.faults:
            raise InstructionError(f"{self.function.symbol} calls what faults, so it faults too")
        bad, good = self.label(), self.label()
        fault = self.emit(I64, f"load i64, ptr {FAULT}")
        self.branch(self.compare(Relation.EQUAL, fault, Operand(I64, "0")), good, bad)
        with self.aside(bad):
            self.pass_on()
        self.begin(good)

    def pass_on(self) -> None:
        """Go on with the fault that there is: to the handler, or to the caller."""
        if self.place is not None:
            self._add(f"call void {PASS}(i64 {self.place()})")
        self._give_up()

    @property
    def handler(self) -> Label | None:
        """Label of the handler of faults; None: faults leave the function."""
        return self._handler

    @contextmanager
    def protected(self, handler: Label | None) -> Iterator[None]:
        """Faults within lead to the handler. There the fault is still to be read; see
        `MachineCode.caught`."""
        before, self._handler = self._handler, handler
        yield
        self._handler = before

    @contextmanager
    def counting_faults(self, base: Operand, offset: int) -> Iterator[None]:
        """Faults within add 1 to the word at `base` and `offset` bytes on their way out."""
        before, self._fault_counter = self._fault_counter, (base, offset)
        yield
        self._fault_counter = before

    @contextmanager
    def aside(self, label: Label) -> Iterator[None]:
        """Put the instructions written within, at a label, aside from the usual path."""
        lines, ended = self._lines, self._ended
        self._lines, self._ended = [f"{label}:"], False
        yield
        self._cold += self._lines
        self._lines, self._ended = lines, ended

    def spend(self, amount: int | Operand = 1, fault: int = OwnFault.BUDGET_SPENT) -> None:
        """Take from the budget that the host sets; a fault if it is not enough."""
        budget = self.emit(I64, f"load i64, ptr {BUDGET}")
        if isinstance(amount, int):
            amount = Operand(I64, str(amount))
        left = self.subtract(budget, amount)
        self._add(f"store {left.typed}, ptr {BUDGET}")
        enough = self.compare(Relation.GREATER_EQUAL, left, Operand(I64, "0"))
        self.require(enough, fault)

    def stack_pointer(self) -> Operand:
        """U64: the address of the lowest byte of the function's frame."""
        self.module.external(CallTarget(STACK_POINTER, FunctionSignature((), (ADDRESS,))))
        pointer = self.emit(ADDRESS, f"call ptr {STACK_POINTER}()")
        return self.emit(U64, f"ptrtoint {pointer.typed} to i64")

    def will_descend(self) -> None:
        """Say before the body is written that `descend` comes in its `opening`."""
        self._deep = True

    def descend(self, fault: int = OwnFault.TOO_DEEP) -> None:
        """Check the depth at the start of a recursive function: a fault instead of a crash.

        The fault comes with the stack pointer if the stack is full, else with 0.
        """
        self._deep, self._too_deep = True, int(fault)
        self._add(f"{_DEPTH_BEFORE} = load i64, ptr {DEPTH}")
        place = self.stack_pointer()
        limit = self.emit(U64, f"load i64, ptr {STACK}")
        self.require(self.compare(Relation.GREATER_EQUAL, place, limit), fault, place)
        left = self.subtract(Operand(I64, _DEPTH_BEFORE), Operand(I64, "1"))
        self._add(f"store {left.typed}, ptr {DEPTH}")
        enough = self.compare(Relation.GREATER_EQUAL, left, Operand(I64, "0"))
        self.require(enough, fault)

    def _rise(self) -> None:
        """Restore the depth before the call."""
        if self._deep:
            self._add(f"store i64 {_DEPTH_BEFORE}, ptr {DEPTH}")

    def named(self, name: str, value: Operand) -> Operand:
        """Return the same value under a name that was used before it was there: see `opening`."""
        same = "add {}, 0" if value.type.is_whole else "getelementptr i8, {}, i64 0"
        self._add(f"%{name} = {same.format(value.typed)}")
        return Operand(value.type, f"%{name}")

    # -- the text ----------------------------------------------------------------------------

    @property
    def descends(self) -> bool:
        """True if the function checks the stack."""
        return self._deep

    def text(self, *, checked: bool = False) -> str:
        """Return the function as LLVM assembly.

        `checked`: functions of the module check the stack; those that Python calls make sure that
        it is the right one.
        """
        result = self.function.signature.llvm_result
        end = [] if self._ended else ["  unreachable" if result != "void" else "  ret void"]
        body = [*self._lines, *end, *self._cold]
        start = [*here(), *whose_stack(result)] if checked and self._exported else []
        guard = self.guard
        symbol = self.function.symbol
        if guard is None:
            return self._defined(symbol, [*self._slots, *start, *body], exported=self._exported)
        call = guard.lines([each.typed for each in self.parameters])
        return "\n".join(
            [
                guard.data,
                self._defined(guard.body, [*self._slots, *body], exported=False),
                self._defined(symbol, [*(start or here()), *call], exported=self._exported),
            ]
        )

    def _defined(self, symbol: str, lines: Sequence[str], *, exported: bool) -> str:
        signature = self.function.signature
        parameters, linkage = [each.typed for each in self.parameters], "internal "
        if exported:
            linkage = "".join(each.extension for each in signature.results)
            parameters = [f"{e.type.llvm} {e.type.extension}{e.text}" for e in self.parameters]
        kind = "noinline nounwind" if self._deep else "nounwind"
        head = f"define {linkage}{signature.llvm_result} {symbol}({', '.join(parameters)}) {kind}"
        return "\n".join([head + " {", "begin:", *lines, "}"])
