"""Routers of a world: clients reach the station through them, whatever is cut or killed."""

import random
from collections.abc import Callable
from operator import itemgetter
from types import SimpleNamespace
from typing import Any

import pytest

from achse.router.forwarding.forwarding import Forwarding
from achse.router.forwarding.sessions import Sessions
from achse.server.handles import HandleTable
from achse.swarm.play import play
from achse.swarm.routers import RouterScheduler
from achse.swarm.worlds.drawing import draw_world
from achse.swarm.worlds.draws import Stream
from achse.swarm.worlds.program import draw_programs
from achse.swarm.worlds.world import STATION, Act, DrawnClient, DrawnRouter, World

SECOND = 1_000_000_000

PROGRAMS = draw_programs(Stream(1, "programs")) or draw_programs(Stream(2, "programs"))


def world_of(acts: list[Act], *, resubscribe: bool = True, behind: int = -1) -> World:
    """Two clients with one address behind the last of two routers, and one at the station."""
    routers = [DrawnRouter(1_000_000, 0, resubscribe), DrawnRouter(100_000, 7, resubscribe, behind)]
    clients = [DrawnClient("watch", 1_000_000, 0, False, router) for router in (1, 1, -1)]
    first: list[tuple[str, list[Any]]] = [
        ("dial", []),
        ("handle", [1]),
        ("subscribe", [0, True, 20_000_000, 0]),
        ("subscribe_axis", [1, True, 20_000_000, 0]),
        ("use", [0, None]),
    ]
    begin = [
        Act(at * SECOND // 10, client, kind, values)
        for client in range(3)
        for at, (kind, values) in enumerate(first)
    ]
    axes = draw_world(1).axes[:1]
    all_acts = sorted([*begin, *acts], key=lambda act: act.at_ns)
    return World(
        *(3, 5 * SECOND // 2, 2_000_000, axes, (), PROGRAMS, clients, {"abandoned_handles": 1000}),
        acts=all_acts,
        routers=routers,
    )


@pytest.mark.parametrize("behind", [-1, 0])
def test_clients_behind_routers_get_answers_and_samples(behind: int) -> None:
    outcome = play(world_of([], behind=behind))
    assert outcome.violation is None
    assert outcome.answers >= 12
    assert outcome.samples > 3 * 2 * 80
    assert not outcome.excuses["sample_gap"]


@pytest.mark.parametrize("kind", ["router_cut", "router_kill", "router_restart", "kill"])
@pytest.mark.parametrize("resubscribe", [True, False])
def test_what_happens_to_a_router_holds(kind: str, resubscribe: bool) -> None:
    values = [] if kind == "kill" else [0, 300_000_000]
    acts = [
        Act(SECOND, 0, "handle", [2]),
        Act(SECOND, STATION, kind, values),
        *(Act(3 * SECOND // 2, client, "dial") for client in range(3)),
        *(Act(3 * SECOND // 2, client, "handle", [1]) for client in range(3)),
        Act(2 * SECOND, STATION, "router_kill", [1, 100_000_000]),
    ]
    world = world_of(acts, resubscribe=resubscribe, behind=0)
    outcome = play(world)
    assert outcome.violation is None
    if kind == "router_kill":
        assert play(world).digest == outcome.digest


def test_router_notices_that_the_router_before_it_was_killed() -> None:
    acts = [
        Act(SECOND, STATION, "router_kill", [0, 1_000_000]),
        *(Act(3 * SECOND // 2, 0, "use", [0, None]) for _ in range(3)),
    ]
    assert play(world_of(acts, behind=0)).violation is None


def test_subscription_goes_on_behind_a_cut() -> None:
    acts = [Act(SECOND, STATION, "router_cut", [1, 0])]
    samples = play(world_of(acts)).samples
    ended = play(world_of(acts, resubscribe=False)).samples
    assert samples > ended + 100


def test_router_that_forgets_a_release_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Forwarding, "_give_back", lambda *_: None)
    violation = play(world_of([])).violation
    assert violation is not None
    assert violation.invariant == "released"


def test_router_that_leaves_handles_of_a_kill_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Forwarding, "release_orphans", lambda self, done: done())
    monkeypatch.setattr(HandleTable, "release_abandoned", lambda *_: None)
    acts = [Act(SECOND, STATION, "router_kill", [1, 100_000_000])]
    violation = play(world_of(acts)).violation
    assert violation is not None
    assert violation.invariant == "released"


def test_router_that_mixes_up_its_clients_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    def alias_of(self: Sessions, client: object, alias: bytes, own: bool = True) -> bytes:
        return bytes(alias)

    monkeypatch.setattr(Sessions, "_free_alias", alias_of)
    violation = play(world_of([])).violation
    assert violation is not None
    assert violation.invariant in ("samples-to-subscriber", "answered-once")


def test_world_with_routers_is_kept_as_text() -> None:
    world = world_of([Act(SECOND, STATION, "router_kill", [0, 1])])
    assert World.decode(world.encode()).routers == world.routers
    assert World.decode(world.encode()).encode() == world.encode()


def test_each_moment_of_a_router_takes_one_step() -> None:
    """World 8000628: each step armed a further one, and the world never ended."""
    steps: list[tuple[int, Callable[..., None], Any]] = []
    life: Any = SimpleNamespace(begun_ns=0, time_ns=0, now_ns=lambda: life.time_ns)
    life.scheduler = SimpleNamespace(call_at_ns=lambda *call: steps.append(call))
    scheduler, done = RouterScheduler(life), list[int]()
    dice = random.Random(3)
    moments = [dice.randrange(1, 1000) for _ in range(300)]
    for moment in moments:
        scheduler.call_at_ns(moment, done.append, moment)
    count = 0
    while steps:
        due = min(steps, key=itemgetter(0))
        steps.remove(due)
        life.time_ns = due[0]
        due[1](*due[2:])
        count += 1
    assert done == sorted(moments)
    assert count <= 2 * len(moments)
