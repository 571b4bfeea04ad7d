"""Statements of the typed form as lines of Python.

Python takes only so many loops inside each other: what is deeper becomes a function of its own
before the body, which sees the variables of the routine and tells how it was left.
"""

from collections.abc import Callable, Sequence
from enum import IntEnum
from functools import partial
from typing import TYPE_CHECKING

from achse.plc.code.calls import outputs_of
from achse.plc.code.source import CodeExpression, SourceLine, SourceLines
from achse.plc.code.storages import local_name
from achse.st.typed.expressions import Invocation, Latched, Stored, TypedValue
from achse.st.typed.places import FrameBase, Storage, flat
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

if TYPE_CHECKING:
    from achse.plc.code.expressions import ExpressionWriter

__all__ = ["JUMP_COST", "StatementWriter"]

_DEEPEST = 12
"""Loops and __TRY inside each other in one Python function, which takes 20 at most: a statement
and its list may add some before the next statement is checked."""

JUMP_COST = 10
"""Budget that a jump costs: an exception of Python, as long as some loop passes."""

_WIDEST = 60
"""Levels of indentation in one Python function; Python takes 100."""

_MOST_BRANCHES = 30
"""Branches of one choice that are written with `elif`."""

_COMPOUND = (Conditional, CaseSelection, CountedLoop, ConditionLoop, Protected)


class _Leaves(IntEnum):
    """Return code of a part of a routine that is a function of its own."""

    RETURN = 1
    EXIT = 2
    CONTINUE = 3


class StatementWriter:
    """Writes the statements of one routine."""

    def __init__(self, expressions: "ExpressionWriter", lines: SourceLines) -> None:
        self._of = expressions
        self._lines = lines
        self._loops: list[tuple[str, TypedStatement, int]] = []
        """Meaning of EXIT and CONTINUE here: `plain` for Python's own, `raised` inside marks; and
        the function that contains the loop."""
        self._depth = 0
        self._function = 0
        """Nesting depth of own functions around the present statement."""
        self._leaves: set[_Leaves] = set()
        """Ways to leave the present own function."""
        self.pieces: list[SourceLine] = []
        """The lines of those functions."""

    def block(self, statements: TypedStatements) -> None:
        """A list of statements, one level in."""
        self._lines.indent()
        if any(isinstance(one, JumpMark) for one in statements):
            self._with_marks(statements)
        else:
            for one in statements:
                self.statement(one)
            if not statements:
                self._lines.add("pass")
        self._lines.dedent()

    def statement(self, statement: TypedStatement) -> None:
        """One statement."""
        lines = self._lines
        if statement.at:
            lines.place(statement.at)
        if isinstance(statement, _COMPOUND) and (self._depth >= _DEEPEST or lines.depth >= _WIDEST):
            self._piece(statement)
            return
        self._mark(statement)
        match statement:
            case Do(value):
                self.do(value)
            case Conditional(branches, otherwise):
                self._branches(
                    [
                        (
                            one.at or statement.at,
                            partial(self._of.condition, one.condition),
                            one.body,
                        )
                        for one in branches
                    ],
                    otherwise,
                )
            case CaseSelection():
                self._selection(statement)
            case CountedLoop():
                self._counted(statement)
            case ConditionLoop():
                self._conditional_loop(statement)
            case Protected():
                self._protected(statement)
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
            case LifeStep():
                self._life(statement)

    def _mark(self, statement: TypedStatement) -> None:
        """In a debug build: say that the statement is next."""
        probe = self._of.linker.probe
        if probe is not None and statement.at and not isinstance(statement, LifeStep):
            for line in probe.statement(self._of.routine, statement.at):
                self._lines.add(line)

    def do(self, value: TypedValue) -> None:
        """An expression for what it does."""
        of, lines = self._of, self._lines
        if isinstance(value, Stored):
            lines.add(of.storages.store_statement(value.storage, of.value(value.value)))
        elif isinstance(value, Invocation):
            for line in of.calls.statements(value):
                lines.add(line)
        elif isinstance(value, Latched):
            lines.add(f"if {of.condition(value.value)}:")
            lines.indent()
            state = CodeExpression("True" if value.sets else "False")
            lines.add(of.storages.store_statement(value.storage, state))
            lines.dedent()
        else:
            lines.add(of.value(value).text)

    def _piece(self, statement: TypedStatement) -> None:
        """A statement as a function of its own."""
        name, left = self._of.temporary(), self._of.temporary()
        outer = (self._lines, self._depth, self._leaves)
        self._lines, self._depth, self._leaves = SourceLines(), 0, set()
        self._function += 1
        lines = self._lines
        lines.place(statement.at)
        lines.indent()
        lines.add(f"def {name}():")
        lines.indent()
        routine = self._of.routine
        names = [
            local_name(field)
            for field in routine.frame.fields
            if field.name.lower() not in routine.addressed
        ]
        if names:
            lines.add(f"nonlocal {', '.join(names)}")
        self.statement(statement)
        self._function -= 1
        leaves = self._leaves
        self._lines, self._depth, self._leaves = outer
        self.pieces += lines.lines
        lines = self._lines
        lines.add(f"{left} = {name}()")
        for reason, act in (
            (_Leaves.RETURN, self.leave),
            (_Leaves.EXIT, lambda: self._leave("break", "LoopLeft")),
            (_Leaves.CONTINUE, lambda: self._leave("continue", "LoopGoesOn")),
        ):
            if reason in leaves:
                lines.add(f"if {left} == {reason.value}:")
                lines.indent()
                act()
                lines.dedent()

    def leave(self) -> None:
        """RETURN, with what the routine gives."""
        if self._function:
            self._give_back(_Leaves.RETURN)
            return
        self._lines.add(f"return {self.results()}".rstrip())

    def _give_back(self, reason: _Leaves) -> None:
        self._leaves.add(reason)
        self._lines.add(f"return {reason.value}")

    def results(self) -> str:
        """The result; with outputs a tuple of it and them."""
        routine = self._of.routine
        given = [] if routine.result is None else [routine.result]
        outputs = outputs_of(routine)
        texts = []
        for variable in (*given, *outputs):
            storage = Storage(FrameBase(), variable.offset, flat(variable.type))
            is_local = variable.name.lower() not in routine.addressed
            texts.append(local_name(variable) if is_local else self._of.storages.read(storage).text)
        if not outputs:
            return texts[0] if texts else ""
        return f"({', '.join(texts if given else ['None', *texts])})"

    # choices and loops -----------------------------------------------------------------------

    def _selection(self, statement: CaseSelection) -> None:
        lines, held = self._lines, self._of.temporary()
        lines.add(f"{held} = {self._of.exact_value(statement.selector).text}")
        branches = []
        for choice in statement.choices:
            tests = [
                f"{held} == {low}" if low == high else f"{low} <= {held} <= {high}"
                for low, high in choice.labels
            ]
            test = partial(str, " or ".join(tests))
            branches.append((choice.at or statement.at, test, choice.body))
        self._branches(branches, statement.otherwise)

    def _branches(
        self,
        branches: Sequence[tuple[int, Callable[[], str], TypedStatements]],
        otherwise: TypedStatements,
    ) -> None:
        """The first one whose test holds; each test is written at its own place.

        Each `elif` of Python is inside the one before, and a few hundred are too deep for it. Cases
        of a `match` stand side by side.
        """
        lines = self._lines
        if not branches:
            if otherwise:
                lines.add("if True:")
                self.block(otherwise)
            return
        is_long = len(branches) > _MOST_BRANCHES
        word, last = ("case _ if", "case _:") if is_long else ("if", "else:")
        if is_long:
            lines.add("match None:")
            lines.indent()
        for at, test, body in branches:
            lines.place(at)
            lines.add(f"{word} {test()}:")
            self.block(body)
            word = word if is_long else "elif"
        if otherwise:
            lines.add(last)
            self.block(otherwise)
        if is_long:
            lines.dedent()

    def _counted(self, statement: CountedLoop) -> None:
        self.do(statement.start)
        test = self._of.value(statement.beyond)
        self._loop(f"while not ({test.text}):", statement.body, statement)

    def _conditional_loop(self, statement: ConditionLoop) -> None:
        before = statement.before
        test = self._of.condition(statement.condition) if before else "True"
        self._loop(f"while {test}:", statement.body, statement)

    def _loop(self, head: str, body: TypedStatements, statement: TypedStatement) -> None:
        """A loop; with marks inside, EXIT and CONTINUE come as exceptions."""
        lines = self._lines
        self._depth += 1
        raised = _has_marks(body)
        if raised:
            self._depth += 1
            lines.add("try:")
            lines.indent()
        lines.add(head)
        lines.indent()
        lines.add("F[0] = fuel = F[0] - 1")
        lines.add("if fuel < 0: exhausted()")
        self._loops.append(("raised" if raised else "plain", statement, self._function))
        if raised:
            self._depth += 1
            lines.add("try:")
            self.block(body)
            lines.add("except LoopGoesOn:")
            lines.indent()
            lines.add("pass")
            lines.dedent()
            self._depth -= 1
        elif body:
            lines.dedent()
            self.block(body)
            lines.indent()
        self._loops.pop()
        self._advance(statement)
        lines.dedent()
        if raised:
            lines.dedent()
            lines.add("except LoopLeft:")
            lines.indent()
            lines.add("pass")
            lines.dedent()
            self._depth -= 1
        self._depth -= 1

    def _advance(self, statement: TypedStatement) -> None:
        """Write the step between a pass of a loop and the next."""
        self._mark(statement)
        if isinstance(statement, CountedLoop):
            self.do(statement.advance)
        elif isinstance(statement, ConditionLoop) and not statement.before:
            self._lines.add(f"if not ({self._of.value(statement.condition).text}): break")

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

    def _protected(self, statement: Protected) -> None:
        lines, of = self._lines, self._of
        self._depth += 2
        held = of.temporary()
        lines.add("try:")
        lines.indent()
        lines.add("try:")
        self.block(statement.body)
        lines.add(f"except CATCHABLE as {held}:")
        lines.indent()
        lines.add(f"caught({held})")
        if statement.code is not None:
            code = CodeExpression(f"code_of({held})", low=0, high=0xFFFF_FFFF)
            lines.add(of.storages.store_statement(statement.code, code))
        lines.dedent()
        self.block(statement.handler)
        lines.dedent()
        lines.add("finally:")
        self.block(statement.final)
        self._depth -= 2

    def _with_marks(self, statements: TypedStatements) -> None:
        """A list with marks: from the mark that was jumped to, on to the end."""
        lines = self._lines
        self._depth += 2
        where = self._of.temporary()
        marks: dict[str, int] = {}
        sections: list[list[TypedStatement]] = [[]]
        for one in statements:
            if isinstance(one, JumpMark):
                marks[one.label] = len(sections)
                sections.append([])
            else:
                sections[-1].append(one)
        lines.add(f"{where} = 0")
        lines.add("while True:")
        lines.indent()
        lines.add(f"F[0] = fuel = F[0] - {JUMP_COST}")
        lines.add("if fuel < 0: exhausted()")
        lines.add("try:")
        lines.indent()
        for number, section in enumerate(sections):
            lines.add(f"if {where} <= {number}:")
            self.block(tuple(section))
        lines.add("break")
        lines.dedent()
        lines.add("except Jump as jump:")
        lines.indent()
        lines.add(f"{where} = {marks!r}.get(jump.label, -1)")
        lines.add(f"if {where} < 0: raise")
        lines.dedent()
        lines.dedent()
        self._depth -= 2

    # life ------------------------------------------------------------------------------------

    def _life(self, statement: LifeStep) -> None:
        of, lines = self._of, self._lines
        record = of.linker.record(statement.of)
        if record is None:
            return
        address = of.storages.address(statement.storage).text
        held = of.temporary()
        if statement.event is LifeEvent.CREATE:
            life = of.calls.life_call(statement.of, statement.arguments)
            self._each(statement, held, address, life)
            if statement.values:
                lines.dedent()
                self.block(statement.values)
                lines.indent()
            self._after_init(statement, address)
            return
        key = record.exit if statement.event is LifeEvent.EXIT else record.reinit
        if not key:
            return
        routine = of.linker.routine(key)
        if isinstance(routine, str):
            lines.add(f"unavailable({routine!r})")
            return
        arguments = ", ".join([held, *of.calls.arguments(routine, statement.arguments)])
        lines.add(f"for {held} in {self._range(statement, address)}:")
        lines.indent()
        lines.add(f"{of.linker.name_of(key)}({arguments})")
        lines.dedent()

    def _range(self, statement: LifeStep, address: str) -> str:
        if statement.count == 1:
            return f"({address},)"
        return (
            f"range({address}, {address} + {statement.count * statement.stride},"
            f" {statement.stride})"
        )

    def _each(self, statement: LifeStep, held: str, address: str, life: str) -> None:
        if life == "None":
            return
        self._lines.add(f"for {held} in {self._range(statement, address)}:")
        self._lines.indent()
        self._lines.add(f"({life})({held})")
        self._lines.dedent()

    def _after_init(self, statement: LifeStep, address: str) -> None:
        record = self._of.linker.record(statement.of)
        if record is None or not record.after_init:
            return
        held = self._of.temporary()
        self._lines.add(f"for {held} in {self._range(statement, address)}:")
        self._lines.indent()
        for key in record.after_init:
            self._lines.add(f"{self._of.linker.name_of(key)}({held})")
        self._lines.dedent()


def _has_marks(statements: TypedStatements) -> bool:
    """Return True if there are marks in the statements, outside of loops inside them."""
    for one in statements:
        match one:
            case JumpMark():
                return True
            case Conditional(branches, otherwise):
                if _has_marks(otherwise) or any(_has_marks(each.body) for each in branches):
                    return True
            case CaseSelection():
                inner = (*(choice.body for choice in one.choices), one.otherwise)
                if any(_has_marks(each) for each in inner):
                    return True
            case Protected():
                if any(_has_marks(each) for each in (one.body, one.handler, one.final)):
                    return True
    return False
