"""Statements: loops with their budget, latches, calls and lifecycles in the order of effects."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from achse.iec.elementary import LINT
from achse.plc.lowering import nodes
from achse.plc.lowering.counters import (
    DecisionPoint,
    RoutineCounters,
    Tally,
    can_leave,
    is_straight,
)
from achse.plc.lowering.decisions import MOST_CONDITIONS, shape_of
from achse.plc.lowering.places import ADDRESS_TYPE
from achse.plc.lowering.project import LoweredProject
from achse.plc.lowering.values import ValueLowering
from achse.st.check.kinds import counted
from achse.st.typed.expressions import (
    Computed,
    Invocation,
    Known,
    Latched,
    Operator,
    Shortcut,
    Stored,
    TypedValue,
)
from achse.st.typed.project import Routine
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
    TypedStatement,
    TypedStatements,
)

JUMP_COST = 10
"""Budget that a jump costs: an exception of plain code, as long as some loop passes."""

TEXT_COST = 5
"""Budget that a text function or a conversion of a text costs, as long as some loop passes."""


class StatementLowering(ValueLowering):
    """Lowers the statements of one routine; with `counters` they count."""

    def __init__(
        self,
        project: LoweredProject,
        routine: Routine,
        in_memory: frozenset[str],
        counters: RoutineCounters | None = None,
    ) -> None:
        super().__init__(project, routine, in_memory)
        self.counters = counters
        self._begins = Tally()
        """Number of times that the present statement begins."""
        self._completes: Tally | None = None
        """Number of times that the statement or list before ended and went on to the next; None if
        that does not follow from other counters."""
        self._loops: list[_LoopExits] = []
        """Loops around the present statement."""
        self._decides_at: int | None = None
        """Offset of the statement or ELSIF whose decisions count; None if they do not."""
        self._conditions: dict[int, tuple[nodes.Temporary, int]] = {}
        """Conditions of decisions, by their identity: vector and bit."""

    def value(self, value: TypedValue) -> nodes.LoweredValue:
        """Return a value; decisions and their conditions count."""
        condition = self._conditions.get(id(value))
        if condition is not None:
            return nodes.ConditionBit(*condition, super().value(value))
        at, counters = self._decides_at, self.counters
        if at is None or counters is None or not isinstance(value, Computed | Shortcut):
            return super().value(value)
        decision = shape_of(value)
        if decision is None or decision[0].count > MOST_CONDITIONS:
            return super().value(value)
        shape, conditions = decision
        vector, first = self.temporary(LINT), counters.new(1 << shape.count)
        places = tuple(one.at for one in conditions)
        counters.decisions.append(DecisionPoint(at, shape, places, first))
        for bit, one in enumerate(conditions):
            self._conditions[id(one)] = vector, bit
        self._decides_at = None  # its operators are no decisions of their own
        lowered = super().value(value)
        self._decides_at = at
        return nodes.CountVector(vector, first, lowered)

    def block(
        self, statements: TypedStatements, entered: Tally | None = None
    ) -> nodes.LoweredStatements:
        """Return a list of statements, which takes from the budget for its text functions.

        `entered`: how often it begins, where that is known.
        """
        counters = self.counters
        if counters is not None and entered is not None and statements:
            counters.sums.append(entered)  # without what the budget ends at once, see below
            place = len(counters.sums)
            lowered, cost = self.priced(statements, Tally((-place,)))
            if not cost:
                return lowered
            faults = counters.new()
            counters.sums[place - 1] = entered - Tally((faults,))
            return (nodes.Spend(cost, statements[0].at, faults), *lowered)
        lowered, cost = self.priced(statements, entered)
        if cost:
            return (nodes.Spend(cost, statements[0].at), *lowered)
        return lowered

    def _counted(self, statements: TypedStatements) -> tuple[nodes.LoweredStatements, Tally]:
        """Return a list of statements that counts how often it begins, and how often that is."""
        if self.counters is None:
            return self.block(statements), Tally()
        number = self.counters.new()
        entered = Tally((number,))
        return (nodes.Count(number), *self.block(statements, entered)), entered

    def priced(
        self, statements: TypedStatements, entered: Tally | None = None, *, uncounted: int = 0
    ) -> tuple[nodes.LoweredStatements, int]:
        """Return a list of statements, and the budget that its text functions take.

        Those of lists inside take their own. With marks each statement takes for itself, since
        jumps may repeat it. The first `uncounted` statements do not count.
        """
        lowered: list[nodes.LoweredStatement] = []
        has_marks = any(isinstance(one, JumpMark) for one in statements)
        of_routine = self.counters
        with self._counting() as count:
            for place, one in enumerate(statements):
                number = None
                self.counters = counters = None if place < uncounted else of_routine
                if isinstance(one, JumpMark):
                    entered = None
                elif counters is not None:
                    if entered is None:
                        number = counters.new()
                        entered = Tally((number,))
                    self._begins = entered
                    counters.statement(one.at, entered)
                is_counted = self.project.conditions and place >= uncounted
                self._decides_at = one.at if is_counted else None
                self._completes = None
                each = [*_LOWERINGS[type(one)](self, one)]
                if has_marks and (cost := count()):
                    lowered.append(nodes.Spend(cost, one.at))
                    self.texts = 0
                if number is not None:
                    lowered.append(nodes.Count(number))
                lowered += each
                if counters is None or has_marks:
                    entered = None
                elif can_leave(tuple(each)):
                    completes = self._completes
                    entered = None if completes is None else counters.short(completes)
            self.counters, self._completes = of_routine, entered
            return tuple(lowered), count()

    @contextmanager
    def _counting(self) -> Iterator[Callable[[], int]]:
        """Meanwhile text functions count for what is inside alone; yields their budget so far."""
        outer, self.texts = self.texts, 0
        yield lambda: self.texts * TEXT_COST
        self.texts = outer

    def effects(self, value: TypedValue) -> tuple[nodes.LoweredValue, ...]:
        """Return a value evaluated for what it does."""
        if isinstance(value, Stored):
            return (self.store(value.storage, value.value, alone=True),)
        if isinstance(value, Invocation):
            return tuple(self.call_effects(value, alone=True)[0])
        return (self.value(value),)

    def do(self, statement: Do) -> Iterator[nodes.LoweredStatement]:
        """Return an assignment, a call; a latch is one only if its condition holds."""
        value, at = statement.value, statement.at
        if isinstance(value, Latched):
            condition = self.value(value.value)
            known = Known(value.sets, value.storage.type)
            store = nodes.Effects((self.store(value.storage, known, alone=True),), 0)
            yield nodes.Branches((nodes.LoweredBranch(condition, (store,), at),), (), at)
            return
        effects, faults = self.effects(value), None
        if self.counters is not None and not all(map(is_straight, effects)):
            faults = self.counters.new()
            self._completes = self._begins - Tally((faults,))
        yield nodes.Effects(effects, at, faults)

    def conditional(self, statement: Conditional) -> Iterator[nodes.LoweredStatement]:
        """IF."""
        counters, evaluated = self.counters, self._begins
        branches = []
        completes: list[Tally | None] = []
        waiting: int | None = None
        """Counter of the times that the conditions so far are FALSE, if it needs one."""
        for one in statement.branches:
            at, before = one.at or statement.at, waiting
            waiting = None
            if self.project.conditions and counters is not None:
                self._decides_at = at
            condition = self.value(one.condition)
            body, taken = self._counted(one.body)
            completes.append(self._completes)
            if counters is not None:
                if is_straight(condition):
                    evaluated -= taken
                else:
                    waiting = counters.new()
                    evaluated = Tally((waiting,))
                if not isinstance(one.condition, Known):
                    counters.branch(at, "TRUE", taken)
                    counters.branch(at, "FALSE", evaluated)
            if before is not None:
                condition = nodes.Sequence((nodes.Count(before),), condition)
            branches.append(nodes.LoweredBranch(condition, body, at))
        otherwise = self.block(statement.otherwise, evaluated)
        self._completes = _together([*completes, self._completes])
        if waiting is not None:
            otherwise = (nodes.Count(waiting), *otherwise)
        yield nodes.Branches(tuple(branches), otherwise, statement.at)

    def selection(self, statement: CaseSelection) -> Iterator[nodes.LoweredStatement]:
        """CASE: labels that the selector can be."""
        counters, rest = self.counters, self._begins
        selector = self.value(statement.selector)
        assert selector.type is not None
        whole = counted(selector.type)
        cases = []
        completes: list[Tally | None] = []
        for one in statement.choices:
            at = one.at or statement.at
            body, taken = self._counted(one.body)
            completes.append(self._completes)
            labels = tuple((max(low, whole.low), min(high, whole.high)) for low, high in one.labels)
            cases.append(nodes.LoweredCase(labels, body, at))
            if counters is not None:
                rest -= taken
                counters.branch(statement.at, _written(one.labels), taken)
        if counters is None or is_straight(selector):
            otherwise = self.block(statement.otherwise, rest)
        else:
            otherwise, rest = self._counted(statement.otherwise)
        self._completes = _together([*completes, self._completes])
        if counters is not None:
            counters.branch(statement.at, "ELSE", rest)
        yield nodes.LoweredSelection(selector, tuple(cases), otherwise, statement.at)

    def _loop_body(
        self, body: TypedStatements, begins: Tally
    ) -> tuple[nodes.LoweredStatements, int, "_LoopCounters | None"]:
        """Return the body of a loop that begins so often, its cost, and what is counted."""
        if self.counters is None:
            return (*self.priced(body), None)
        number, faults = self.counters.new(), self.counters.new()
        passes = Tally((number,))
        self._loops.append(exits := _LoopExits())
        lowered, cost = self.priced(body, passes)
        self._loops.pop()
        ends = None
        if self._completes is not None and exits.are_known:
            ends = begins - passes + self._completes + exits.continues - Tally((faults,))
        counted = _LoopCounters(passes, faults, ends, exits)
        return (nodes.Count(number), *lowered), cost, counted

    def _loop_ends(self, counted: "_LoopCounters", is_sure: bool) -> tuple[Tally, int | None]:
        """Return how often the condition of a loop ends it, and its counter if it needs one.

        `is_sure`: nothing between its passes leaves it.
        """
        assert self.counters is not None
        exits, ends, number = counted.exits, counted.ends, None
        if ends is None or not is_sure:
            number = self.counters.new()
            ends = Tally((number,))
        self._completes = ends + exits.exits if exits.are_known else None
        return self.counters.short(ends), number

    def counted_loop(self, statement: CountedLoop) -> Iterator[nodes.LoweredStatement]:
        """FOR."""
        start, begins = self.effects(statement.start), self._begins
        decides_at = self._decides_at
        with self._counting() as count:
            beyond = self.value(statement.beyond)
            assert beyond.type is not None
            before = nodes.Compute(Operator.NOT, (beyond,), beyond.type)
            body, cost, counted = self._loop_body(statement.body, begins)
            self._decides_at = decides_at
            advance = self.effects(statement.advance)
            cost += 1 + count()
        number = faults = None
        if self.counters is not None and counted is not None:
            faults = counted.faults
            is_sure = all(map(is_straight, (*start, before, *advance)))
            ends, number = self._loop_ends(counted, is_sure)
            self.counters.branch(statement.at, "PASS", counted.passes)
            self.counters.branch(statement.at, "END", ends)
        yield nodes.Loop(cost, start, before, body, advance, None, statement.at, number, faults)

    def condition_loop(self, statement: ConditionLoop) -> Iterator[nodes.LoweredStatement]:
        """WHILE, REPEAT."""
        begins = self._begins
        with self._counting() as count:
            condition = self.value(statement.condition)
            body, cost, counted = self._loop_body(statement.body, begins)
            cost += 1 + count()
        number = faults = None
        if self.counters is not None and counted is not None:
            faults, passes = counted.faults, counted.passes
            ends, number = self._loop_ends(counted, is_straight(condition))
            if not isinstance(statement.condition, Known):
                again = passes if statement.before else passes + Tally((faults,)) - begins
                self.counters.branch(statement.at, "PASS" if statement.before else "AGAIN", again)
                self.counters.branch(statement.at, "END", ends)
        before, after = (condition, None) if statement.before else (None, condition)
        yield nodes.Loop(cost, (), before, body, (), after, statement.at, number, faults)

    def goes_elsewhere(self, statement: TypedStatement) -> None:
        """Note how often EXIT and CONTINUE are done; none of their kind goes on to the next."""
        if self._loops and isinstance(statement, LoopExit):
            self._loops[-1].exits += self._begins
        elif self._loops and isinstance(statement, LoopNext):
            self._loops[-1].continues += self._begins
        self._completes = Tally()

    def protected(self, statement: Protected) -> Iterator[nodes.LoweredStatement]:
        """__TRY. A statement that leaves it may fail in its FINALLY."""
        for loop in self._loops:
            loop.are_known = False
        code = None if statement.code is None else self.place(statement.code)
        body = self.block(statement.body, self._begins if self.counters else None)
        handler = self.block(statement.handler)
        final = self.block(statement.final)
        self._completes = None
        yield nodes.LoweredTry(body, code, handler, final, statement.at)

    def life(self, statement: LifeStep) -> Iterator[nodes.LoweredStatement]:
        """Return a step in the lifecycle of records."""
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
            counters, self.counters = self.counters, None  # of a declaration
            yield from self.block(statement.values)
            self.counters = counters
            yield from each(self.after_init(statement.of, pointer))
            return
        key = record.exit if statement.event is LifeEvent.EXIT else record.reinit
        if key:
            yield from each([self.life_call(key, statement.arguments, pointer)])


@dataclass(slots=True)
class _LoopExits:
    """Exits of the passes of a loop."""

    exits: Tally = field(default_factory=Tally)
    continues: Tally = field(default_factory=Tally)
    are_known: bool = True
    """True if both numbers are exact."""


class _LoopCounters(NamedTuple):
    """Counters of a loop."""

    passes: Tally
    faults: int
    """Counter of the times that the budget ends it."""
    ends: Tally | None
    """Number of ends by its condition, if nothing between passes leaves it."""
    exits: _LoopExits


def _together(tallies: list[Tally | None]) -> Tally | None:
    """Return the sum, if all are known."""
    total = Tally()
    for one in tallies:
        if one is None:
            return None
        total += one
    return total


def _written(labels: tuple[tuple[int, int], ...]) -> str:
    """Labels of a CASE as numbers."""
    return ", ".join(str(low) if low == high else f"{low}..{high}" for low, high in labels)


def _same(of: StatementLowering, statement: Any) -> Iterator[nodes.LoweredStatement]:
    """Return a statement that goes elsewhere."""
    of.goes_elsewhere(statement)
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
