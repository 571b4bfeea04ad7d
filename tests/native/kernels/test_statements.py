"""Statements: names, loops, ways out, and what is refused."""

from typing import Any

import pytest

from achse.native.kernels.arithmetic import TranslationError
from achse.native.kernels.translate import translate

COUNTING = """
def run(n: int) -> int:
    total = 0
    for i in range(n):
        if i == 3:
            continue
        if i == 8:
            break
        total += i
    for i in range(n, 0, -2):
        total = total * 2 + i
        i = 0
    for i in range(2, 5):
        total -= i
    last = i
    while total > 1000:
        total //= 3
        if total % 5 == 0:
            break
    return total + last
"""
NAMES = """
def two(a: float, b: float) -> tuple[float, int]:
    a, b = b, a
    return a, int(b)

def pair(limits: tuple[float, float]) -> float:
    low, high = limits
    return high - limits[0]

def run(a: float, b: float) -> float:
    x = 0
    y: float = a
    if a > 1.0:
        x = 2.5
        y *= x
    elif b > 1.0:
        y = -y
    else:
        pass
    c = d = two(y, b)[0]
    first, second = two(c, d)
    both = (first, x)
    both = (x, first)
    limits = (both[1], 3)
    unused: int
    return first + second + both[0] + pair(limits) + shifted(a, by=b) + shifted(a)

def shifted(a: float, by: float = 0.5) -> float:
    \"\"\"Documented.\"\"\"
    return a + by

def nothing(a: float) -> None:
    if a:
        return
    return None
"""
TABLE = """
from typing import NamedTuple, Callable


class Row(NamedTuple):
    numbers: tuple[int, ...]
    share: float
    work: Callable[[float, float], float]


def grow(a: float, share: float) -> float:
    return a + share


def shrink(a: float, share: float) -> float:
    return a - 2.0 * share


ROWS = (Row((1, 2), 0.5, grow), Row((3,), 0.25, shrink), Row((4, 5), 0.125, grow))


def first(a: float, n: int) -> float:
    for row in ROWS:
        if n in row.numbers:
            return row.work(a, row.share)
    return a


def some(a: float, n: int) -> float:
    for row in ROWS:
        if row.share < 0.2:
            break
        if n == 3:
            continue
        a = row.work(a, row.share)
    for row in ROWS:
        a += row.share
    return a


def always(a: float, n: int) -> float:
    for row in ROWS:
        return row.work(a, row.share)
    return a
"""
OUTSIDE = {
    "    with a:\n        pass": "With",
    "    for i in (1, 2):\n        pass": "goes through a table",
    "    for i in range(0, 9, n):\n        pass": "constant", "    raise ValueError": "Raise",
    "    x = 1\n    x = (1, 2)": "x holds values", "    del a": "Delete",
    "    x, y = 1, 2, 3": "2 values expected", "    a[0] = 1": "not a sequence",
    "    while a:\n        pass\n    else:\n        pass": "While",
    "    return (1, 2)": "a tuple where",
    "    x += 1": "x has no value yet", "    f(a)": "f takes a, n",
    "    f(a, 1, m=2)": "argument m",
    "    f(a, 1.5)": "a float where a whole number belongs", "    *x, y = 1, 2": "cannot assign",
    "    [x][0] = a": "List", "    g = lambda: 1": "Lambda",
}  # fmt: skip


def test_loops_and_their_ends(written: Any, compiled: Any) -> None:
    module = written(COUNTING)
    run = compiled(module.run)
    for n in (1, 3, 5, 7, 20, 33):
        assert run(n) == module.run(n)


def test_names_and_tuples(written: Any, compiled: Any) -> None:
    module = written(NAMES)
    run = compiled(module.run)
    for a, b in ((2.0, 3.25), (0.5, 2.0), (0.5, 0.25), (-7.0, 9.0)):
        assert run(a, b) == module.run(a, b)
    assert compiled(module.nothing)(1.0) is None


@pytest.mark.parametrize("name", ["first", "some", "always"])
def test_a_loop_goes_through_the_rows_of_a_table(written: Any, compiled: Any, name: str) -> None:
    function = getattr(written(TABLE), name)
    run = compiled(function)
    for n in range(7):
        assert run(1.5, n) == function(1.5, n)


@pytest.mark.parametrize(("text", "reason"), OUTSIDE.items())
def test_what_the_language_lacks_is_named(written: Any, text: str, reason: str) -> None:
    module = written(f"def f(a: float, n: int) -> float:\n{text}\n    return a\n")
    with pytest.raises(TranslationError, match=reason):
        translate(module.f, {})
