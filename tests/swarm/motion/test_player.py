"""Worlds of motion alone: they hold, are determined by their seed, and show what is wrong."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from achse.motion.setpoints import planning
from achse.swarm.motion import player
from achse.swarm.play import play, play_twice
from achse.swarm.worlds.motion import draw_motion_world
from achse.swarm.worlds.world import World

SECOND = 1_000_000_000
FIRST = 7000


def short(seed: int, acts: int = 60) -> World:
    """The begin of a world, so that plain Python plays it at once too."""
    world = draw_motion_world(seed)
    left = list(world.acts)[:acts]
    length = min(world.length_ns, SECOND + max((act.at_ns for act in left), default=0))
    return replace(world, acts=left, length_ns=min(length, 5 * SECOND))


def test_drawn_motion_keeps_the_invariants(many: Callable[[int], int]) -> None:
    moves = 0
    for seed in range(FIRST, FIRST + many(20)):
        outcome = play(short(seed, many(60)))
        assert outcome.violation is None, (seed, outcome.violation)
        moves += outcome.moves
    assert moves > 100


def test_equal_worlds_have_equal_digests_in_both_kernels() -> None:
    seed = next(seed for seed in range(100) if draw_motion_world(seed).channel is None)
    world = replace(short(seed), length_ns=SECOND // 4)
    outcome = play_twice(world)
    assert outcome.violation is None
    assert play(world).digest == outcome.digest
    assert outcome.station_s == pytest.approx(0.25, abs=0.004)


def test_move_that_is_too_fast_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = planning._plan_to_target
    monkeypatch.setattr(planning, "_plan_to_target", lambda ax, v, end: plan(ax, 1.05 * v, end))
    for seed in range(FIRST, FIRST + 20):
        outcome = play(replace(short(seed), channel=None), code="plain")
        if outcome.violation is not None:
            break
    assert outcome.violation is not None
    assert outcome.violation.invariant in ("velocity", "jerk", "position")


def test_code_that_is_in_no_table_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(player, "_CODES", frozenset())
    violations = {play(short(seed)).violation for seed in range(FIRST, FIRST + 8)} - {None}
    assert {each.invariant for each in violations if each is not None} == {"known-codes"}
