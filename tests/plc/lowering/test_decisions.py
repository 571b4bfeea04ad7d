"""Decisions: which condition decides, against a definition by trying everything."""

from itertools import product
from random import Random

from hypothesis import given
from hypothesis import strategies as st

from achse.iec.elementary import BOOL, WORD
from achse.plc.lowering.decisions import DecisionShape, Shape, shape_of
from achse.st.typed.expressions import Computed, Known, Operator, Read, Shortcut
from achse.st.typed.places import FrameBase, Storage

NAMES = ("AND", "OR", "XOR", "NOT", "AND_THEN", "OR_ELSE")


def drawn(random: Random, depth: int, numbers: list[int]) -> Shape:
    """A shape with conditions from `numbers`, which it takes."""
    if depth == 0 or random.random() < 0.3 or len(numbers) < 3:
        return numbers.pop(0) if numbers and random.random() < 0.95 else random.random() < 0.5
    name = random.choice(NAMES)
    count = 1 if name == "NOT" else 2 if "_" in name else random.randint(2, 3)
    return name, tuple(drawn(random, depth - 1, numbers) for _ in range(count))


def holds(shape: Shape, values: list[bool], seen: set[int]) -> bool:
    """The outcome with all conditions known; `seen` are those that are evaluated."""
    if isinstance(shape, bool):
        return shape
    if isinstance(shape, int):
        seen.add(shape)
        return values[shape]
    name, parts = shape
    first = holds(parts[0], values, seen)
    if name == "AND_THEN":
        return first and holds(parts[1], values, seen)
    if name == "OR_ELSE":
        return first or holds(parts[1], values, seen)
    outcomes = [first, *(holds(part, values, seen) for part in parts[1:])]
    if name == "NOT":
        return not first
    return {"AND": all(outcomes), "OR": any(outcomes), "XOR": outcomes.count(True) % 2 == 1}[name]


@given(st.randoms(use_true_random=False))
def test_a_condition_decides_if_its_change_can_change_the_outcome(random: Random) -> None:
    numbers = list(range(5))
    shape = drawn(random, 3, numbers)
    size = 5 - len(numbers)
    decision = DecisionShape(shape, size)
    for bits, vector in enumerate(decision.vectors):
        values = [bool(bits >> number & 1) for number in range(size)]
        seen: set[int] = set()
        assert vector.outcome is holds(shape, values, seen)
        assert vector.values == tuple(
            value if number in seen else None for number, value in enumerate(values)
        )
        unseen = [number for number in range(size) if number not in seen]
        deciding = set()
        for number in seen:
            for others in product((False, True), repeat=len(unseen)):
                before = values.copy()
                for place, value in zip(unseen, others, strict=True):
                    before[place] = value
                after = before.copy()
                after[number] = not after[number]
                if holds(shape, before, set()) is not holds(shape, after, set()):
                    deciding.add(number)
        assert vector.unmasked == deciding, (shape, values)


@given(st.randoms(use_true_random=False))
def test_pairs_are_found_if_there_are_any(random: Random) -> None:
    numbers = list(range(4))
    decision = DecisionShape(drawn(random, 3, numbers), 4 - len(numbers))
    all_of = decision.vectors
    seen = sorted(random.sample(range(len(all_of)), random.randint(0, len(all_of))))
    for condition in range(decision.count):
        pairs = {
            (a, b)
            for a, b in product(seen, repeat=2)
            if all_of[a].values[condition] is False
            and all_of[b].values[condition] is True
            and all_of[a].outcome is not all_of[b].outcome
            and condition in all_of[a].unmasked & all_of[b].unmasked
        }
        pair = decision.pair(condition, seen)
        assert (pair is None) is not bool(pairs)
        assert pair is None or pair in pairs


def test_a_constant_that_is_left_out_decides_too() -> None:
    for constant in (
        False,
        ("AND", (False, 1)),
        ("NOT", (("OR", (1, True)),)),
        ("XOR", (True, True)),
    ):
        decision = DecisionShape(("AND", (("AND_THEN", (0, constant)), 2)), 3)
        assert all(0 not in vector.unmasked for vector in decision.vectors)
        decision = DecisionShape(("AND_THEN", (0, ("NOT", (constant,)))), 2)
        assert all(0 in vector.unmasked for vector in decision.vectors if not vector.values[0])


def read(offset: int) -> Read:
    return Read(Storage(FrameBase(), offset, BOOL), BOOL)


def test_shapes_of_typed_values() -> None:
    a, b = read(0), read(1)
    both = Computed(Operator.AND, (a, Computed(Operator.NOT, (b,), BOOL)), BOOL)
    shape = shape_of(both)
    assert shape is not None
    assert shape[0].shape == ("AND", (0, ("NOT", (1,))))
    assert shape[1] == (a, b)
    lazy = shape_of(Shortcut(False, both, Known(True, BOOL), BOOL))
    assert lazy is not None
    assert lazy[0].shape == ("OR_ELSE", (("AND", (0, ("NOT", (1,)))), True))
    assert shape_of(Computed(Operator.NOT, (both,), BOOL)) is None
    assert shape_of(Computed(Operator.AND, (a, Known(True, BOOL)), BOOL)) is None
    assert shape_of(Computed(Operator.AND, (read(0), read(2)), WORD)) is None
    assert shape_of(a) is None
