"""One seed of the swarm as a scenario of `achse.sweeps`: workers play it, and give its figures."""

from pathlib import Path
from typing import Any

from achse.swarm.excuses import EXCUSES
from achse.swarm.play import WorldOutcome, play, play_twice
from achse.swarm.project import draw_project_world, load_checks
from achse.swarm.worlds.drawing import draw_world
from achse.swarm.worlds.draws import SEEDS
from achse.swarm.worlds.world import World

__all__ = ["TWICE_EVERY", "play_seed", "run", "world_of"]

TWICE_EVERY = 16
"""Of so many seeds one is played in both kernels."""


def world_of(seed: int, project: str = "") -> World:
    """Return the world of a seed, with the station of a project if there is one."""
    return draw_project_world(seed, Path(project)) if project else draw_world(seed)


def play_seed(seed: int, project: str = "", invariants: str = "") -> WorldOutcome:
    """Play the world of a seed."""
    world = world_of(seed, project)
    checks = load_checks(Path(invariants)) if invariants else ()
    if project:
        return play(world, checks=checks)
    return play_twice(world) if seed % TWICE_EVERY == 0 else play(world)


def run(*, first: int, project: str, invariants: str, seed: int) -> dict[str, Any]:
    """Return the figures of seed number `seed` from `first` on."""
    number = (first + seed) % SEEDS
    outcome = play_seed(number, project, invariants)
    violation = outcome.violation
    return {
        "world": str(number),  # beyond 63 bits no column holds it
        "invariant": "" if violation is None else violation.invariant,
        "what": "" if violation is None else violation.what,
        "digest": outcome.digest,
        "station_s": outcome.station_s,
        "cycles": outcome.cycles,
        "moves": outcome.moves,
        "requests": outcome.requests,
        "samples": outcome.samples,
        "cpu_s": round(outcome.cpu_s, 4),
        **{name: outcome.excuses[name] for name in EXCUSES},
    }
