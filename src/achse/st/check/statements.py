"""Statements: from the tree to the typed form. A fault costs the statement it is in."""

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from achse.iec.derived import resolved
from achse.iec.elementary import BOOL, DINT, USINT, BoolType, IntegerType
from achse.iec.enums import EnumType
from achse.iec.errors import IecError
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.st.check.conversions import converted
from achse.st.check.folding import cut, folded
from achse.st.check.kinds import counted
from achse.st.check.meanings import PropertyUse
from achse.st.check.operands import TypedOperand, known
from achse.st.declared.scopes import Failed
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import (
    Assign,
    Branch,
    Call,
    Case,
    Choice,
    Continue,
    Dereference,
    Exit,
    Expression,
    For,
    GlobalName,
    If,
    Index,
    Jump,
    Label,
    Let,
    Member,
    Name,
    Range,
    RepeatUntil,
    Return,
    Statement,
    Statements,
    Try,
    While,
)
from achse.st.typed.expressions import (
    Computed,
    Invocation,
    Known,
    Operator,
    Read,
    Stored,
    TypedValue,
)
from achse.st.typed.places import PointerBase
from achse.st.typed.statements import (
    CaseSelection,
    Conditional,
    ConditionLoop,
    CountedLoop,
    Do,
    JumpMark,
    JumpTo,
    LoopExit,
    LoopNext,
    Protected,
    RoutineExit,
    TypedBranch,
    TypedChoice,
    TypedStatement,
    TypedStatements,
)

if TYPE_CHECKING:
    from achse.st.check.body import RoutineBody


class StatementChecker:
    """Checks the statements of one routine."""

    def __init__(self, body: "RoutineBody") -> None:
        self._body = body
        self._loops = 0
        self._labels: list[set[str]] = []
        self._all_labels: set[str] = set()

    def routine(self, statements: Statements) -> TypedStatements:
        """Return the whole body of a routine."""
        self._all_labels = {label.name.lower() for label in _labels_within(statements)}
        return self.sequence(statements)

    def sequence(self, statements: Statements) -> TypedStatements:
        """Statements that follow each other."""
        typed_statements: list[TypedStatement] = []
        if self._all_labels:
            own = {item.name.lower() for item in statements if isinstance(item, Label)}
            self._labels.append(own)
        after = self._body.calls.after
        if after:
            self._none_after(statements[0].at if statements else 0)
        for statement in statements:
            try:
                typed = _CHECKS[statement.__class__](self, statement)
            except Unexpected as fault:
                self._body.fault(fault.at, fault.message, fault.code)
            except Failed:
                self._body.failed = True
            except IecError as error:
                self._body.fault(statement.at, str(error), Code.BAD_DECLARATION)
            else:
                if typed is not None:
                    typed_statements.append(typed)
                if after:
                    if isinstance(statement, Assign | Call):
                        typed_statements += after
                        after.clear()
                    self._none_after(statement.at)
        if self._all_labels:
            self._labels.pop()
        return tuple(typed_statements)

    def _none_after(self, at: int) -> None:
        """Refuse an assignment of an output to a property in the middle of something else."""
        if self._body.calls.after:
            self._body.calls.after.clear()
            self._body.fault(
                at,
                "a property takes an output (=>) of a call that stands alone",
                Code.PROPERTY_ACCESS,
            )

    # simple ----------------------------------------------------------------------------------

    def _assign(self, tree: Assign) -> TypedStatement:
        return Do(self._body.assignments.assign(tree).value, tree.at)

    def _implicit_init(self, tree: Call) -> list[TypedStatement]:
        """Return the statements of `fb.FB_init(…)` of a block that declares none; else nothing."""
        of = tree.of
        if not isinstance(of, Member) or of.name.lower() != "fb_init":
            return []
        body = self._body
        block = body.expressions.meaning(of.of)
        if not isinstance(block, TypedOperand):
            return []  # of a program, whose FB_init is a method like others
        type = block.flat
        if not isinstance(type, StructType) or not body.life.is_block(type):
            return []
        if block.storage is None or body.life.init_method(type) is not None:
            return []
        return body.life.created_again(body, block.storage, type, tree.arguments, of.at)

    def _call(self, tree: Call) -> TypedStatement:
        if statements := self._implicit_init(tree):
            self._body.calls.after += statements[1:]
            return statements[0]
        value = self._body.calls.call(tree).value
        if isinstance(value, Read) and isinstance(value.storage.base, PointerBase):
            # The target of a returned REFERENCE is not read: the call is all there is to do.
            value = value.storage.base.address
        return Do(value, tree.of.at)

    def _bare(self, tree: Expression) -> TypedStatement | None:
        """Return a name alone: a call without parentheses, or nothing that does anything."""
        body = self._body
        meaning = body.expressions.meaning(tree)
        if isinstance(meaning, PropertyUse):
            return Do(body.calls.read_property(meaning).value, tree.at)
        if isinstance(meaning, TypedOperand) and not isinstance(meaning.value, Invocation):
            body.warn(
                tree.at, "this does nothing: it is neither an assignment nor a call", Code.NO_EFFECT
            )
            return None
        return Do(body.calls.statement(meaning, tree.at).value, tree.at)

    def _return(self, tree: Return) -> TypedStatement:
        return RoutineExit(tree.at)

    def _exit(self, tree: Exit) -> TypedStatement:
        if not self._loops:
            raise Unexpected(tree.at, "EXIT is not in a loop", Code.OUTSIDE_LOOP)
        return LoopExit(tree.at)

    def _continue(self, tree: Continue) -> TypedStatement:
        if not self._loops:
            raise Unexpected(tree.at, "CONTINUE is not in a loop", Code.OUTSIDE_LOOP)
        return LoopNext(tree.at)

    def _jump(self, tree: Jump) -> TypedStatement:
        key = tree.label.lower()
        if not any(key in labels for labels in self._labels):
            if key in self._all_labels:
                raise Unexpected(
                    tree.at, f"JMP cannot go into a block: {tree.label} is in one", Code.BAD_JUMP
                )
            raise Unexpected(tree.at, f"no label is named '{tree.label[:80]}' here", Code.BAD_JUMP)
        return JumpTo(key, tree.at)

    def _label(self, tree: Label) -> TypedStatement:
        return JumpMark(tree.name.lower(), tree.at)

    def _let(self, tree: Let) -> TypedStatement:
        body = self._body
        operand = body.expressions.operand(tree.value)
        if operand.loose:
            operand = body.widened(operand, tree.at)
        variable = body.frame.find(tree.name.lower())
        if variable is None:
            variable = body.frame.hidden(tree.name, operand.type)
        storage = body.frame.storage(variable, tree.at)
        value = body.converter.implicit(operand, variable.type, tree.at)
        return Do(Stored(storage, value, storage.type, tree.at), tree.at)

    # choices ---------------------------------------------------------------------------------

    def _condition(self, tree: Expression) -> TypedValue:
        """Return a BOOL; a fault in it is reported, and the check continues."""
        body = self._body
        try:
            return body.truth(body.expressions.operand(tree), tree.at)
        except Unexpected as fault:
            body.fault(fault.at, fault.message, fault.code)
        except Failed:
            body.failed = True
        return Known(False, BOOL, tree.at)

    def _if(self, tree: If) -> TypedStatement:
        branches = tuple(self._branch(branch) for branch in tree.branches)
        return Conditional(branches, self.sequence(tree.otherwise), tree.at)

    def _branch(self, tree: Branch) -> TypedBranch:
        return TypedBranch(self._condition(tree.condition), self.sequence(tree.body), tree.at)

    def _case(self, tree: Case) -> TypedStatement:
        body = self._body
        selector: TypedOperand | None = None
        try:
            selector = body.expressions.operand(tree.selector)
            if not isinstance(selector.flat, IntegerType | BoolType):
                name = selector.type.name
                raise Unexpected(
                    tree.selector.at,
                    f"CASE takes a whole number or enumeration, got a {name}",
                    Code.BAD_CASE,
                )
        except Unexpected as fault:
            body.fault(fault.at, fault.message, fault.code)
            selector = None
        except Failed:
            body.failed = True
        type = DINT if selector is None else selector.flat
        machine = USINT if isinstance(type, BoolType) else type
        taken: dict[tuple[int, int], int] = {}
        choices = tuple(self._choice(choice, selector, machine, taken) for choice in tree.choices)
        otherwise = self.sequence(tree.otherwise)
        if selector is None:
            return RoutineExit(tree.at)  # The fault is reported; nothing of this runs.
        value = converted(selector.value, machine, tree.at)
        return CaseSelection(value, choices, otherwise, tree.at)

    def _choice(
        self,
        tree: Choice,
        selector: TypedOperand | None,
        machine: IecType[Any],
        taken: dict[tuple[int, int], int],
    ) -> TypedChoice:
        body = self._body
        labels: list[tuple[int, int]] = []
        for label in tree.labels:
            try:
                if isinstance(label, Range):
                    low = self._case_value(label.low, selector, machine)
                    high = self._case_value(label.high, selector, machine)
                    if high < low:
                        raise Unexpected(
                            label.at, f"the range {low}..{high} runs backwards", Code.BAD_CASE
                        )
                else:
                    low = high = self._case_value(label, selector, machine)
                if (low, high) in taken:
                    body.warn(
                        label.at,
                        f"label {low} is there already: this one is never taken",
                        Code.DEAD_LABEL,
                    )
                taken[low, high] = label.at
                labels.append((low, high))
            except Unexpected as fault:
                body.fault(fault.at, fault.message, fault.code)
            except Failed:
                body.failed = True
        return TypedChoice(tuple(labels), self.sequence(tree.body), tree.at)

    def _case_value(
        self, tree: Expression, selector: TypedOperand | None, machine: IecType[Any]
    ) -> int:
        operand = self._body.expressions.operand(tree)
        value = operand.constant
        if not isinstance(value, int):
            raise Unexpected(tree.at, "a label of CASE is a constant whole number", Code.BAD_CASE)
        value = int(value)
        whole = counted(machine)
        if not whole.low <= value <= whole.high:
            if operand.is_bits:
                return cut(value, machine)
            name = "selector" if selector is None else selector.type.name
            self._body.warn(
                tree.at, f"{value} does not fit into a {name}: it is never taken", Code.DEAD_LABEL
            )
        enum = None if selector is None else resolved(selector.type)
        if isinstance(enum, EnumType) and operand.loose and value not in enum.numbers.values():
            self._body.warn(tree.at, f"{value} is not a value of {enum.name}", Code.DEAD_LABEL)
        return value

    # loops -----------------------------------------------------------------------------------

    def _inside_loop(self, statements: Statements) -> TypedStatements:
        self._loops += 1
        try:
            return self.sequence(statements)
        finally:
            self._loops -= 1

    def _while(self, tree: While) -> TypedStatement:
        condition = self._condition(tree.condition)
        return ConditionLoop(condition, self._inside_loop(tree.body), True, tree.at)

    def _repeat(self, tree: RepeatUntil) -> TypedStatement:
        inside = self._inside_loop(tree.body)
        until = self._condition(tree.condition)
        again = folded(Computed(Operator.NOT, (until,), BOOL, tree.at))
        return ConditionLoop(again, inside, False, tree.at)

    def _for(self, tree: For) -> TypedStatement:
        body = self._body
        try:
            start, beyond, advance = self._head(tree)
        except Unexpected as fault:
            body.fault(fault.at, fault.message, fault.code)
            return ConditionLoop(Known(False, BOOL), self._inside_loop(tree.body), True, tree.at)
        except Failed:
            body.failed = True
            return ConditionLoop(Known(False, BOOL), self._inside_loop(tree.body), True, tree.at)
        return CountedLoop(start, beyond, advance, self._inside_loop(tree.body), tree.at)

    def _head(self, tree: For) -> tuple[Stored, TypedValue, Stored]:
        body = self._body
        at = tree.at
        counter = body.expressions.operand(tree.variable)
        storage = counter.storage
        type = counter.flat
        if storage is None or not isinstance(type, IntegerType):
            raise Unexpected(
                tree.variable.at,
                f"FOR counts a whole number, got {counter.type.name}",
                Code.BAD_FOR,
            )
        body.check_writable(counter, tree.variable.at)
        first = body.expressions.operand(tree.first)
        start = Stored(
            storage, body.converter.implicit(first, counter.type, tree.first.at), type, at
        )
        last = body.expressions.operand(tree.last)
        if not isinstance(last.flat, IntegerType):
            raise Unexpected(
                tree.last.at, f"FOR ends at a whole number, got a {last.type.name}", Code.BAD_FOR
            )
        if not last.is_constant and last.type.size > type.size:
            message = f"FOR ends at a {last.type.name}, wider than its counter {counter.type.name}"
            body.warn(tree.last.at, message, Code.NARROW_COUNTER)
        step = known(1, counter.type, at, loose=True)
        if tree.step is not None:
            step = body.expressions.operand(tree.step)
            if not isinstance(step.flat, IntegerType):
                raise Unexpected(
                    tree.step.at, f"FOR steps by a whole number, got {step.type.name}", Code.BAD_FOR
                )
        # The counter is read where it is, also if it leads through a pointer or an index.
        now = TypedOperand(Read(storage, type, at), counter.type, storage)
        beyond = self._beyond(now, last, step, at)
        total = body.operators.binary("+", now, step, at)
        advance = Stored(storage, converted(total.value, type, at), type, at)
        return start, beyond, advance

    def _beyond(
        self, counter: TypedOperand, last: TypedOperand, step: TypedOperand, at: int
    ) -> TypedValue:
        """Return a condition: the counter is beyond the end, in the direction of the step."""
        operators = self._body.operators
        if isinstance(step.constant, int):
            sign = Operator.LT if step.constant < 0 else Operator.GT
            return operators.compared(sign, counter, last, at).value
        down = operators.compared(Operator.LT, step, known(0, DINT, at, loose=True), at).value
        over = operators.compared(Operator.GT, counter, last, at).value
        assert isinstance(over, Computed)
        # The end is evaluated once, whichever way it goes.
        left, right = over.operands
        type = right.type
        assert type is not None
        frame = self._body.frame
        temporary = frame.storage(frame.temporary(type), at)
        stored = Stored(temporary, right, type, at)
        over = Computed(Operator.GT, (left, stored), BOOL, at)
        under = Computed(Operator.LT, (left, Read(temporary, type, at)), BOOL, at)
        return Computed(Operator.SEL, (down, over, under), BOOL, at)

    # exceptions ------------------------------------------------------------------------------

    def _try(self, tree: Try) -> TypedStatement:
        body = self._body
        code = None
        if tree.exception is not None:
            operand = body.expressions.operand(tree.exception)
            code = operand.storage
            if code is None or not isinstance(operand.flat, IntegerType):
                raise Unexpected(
                    tree.exception.at, "__CATCH takes a variable for the code", Code.BAD_CATCH
                )
        return Protected(
            self.sequence(tree.body),
            code,
            self.sequence(tree.handler),
            self.sequence(tree.final),
            bool(tree.handler) or tree.exception is not None,
            tree.at,
        )


def _labels_within(statements: Statements) -> Iterator[Label]:
    """Return all labels of a body at any depth."""
    for statement in statements:
        match statement:
            case Label():
                yield statement
            case If(branches, otherwise):
                for branch in branches:
                    yield from _labels_within(branch.body)
                yield from _labels_within(otherwise)
            case Case(_, choices, otherwise):
                for choice in choices:
                    yield from _labels_within(choice.body)
                yield from _labels_within(otherwise)
            case For() | While() | RepeatUntil():
                yield from _labels_within(statement.body)
            case Try(inside, _, handler, final):
                for part in (inside, handler, final):
                    yield from _labels_within(part)


_CHECKS: dict[type[Statement], Callable[[StatementChecker, Any], TypedStatement | None]] = {
    Assign: StatementChecker._assign,
    Call: StatementChecker._call,
    Name: StatementChecker._bare,
    GlobalName: StatementChecker._bare,
    Member: StatementChecker._bare,
    Dereference: StatementChecker._bare,
    Index: StatementChecker._bare,
    If: StatementChecker._if,
    Case: StatementChecker._case,
    For: StatementChecker._for,
    While: StatementChecker._while,
    RepeatUntil: StatementChecker._repeat,
    Try: StatementChecker._try,
    Exit: StatementChecker._exit,
    Continue: StatementChecker._continue,
    Return: StatementChecker._return,
    Jump: StatementChecker._jump,
    Label: StatementChecker._label,
    Let: StatementChecker._let,
}
