"""Worlds that are played: they hold, they are determined by their seed, and they end well."""

import logging
from itertools import count, islice

import pytest

from achse.swarm.outcome import BrokenInvariant
from achse.swarm.play import play, play_twice
from achse.swarm.worlds.drawing import draw_world
from achse.swarm.worlds.world import STATION, Act, DrawnClient, World

SHORT = list(islice((seed for seed in count() if len(draw_world(seed).acts) < 60), 3))
"""Seeds of small worlds. One of eight is tried for memory that stays: the first."""


def test_worlds_hold_and_equal_seeds_have_equal_digests_in_both_kernels() -> None:
    flat, tiny, busy = map(draw_world, SHORT)
    assert play(flat).violation is None
    once, again = play(tiny), play_twice(tiny)
    assert again.violation is None
    assert once.digest == again.digest
    outcome = play_twice(busy)
    assert outcome.violation is None
    assert outcome.requests > 0


def test_exception_of_a_station_is_a_violation(monkeypatch: pytest.MonkeyPatch) -> None:
    acts = [Act(1_000_000, STATION, "online_change", [0])]
    world = World(1, 10_000_000, 2_000_000, acts=acts)
    violation = play(world).violation  # a world without a program
    assert violation is not None
    assert violation.invariant == "no-traceback"


def test_logged_traceback_is_a_violation() -> None:
    def check(_: object) -> None:
        try:
            raise KeyError("planted")
        except KeyError:
            logging.getLogger("achse.test").exception("planted")

    world = World(2, 100_000_000, 2_000_000, draw_world(1).axes[:1])
    violation = play(world, checks=[("planted", check)]).violation
    assert violation is not None
    assert "planted" in str(violation)


def test_check_of_a_user_is_a_violation_when_it_returns_a_reason() -> None:
    world = World(2, 100_000_000, 2_000_000, draw_world(1).axes[:1])
    assert play(world, checks=[("mine", lambda station: None)]).violation is None
    violation = play(world, checks=[("mine", lambda station: "wrong")]).violation
    assert violation is not None
    assert violation == BrokenInvariant("mine", violation.what)
    assert "wrong" in violation.what


@pytest.mark.parametrize("after", [1, 40, 300, 1_000_000])
def test_saved_value_survives_a_kill_and_a_power_cut(after: int) -> None:
    second = 1_000_000_000
    acts = [
        Act(0, 0, "dial"),
        Act(second // 10, 0, "handle", [1]),
        Act(second // 2, 0, "use", [0, 77]),
        Act(second, STATION, "save"),
        Act(2 * second, 0, "use", [0, 99]),
        Act(3 * second, STATION, "cut", [after]),
        Act(4 * second, STATION, "kill"),
    ]
    programs = draw_world(1).programs
    client = DrawnClient("watch", 0, 0, True)
    world = World(
        2, 5 * second, 2_000_000, draw_world(1).axes[:1], (), programs, [client], {}, acts
    )
    assert play(world).violation is None
