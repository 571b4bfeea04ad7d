"""Parameters as text, and every combination in order."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.sweeps import Run, SweepError, SweepParameter, SweepPlan


@pytest.mark.parametrize(
    ("text", "parameter"),
    [
        ("kv=1:50:3", SweepParameter("kv", (1.0, 25.5, 50.0))),
        ("kv=2:9:1", SweepParameter("kv", (2.0,))),
        ("kv=3:1:2", SweepParameter("kv", (3.0, 1.0))),
        ("mode=slow,fast", SweepParameter("mode", ("slow", "fast"))),
        ("n=1,2.5,true,x", SweepParameter("n", (1, 2.5, True, "x"))),
    ],
)
def test_parameters_as_text(text: str, parameter: SweepParameter) -> None:
    assert SweepParameter.parse(text) == parameter


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("kv", "name=from:to:count"),
        ("=1", "name=from:to:count"),
        ("k v=1", "name of an argument|that of an"),
        ("seed=1,2", "other than seed"),
        ("kv=a:b:3", "are numbers"),
        ("kv=1:2:0", "count is 1"),
        ("kv=1:inf:3", "finite"),
    ],
)
def test_parameters_that_cannot_be(text: str, message: str) -> None:
    with pytest.raises(SweepError, match=message):
        SweepParameter.parse(text)


@given(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6), st.integers(2, 300))
def test_both_ends_are_among_the_values(begin: float, end: float, count: int) -> None:
    values = SweepParameter.parse(f"x={begin!r}:{end!r}:{count}").values
    assert (values[0], values[-1], len(values)) == (begin, end, count)


def test_seeds_change_fastest() -> None:
    plan = SweepPlan([SweepParameter("a", (1, 2)), SweepParameter("b", ("x",))], 2)
    assert list(plan) == [
        Run(0, {"a": 1, "b": "x"}, 0),
        Run(1, {"a": 1, "b": "x"}, 1),
        Run(2, {"a": 2, "b": "x"}, 0),
        Run(3, {"a": 2, "b": "x"}, 1),
    ]
    assert len(plan) == 4
    assert list(SweepPlan()) == [Run(0, {}, 0)]


def test_plans_that_cannot_be() -> None:
    with pytest.raises(SweepError, match="each parameter once"):
        SweepPlan([SweepParameter("a", (1,)), SweepParameter("a", (2,))])
    with pytest.raises(SweepError, match="one seed at least"):
        SweepPlan(seeds=0)
    with pytest.raises(SweepError, match="10000000 runs at most"):
        SweepPlan([SweepParameter("a", tuple(range(1001)))], 10_000)
