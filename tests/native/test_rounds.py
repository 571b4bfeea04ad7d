"""Rounds of calls by machine code do what a loop of the same calls does."""

from collections.abc import MutableSequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.native.compiled import Kernel, bound_call, checked_builds
from achse.native.declare import Slot, lay_out
from achse.native.memory import Rows
from achse.native.rounds import Rounds

pytest.importorskip("llvmlite")


class Count:
    value: int = 0


WORDS = lay_out("Count", [Count], Slot)
MOST = 1 << 61


def advance(words: MutableSequence[int], factor: int, by: int) -> None:
    """Take the next of a sequence of numbers, which depends on the order of calls."""
    words[0] = (words[0] * factor + by) % MOST


def is_multiple(words: MutableSequence[int], of: int) -> int:
    """Count the calls; True if the number is a multiple."""
    words[1] += 1
    return int(words[0] % of == 0)


ADVANCE, IS_MULTIPLE = Kernel("advance", advance, {}), Kernel("is-multiple", is_multiple, {})


@given(
    st.lists(st.tuples(st.integers(1, 9), st.integers(0, 9)), max_size=4),
    st.lists(st.integers(2, 9), min_size=1, max_size=3),
    st.integers(1, 30),
    st.integers(0, 100),
)
def test_rounds_end_with_the_first_result_or_the_last_round(
    steps: list[tuple[int, int]], divisors: list[int], most: int, start: int
) -> None:
    rows = Rows(WORDS, 2)
    words = rows.memory.cast("q")
    words[0] = start
    plain = [start, 0]
    rounds = Rounds(
        [ADVANCE.bind(rows.address, 2, *numbers) for numbers in steps],
        [IS_MULTIPLE.bind(rows.address, 2, each) for each in divisors],
    )
    done = ended = 0
    while not ended and done < most:
        for numbers in steps:
            advance(plain, *numbers)
        for each in divisors:
            ended |= is_multiple(plain, each)
        done += 1
    assert rounds.run(most) == done
    assert list(words) == plain


def test_last_arguments_can_be_set_between_rounds() -> None:
    rows = Rows(WORDS, 2)
    bound = ADVANCE.bind(rows.address, 2, 1)
    call = bound_call(bound)
    assert call is not None
    rounds = Rounds([bound], [])
    for by in (3, 5):
        call.words[-1] = by
        rounds.run(2)
    assert rows.memory.cast("q")[0] == 16


def test_functions_without_machine_code_are_refused() -> None:
    rows = Rows(WORDS, 2)
    with checked_builds():
        checked = ADVANCE.bind(rows.address, 2, 1, 1)
    assert bound_call(checked) is None
    for function in (checked, lambda: None):
        with pytest.raises(ValueError, match="expected functions of machine code, got"):
            Rounds([function], [])
