"""Statements: loops with their budget, latches, calls and lifecycles in the order of effects."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from achse.plc.lowering import nodes
from achse.plc.lowering.places import ADDRESS_TYPE
from achse.plc.lowering.values import ValueLowering
from achse.st.check.kinds import counted
from achse.st.typed.expressions import Invocation, Known, Latched, Operator, Stored, TypedValue
from achse.st.typed.statements import (
    CaseSelection,
    Conditional,
    ConditionLoop,
    CountedLoop,
    Do,
    JumpMark,
    JumpTo,
    LifeEvent,
    LifeStep,
    LoopExit,
    LoopNext,
    Protected,
    RoutineExit,
    TypedStatements,
)

__all__ = ["JUMP_COST", "TEXT_COST", "StatementLowering"]

JUMP_COST = 10
"""Budget that a jump costs: an exception of plain code, as long as some loop passes."""

TEXT_COST = 5
"""Budget that a text function or a conversion of a text costs, as long as some loop passes."""


class StatementLowering(ValueLowering):
    """Lowers the statements of one routine."""

    def block(self, statements: TypedStatements) -> nodes.LoweredStatements:
        """A list of statements, which takes from the budget for its text functions."""
        lowered, cost = self.priced(statements)
        if cost:
            return (nodes.Spend(cost, statements[0].at), *lowered)
        return lowered

    def priced(self, statements: TypedStatements) -> tuple[nodes.LoweredStatements, int]:
        """A list of statements, and the budget that its text functions take.

        Those of lists inside take their own. With marks each statement takes for itself, since
        jumps may repeat it.
        """
        lowered: list[nodes.LoweredStatement] = []
        has_marks = any(isinstance(one, JumpMark) for one in statements)
        with self._counting() as count:
            for one in statements:
                each = [*_LOWERINGS[type(one)](self, one)]
                if has_marks and (cost := count()):
                    lowered.append(nodes.Spend(cost, one.at))
                    self.texts = 0
                lowered += each
            return tuple(lowered), count()

    @contextmanager
    def _counting(self) -> Iterator[Callable[[], int]]:
        """Meanwhile text functions count for what is inside alone; yields their budget so far."""
        outer, self.texts = self.texts, 0
        yield lambda: self.texts * TEXT_COST
        self.texts = outer

    def effects(self, value: TypedValue) -> tuple[nodes.LoweredValue, ...]:
        """A value evaluated for what it does."""
        if isinstance(value, Stored):
            return (self.store(value.storage, value.value, alone=True),)
        if isinstance(value, Invocation):
            return tuple(self.call_effects(value, alone=True)[0])
        return (self.value(value),)

    def do(self, statement: Do) -> Iterator[nodes.LoweredStatement]:
        """An assignment, a call; a latch is one only if its condition holds."""
        value, at = statement.value, statement.at
        if isinstance(value, Latched):
            condition = self.value(value.value)
            known = Known(value.sets, value.storage.type)
            store = nodes.Effects((self.store(value.storage, known, alone=True),), 0)
            yield nodes.Branches((nodes.LoweredBranch(condition, (store,), at),), (), at)
        else:
            yield nodes.Effects(self.effects(value), at)

    def conditional(self, statement: Conditional) -> Iterator[nodes.LoweredStatement]:
        """IF."""
        branches = tuple(
            nodes.LoweredBranch(
                self.value(one.condition), self.block(one.body), one.at or statement.at
            )
            for one in statement.branches
        )
        yield nodes.Branches(branches, self.block(statement.otherwise), statement.at)

    def selection(self, statement: CaseSelection) -> Iterator[nodes.LoweredStatement]:
        """CASE: labels that the selector can be."""
        selector = self.value(statement.selector)
        assert selector.type is not None
        whole = counted(selector.type)
        cases = tuple(
            nodes.LoweredCase(
                tuple((max(low, whole.low), min(high, whole.high)) for low, high in one.labels),
                self.block(one.body),
                one.at or statement.at,
            )
            for one in statement.choices
        )
        yield nodes.LoweredSelection(selector, cases, self.block(statement.otherwise), statement.at)

    def counted_loop(self, statement: CountedLoop) -> Iterator[nodes.LoweredStatement]:
        """FOR."""
        start = self.effects(statement.start)
        with self._counting() as count:
            beyond = self.value(statement.beyond)
            assert beyond.type is not None
            before = nodes.Compute(Operator.NOT, (beyond,), beyond.type)
            body, cost = self.priced(statement.body)
            advance = self.effects(statement.advance)
            cost += 1 + count()
        yield nodes.Loop(cost, start, before, body, advance, None, statement.at)

    def condition_loop(self, statement: ConditionLoop) -> Iterator[nodes.LoweredStatement]:
        """WHILE, REPEAT."""
        with self._counting() as count:
            condition = self.value(statement.condition)
            body, cost = self.priced(statement.body)
            cost += 1 + count()
        if statement.before:
            yield nodes.Loop(cost, (), condition, body, (), None, statement.at)
        else:
            yield nodes.Loop(cost, (), None, body, (), condition, statement.at)

    def protected(self, statement: Protected) -> Iterator[nodes.LoweredStatement]:
        """__TRY."""
        code = None if statement.code is None else self.place(statement.code)
        body, handler = self.block(statement.body), self.block(statement.handler)
        yield nodes.LoweredTry(body, code, handler, self.block(statement.final), statement.at)

    def life(self, statement: LifeStep) -> Iterator[nodes.LoweredStatement]:
        """A step in the lifecycle of records."""
        record = self.project.record(statement.of)
        if record is None:
            return
        pointer = self.temporary(ADDRESS_TYPE)
        address = self.address(statement.storage)

        def each(effects: list[nodes.LoweredValue]) -> Iterator[nodes.LoweredStatement]:
            if effects:
                count, stride = statement.count, statement.stride
                yield nodes.Lifecycle(pointer, address, count, stride, tuple(effects), statement.at)

        if statement.event is LifeEvent.CREATE:
            yield from each(self.begin(statement.of, statement.arguments, pointer))
            yield from self.block(statement.values)
            yield from each(self.after_init(statement.of, pointer))
            return
        key = record.exit if statement.event is LifeEvent.EXIT else record.reinit
        if key:
            yield from each([self.life_call(key, statement.arguments, pointer)])


def _same(_: StatementLowering, statement: Any) -> Iterator[nodes.LoweredStatement]:
    yield statement


_LOWERINGS: dict[
    type[Any], Callable[[StatementLowering, Any], Iterator[nodes.LoweredStatement]]
] = {
    Do: StatementLowering.do,
    Conditional: StatementLowering.conditional,
    CaseSelection: StatementLowering.selection,
    CountedLoop: StatementLowering.counted_loop,
    ConditionLoop: StatementLowering.condition_loop,
    Protected: StatementLowering.protected,
    LifeStep: StatementLowering.life,
    LoopExit: _same,
    LoopNext: _same,
    RoutineExit: _same,
    JumpTo: _same,
    JumpMark: _same,
}
