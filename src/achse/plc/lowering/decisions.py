"""Decisions: Boolean expressions of two conditions or more, and which condition decides when.

One evaluation gives a vector: bit n is condition n, 0 too if AND_THEN or OR_ELSE leave it out. What
was left out follows from the others. A condition is masked where another one decides alone.

Source: masking MC/DC as in CAST-10.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import NamedTuple, TypeAlias

from achse.iec.elementary import BoolType
from achse.st.typed.expressions import Computed, Known, Operator, Shortcut, TypedValue

MOST_CONDITIONS = 8
"""Conditions of a decision that is counted: there is a counter for each vector."""

_LOGIC = (Operator.AND, Operator.OR, Operator.XOR, Operator.NOT)

Shape: TypeAlias = "int | bool | tuple[str, tuple[Shape, ...]]"
"""Number of a condition, a constant, or an operator and its operands."""

_DECIDING = {"AND": False, "AND_THEN": False, "OR": True, "OR_ELSE": True}
"""Value of an operand that decides alone."""


@dataclass(frozen=True, slots=True)
class Vector:
    """One way that a decision can be evaluated."""

    outcome: bool
    values: tuple[bool | None, ...]
    """Values of the conditions; None for skipped conditions."""
    unmasked: frozenset[int]
    """Conditions whose change alone would change the outcome."""


class IndependencePair(NamedTuple):
    """Two vectors that show that a condition decides alone, FALSE and TRUE."""

    without: int
    with_: int


@dataclass(frozen=True)
class DecisionShape:
    """A decision without its conditions' own expressions."""

    shape: Shape
    count: int
    """Number of conditions."""

    @cached_property
    def vectors(self) -> tuple[Vector, ...]:
        """The meaning of each vector."""
        return tuple(self._vector(bits) for bits in range(1 << self.count))

    def _vector(self, bits: int) -> Vector:
        values: list[bool | None] = [None] * self.count
        outcome = _evaluated(self.shape, bits, values)
        assert outcome is not None
        unmasked: set[int] = set()
        _unmask(self.shape, bits, unmasked)
        return Vector(outcome, tuple(values), frozenset(unmasked))

    def pair(self, condition: int, seen: Sequence[int]) -> IndependencePair | None:
        """Return the first two of the vectors that were seen that show that a condition decides."""
        showing = [bits for bits in seen if condition in self.vectors[bits].unmasked]
        for without in showing:
            if self.vectors[without].values[condition] is not False:
                continue
            for other in showing:
                vector = self.vectors[other]
                if vector.values[condition] and vector.outcome != self.vectors[without].outcome:
                    return IndependencePair(without, other)
        return None


def _evaluated(shape: Shape, bits: int, values: list[bool | None]) -> bool:
    """Return the outcome of a shape; notes the values of the conditions that are evaluated."""
    if isinstance(shape, bool):
        return shape
    if isinstance(shape, int):
        value = values[shape] = bool(bits >> shape & 1)
        return value
    operator, parts = shape
    if operator in ("AND_THEN", "OR_ELSE"):
        left = _evaluated(parts[0], bits, values)
        return left if left is _DECIDING[operator] else _evaluated(parts[1], bits, values)
    return _combined(operator, [_evaluated(part, bits, values) for part in parts])


def _combined(operator: str, operands: Sequence[bool]) -> bool:
    match operator:
        case "AND" | "AND_THEN":
            return all(operands)
        case "OR" | "OR_ELSE":
            return any(operands)
        case "XOR":
            return sum(operands) % 2 == 1
    return not operands[0]


def _unmask(shape: Shape, bits: int, unmasked: set[int]) -> None:
    """Note the conditions of a shape that its outcome depends on."""
    if isinstance(shape, bool):
        return
    if isinstance(shape, int):
        unmasked.add(shape)
        return
    operator, parts = shape
    deciding = _DECIDING.get(operator)
    for place, part in enumerate(parts):
        if operator in ("AND_THEN", "OR_ELSE") and place and _value(parts[0], bits) is deciding:
            return  # left out
        others = (*parts[:place], *parts[place + 1 :])
        if operator in ("AND_THEN", "OR_ELSE") and not place and _value(part, bits) is deciding:
            if (not deciding) not in _outcomes(others[0]):
                return  # a constant decides alone
            others = ()  # left out
        if deciding is None or all(_value(other, bits) is not deciding for other in others):
            _unmask(part, bits, unmasked)


def _outcomes(shape: Shape) -> set[bool]:
    """Return the outcomes that a shape can have; each of its conditions is independent."""
    if isinstance(shape, bool):
        return {shape}
    if isinstance(shape, int):
        return {False, True}
    operator, parts = shape
    return {_combined(operator, operands) for operands in product(*map(_outcomes, parts))}


def _value(shape: Shape, bits: int) -> bool:
    size = 1 + max(_conditions(shape), default=-1)
    return _evaluated(shape, bits, [None] * size)


def _conditions(shape: Shape) -> Iterator[int]:
    if isinstance(shape, bool):
        return
    if isinstance(shape, int):
        yield shape
        return
    for part in shape[1]:
        yield from _conditions(part)


def shape_of(value: TypedValue) -> tuple[DecisionShape, tuple[TypedValue, ...]] | None:
    """Return the shape of a decision and its conditions; None for other values.

    Of a negation the decision is what it negates.
    """
    if isinstance(value, Computed) and value.operator is Operator.NOT:
        return None
    conditions: list[TypedValue] = []
    shape = _shape(value, conditions)
    if len(conditions) < 2:
        return None
    return DecisionShape(shape, len(conditions)), tuple(conditions)


def _shape(value: TypedValue, conditions: list[TypedValue]) -> Shape:
    if isinstance(value, Known):
        return bool(value.value)
    if isinstance(value, Shortcut):
        name = "AND_THEN" if value.is_and else "OR_ELSE"
        return name, (_shape(value.left, conditions), _shape(value.right, conditions))
    is_logic = isinstance(value, Computed) and value.operator in _LOGIC
    if isinstance(value, Computed) and is_logic and isinstance(value.type, BoolType):
        return value.operator.value, tuple(_shape(one, conditions) for one in value.operands)
    conditions.append(value)
    return len(conditions) - 1
