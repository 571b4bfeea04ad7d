"""Statements of the typed form as lines of Python."""

from typing import TYPE_CHECKING

from achse.plc.code.calls import outputs_of
from achse.plc.code.source import CodeExpression, SourceLines
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

__all__ = ["StatementWriter", "TooDeepError"]

_DEEPEST = 18
"""Loops and __TRY inside each other, beyond which Python takes no more."""


class TooDeepError(Exception):
    """Statements inside each other deeper than Python takes."""


class StatementWriter:
    """Writes the statements of one routine."""

    def __init__(self, expressions: "ExpressionWriter", lines: SourceLines) -> None:
        self._of = expressions
        self._lines = lines
        self._loops: list[tuple[str, TypedStatement]] = []
        """What EXIT and CONTINUE mean here: `plain` for Python's own, `raised` inside marks."""
        self._depth = 0

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
        match statement:
            case Do(value):
                self.do(value)
            case Conditional(branches, otherwise):
                word = "if"
                for branch in branches:
                    lines.place(branch.at or statement.at)
                    lines.add(f"{word} {self._of.condition(branch.condition)}:")
                    self.block(branch.body)
                    word = "elif"
                if otherwise:
                    lines.add("else:")
                    self.block(otherwise)
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

    def leave(self) -> None:
        """RETURN, with what the routine gives."""
        self._lines.add(f"return {self.results()}".rstrip())

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
        word = "if"
        for choice in statement.choices:
            tests = [
                f"{held} == {low}" if low == high else f"{low} <= {held} <= {high}"
                for low, high in choice.labels
            ]
            lines.place(choice.at or statement.at)
            lines.add(f"{word} {' or '.join(tests)}:")
            self.block(choice.body)
            word = "elif"
        if statement.otherwise and word == "if":
            lines.add("if True:")
            self.block(statement.otherwise)
        elif statement.otherwise:
            lines.add("else:")
            self.block(statement.otherwise)

    def _deeper(self) -> None:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise TooDeepError

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
        self._deeper()
        raised = _has_marks(body)
        if raised:
            self._deeper()
            lines.add("try:")
            lines.indent()
        lines.add(head)
        lines.indent()
        lines.add("F[0] = fuel = F[0] - 1")
        lines.add("if fuel < 0: exhausted()")
        self._loops.append(("raised" if raised else "plain", statement))
        if raised:
            self._deeper()
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
        """What is between a pass of a loop and the next."""
        if isinstance(statement, CountedLoop):
            self.do(statement.advance)
        elif isinstance(statement, ConditionLoop) and not statement.before:
            self._lines.add(f"if not ({self._of.value(statement.condition).text}): break")

    def _leave(self, word: str, exception: str) -> None:
        form, statement = self._loops[-1]
        if form == "raised":
            self._lines.add(f"raise {exception}")
            return
        if word == "continue":
            self._advance(statement)
        self._lines.add(word)

    # exceptions and jumps --------------------------------------------------------------------

    def _protected(self, statement: Protected) -> None:
        lines, of = self._lines, self._of
        self._deeper()
        self._deeper()
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
        self._deeper()
        self._deeper()
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
        lines.add("F[0] = fuel = F[0] - 1")
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
    """Whether there are marks in the statements, outside of loops inside them."""
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
