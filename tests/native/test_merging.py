"""Steps of a table that become statements of the function that calls them."""

from itertools import permutations
from typing import Any

import pytest

from achse.native.compiled import Kernel
from achse.native.merging import _code_named, merge_steps

SOURCE = """
def add(total: list[int], n: int) -> None:
    twice = 2 * n
    total[0] += twice

def take(total: list[int], n: int) -> None:
    if n % 3:
        twice = total[0] // 2
        total[0] -= twice

def leave(total: list[int], n: int) -> None:
    if n % 2:
        return
    total[0] += 1

def other_names(sum: list[int], n: int) -> None:
    sum[0] *= 3

def shares_a_name(total: list[int], n: int) -> None:
    seen = n
    total[0] += seen

STEPS = (add, take, add)
EARLY = (add, leave)
NAMED = (add, other_names)
SHARED = (shares_a_name,)
NUMBERS = (1, 2)

def run(total: list[int], n: int) -> int:
    seen = 0
    if n > 1:
        for step in STEPS:
            step(total, n)
    else:
        for step in EARLY:
            step(total, n)
        for step in NAMED:
            step(total, n)
    for step in SHARED:
        step(total, n)
    for number in NUMBERS:
        seen += number
    return total[0] + seen
"""


def test_merged_steps_do_the_same_without_being_called(written: Any) -> None:
    merged, plain = written(SOURCE), written(SOURCE)
    merge_steps(merged.run)
    for n in range(12):
        totals = [n], [n]
        assert merged.run(totals[0], n) == plain.run(totals[1], n)
        assert totals[0] == totals[1]
    names = merged.run.__code__.co_names
    assert "STEPS" not in names
    assert {"EARLY", "NAMED", "SHARED", "NUMBERS"} <= set(names)


def test_lines_of_merged_steps_stay_theirs(written: Any) -> None:
    module = written(SOURCE)
    merge_steps(module.run)
    with pytest.raises(TypeError) as caught:
        module.run(None, 2)
    assert caught.traceback[-1].lineno == SOURCE.splitlines().index("    total[0] += twice")


def test_function_without_steps_stays_as_it_is(written: Any) -> None:
    module = written(SOURCE)
    before = module.add.__code__
    merge_steps(module.add)
    assert module.add.__code__ is before


@pytest.mark.parametrize("merges", [False, True])
def test_plain_kernel_is_merged_unless_switched_off(
    written: Any, monkeypatch: pytest.MonkeyPatch, merges: bool
) -> None:
    monkeypatch.setattr("achse.native.compiled.merges", merges)
    module = written(SOURCE)
    plain = Kernel("steps", module.run, {}).plain
    assert plain([1], 2) == 12
    assert ("STEPS" in plain.__code__.co_names) is not merges


@pytest.mark.parametrize("names", [*permutations(("__annotate__", "run"))])
def test_the_code_of_a_function_is_found_beside_that_of_its_annotations(
    names: tuple[str, ...],
) -> None:
    module = compile("".join(f"def {name}():\n pass\n" for name in names), "m", "exec")
    assert _code_named(module, "run").co_name == "run"
