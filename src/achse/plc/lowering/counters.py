"""Counters: how often statements begin and branches are taken, in as few counters as are exact.

Statements behind each other share a counter as long as the first of them cannot leave: by a
fault, an exit, a jump. A number that follows from others needs no counter: that of an ELSE, or of a
statement behind one that failed a known number of times. Faults are counted on their way out.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from achse.iec.strings import StringType
from achse.plc.lowering import nodes
from achse.plc.lowering.decisions import DecisionShape
from achse.st.typed.expressions import Known, Operator

_MOST_TERMS = 6
"""Terms of a tally that others are made of."""


@dataclass(frozen=True, slots=True)
class Tally:
    """A number of times: the sum of some counters, less that of others."""

    plus: tuple[int, ...] = ()
    minus: tuple[int, ...] = ()

    def __sub__(self, other: "Tally") -> "Tally":
        plus = list(self.plus + other.minus)
        minus = []
        for counter in self.minus + other.plus:
            if counter in plus:
                plus.remove(counter)
            else:
                minus.append(counter)
        return Tally(tuple(plus), tuple(minus))

    def __add__(self, other: "Tally") -> "Tally":
        return self - Tally(other.minus, other.plus)

    def of(self, counts: Sequence[int] | Mapping[int, int]) -> int:
        """Return the number, from the values of counters: see `RoutineCounters.values`."""
        return sum(counts[one] for one in self.plus) - sum(counts[one] for one in self.minus)


@dataclass(frozen=True, slots=True)
class StatementPoint:
    """A statement: `at` is its offset in the source."""

    at: int
    tally: Tally


@dataclass(frozen=True, slots=True)
class BranchPoint:
    """One way out of the decision at an offset in the source."""

    at: int
    name: str
    """`TRUE`, `FALSE`; of a CASE its labels, `ELSE`."""
    tally: Tally


@dataclass(frozen=True, slots=True)
class DecisionPoint:
    """A decision of a statement or ELSIF at an offset: vector n is the counter `first` + n."""

    at: int
    shape: DecisionShape
    conditions: tuple[int, ...]
    """Offsets of the conditions."""
    first: int


@dataclass(slots=True)
class RoutineCounters:
    """Counters of a routine, from the number `first` on, and what follows from them."""

    first: int = 0
    size: int = 0
    statements: list[StatementPoint] = field(default_factory=list)
    branches: list[BranchPoint] = field(default_factory=list)
    decisions: list[DecisionPoint] = field(default_factory=list)
    """Decisions of two conditions or more, if conditions count."""
    sums: list[Tally] = field(default_factory=list)
    """Tallies that others refer to, by -1, -2 and so on; each of counters and of those before."""

    def new(self, count: int = 1) -> int:
        """Return the number of one more counter, or the first of several."""
        self.size += count
        return self.first + self.size - count

    def named(self, tally: Tally) -> Tally:
        """Return the same number as one term, which `sums` has."""
        self.sums.append(tally)
        return Tally((-len(self.sums),))

    def short(self, tally: Tally) -> Tally:
        """Return the same number in a few terms."""
        terms = len(tally.plus) + len(tally.minus)
        return tally if terms <= _MOST_TERMS else self.named(tally)

    def values(self, counts: Sequence[int] | Mapping[int, int]) -> dict[int, int]:
        """Values of the counters of the routine and of its `sums`, by their numbers."""
        values = {number: counts[number] for number in range(self.first, self.first + self.size)}
        for number, tally in enumerate(self.sums, 1):
            values[-number] = tally.of(values)
        return values

    def statement(self, at: int, tally: Tally) -> None:
        """Note how often a statement begins."""
        self.statements.append(StatementPoint(at, tally))

    def branch(self, at: int, name: str, tally: Tally) -> None:
        """Note how often a decision goes one way."""
        self.branches.append(BranchPoint(at, name, tally))


# What cannot leave ------------------------------------------------------------------------------

_STRAIGHT = frozenset(
    {
        *(Operator.ADD, Operator.SUB, Operator.MUL, Operator.NEG, Operator.ABS),
        *(Operator.AND, Operator.OR, Operator.XOR, Operator.NOT),
        *(Operator.EQ, Operator.NE, Operator.LT, Operator.LE, Operator.GT, Operator.GE),
        *(Operator.MIN, Operator.MAX, Operator.SEL, Operator.SHL, Operator.SHR),
        *(Operator.ROL, Operator.ROR, Operator.MOD),
    }
)
"""Operators of numbers that always give one."""


def can_leave(statements: nodes.LoweredStatements) -> bool:
    """Return True if what follows a list may not be reached."""
    for one in statements:
        match one:
            case nodes.Count():
                pass
            case nodes.Effects(values, _):
                if not all(map(is_straight, values)):
                    return True
            case nodes.Branches(branches, otherwise):
                if can_leave(otherwise) or not all(
                    is_straight(each.condition) and not can_leave(each.body) for each in branches
                ):
                    return True
            case nodes.LoweredSelection(selector, cases, otherwise):
                bodies = (*(each.body for each in cases), otherwise)
                if not is_straight(selector) or any(map(can_leave, bodies)):
                    return True
            case _:
                return True
    return False


def is_straight(value: nodes.LoweredValue) -> bool:
    """Return True if a value is evaluated to its end whatever its operands are."""
    match value:
        case Known() | nodes.Temporary() | nodes.Count():
            return True
        case nodes.ConditionBit(_, _, inner) | nodes.CountVector(_, _, inner):
            return is_straight(inner)
        case nodes.Keep(_, inner) | nodes.Convert(inner) | nodes.Copy(inner):
            return is_straight(inner)
        case nodes.LoadValue(place, spends):
            return not spends and _is_sure(place)
        case nodes.PlaceAddress(place):
            return _is_sure(place)
        case nodes.Compute(operator, operands):
            return operator in _STRAIGHT and all(map(_is_straight_number, operands))
        case nodes.LazyChoice(condition, yes, no):
            return is_straight(condition) and is_straight(yes) and is_straight(no)
        case nodes.Sequence(effects, inner):
            return all(map(is_straight, effects)) and is_straight(inner)
        case nodes.StoreValue(place, inner):
            return _is_sure(place) and is_straight(inner)
    return False


def _is_straight_number(value: nodes.LoweredValue) -> bool:
    type: Any = value.type
    return not isinstance(type, StringType) and is_straight(value)


def _is_sure(place: nodes.ResolvedPlace) -> bool:
    """Return True if a place is always there."""
    if place.home is nodes.Home.ADDRESS or not place.is_bounded:
        return False
    return all(term.low is None and is_straight(term.index) for term in place.terms)
