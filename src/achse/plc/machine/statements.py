"""Statements of the typed form in machine code.

The place of a statement is written down as plain code has it, so that both name the same line in
the same fault; and both take from the budget at the same places.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from achse.native.backend import I64, U32, Label, Operand, Relation
from achse.plc.lowering import nodes
from achse.plc.lowering.statements import JUMP_COST
from achse.plc.machine.fault_places import FaultKind
from achse.plc.machine.values import NotTranslatedError
from achse.st.typed.expressions import Operator
from achse.st.typed.statements import JumpMark, JumpTo, LoopExit, LoopNext, RoutineExit

if TYPE_CHECKING:
    from achse.plc.machine.expressions import ExpressionTranslator

_WIDEST = 64
"""Labels of a CASE that one range may become."""


@dataclass(slots=True)
class _Loop:
    """Targets of EXIT and CONTINUE in a loop."""

    statement: nodes.Loop
    head: Label
    end: Label
    finals: int
    """Number of FINALLY parts around the loop."""


@dataclass(slots=True)
class _Marks:
    """A list with marks."""

    labels: dict[str, Label]
    finals: int
    at: int
    handler: Label | None


class StatementTranslator:
    """Translates the statements of one routine.

    `results` computes what the routine gives, `leave` returns with it.
    """

    def __init__(
        self,
        expressions: "ExpressionTranslator",
        results: Callable[[], list[Operand]],
        leave: Callable[[list[Operand]], None],
    ) -> None:
        self._of = expressions
        self._results = results
        self._leave = leave
        self._loops: list[_Loop] = []
        self._marks: list[_Marks] = []
        self._counted_ends: list[list[tuple[Label, int, Label]]] = []
        """Counted exits by loop, with their counter and their target."""
        self._finals: list[tuple[Label | None, nodes.LoweredStatements]] = []
        """FINALLY parts that are around the statement."""

    def block(self, statements: nodes.LoweredStatements) -> None:
        """Write a list of statements."""
        if any(isinstance(one, JumpMark) for one in statements):
            self._with_marks(statements)
            return
        for one in statements:
            self.statement(one)

    def statement(self, statement: nodes.LoweredStatement) -> None:
        of = self._of
        b = of.builder
        if statement.at:
            of.place(statement.at)
        match statement:
            case nodes.Effects(values, _, faults):
                with of.counting_faults(faults):
                    self._effects(values)
            case nodes.Branches():
                self._branches(statement)
            case nodes.LoweredSelection():
                self._selection(statement)
            case nodes.Loop():
                self._loop(statement)
            case nodes.Spend(cost, _, faults):
                with of.counting_faults(faults):
                    b.spend(cost, of.site(FaultKind.BUDGET))
            case nodes.Count(number):
                of.count(number)
            case nodes.LoweredTry():
                self._try(statement)
            case LoopExit():
                loop = self._loops[-1]
                self._through(loop.finals)
                b.jump(loop.end)
            case LoopNext():
                loop = self._loops[-1]
                self._through(loop.finals)
                self._advance(loop)
            case RoutineExit():
                results = self._results()
                self._through(0)
                self._leave(results)
            case JumpTo(label):
                self._jump(label)
            case JumpMark():
                raise AssertionError("a mark is part of its list")
            case nodes.Lifecycle():
                raise NotTranslatedError("instances are created in it")

    def _effects(self, values: Sequence[nodes.LoweredValue]) -> None:
        """Evaluate values for their effects."""
        for value in values:
            self._of.value(value)
        self._of.end_statement()

    def _branch(self, condition: nodes.LoweredValue, yes: Label, no: Label) -> None:
        of = self._of
        b = of.builder
        while isinstance(condition, nodes.Compute) and condition.operator is Operator.NOT:
            condition, yes, no = condition.operands[0], no, yes
        b.branch(of.number(condition), yes, no)
        of.end_statement()

    # choices ---------------------------------------------------------------------------------

    def _branches(self, statement: nodes.Branches) -> None:
        of = self._of
        b = of.builder
        end = b.label()
        for branch in statement.branches:
            of.place(branch.at)
            yes, no = b.label(), b.label()
            self._branch(branch.condition, yes, no)
            b.begin(yes)
            self.block(branch.body)
            b.jump(end)
            b.begin(no)
        self.block(statement.otherwise)
        b.begin(end)

    def _selection(self, statement: nodes.LoweredSelection) -> None:
        of = self._of
        b = of.builder
        selector = of.number(statement.selector)
        of.end_statement()
        end, otherwise = b.label(), b.label()
        bodies = [b.label() for _ in statement.cases]
        cases: dict[int, Label] = {}
        wide = False
        for choice, body in zip(statement.cases, bodies, strict=True):
            for first, last in choice.labels:
                wide = wide or last - first > _WIDEST
                if not wide:
                    for number in range(first, last + 1):
                        cases.setdefault(number, body)
        if wide:
            self._ranges(statement, selector, bodies, otherwise)
        else:
            b.switch(selector, cases, otherwise)
        for choice, body in zip(statement.cases, bodies, strict=True):
            of.place(choice.at)
            b.begin(body)
            self.block(choice.body)
            b.jump(end)
        b.begin(otherwise)
        self.block(statement.otherwise)
        b.begin(end)

    def _ranges(
        self,
        statement: nodes.LoweredSelection,
        selector: Operand,
        bodies: list[Label],
        otherwise: Label,
    ) -> None:
        """Write the branches, range by range."""
        b, type = self._of.builder, selector.type
        for choice, body in zip(statement.cases, bodies, strict=True):
            for first, last in choice.labels:
                if first > last:
                    continue
                above = b.compare(Relation.GREATER_EQUAL, selector, b.constant(type, first))
                below = b.compare(Relation.LESS_EQUAL, selector, b.constant(type, last))
                more = b.label()
                b.branch(b.bit_and(above, below), body, more)
                b.begin(more)
        b.jump(otherwise)

    # loops -----------------------------------------------------------------------------------

    def _loop(self, statement: nodes.Loop) -> None:
        of = self._of
        b = of.builder
        self._effects(statement.start)
        head, body, end = b.label(), b.label(), b.label()
        loop = _Loop(statement, head, end, len(self._finals))
        self._counted_ends.append([])
        b.begin(head)
        if statement.before is not None:
            self._branch(statement.before, body, self._ends(statement, end))
        b.begin(body)
        with of.counting_faults(statement.faults):
            b.spend(statement.cost, of.site(FaultKind.BUDGET))
        self._loops.append(loop)
        self.block(statement.body)
        self._loops.pop()
        self._advance(loop)
        for label, number, target in self._counted_ends.pop():
            b.begin(label)
            of.count(number)
            b.jump(target)
        b.begin(end)

    def _ends(self, statement: nodes.Loop, end: Label) -> Label:
        """Target of the condition of a loop that ends it: the counter of ends is on the way."""
        if statement.ends is None:
            return end
        label = self._of.builder.label()
        self._counted_ends[-1].append((label, statement.ends, end))
        return label

    def _advance(self, loop: _Loop) -> None:
        """Write the step between a pass of a loop and the next."""
        b, statement = self._of.builder, loop.statement
        if b.ended:
            return
        self._effects(statement.advance)
        if statement.after is not None:
            self._branch(statement.after, loop.head, self._ends(statement, loop.end))
        else:
            b.jump(loop.head)

    # jumps -----------------------------------------------------------------------------------

    def _with_marks(self, statements: nodes.LoweredStatements) -> None:
        """Write a list with marks; it charges the budget when it begins and with each jump."""
        of = self._of
        b = of.builder
        labels = {one.label: b.label() for one in statements if isinstance(one, JumpMark)}
        b.spend(JUMP_COST, of.site(FaultKind.BUDGET))
        self._marks.append(_Marks(labels, len(self._finals), of.at, b.handler))
        for one in statements:
            if isinstance(one, JumpMark):
                b.begin(labels[one.label])
            else:
                self.statement(one)
        self._marks.pop()

    def _jump(self, label: str) -> None:
        of = self._of
        b = of.builder
        for marks in reversed(self._marks):
            if label in marks.labels:
                self._through(marks.finals)
                at = of.at
                of.place(marks.at)
                with b.protected(marks.handler):
                    b.spend(JUMP_COST, of.site(FaultKind.BUDGET))
                b.jump(marks.labels[label])
                of.place(at)
                return
        raise NotTranslatedError(f"a jump to {label}, which is not there")

    # exceptions ------------------------------------------------------------------------------

    def _through(self, finals: int) -> None:
        """Write the FINALLY parts between here and the target, the innermost first."""
        b, around, at = self._of.builder, list(self._finals), self._of.at
        while len(self._finals) > finals:
            outer, part = self._finals.pop()
            with b.protected(outer):
                self.block(part)
        self._finals = around
        self._of.place(at)

    def _try(self, statement: nodes.LoweredTry) -> None:
        of = self._of
        b = of.builder
        caught, failed, end = b.label(), b.label(), b.label()
        frames = of.module.support.frames
        depth = b.variable(I64)
        b.set(depth, b.load(I64, frames))
        self._finals.append((b.handler, statement.final))
        with b.protected(caught):
            self.block(statement.body)
        b.jump(end)
        b.begin(caught)
        b.store(b.get(depth), frames)
        with b.protected(failed):
            (code,) = b.call(of.module.support.caught)
            if statement.code is not None:
                of.storages.put(statement.code, b.convert(code, U32))
                of.end_statement()
            self.block(statement.handler)
        self._finals.pop()
        b.jump(end)
        at = of.at
        b.begin(failed)
        b.store(b.get(depth), frames)
        b.call(of.module.support.push_exception)
        self.block(statement.final)
        b.call(of.module.support.reraise)
        b.begin(end)
        of.at = at
        self.block(statement.final)
