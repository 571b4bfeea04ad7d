"""Faults that are planted on purpose, each as defects of reviews were: the swarm finds them.

`python -m tests.swarm.planted` says for each after how many CPU seconds.
"""

import random
import statistics
from collections.abc import Callable
from typing import Any

import pytest

from achse.ams import Command
from achse.motion.commands import stops
from achse.motion.couplings import cam_checks, cams, linear
from achse.motion.couplings import table as coupling_table
from achse.motion.couplings.flying_saws import flying_saw, synchronising
from achse.motion.setpoints import planning
from achse.router import Router
from achse.server.handles import HandleTable
from achse.server.notifications import Notifications
from achse.station.persistence.state_file import StateFile
from achse.station.running import states
from achse.swarm.outcome import WorldOutcome
from achse.swarm.play import play, play_twice
from achse.swarm.worlds.drawing import draw_world
from achse.transport.connections.peer import Peer
from achse.transport.connections.send_budget import SendBudget

__all__ = ["PLANTED", "search"]

Patch = pytest.MonkeyPatch


def _around(patch: Patch, where: Any, name: str, wrap: Callable[..., Any]) -> None:
    """Let `wrap(original, *arguments)` be called instead of a function."""
    original = getattr(where, name)
    patch.setattr(where, name, lambda *arguments, **named: wrap(original, *arguments, **named))


def halt_that_accelerates(patch: Patch) -> None:
    def begin_stop(original: Any, axis: Any, deceleration: float, jerk: float) -> None:
        original(axis, deceleration, jerk)
        axis.set.acceleration += 0.5 * deceleration * (1.0 if axis.set_velocity >= 0.0 else -1.0)

    _around(patch, stops, "begin_stop", begin_stop)


def move_too_fast(patch: Patch) -> None:
    _around(
        patch, planning, "_plan_to_target", lambda plan, ax, limit, end: plan(ax, 1.05 * limit, end)
    )


def acceleration_too_strong(patch: Patch) -> None:
    def to_position(plan: Any, *numbers: float) -> int:
        *rest, acceleration, deceleration, jerk = numbers
        return int(plan(*rest, 1.05 * acceleration, deceleration, jerk))

    _around(patch, planning, "plan_to_position", to_position)


def deceleration_too_strong(patch: Patch) -> None:
    def to_position(plan: Any, *numbers: float) -> int:
        *rest, acceleration, deceleration, jerk = numbers
        return int(plan(*rest, acceleration, 1.05 * deceleration, jerk))

    _around(patch, planning, "plan_to_position", to_position)


def jerk_too_strong(patch: Patch) -> None:
    def to_position(plan: Any, *numbers: float) -> int:
        return int(plan(*numbers[:-1], 1.5 * numbers[-1]))

    _around(patch, planning, "plan_to_position", to_position)


def gear_with_another_ratio(patch: Patch) -> None:
    _around(patch, linear, "leading_position", lambda find, *arguments: 1.001 * find(*arguments))


def gear_with_another_velocity(patch: Patch) -> None:
    _around(patch, linear, "leading_velocity", lambda find, *arguments: 1.2 * find(*arguments))


def saw_with_any_gear(patch: Patch) -> None:
    for law in (flying_saw, synchronising):
        patch.setattr(law, "check_gear", lambda *arguments: 0)


def cam_exchange_that_jumps(patch: Patch) -> None:
    for where in (cam_checks, cams, coupling_table):
        patch.setattr(where, "check_step", lambda *_: 0)


def _every(patch: Patch, number: int, which: Callable[[Any], bool], instead: Any) -> None:
    """Do something else with each so-many-th frame for a peer."""
    count = 0

    def deliver(original: Any, peer: Peer, frame: Any) -> bool:
        nonlocal count
        if which(frame):
            count += 1
            if count % number == 0:
                return bool(instead(original, peer, frame))
        return bool(original(peer, frame))

    original = Peer.deliver
    patch.setattr(Peer, "deliver", lambda peer, frame: deliver(original, peer, frame))


def _is_sample(frame: Any) -> bool:
    return bool(frame.command == Command.NOTIFICATION)


def _is_answer(frame: Any) -> bool:
    return bool(frame.flags & 1)


def _twice(deliver: Any, peer: Peer, frame: Any) -> bool:
    deliver(peer, frame)
    return bool(deliver(peer, frame))


def notification_lost(patch: Patch) -> None:
    _every(patch, 30, _is_sample, lambda deliver, peer, frame: True)


def notification_twice(patch: Patch) -> None:
    _every(patch, 30, _is_sample, _twice)


def answer_lost(patch: Patch) -> None:
    _every(patch, 30, _is_answer, lambda deliver, peer, frame: True)


def answer_twice(patch: Patch) -> None:
    _every(patch, 30, _is_answer, _twice)


def answer_to_another(patch: Patch) -> None:
    def elsewhere(deliver: Any, peer: Peer, frame: Any) -> bool:
        others = [each for each in peer.owner.connections if each is not peer]  # type: ignore[attr-defined]
        return bool(deliver(others[0] if others else peer, frame))

    _every(patch, 10, _is_answer, elsewhere)


def subscriptions_of_a_closed_connection_kept(patch: Patch) -> None:
    patch.setattr(Notifications, "end_way", lambda *_: None)
    patch.setattr(Notifications, "end_client", lambda *_: None)


def handles_of_a_closed_connection_kept(patch: Patch) -> None:
    patch.setattr(HandleTable, "abandon_way", lambda *_: None)
    patch.setattr(HandleTable, "abandon_client", lambda *_: None)


def clients_kept_by_the_router(patch: Patch) -> None:
    patch.setattr(Router, "forget", lambda *_: None)


def ports_kept_by_the_router(patch: Patch) -> None:
    patch.setattr(Router, "unregister", lambda *_: None)


def bytes_of_a_closed_connection_counted(patch: Patch) -> None:
    _around(
        patch, SendBudget, "count", lambda count, budget, peer, size: count(budget, peer, size or 1)
    )


def leak_after_a_restart(patch: Patch) -> None:
    stations: list[Any] = []

    def assemble(original: Any, *arguments: Any) -> Any:
        stations.append(original(*arguments))
        return stations[-1]

    _around(patch, states, "assemble", assemble)


def saved_before_it_is_written(patch: Patch) -> None:
    patch.setattr(StateFile, "write", lambda *_: None)


def saved_in_place(patch: Patch) -> None:
    def write(file: Any, text: str) -> None:
        file._port.create(file.path, text.encode())

    patch.setattr(StateFile, "write", write)


def exception_in_a_device(patch: Patch) -> None:
    def find(original: Any, table: Any, number: int) -> Any:
        if number not in table.valid:
            raise KeyError(number)
        return original(table, number)

    _around(patch, HandleTable, "find", find)


def answer_that_is_drawn(patch: Patch) -> None:
    dice = random.Random()
    _around(
        patch,
        Router,
        "_free_port",
        lambda find, router: (
            find(router) if dice.random() < 0.5 else dice.randrange(33_000, 60_000)
        ),
    )


PLANTED: dict[str, Callable[[Patch], None]] = {
    each.__name__: each
    for each in (
        halt_that_accelerates,
        move_too_fast,
        acceleration_too_strong,
        deceleration_too_strong,
        jerk_too_strong,
        gear_with_another_ratio,
        saw_with_any_gear,
        gear_with_another_velocity,
        cam_exchange_that_jumps,
        notification_lost,
        notification_twice,
        answer_lost,
        answer_twice,
        answer_to_another,
        subscriptions_of_a_closed_connection_kept,
        handles_of_a_closed_connection_kept,
        clients_kept_by_the_router,
        ports_kept_by_the_router,
        bytes_of_a_closed_connection_counted,
        leak_after_a_restart,
        saved_before_it_is_written,
        saved_in_place,
        exception_in_a_device,
        answer_that_is_drawn,
    )
}
"""Faults by name."""


def search(plant: Callable[[Patch], None], seeds: range) -> tuple[int, WorldOutcome, float]:
    """Play seeds until one fails: its number, its end, and CPU seconds so far."""
    used = 0.0
    with pytest.MonkeyPatch.context() as patch:
        plant(patch)
        for seed in seeds:
            world = draw_world(seed)
            if plant is answer_that_is_drawn:
                outcome = play_twice(world, ("plain", "plain"))
            else:
                outcome = play(world, code="plain")
            used += outcome.cpu_s
            if outcome.violation is not None:
                return seed, outcome, used
    raise AssertionError(f"{plant.__name__} is not found in {seeds}, {used:.1f} CPU seconds")


def _report() -> None:
    spent = []
    for name, plant in PLANTED.items():
        try:
            seed, outcome, used = search(plant, range(1000, 1200))
        except AssertionError as failure:
            print(failure, flush=True)
            continue
        spent.append(used)
        print(f"{used:7.2f} s  {name}, seed {seed}: {str(outcome.violation)[:110]}", flush=True)
    print(f"{len(spent)} of {len(PLANTED)}, median {statistics.median(spent):.2f} CPU seconds")


if __name__ == "__main__":
    _report()
