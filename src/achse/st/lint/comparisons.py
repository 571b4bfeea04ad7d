"""Rules about comparisons: equality of floating point numbers, unsigned numbers below zero."""

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

from achse.iec.elementary import IntegerType, RealType
from achse.st.lexis.codes import Code
from achse.st.lexis.source import Source
from achse.st.lint.report import LintReport
from achse.st.syntax.nodes import field_names
from achse.st.typed.expressions import Computed, Conversion, Converted, Known, Operator, TypedValue
from achse.st.typed.project import Routine, RoutineKind

RULES = (Code.FLOAT_EQUALITY, Code.DEAD_COMPARISON)

_SIGNS = {Operator.EQ: "=", Operator.NE: "<>"}

_DEAD = {
    (Operator.LT, 1): "FALSE",
    (Operator.GE, 1): "TRUE",
    (Operator.GT, 0): "FALSE",
    (Operator.LE, 0): "TRUE",
}
"""Results of comparisons with zero on the left (0) or right (1) of an unsigned number."""

_TYPED = "achse.st.typed."


class FoundComparison(NamedTuple):
    """A comparison that a rule finds, by its offset in the source."""

    code: Code
    at: int
    message: str


def check_comparisons(
    routines: Iterable[Routine], sources: frozenset[Source], report: LintReport
) -> None:
    """Apply the rules to the bodies of routines from these sources."""
    if not report.wants(*RULES):
        return
    for routine in routines:
        if routine.source in sources and routine.kind is not RoutineKind.LIFE:
            for comparison in comparisons_in(routine.body):
                report.add(comparison.code, routine.source, comparison.at, comparison.message)


def comparisons_in(statements: object) -> Iterator[FoundComparison]:
    """Return what the rules find in statements of the typed form, in no order."""
    seen: set[int] = set()
    stack: list[Any] = [statements]
    while stack:
        node = stack.pop()
        if isinstance(node, tuple):
            stack += node
        elif node.__class__.__module__.startswith(_TYPED) and id(node) not in seen:
            seen.add(id(node))
            if isinstance(node, Computed):
                yield from _check_comparison(node)
            stack += [getattr(node, name) for name in field_names(node.__class__)]


def _check_comparison(node: Computed) -> Iterator[FoundComparison]:
    if len(node.operands) != 2:
        return
    sign = _SIGNS.get(node.operator)
    if _is_of_itself(node):
        return  # the usual question whether a number is none
    if sign is not None and isinstance(node.operands[0].type, RealType):
        message = f"'{sign}' compares floating point numbers, which are seldom equal"
        yield FoundComparison(Code.FLOAT_EQUALITY, node.at, message)
    for side in (0, 1):
        result = _DEAD.get((node.operator, side))
        zero, other = node.operands[side], node.operands[1 - side]
        if result is not None and isinstance(zero, Known) and zero.value == 0:
            type = _unsigned(other)
            if type is not None:
                message = f"a {type.name} is never below 0: this is always {result}"
                yield FoundComparison(Code.DEAD_COMPARISON, node.at, message)


def _is_of_itself(node: Computed) -> bool:
    """Return True if a variable is compared with itself."""
    one, other = node.operands
    return not isinstance(one, Computed) and one == other


def _unsigned(value: TypedValue) -> IntegerType | None:
    """Return the type of a variable that has no sign, as declared."""
    while isinstance(value, Converted) and value.rule is Conversion.EXTEND:
        value = value.operand
    type = value.type
    if isinstance(value, Known) or not isinstance(type, IntegerType):
        return None
    return type if type.low == 0 else None
