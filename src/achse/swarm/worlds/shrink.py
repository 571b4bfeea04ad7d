"""Make a failing world small: fewer acts, clients and axes, shorter, simpler, and still failing.

A smaller world counts if the same invariant does not hold in it. Parts are left out in halves,
quarters and so on (delta debugging), until none can be left out, or the budget is used up.
"""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import TypeVar

from achse.swarm.worlds.routers import ROUTER_ACTS
from achse.swarm.worlds.world import STATION, Act, World

T = TypeVar("T")

_SETTLING_NS = 1_000_000
"""Time that a shorter world has after its last act."""


def shrink(
    world: World,
    fails: Callable[[World], bool],
    *,
    budget_s: float = 60.0,
    clock: Callable[[], float] = time.process_time,
) -> World:
    """Return a small world that fails as `world` does, found within some seconds of `clock`."""
    end = clock() + budget_s

    def try_world(smaller: World) -> bool:
        return clock() < end and fails(smaller)

    before = None
    while before != world and clock() < end:
        before = world
        world = _fewer_clients(world, try_world)
        acts = _fewer(
            world.acts,
            partial(_fails_with, world, try_world),
        )
        world = replace(world, acts=acts)
        for simpler in _simpler(world):
            if try_world(simpler):
                world = simpler
    return world


def _fails_with(world: World, fails: Callable[[World], bool], acts: Sequence[Act]) -> bool:
    """Return True if a world fails with these acts."""
    return fails(replace(world, acts=tuple(acts)))


def _fewer(parts: Sequence[T], fails: Callable[[Sequence[T]], bool]) -> Sequence[T]:
    """Return as few of the parts as fail."""
    size = max(1, len(parts) // 2)
    while True:
        begin, removed = 0, False
        while begin < len(parts):
            rest = [*parts[:begin], *parts[begin + size :]]
            if fails(rest):
                parts, removed = rest, True
            else:
                begin += size
        if size == 1 and not removed:
            return parts
        size = max(1, size // 2)


def _fewer_clients(world: World, fails: Callable[[World], bool]) -> World:
    """Leave clients out, with all that they do."""
    for number in reversed(range(len(world.clients))):
        acts = [each for each in world.acts if each.actor != number]
        smaller = replace(world, acts=acts)
        if len(acts) < len(world.acts) and fails(smaller):
            world = smaller
    used = sorted({act.actor for act in world.acts} - {STATION})
    if len(used) < len(world.clients):
        numbers = {old: new for new, old in enumerate(used)} | {STATION: STATION}
        smaller = replace(
            world,
            clients=[world.clients[number] for number in used],
            acts=[replace(act, actor=numbers[act.actor]) for act in world.acts],
        )
        if fails(smaller):
            return smaller
    return world


def _simpler(world: World) -> Iterator[World]:
    """Yield worlds with a part that is simpler than in this one."""
    last = max((act.at_ns for act in world.acts), default=0)
    for length in (last + _SETTLING_NS, last + 100 * _SETTLING_NS, last + 1000 * _SETTLING_NS):
        if length < world.length_ns:
            yield replace(world, length_ns=length)
    if world.programs:
        yield replace(world, programs=())
        yield replace(world, programs=[replace(world.programs[0], statements=(), variables={})])
    if world.cams:
        yield replace(world, cams=world.cams[:-1])
    if len(world.axes) > 1:
        yield replace(world, axes=world.axes[:-1])
    yield from _fewer_routers(world)
    if world.limits:
        yield replace(world, limits={})
    for number, part in enumerate(world.clients):
        simple = replace(part, delay_ns=0, piece=0, registers=False)
        if simple != part:
            clients = [simple if n == number else each for n, each in enumerate(world.clients)]
            yield replace(world, clients=clients)
    for number, axis in enumerate(world.axes):
        values = {
            name: value
            for name, value in axis.values.items()
            if not name.startswith(("encoder_soft", "override", "rapid", "homing", "jog"))
        }
        if len(values) < len(axis.values):
            axes = [
                replace(each, values=values) if n == number else each
                for n, each in enumerate(world.axes)
            ]
            yield replace(world, axes=axes)
    yield from _earlier(world)


def _fewer_routers(world: World) -> Iterator[World]:
    """Yield the world without its last router, and with routers on fast links."""
    last = len(world.routers) - 1
    if last < 0:
        return
    yield replace(
        world,
        routers=world.routers[:-1],
        clients=[replace(each, router=min(each.router, last - 1)) for each in world.clients],
        acts=[act for act in world.acts if act.kind not in ROUTER_ACTS or act.values[0] != last],
    )
    simple = [replace(each, delay_ns=0, piece=0, behind=-1) for each in world.routers]
    if simple != list(world.routers):
        yield replace(world, routers=simple)


def _earlier(world: World) -> Iterator[World]:
    """Yield worlds in which a gap between two acts is shorter."""
    for number in range(len(world.acts)):
        before = world.acts[number - 1].at_ns if number else 0
        gap = world.acts[number].at_ns - before
        if gap < 10_000_000:
            continue
        for less in (gap, gap // 2):
            moved: list[Act] = [
                replace(act, at_ns=act.at_ns - less) if n >= number else act
                for n, act in enumerate(world.acts)
            ]
            yield replace(world, acts=moved, length_ns=world.length_ns - less)
