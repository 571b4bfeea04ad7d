"""Statements of the typed form as lines of Python.

Python takes only so many loops inside each other: what is deeper becomes a function of its own
before the body, which sees the variables of the routine and returns how it was left.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from enum import IntEnum
from functools import partial

from achse.plc.code.expressions import ExpressionWriter
from achse.plc.code.source import CodeExpression, SourceLine, SourceLines
from achse.plc.code.storages import local_name
from achse.plc.lowering import nodes
from achse.plc.lowering.statements import JUMP_COST
from achse.st.typed.statements import JumpMark, JumpTo, LoopExit, LoopNext, RoutineExit

_DEEPEST = 12
"""Loops and __TRY inside each other in one Python function, which takes 20 at most: a statement
and its list may add some before the next statement is checked."""

_WIDEST = 60
"""Levels of indentation in one Python function; Python takes 100."""

_MOST_BRANCHES = 30
"""Branches of one choice that are written with `elif`."""

_WITHOUT_STOP = (nodes.Lifecycle, nodes.Spend, nodes.Count)
"""Statements that the source does not have: a debugger does not stop there."""

_COMPOUND = (nodes.Branches, nodes.LoweredSelection, nodes.Loop, nodes.LoweredTry)


class _Leaves(IntEnum):
    """Return code of a part of a routine that is a function of its own."""

    RETURN = 1
    EXIT = 2
    CONTINUE = 3


class StatementWriter:
    """Writes the statements of one routine."""

    def __init__(
        self, routine: nodes.LoweredRoutine, expressions: ExpressionWriter, lines: SourceLines
    ) -> None:
        self._routine = routine
        self._of = expressions
        self._lines = lines
        self._base = lines.depth
        self._loops: list[tuple[str, nodes.Loop, int]] = []
        """Meaning of EXIT and CONTINUE here: `plain` for Python's own, `raised` if not; and
        the function that contains the loop."""
        self._depth = 0
        self._function = 0
        """Nesting depth of own functions around the present statement."""
        self._leaves: set[_Leaves] = set()
        """Ways to leave the present own function."""
        self.nested_lines: list[SourceLine] = []
        """The lines of those functions."""

    def block(self, head: str, statements: nodes.LoweredStatements) -> None:
        """Write a line, and a list of statements one level in."""
        with self._lines.within(head):
            self.list_of(statements)

    def list_of(self, statements: nodes.LoweredStatements) -> None:
        if any(isinstance(one, JumpMark) for one in statements):
            self._with_marks(statements)
            return
        for one in statements:
            self.statement(one)
        if not statements:
            self._lines.add("pass")

    def statement(self, statement: nodes.LoweredStatement) -> None:
        lines = self._lines
        if statement.at:
            lines.place(statement.at)
        if isinstance(statement, _COMPOUND) and (self._depth >= _DEEPEST or lines.depth >= _WIDEST):
            self._nested_function(statement)
            return
        self._mark(statement)
        match statement:
            case nodes.Effects(values, _, faults):
                with self._counting_faults(faults):
                    self.effects(values)
            case nodes.Branches(branches, otherwise):
                self._branches(
                    [
                        (one.at, partial(self._of.condition, one.condition), one.body)
                        for one in branches
                    ],
                    otherwise,
                )
            case nodes.LoweredSelection():
                self._selection(statement)
            case nodes.Loop():
                self._loop(statement)
            case nodes.Spend(cost, _, faults):
                self._spend(cost, faults)
            case nodes.Count(number):
                lines.add(_counting(number))
            case nodes.LoweredTry():
                self._try(statement)
            case LoopExit():
                self._leave("break", "LoopLeft")
            case LoopNext():
                self._leave("continue", "LoopGoesOn")
            case RoutineExit():
                self.leave()
            case JumpTo(label):
                lines.add(f"raise Jump({label!r})")
            case JumpMark():
                raise AssertionError("a mark is part of its list")
            case nodes.Lifecycle():
                self._lifecycle(statement)

    def _mark(self, statement: nodes.LoweredStatement) -> None:
        """Mark the statement as the next one in a debug build."""
        probe = self._of.linker.probe
        if probe is not None and statement.at and not isinstance(statement, _WITHOUT_STOP):
            for line in probe.statement(self._routine.routine, statement.at):
                self._lines.add(line)

    def effects(self, values: Sequence[nodes.LoweredValue]) -> None:
        """Evaluate values for their effects."""
        for value in values:
            self._lines.add(self._of.effect(value))

    @contextmanager
    def _counting_faults(self, number: int | None) -> Iterator[None]:
        """Lines whose exceptions count on their way out, which takes no time until then."""
        if number is None:
            yield
            return
        with self._lines.within("try:"):
            yield
        self._lines.add(f"except BaseException: {_counting(number)}; raise")

    def _spend(self, cost: int, faults: int | None = None) -> None:
        """Take from the budget; CYCLE_TIME_EXCEED if it is not enough."""
        count = "" if faults is None else f"{_counting(faults)}; "
        self._lines.add(f"F[0] = fuel = F[0] - {cost}")
        self._lines.add(f"if fuel < 0: {count}exhausted()")

    def _nested_function(self, statement: nodes.LoweredStatement) -> None:
        """Write a statement as a function of its own."""
        name, left = self._of.temporary(), self._of.temporary()
        outer = (self._lines, self._depth, self._leaves)
        lines = SourceLines(statement.at, self._base)
        self._lines, self._depth, self._leaves = lines, 0, set()
        self._function += 1
        places = (store.place for store in self._routine.start)
        names = [local_name(place.variable) for place in places if place.variable is not None]
        with lines.within(f"def {name}():"):
            if names:
                lines.add(f"nonlocal {', '.join(names)}")
            self.statement(statement)
        self._function -= 1
        self.nested_lines += lines.lines
        leaves = self._leaves
        self._lines, self._depth, self._leaves = outer
        self._lines.add(f"{left} = {name}()")
        for reason, act in (
            (_Leaves.RETURN, self.leave),
            (_Leaves.EXIT, lambda: self._leave("break", "LoopLeft")),
            (_Leaves.CONTINUE, lambda: self._leave("continue", "LoopGoesOn")),
        ):
            if reason in leaves:
                with self._lines.within(f"if {left} == {reason.value}:"):
                    act()

    def leave(self) -> None:
        """Write RETURN, with the routine's result."""
        if self._function:
            self._give_back(_Leaves.RETURN)
            return
        self._lines.add(f"return {self.results()}".rstrip())

    def _give_back(self, reason: _Leaves) -> None:
        self._leaves.add(reason)
        self._lines.add(f"return {reason.value}")

    def results(self) -> str:
        """Return the result; with outputs a tuple of it and them."""
        routine = self._routine.routine
        texts = [self._of.value(value).text for value in self._routine.results]
        if len(texts) == (routine.result is not None):
            return texts[0] if texts else ""
        return f"({', '.join(texts if routine.result is not None else ['None', *texts])})"

    # choices and loops -----------------------------------------------------------------------

    def _selection(self, statement: nodes.LoweredSelection) -> None:
        lines, selector = self._lines, self._of.temporary()
        lines.add(f"{selector} = {self._of.exact_value(statement.selector).text}")
        branches = []
        for choice in statement.cases:
            tests = [
                f"{selector} == {low}" if low == high else f"{low} <= {selector} <= {high}"
                for low, high in choice.labels
            ]
            test = partial(str, " or ".join(tests))
            branches.append((choice.at, test, choice.body))
        self._branches(branches, statement.otherwise)

    def _branches(
        self,
        branches: Sequence[tuple[int, Callable[[], str], nodes.LoweredStatements]],
        otherwise: nodes.LoweredStatements,
    ) -> None:
        """Write the branches; the first one whose test holds is run.

        Each test is written at its own place. Each `elif` of Python is inside the one before, and a
        few hundred are too deep for it; cases of a `match` are on one level.
        """
        lines = self._lines
        if not branches:
            self.list_of(otherwise)
        elif len(branches) > _MOST_BRANCHES:
            with lines.within("match None:"):
                for at, test, body in branches:
                    lines.place(at)
                    self.block(f"case _ if {test()}:", body)
                if otherwise:
                    self.block("case _:", otherwise)
        else:
            word = "if"
            for at, test, body in branches:
                lines.place(at)
                self.block(f"{word} {test()}:", body)
                word = "elif"
            if otherwise:
                self.block("else:", otherwise)

    def _loop(self, statement: nodes.Loop) -> None:
        """Write a loop; with marks or CONTINUE in a __TRY, EXIT and CONTINUE are exceptions."""
        self.effects(statement.start)
        head = "True" if statement.before is None else self._of.condition(statement.before)
        lines, body = self._lines, statement.body
        raised = _has_marks(body) or _goes_on_in_try(body)
        self._depth += 1
        with self._passing("LoopLeft" if raised else ""):
            with lines.within(f"while {head}:"):
                self._spend(statement.cost, statement.faults)
                self._loops.append(("raised" if raised else "plain", statement, self._function))
                with self._passing("LoopGoesOn" if raised else ""):
                    self.list_of(body)
                self._loops.pop()
                self._advance(statement)
            if statement.ends is not None and statement.before is not None:
                with lines.within("else:"):
                    lines.add(_counting(statement.ends))
        self._depth -= 1

    @contextmanager
    def _passing(self, exception: str) -> Iterator[None]:
        """An exception, if it is named, ends what is within."""
        if not exception:
            yield
            return
        self._depth += 1
        with self._lines.within("try:"):
            yield
        self._lines.add(f"except {exception}: pass")
        self._depth -= 1

    def _advance(self, statement: nodes.Loop) -> None:
        """Write the step between a pass of a loop and the next."""
        self._mark(statement)
        self.effects(statement.advance)
        if statement.after is not None:
            ends = "" if statement.ends is None else f"{_counting(statement.ends)}; "
            self._lines.add(f"if not ({self._of.value(statement.after).text}): {ends}break")

    def _leave(self, word: str, exception: str) -> None:
        form, statement, function = self._loops[-1]
        if form == "raised":
            self._lines.add(f"raise {exception}")
            return
        if function != self._function:
            self._give_back(_Leaves.EXIT if word == "break" else _Leaves.CONTINUE)
            return
        if word == "continue":
            self._advance(statement)
        self._lines.add(word)

    # exceptions and jumps --------------------------------------------------------------------

    def _try(self, statement: nodes.LoweredTry) -> None:
        lines, of = self._lines, self._of
        self._depth += 2
        caught_error = of.temporary()
        with lines.within("try:"):
            self.block("try:", statement.body)
            with lines.within(f"except CATCHABLE as {caught_error}:"):
                lines.add(f"caught({caught_error})")
                if statement.code is not None:
                    code = CodeExpression(f"code_of({caught_error})", low=0, high=0xFFFF_FFFF)
                    lines.add(of.storages.store_statement(statement.code, code))
                self.list_of(statement.handler)
        self.block("finally:", statement.final)
        self._depth -= 2

    def _with_marks(self, statements: nodes.LoweredStatements) -> None:
        """Write a list with marks: from the mark that was jumped to, on to the end."""
        lines = self._lines
        self._depth += 2
        where = self._of.temporary()
        marks: dict[str, int] = {}
        sections: list[list[nodes.LoweredStatement]] = [[]]
        for one in statements:
            if isinstance(one, JumpMark):
                marks[one.label] = len(sections)
                sections.append([])
            else:
                sections[-1].append(one)
        lines.add(f"{where} = 0")
        with lines.within("while True:"):
            self._spend(JUMP_COST)
            with lines.within("try:"):
                for number, section in enumerate(sections):
                    self.block(f"if {where} <= {number}:", tuple(section))
                lines.add("break")
            with lines.within("except Jump as jump:"):
                lines.add(f"{where} = {marks!r}.get(jump.label, -1)")
                lines.add(f"if {where} < 0: raise")
        self._depth -= 2

    # lifecycle -------------------------------------------------------------------------------

    def _lifecycle(self, statement: nodes.Lifecycle) -> None:
        lines = self._lines
        address = self._of.value(statement.address).text
        pointer = self._of.keep(statement.pointer)
        if statement.count == 1:
            lines.add(f"{pointer} = {address}")
            self.effects(statement.effects)
            return
        end = f"{address} + {statement.count * statement.stride}"
        with lines.within(f"for {pointer} in range({address}, {end}, {statement.stride}):"):
            self.effects(statement.effects)


def _counting(number: int) -> str:
    """Return a counting line of code."""
    return f"COUNTS[{number}] += 1"


def _lists_in(statement: nodes.LoweredStatement) -> tuple[nodes.LoweredStatements, ...]:
    """Lists of statements inside a statement; none of a loop."""
    match statement:
        case nodes.Branches(branches, otherwise):
            return (*(each.body for each in branches), otherwise)
        case nodes.LoweredSelection():
            return (*(case.body for case in statement.cases), statement.otherwise)
        case nodes.LoweredTry():
            return (statement.body, statement.handler, statement.final)
    return ()


def _has_marks(statements: nodes.LoweredStatements) -> bool:
    """Return True if there are marks in the statements, outside of loops inside them."""
    return any(
        isinstance(one, JumpMark) or any(map(_has_marks, _lists_in(one))) for one in statements
    )


def _goes_on_in_try(statements: nodes.LoweredStatements, *, is_inside: bool = False) -> bool:
    """Return True if a CONTINUE of these statements is in a __TRY, whose FINALLY comes first."""
    return any(
        (is_inside and isinstance(one, LoopNext))
        or any(
            _goes_on_in_try(each, is_inside=is_inside or isinstance(one, nodes.LoweredTry))
            for each in _lists_in(one)
        )
        for one in statements
    )
