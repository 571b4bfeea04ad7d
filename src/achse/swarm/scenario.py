"""One seed of the swarm as a scenario of `achse.sweeps`: workers play it, and give its figures."""

import time
from pathlib import Path
from typing import Any

from achse.swarm.excuses import EXCUSES
from achse.swarm.motion.kernel import CYCLES
from achse.swarm.outcome import WorldOutcome
from achse.swarm.plans.player import play_plans
from achse.swarm.play import play, play_twice
from achse.swarm.project import draw_project_world, load_checks
from achse.swarm.track import Track
from achse.swarm.worlds.drawing import draw_world
from achse.swarm.worlds.draws import SEEDS
from achse.swarm.worlds.motion import draw_motion_world
from achse.swarm.worlds.world import World

TWICE_EVERY = 16
"""Of so many seeds one is played in both kernels."""

MOTION_TWICE_EVERY = 1024
"""The same of worlds of motion alone, which plain Python plays a hundred times slower."""


def world_of(seed: int, project: str = "", *, motion: bool = False) -> World:
    """Return the world of a seed: motion alone, the station of a project, or a drawn one."""
    if motion:
        return draw_motion_world(seed)
    return draw_project_world(seed, Path(project)) if project else draw_world(seed)


def play_seed(
    seed: int,
    project: str = "",
    invariants: str = "",
    *,
    motion: bool = False,
    track: Track | None = None,
) -> WorldOutcome:
    """Play the world of a seed, in both kernels if its number says so; with a track in one."""
    world = world_of(seed, project, motion=motion)
    if motion:
        if seed % MOTION_TWICE_EVERY == 0 and CYCLES.available and track is None:
            return play_twice(world)
        code = "machine" if CYCLES.available else "plain"
        return play(world, code=code, track=track)
    checks = load_checks(Path(invariants)) if invariants else ()
    if project:
        return play(world, checks=checks, track=track)
    if seed % TWICE_EVERY == 0 and track is None:
        return play_twice(world)
    return play(world, track=track)


def run(
    *,
    first: int,
    project: str,
    invariants: str,
    seed: int,
    motion: bool = False,
    plans: bool = False,
) -> dict[str, Any]:
    """Return the figures of seed number `seed` from `first` on."""
    number = (first + seed) % SEEDS
    if plans:
        begin = time.process_time()
        outcome = play_plans(number)
        outcome.cpu_s = time.process_time() - begin
    else:
        outcome = play_seed(number, project, invariants, motion=motion)
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
