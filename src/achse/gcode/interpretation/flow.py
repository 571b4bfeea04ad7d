"""Control flow of a program: jumps, cases, loops, subroutines, and the arithmetic of @ commands.

Source: tcnci, jumps, loops, subroutine techniques. Loops test at their top: while the condition
holds, the next block runs, else the block behind the loop; the program itself jumps back and
counts (`@620`).
"""

import operator
from collections.abc import Callable
from dataclasses import dataclass
from math import hypot, isfinite

from achse.codes import NcError
from achse.gcode.errors import WordRefused
from achse.gcode.state.registers import Registers
from achse.gcode.text.blocks import AtCall, AtOperand
from achse.gcode.text.formula import FUNCTIONS
from achse.gcode.text.program import PartProgram, SubroutineSource
from achse.gcode.text.words import AtForm

MAX_DEPTH = 20
"""Subroutines inside one another; the number is not printed."""

_RELATIONS: dict[str, Callable[[float, float], bool]] = {
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


@dataclass(slots=True)
class ProgramPlace:
    """A program that runs, and its next line, from 0."""

    program: PartProgram
    line: int = 0
    label: int = 0
    """Line at which its subroutine begins."""
    repeats: int = 1
    """Number of runs from here on, this run included."""


class LoopWatch:
    """Finds a loop that cannot end: a jump back with places and R parameters as they were before.

    What is compared is taken at the first, second, fourth, eighth … jump (Brent's method), so a
    loop of n jumps is found after at most 3 n of them.
    """

    def __init__(self) -> None:
        self.endless_jump: tuple[str, int, int] | None = None
        """Name of the program, the line that jumps back and the line it goes to, from 1."""
        self._reference: object = None
        self._power, self._jumps = 1, 0

    def forget(self) -> None:
        """Forget the earlier visits: positions of axes have come in from outside."""
        self._reference, self._power, self._jumps = None, 1, 0

    def back(self, flow: "Flow", line: int, target: int) -> None:
        """Count a jump from one line back to another, both from 0."""
        registers = flow.registers
        now = (
            [(id(each.program), each.line, each.repeats) for each in flow.places],
            (registers.own, registers.shared, registers.stack),
        )
        if now == self._reference:
            self.endless_jump = (flow.place.program.name, line + 1, target + 1)
        self._jumps += 1
        if self._jumps == self._power:
            own = [list(each) for each in now[1]]
            self._reference, self._power, self._jumps = (now[0], tuple(own)), 2 * self._power, 0


class Flow:
    """The running programs: the last of `places` is the one whose blocks run now."""

    def __init__(
        self,
        program: PartProgram,
        registers: Registers,
        subroutines: SubroutineSource | None,
    ) -> None:
        self.main = program
        self.places = [ProgramPlace(program)]
        self.registers = registers
        self.subroutines = subroutines
        self.watch: LoopWatch | None = None
        self.case: AtCall | None = None
        """A case command whose pairs may go on in the next line."""

    @property
    def place(self) -> ProgramPlace:
        """The program that runs now, and its next line."""
        return self.places[-1]

    def call(self, number: int, repeats: int) -> None:
        """Go to subroutine `number`: a label of this file wins over a file of its own."""
        if len(self.places) > MAX_DEPTH:
            raise WordRefused(
                NcError.SUBROUTINE_STACK_OVERFLOW, f"more than {MAX_DEPTH} subroutines are nested"
            )
        program = self.place.program
        for own in (program, self.main):
            label = own.labels.get(number)
            if label is not None:
                self.places.append(ProgramPlace(own, label + 1, label + 1, repeats))
                return
        subroutine = self.subroutines(number) if self.subroutines is not None else None
        if subroutine is None:
            raise WordRefused(
                NcError.SUBROUTINE_MISSING, f"there is neither a label L{number} nor L{number}.NC"
            )
        start = subroutine.begin(number)
        self.places.append(ProgramPlace(subroutine, start, start, repeats))

    def leave(self) -> bool:
        """M17: back to the caller, or once more from the label. False in the main program."""
        place = self.place
        if len(self.places) == 1:
            return False
        if place.repeats > 1:
            place.repeats -= 1
            place.line = place.label
        else:
            self.places.pop()
        return True

    def jump(self, target: AtOperand, line: int) -> None:
        """Go to the block of a K operand, or the one that an R parameter holds; `line` jumps."""
        value = target.value if target.letter == "K" else self.value(target)
        direction = "-" if value < 0.0 or target.sign == "-" else "+"
        number = abs(value)
        target_line = None
        if number == int(number):
            target_line = self.place.program.find_block(int(number), line, direction)
        if target_line is None:
            where = "before" if direction == "-" else "behind"
            raise WordRefused(
                NcError.PROGRAM_SYNTAX_RUNNING,
                f"there is no block N{number:g} {where} this one",
                f"{target.letter}{target.sign}{abs(target.value):g}",
            )
        self.place.line = target_line
        if self.watch is not None and target_line <= line:
            self.watch.back(self, line, target_line)

    def value(self, operand: AtOperand) -> float:
        """K as it is, R its value, P the value of the parameter that R names."""
        number = operand.value
        if operand.letter == "K":
            return number
        if operand.letter == "P":
            number = self.registers.pointed(int(number))
        return self._finite(self.registers[int(number)], operand)

    def register(self, operand: AtOperand) -> int:
        """Return the number of the parameter that an R or P operand means."""
        if operand.letter == "K":
            raise self._operand(operand, "expected an R parameter")
        if operand.letter == "P":
            return self.registers.pointed(int(operand.value))
        number = int(operand.value)
        _ = self.registers[number]
        return number

    @staticmethod
    def _operand(operand: AtOperand, message: str) -> WordRefused:
        word = f"{operand.letter}{operand.sign}{abs(operand.value):g}"
        return WordRefused(NcError.PROGRAM_SYNTAX_RUNNING, message, word)

    def run(self, call: AtCall, line: int) -> None:
        """Carry out an @ command that is not a decoder stop; `line` is its line, from 0."""
        if call.row is None:
            if self.case is None:
                raise WordRefused(
                    NcError.PROGRAM_SYNTAX_RUNNING, "pairs of K belong behind @111", "K"
                )
            self._case(self.case.operands[0], call.operands, line, self.case)
            return
        row, operands = call.row, call.operands
        check_operands(call)
        if row.form in (AtForm.SAVE_LIST, AtForm.RESTORE_LIST):
            numbers = [self.register(each) for each in operands[1:]]
            self._move(numbers, row.form is AtForm.SAVE_LIST)
        elif row.form in (AtForm.SAVE_RANGE, AtForm.RESTORE_RANGE):
            first, last = self.register(operands[0]), self.register(operands[1])
            step = 1 if last >= first else -1
            self._move(list(range(first, last + step, step)), row.form is AtForm.SAVE_RANGE)
        elif row.form is AtForm.JUMP:
            self.jump(operands[0], line)
        elif row.form is AtForm.CASE:
            self._case(operands[0], operands[1:], line, call)
        elif row.form is AtForm.JUMP_IF:
            if _RELATIONS[row.relation](self._first(operands), self.value(operands[1])):
                self.jump(operands[2], line)
        elif row.form is AtForm.LOOP_IF:
            if not _RELATIONS[row.relation](self._first(operands), self.value(operands[1])):
                self.jump(operands[2], line)
        else:
            self._work_out(row.relation, operands)

    def _first(self, operands: tuple[AtOperand, ...]) -> float:
        return self._finite(self.registers[self.register(operands[0])], operands[0])

    @staticmethod
    def _finite(value: float, operand: AtOperand) -> float:
        """Return the value; raise `WordRefused` if a snapshot file or a formula gave NaN or
        infinity."""
        if isfinite(value):
            return value
        word = f"{operand.letter}{operand.value:g}"
        raise WordRefused(
            NcError.FLOATING_POINT_OPERATION, f"{word} holds {value:g}, not a number", word
        )

    def _move(self, numbers: list[int], save: bool) -> None:
        if save:
            self.registers.save(numbers)
        else:
            self.registers.restore(numbers)

    def _case(
        self, value: AtOperand, pairs: tuple[AtOperand, ...], line: int, call: AtCall
    ) -> None:
        self.case = call
        if len(pairs) % 2:
            raise self._operand(pairs[-1], "expected pairs of a value and a block")
        chosen = self._first((value,))
        for case, target in zip(pairs[::2], pairs[1::2], strict=True):
            if self.value(case) == chosen:
                self.case = None
                self.jump(target, line)
                return

    def _work_out(self, relation: str, operands: tuple[AtOperand, ...]) -> None:
        registers = self.registers
        target = self.register(operands[0])
        if relation == "clear":
            registers[target] = 0.0
        elif relation == "swap":
            other = self.register(operands[1])
            registers[target], registers[other] = registers[other], registers[target]
        elif relation == "+":
            registers[target] += 1.0
        elif relation == "-":
            registers[target] -= 1.0
        elif relation == "INT":
            registers[target] = float(int(self._first(operands)))
        elif relation == "hypot":
            registers[target] = hypot(self.value(operands[1]), self.value(operands[2]))
        else:
            value = self.value(operands[1])
            try:
                registers[target] = float(FUNCTIONS[relation](value))
            except (ValueError, OverflowError):
                raise WordRefused(
                    NcError.FLOATING_POINT_OPERATION, f"{relation} of {value:g} is not defined"
                ) from None


_OPERAND_COUNTS = {
    AtForm.SAVE_RANGE: 2,
    AtForm.RESTORE_RANGE: 2,
    AtForm.JUMP: 1,
    AtForm.JUMP_IF: 3,
    AtForm.LOOP_IF: 3,
    AtForm.ONE: 1,
    AtForm.TWO: 2,
    AtForm.THREE: 3,
    AtForm.STOP: 0,
}


def check_operands(call: AtCall) -> None:
    """Refuse an @ command that has not the operands of its row."""
    row, operands = call.row, call.operands
    assert row is not None
    count = len(operands)
    if row.form in (AtForm.SAVE_LIST, AtForm.RESTORE_LIST):
        good = count >= 1 and operands[0].letter == "K" and operands[0].value == count - 1
    elif row.form is AtForm.CASE:
        good = count >= 3 and count % 2 == 1
    else:
        good = count == _OPERAND_COUNTS[row.form]
    if not good:
        raise WordRefused(
            NcError.PROGRAM_SYNTAX_RUNNING,
            f"expected the operands: {row.form.value}",
            f"@{row.number}",
        )
