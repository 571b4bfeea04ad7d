"""Mutation operators: small faults in the typed form of a routine, one at a time.

A fault in text is one that the text shows: the operator, literal or statement at the place of the
node. Nodes that the checker made for itself (the end of a FOR, a check of bounds) are left alone.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum
from typing import Any, TypeAlias

from achse.iec.elementary import BOOL, BoolType, IntegerType, RealType
from achse.iec.times import TimeType
from achse.st.check.kinds import counted
from achse.st.syntax.nodes import changed, field_names
from achse.st.typed.expressions import (
    Computed,
    Known,
    Latched,
    Operator,
    Shortcut,
    TypedValue,
)
from achse.st.typed.nodes import is_node
from achse.st.typed.project import Routine
from achse.st.typed.statements import (
    CaseSelection,
    Conditional,
    ConditionLoop,
    CountedLoop,
    Do,
    JumpTo,
    LifeStep,
    LoopExit,
    LoopNext,
    Protected,
    RoutineExit,
    TypedStatements,
)
from achse.tcunit.mutation.edits import SourceEdits, TextEdit


class MutationOperator(Enum):
    """Kind of a planted fault."""

    RELATION = "relational operator"
    BOUNDARY = "boundary"
    ARITHMETIC = "arithmetic operator"
    LOGIC = "boolean operator"
    NEGATION = "negation"
    CONDITION = "condition"
    CONSTANT = "constant"
    STATEMENT = "statement"
    LEAVING = "RETURN, EXIT, CONTINUE"
    LABEL = "label of a CASE"


@dataclass(frozen=True, slots=True)
class Mutant:
    """A routine with one fault."""

    routine: Routine
    body: TypedStatements
    fault: MutationOperator
    at: int
    """Offset of what is changed, in the source of the routine."""
    statement: int
    """Offset of the innermost statement around it."""
    branch: int | None
    """Offset of the ELSIF that it is in the condition of; None elsewhere."""
    change: str
    """Change in words: `< becomes <=`."""
    edit: TextEdit | None = None
    """The same change in the text; None for drawings."""


@dataclass(slots=True)
class _Site:
    """A fault on its way up from its node to the body."""

    fault: MutationOperator
    at: int
    change: str
    edit: TextEdit | None = None
    statement: int | None = None
    branch: int | None = None


_Variants: TypeAlias = Iterator[tuple[Any, _Site]]
"""A node with a fault inside, again and again."""

_RELATIONS: dict[Operator, tuple[tuple[Operator, MutationOperator], ...]] = {
    Operator.LT: (
        (Operator.LE, MutationOperator.BOUNDARY),
        (Operator.GE, MutationOperator.RELATION),
    ),
    Operator.LE: (
        (Operator.LT, MutationOperator.BOUNDARY),
        (Operator.GT, MutationOperator.RELATION),
    ),
    Operator.GT: (
        (Operator.GE, MutationOperator.BOUNDARY),
        (Operator.LE, MutationOperator.RELATION),
    ),
    Operator.GE: (
        (Operator.GT, MutationOperator.BOUNDARY),
        (Operator.LT, MutationOperator.RELATION),
    ),
    Operator.EQ: ((Operator.NE, MutationOperator.RELATION),),
    Operator.NE: ((Operator.EQ, MutationOperator.RELATION),),
}
_SWAPS: dict[Operator, tuple[Operator, MutationOperator]] = {
    Operator.ADD: (Operator.SUB, MutationOperator.ARITHMETIC),
    Operator.SUB: (Operator.ADD, MutationOperator.ARITHMETIC),
    Operator.MUL: (Operator.DIV, MutationOperator.ARITHMETIC),
    Operator.DIV: (Operator.MUL, MutationOperator.ARITHMETIC),
    Operator.MOD: (Operator.MUL, MutationOperator.ARITHMETIC),
    Operator.AND: (Operator.OR, MutationOperator.LOGIC),
    Operator.OR: (Operator.AND, MutationOperator.LOGIC),
    Operator.XOR: (Operator.OR, MutationOperator.LOGIC),
}
_SIGNS: dict[Operator, str] = {
    Operator.LT: "<",
    Operator.LE: "<=",
    Operator.GT: ">",
    Operator.GE: ">=",
    Operator.EQ: "=",
    Operator.NE: "<>",
    Operator.ADD: "+",
    Operator.SUB: "-",
    Operator.MUL: "*",
    Operator.DIV: "/",
    Operator.MOD: "MOD",
    Operator.AND: "AND",
    Operator.OR: "OR",
    Operator.XOR: "XOR",
}
"""Operators as they are written."""

_CHAINS = (Operator.ADD, Operator.MUL, Operator.AND, Operator.OR, Operator.XOR)
"""Operators that the checker makes one node of in a row."""

_NEGATED = frozenset((*_RELATIONS, Operator.NOT))
"""Operators of conditions whose negation is another mutant already."""

_LEAVINGS = {
    RoutineExit: "RETURN",
    LoopExit: "EXIT",
    LoopNext: "CONTINUE",
    JumpTo: "JMP",
}


def mutants_of(routine: Routine) -> Iterator[Mutant]:
    """Yield the mutants of a routine, by place in its body.

    None of a routine without a body. Different mutants may do the same.
    """
    if routine.body is None:
        return
    of = _Walk(routine)
    for body, site in of.statements(routine.body):
        assert site.statement is not None
        yield Mutant(
            routine, body, site.fault, site.at, site.statement, site.branch, site.change, site.edit
        )


class _Walk:
    """A walk through the nodes of a routine."""

    def __init__(self, routine: Routine) -> None:
        self._edits = SourceEdits(routine.source)
        self._statements: dict[type[Any], Callable[[Any], _Variants]] = {
            Do: self._do,
            Conditional: self._conditional,
            ConditionLoop: self._loop,
            CaseSelection: self._selection,
            CountedLoop: self._whole,
            Protected: self._whole,
        }

    # statements ------------------------------------------------------------------------------

    def statements(self, body: TypedStatements) -> Iterator[tuple[TypedStatements, _Site]]:
        """Return variants of a list of statements: each removed, and with faults inside."""
        for place, one in enumerate(body):
            if isinstance(one, LifeStep):
                continue
            before, after = body[:place], body[place + 1 :]
            removed = self._removed(one)
            if removed is not None:
                removed.statement = one.at
                yield (*before, *after), removed
            inside = self._statements.get(type(one))
            if inside is None:
                continue
            for variant, site in inside(one):
                if site.statement is None:
                    site.statement = one.at
                yield (*before, variant, *after), site

    def _removed(self, statement: Any) -> _Site | None:
        """Return the removal of a statement; None of one that is made of others."""
        at = statement.at
        word = _LEAVINGS.get(type(statement))
        if word is not None:
            if self._edits.is_text(at) and self._edits.word(at) != word:
                return None  # made by the checker
            return _Site(
                MutationOperator.LEAVING, at, f"{word} removed", self._edits.without_statement(at)
            )
        if not isinstance(statement, Do):
            return None
        return _Site(
            MutationOperator.STATEMENT, at, "statement removed", self._edits.without_statement(at)
        )

    def _do(self, statement: Do) -> _Variants:
        value = statement.value
        if isinstance(value, Latched):
            signs = ("S=", "R=") if value.sets else ("R=", "S=")
            edit = self._edits.replaced_setter(statement.at, signs[1])
            flipped = changed(value, sets=not value.sets)
            site = _Site(
                MutationOperator.LOGIC, statement.at, f"{signs[0]} becomes {signs[1]}", edit
            )
            yield changed(statement, value=flipped), site
        for variant, site in self.value(value):
            yield changed(statement, value=variant), site

    def _conditional(self, statement: Conditional) -> _Variants:
        branches = statement.branches
        for place, one in enumerate(branches):
            at = one.at or statement.at
            for condition, site in self._condition(one.condition, at, (True, False)):
                if place:
                    site.branch = at
                    site.statement = statement.at
                variant = changed(one, condition=condition)
                yield _with(statement, "branches", place, variant), site
            for body, site in self.statements(one.body):
                yield _with(statement, "branches", place, changed(one, body=body)), site
        for body, site in self.statements(statement.otherwise):
            yield changed(statement, otherwise=body), site

    def _condition(self, condition: TypedValue, at: int, values: tuple[bool, ...]) -> _Variants:
        """Return variants of a condition: constant, negated, and with faults inside."""
        if not isinstance(condition, Known):
            for value in values:
                word = str(value).upper()
                edit = self._edits.replaced_condition(at, word)
                known = Known(value, BOOL, at)
                yield (
                    known,
                    _Site(MutationOperator.CONDITION, at, f"condition becomes {word}", edit),
                )
            if not (isinstance(condition, Computed) and condition.operator in _NEGATED):
                edit = self._edits.negated_condition(at)
                negated = Computed(Operator.NOT, (condition,), BOOL, at)
                yield negated, _Site(MutationOperator.NEGATION, at, "condition is negated", edit)
        yield from self.value(condition)

    def _loop(self, statement: ConditionLoop) -> _Variants:
        values = (False,) if statement.before else ()
        if statement.before:
            inside = self._condition(statement.condition, statement.at, values)
        else:
            inside = self.value(statement.condition)
        for condition, site in inside:
            yield changed(statement, condition=condition), site
        for body, site in self.statements(statement.body):
            yield changed(statement, body=body), site

    def _selection(self, statement: CaseSelection) -> _Variants:
        for selector, site in self.value(statement.selector):
            yield changed(statement, selector=selector), site
        for place, one in enumerate(statement.choices):
            if one.body:
                rest = statement.choices[:place] + statement.choices[place + 1 :]
                site = _Site(
                    MutationOperator.LABEL,
                    one.at or statement.at,
                    "label and its statements removed",
                )
                yield changed(statement, choices=rest), site
            for body, site in self.statements(one.body):
                yield _with(statement, "choices", place, changed(one, body=body)), site
        for body, site in self.statements(statement.otherwise):
            yield changed(statement, otherwise=body), site

    def _whole(self, statement: Any) -> _Variants:
        """Return the variants of any statement, field by field."""
        kind: type = type(statement)
        for name in field_names(kind):
            part = getattr(statement, name)
            inside = self.statements(part) if isinstance(part, tuple) else self.value(part)
            for variant, site in inside:
                yield changed(statement, **{name: variant}), site

    # values ----------------------------------------------------------------------------------

    def value(self, value: Any) -> _Variants:
        """Return variants of any part of an expression, with faults in it."""
        kind: type = type(value)
        if kind is tuple:
            for place, one in enumerate(value):
                for variant, site in self.value(one):
                    yield (*value[:place], variant, *value[place + 1 :]), site
            return
        if not is_node(value):
            return
        if kind is Computed:
            yield from self._computed(value)
        elif kind is Shortcut:
            yield from self._shortcut(value)
        elif kind is Known:
            yield from self._known(value)
            return
        for name in field_names(kind):
            for variant, site in self.value(getattr(value, name)):
                yield changed(value, **{name: variant}), site

    def _is_written(self, at: int, sign: str) -> bool:
        """Return True if an operator is at an offset, or if that is unknown."""
        return not self._edits.is_text(at) or self._edits.word(at) == sign

    def _computed(self, value: Computed) -> _Variants:
        operator, operands, at = value.operator, value.operands, value.at
        if operator in (Operator.NOT, Operator.NEG):
            sign = "NOT" if operator is Operator.NOT else "-"
            if self._is_written(at, sign):
                kind = (
                    MutationOperator.NEGATION
                    if operator is Operator.NOT
                    else MutationOperator.ARITHMETIC
                )
                yield operands[0], _Site(kind, at, f"{sign} removed", self._edits.without_word(at))
            return
        sign = _SIGNS.get(operator, "")
        if not sign or not self._is_written(at, sign):
            return
        for other, fault in _RELATIONS.get(operator, ()):
            edit = self._edits.replaced_word(at, _SIGNS[other])
            site = _Site(fault, at, f"{sign} becomes {_SIGNS[other]}", edit)
            yield changed(value, operator=other), site
        swap = _SWAPS.get(operator)
        if swap is None:
            return
        other, fault = swap
        places = self._edits.chain(at, len(operands) - 1)
        for place in range(1, len(operands)):
            here = places[place - 1] if places else at
            edit = self._edits.replaced_word(here, _SIGNS[other]) if places else None
            site = _Site(fault, here, f"{sign} becomes {_SIGNS[other]}", edit)
            yield _swapped(value, other, place), site
        if isinstance(value.type, BoolType):
            for place in range(len(operands)):
                rest = operands[:place] + operands[place + 1 :]
                variant = rest[0] if len(rest) == 1 else changed(value, operands=rest)
                edit, gone = self._edits.without_operand(places, place)
                here = places[max(place - 1, 0)] if places else at
                change = f"{gone or f'operand {place + 1} of {sign}'} removed"
                yield variant, _Site(MutationOperator.CONDITION, here, change, edit)

    def _shortcut(self, value: Shortcut) -> _Variants:
        signs = ("AND_THEN", "OR_ELSE") if value.is_and else ("OR_ELSE", "AND_THEN")
        at = value.at
        if not self._is_written(at, signs[0]):
            return
        edit = self._edits.replaced_word(at, signs[1])
        site = _Site(MutationOperator.LOGIC, at, f"{signs[0]} becomes {signs[1]}", edit)
        yield changed(value, is_and=not value.is_and), site
        places = self._edits.chain(at, 1)
        for place, operand in enumerate((value.right, value.left)):
            edit, gone = self._edits.without_operand(places, place)
            change = f"{gone or f'operand {place + 1} of {signs[0]}'} removed"
            yield operand, _Site(MutationOperator.CONDITION, at, change, edit)

    def _known(self, value: Known) -> _Variants:
        if not self._edits.is_text(value.at):
            return
        for number in _neighbours(value):
            edit = self._edits.replaced_literal(value.at, value.value, number, value.type)
            if edit is None:
                return
            change = f"{self._edits.literal(value.at)} becomes {edit.text}"
            yield (
                changed(value, value=number),
                _Site(MutationOperator.CONSTANT, value.at, change, edit),
            )


def _with(statement: Any, name: str, place: int, part: Any) -> Any:
    """Return a statement with another part in one of its lists."""
    parts = getattr(statement, name)
    return changed(statement, **{name: (*parts[:place], part, *parts[place + 1 :])})


def _swapped(value: Computed, other: Operator, place: int) -> Computed:
    """Return a chain with another operator before its operand number `place`, as the text would be
    read by the precedence of operators."""
    operator, operands, type = value.operator, value.operands, value.type

    def joined(of: Operator, *parts: TypedValue) -> TypedValue:
        first = parts[0]
        if len(parts) == 1:
            return first
        if isinstance(first, Computed) and first.operator is of in _CHAINS and first.type is type:
            parts = (*first.operands, *parts[1:])
        return Computed(of, parts, type, value.at)

    if operator in (Operator.AND, Operator.XOR):  # OR binds less
        parts = joined(operator, *operands[:place]), joined(operator, *operands[place:])
        whole = joined(other, *parts)
    elif operator is Operator.OR:  # AND binds more
        pair = joined(other, operands[place - 1], operands[place])
        whole = joined(operator, *operands[: place - 1], pair, *operands[place + 1 :])
    else:
        pair = joined(other, joined(operator, *operands[:place]), operands[place])
        whole = joined(operator, pair, *operands[place + 1 :])
    assert isinstance(whole, Computed)
    return whole


def _neighbours(value: Known) -> Iterator[int | float | bool]:
    """Values next to a constant."""
    number, type = value.value, value.type
    if isinstance(type, BoolType) and isinstance(number, bool):
        yield not number
    elif isinstance(type, RealType) and isinstance(number, int | float):
        yield number + 1.0
        yield number - 1.0
    elif isinstance(type, IntegerType | TimeType) and isinstance(number, int):
        low, high = _span(type)
        if number < high:
            yield number + 1
        if number > low:
            yield number - 1


def _span(type: Any) -> tuple[int, int]:
    whole = counted(type)
    return whole.low, whole.high
