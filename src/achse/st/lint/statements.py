"""Rules about statements: CASE without ELSE, unreachable code, empty branches, `:=` for `=`."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

from achse.st.declared.scopes import DeclaredUnit, Scopes
from achse.st.graphical.body import GraphicalBody
from achse.st.lexis.codes import Code
from achse.st.lexis.source import Source
from achse.st.lint.declared_types import DeclaredTypes
from achse.st.lint.report import LintReport
from achse.st.lint.uses import TrackedUnit, TrackedVariable, with_chains
from achse.st.syntax.nodes import field_names
from achse.st.syntax.tree import (
    Assign,
    Branch,
    Case,
    Continue,
    Exit,
    Expression,
    For,
    If,
    Jump,
    Label,
    Literal,
    Member,
    Name,
    Range,
    RepeatUntil,
    Return,
    Statements,
    Try,
    While,
)

RULES = (
    Code.ASSIGNMENT_IN_CONDITION,
    Code.MISSING_ELSE,
    Code.MISSING_CASES,
    Code.UNREACHABLE,
    Code.EMPTY_BRANCH,
)

_LEAVES = {Return: "RETURN", Exit: "EXIT", Continue: "CONTINUE", Jump: "JMP"}
_LOOPS = {For: "FOR", While: "WHILE", RepeatUntil: "REPEAT"}
_MOST_NAMED = 5

Chain = Sequence[Mapping[str, TrackedVariable]]


def check_statements(units: Sequence[TrackedUnit], scopes: Scopes, report: LintReport) -> None:
    """Apply the rules to the bodies of all units; those that are drawn have other forms."""
    if not report.wants(*RULES):
        return
    rules = _Rules(DeclaredTypes(scopes), report)
    for unit, chain in with_chains(units, scopes):
        rules.body(getattr(unit.entry.tree, "body", ()), unit.entry, chain)
        for owner, own in unit.parts:
            rules.body(getattr(owner, "body", ()), unit.entry, [own, *chain])


class _Rules:
    """The rules, and where they look."""

    def __init__(self, types: DeclaredTypes, report: LintReport) -> None:
        self._types = types
        self._report = report
        self._source: Source
        self._unit: DeclaredUnit
        self._chain: Chain = ()

    def body(self, body: object, unit: DeclaredUnit, chain: Chain) -> None:
        """Apply the rules to all statements of a body of a unit."""
        if isinstance(body, GraphicalBody) or not isinstance(body, tuple):
            return
        self._source, self._chain, self._unit = unit.source, chain, unit
        waiting: list[Statements] = [body]
        while waiting:
            statements = waiting.pop()
            self._check_order(statements)
            for statement in statements:
                waiting += self._check(statement)

    def _check(self, statement: object) -> Iterator[Statements]:
        """Check a statement, and yield the lists of statements in it."""
        if isinstance(statement, If):
            for number, branch in enumerate(statement.branches):
                self._check_condition(branch.condition)
                self._check_branch(branch, "ELSIF" if number else "IF")
                yield branch.body
            yield statement.otherwise
        elif isinstance(statement, Case):
            self._check_condition(statement.selector)
            self._check_cases(statement)
            for choice in statement.choices:
                yield choice.body
            yield statement.otherwise
        elif isinstance(statement, For | While | RepeatUntil):
            if not isinstance(statement, For):
                self._check_condition(statement.condition)
            if not statement.body:
                message = f"this {_LOOPS[type(statement)]} has no statements"
                self._add(Code.EMPTY_BRANCH, statement.at, message)
            yield statement.body
        elif isinstance(statement, Try):
            yield from (statement.body, statement.handler, statement.final)

    def _add(self, code: Code, at: int, message: str) -> None:
        self._report.add(code, self._source, at, message)

    def _check_order(self, statements: Statements) -> None:
        for statement, following in pairwise(statements):
            word = _LEAVES.get(type(statement))
            if word is not None and not isinstance(following, Label):
                self._add(Code.UNREACHABLE, _begin(following), f"nothing gets here after {word}")
                return

    def _check_branch(self, branch: Branch, word: str) -> None:
        if not branch.body:
            self._add(Code.EMPTY_BRANCH, branch.at, f"this {word} has no statements")

    def _check_condition(self, condition: Expression) -> None:
        stack: list[Any] = [condition]
        while stack:
            tree = stack.pop()
            if isinstance(tree, Assign):
                message = f"'{tree.operator}' in a condition assigns: '=' compares"
                self._add(Code.ASSIGNMENT_IN_CONDITION, tree.at, message)
            if isinstance(tree, tuple):
                stack += tree
            else:
                stack += [getattr(tree, name) for name in field_names(tree.__class__)]

    def _check_cases(self, tree: Case) -> None:
        if tree.otherwise or tree.has_empty_else:
            return
        known = self._types.values_of(tree.selector, self._chain, self._unit)
        if known is None:
            self._add(Code.MISSING_ELSE, tree.at, "this CASE has no ELSE")
            return
        numbers = {name.lower(): number for name, number in known.numbers.items()}
        taken: set[int] = set()
        for choice in tree.choices:
            for label in choice.labels:
                values = _values(label, numbers)
                if values is None:
                    return  # a constant of another kind
                taken.update(values)
        missing = [name for name, number in known.numbers.items() if number not in taken]
        if missing and not known.name:
            self._add(Code.MISSING_ELSE, tree.at, "this CASE has no ELSE")
        elif missing:
            shown = ", ".join(missing[:_MOST_NAMED]) + ", …" * (len(missing) > _MOST_NAMED)
            message = f"this CASE has no ELSE, and leaves out of {known.name}: {shown}"
            self._add(Code.MISSING_CASES, tree.at, message)


def _values(label: Expression | Range, numbers: Mapping[str, int]) -> list[int] | None:
    """Return the values of an enumeration that a label takes; None if names do not tell them."""
    if isinstance(label, Range):
        low, high = _value(label.low, numbers), _value(label.high, numbers)
        if low is None or high is None:
            return None
        return [number for number in numbers.values() if low <= number <= high]
    value = _value(label, numbers)
    return None if value is None else [value]


def _value(label: Expression, numbers: Mapping[str, int]) -> int | None:
    if isinstance(label, Literal):
        if label.kind == "integer" and label.text.isdecimal():
            return int(label.text)
        return numbers.get(label.text.rpartition("#")[2].lower())
    return numbers.get(label.name.lower()) if isinstance(label, Name | Member) else None


def _begin(statement: Any) -> int:
    """Return the offset of the first sign of a statement."""
    at: int = statement.at
    tree = getattr(statement, "target", statement)
    while True:
        at = min(at, tree.at)
        inner = getattr(tree, "of", None)
        if inner is None:
            return at
        tree = inner
