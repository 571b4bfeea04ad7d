"""`achse swarm` draws worlds from seeds, runs them in virtual time, and checks what must hold."""

import os
import sys
import webbrowser
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.failure import fail
from achse.cli.interrupts import ending
from achse.cli.output import on_terminal, print_json
from achse.cli.target import Json

if TYPE_CHECKING:
    from achse.swarm.campaign import Campaign, FailedSeed
    from achse.swarm.outcome import BrokenInvariant
    from achse.swarm.worlds.world import Act

_RUNS = 10
_SHRINKING_S = 120.0
_MOST_PLAYED = 100_000


@dataclass(frozen=True)
class _Names:
    """Subject of the seeds: files of a user, motion alone, or plans without cycles."""

    project: str
    invariants: str
    motion: bool
    plans: bool

    def failure_lines(self, seed: int, broken: "BrokenInvariant") -> list[str]:
        from achse.swarm.report import failure_lines

        return failure_lines(
            *(seed, broken, self.project, self.invariants), motion=self.motion, plans=self.plans
        )


def register(app: typer.Typer) -> None:
    """Add the command to `app`."""
    app.command()(swarm)


def swarm(
    project: Annotated[
        Path | None,
        typer.Argument(
            help="A station.toml or its folder: that station in drawn worlds.", show_default=False
        ),
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option(min=0, max=(1 << 64) - 1, help="The first seed.", show_default="any"),
    ] = None,
    runs: Annotated[
        int | None, typer.Option(min=1, help="Seeds to run.", show_default=str(_RUNS))
    ] = None,
    cpu: Annotated[
        float | None,
        typer.Option("--for", min=0, metavar="SECONDS", help="CPU seconds to spend instead."),
    ] = None,
    workers: Annotated[
        int, typer.Option(min=0, help="Processes; 0: this one.", show_default=True)
    ] = 0,
    invariants: Annotated[
        Path | None,
        typer.Option(help="File .py with functions check_…(station), or .st.", show_default=False),
    ] = None,
    motion: Annotated[
        bool,
        typer.Option(
            "--motion", help="Axes, couplings, cams and channels alone, without a station."
        ),
    ] = False,
    plans: Annotated[
        bool,
        typer.Option("--plans", help="Plan and check moves alone, without cycles: millions each."),
    ] = False,
    replay: Annotated[
        bool, typer.Option("--replay", help="Run one seed, and print its acts and its end.")
    ] = False,
    scope: Annotated[
        bool,
        typer.Option("--scope", help="With --replay: write its set points as a page, and open it."),
    ] = False,
    keep: Annotated[
        Path | None,
        typer.Option(
            help="Write a small world that fails as a test in Python.", show_default=False
        ),
    ] = None,
    rows: Annotated[
        bool,
        typer.Option("--rows", help="Print a line for each seed as it ends, and the excuses."),
    ] = False,
    in_json: Json = False,
) -> None:
    """Run stations in random worlds, and check what must hold in each.

    Ctrl-C ends it after the seed that runs, with the sums so far; a second one ends it at once.
    """
    import secrets

    from achse.station import ConfigError
    from achse.swarm.excuses import excuse_rows
    from achse.swarm.worlds.world import WorldError

    first = secrets.randbits(64) if seed is None else seed
    if (motion or plans) and (project is not None or invariants is not None):
        own = "--motion" if motion else "--plans"
        fail(f"{own} draws its own axes: expected no project and no --invariants")
    if plans and (motion or scope or keep is not None):
        fail("--plans has no cycles: expected no --motion, --scope or --keep")
    if scope and not replay:
        fail("--scope needs --replay")
    names = _Names(
        "" if project is None else str(project.resolve()),
        "" if invariants is None else str(invariants.resolve()),
        motion,
        plans,
    )
    signals: list[int] = []

    def end(number: int) -> None:
        if signals:
            os._exit(128 + number)
        signals.append(number)

    try:
        if replay:
            _replay(first, names, scope=scope)
        with ending(end) if not workers else nullcontext():
            campaign = _campaign(
                *(first, runs, cpu, workers, names),
                quiet=in_json,
                rows=rows and not in_json,
                stopped=lambda: bool(signals),
            )
    except (WorldError, ConfigError) as fault:
        fail(str(fault))
    except OSError as failure:
        fail(f"{failure.filename}: {failure.strerror or failure}")
    if in_json:
        print_json({"first": first, **campaign.facts()})
    else:
        print(
            f"{campaign.seeds} seeds from {first}, {len(campaign.failures)} failed;"
            f" {campaign.machine_years:.3g} machine-years in {campaign.cpu_s:.1f} CPU seconds"
            f" ({campaign.machine_years_per_cpu_hour:.3g} in a CPU hour),"
            f" {campaign.moves} moves ({campaign.moves_per_cpu_hour:.3g} in a CPU hour),"
            f" {campaign.requests} requests, {campaign.samples} samples"
        )
        if rows:
            print("\n".join(excuse_rows(campaign.excuses)))
    if campaign.failures:
        if keep is not None:
            _keep(keep, campaign.failures[0], names)
        raise typer.Exit(1)
    if signals:
        raise typer.Exit(128 + signals[0])


def _campaign(
    first: int,
    runs: int | None,
    cpu: float | None,
    workers: int,
    names: _Names,
    *,
    quiet: bool,
    rows: bool,
    stopped: Callable[[], bool],
) -> "Campaign":
    from achse.swarm.campaign import Campaign, seed_line, seeds_one_by_one

    campaign = Campaign()
    if runs is None and cpu is None:
        runs = _RUNS
    played: Any
    if workers:
        if runs is None:
            fail("--workers needs --runs")
        played = _played_by_workers(first, min(runs, _MOST_PLAYED), workers, names)
    else:
        played = seeds_one_by_one(
            *(first, runs, cpu, names.project, names.invariants, names.motion, names.plans),
            stopped=stopped,
        )
    for row in played:
        failure = campaign.add(row)
        if rows:
            print(seed_line(row), flush=True)
        if failure is not None and not quiet:
            _report(failure, names)
            sys.stdout.flush()
    return campaign


def _report(failure: "FailedSeed", names: _Names) -> None:
    from achse.swarm.outcome import BrokenInvariant

    broken = BrokenInvariant(failure.invariant, failure.what)
    for line in names.failure_lines(failure.seed, broken):
        print(line)


def _played_by_workers(first: int, runs: int, workers: int, names: _Names) -> Any:
    """Return the figures of all seeds, in the order of the seeds."""
    import achse.swarm.scenario as scenario
    from achse.sweeps import SweepError, sweep

    sys.warnoptions.append("ignore:resource_tracker:UserWarning")
    parameters: dict[str, list[int | str]] = {
        "first": [first],
        "project": [names.project],
        "invariants": [names.invariants],
        "motion": [int(names.motion)],
        "plans": [int(names.plans)],
    }
    try:
        return sweep(scenario.__file__, parameters, seeds=runs, workers=workers).rows
    except SweepError as fault:
        fail(str(fault))


def _replay(seed: int, names: _Names, *, scope: bool) -> None:
    """Play one seed, and print what happens in it."""
    from achse.swarm.scenario import play_seed, world_of
    from achse.swarm.track import Track

    if names.plans:
        _replay_plans(seed, names)
    world = world_of(seed, names.project, motion=names.motion)
    track = Track() if scope else None
    outcome = play_seed(seed, names.project, names.invariants, motion=names.motion, track=track)
    acts = [_act_line(act) for act in world.acts if act.at_ns <= outcome.ended_ns]
    wrong = outcome.violation
    if wrong is not None:
        end = names.failure_lines(seed, wrong)
    else:
        end = [f"seed {seed}: no violation in {outcome.station_s:.3f} s, digest {outcome.digest}"]
    print("\n".join([*acts, *end]))
    if track is not None:
        from achse.cli.test.swarm_page import page_of

        file = Path(f"seed-{seed}.html")
        page = page_of(f"Seed {seed}", end[0], wrong=wrong is not None, acts=acts, track=track)
        file.write_text(page, encoding="utf-8")
        print(f"{file}: the last {len(track)} cycles")
        if on_terminal():
            webbrowser.open(file.resolve().as_uri())
    raise typer.Exit(1 if wrong is not None else 0)


def _replay_plans(seed: int, names: _Names) -> None:
    """Play the chains of a seed, and print the first wrong move."""
    from achse.swarm.plans.player import play_plans

    outcome = play_plans(seed)
    if outcome.violation is not None:
        print("\n".join(names.failure_lines(seed, outcome.violation)))
    else:
        print(f"seed {seed}: no violation in {outcome.moves} moves, digest {outcome.digest}")
    raise typer.Exit(0 if outcome.violation is None else 1)


def _act_line(act: "Act") -> str:
    actor = "station" if act.actor < 0 else f"client {act.actor}"
    values = " ".join(map(str, act.values))
    return f"{act.at_ns / 1e9:10.3f} s  {actor}  {act.kind} {values}".rstrip()


def _keep(file: Path, failure: "FailedSeed", names: _Names) -> None:
    """Make the first failing world small, and write it as a test."""
    from achse.swarm.play import play, play_twice
    from achse.swarm.project import load_checks
    from achse.swarm.report import source_of_test
    from achse.swarm.scenario import world_of
    from achse.swarm.worlds.shrink import shrink
    from achse.swarm.worlds.world import World

    checks = load_checks(Path(names.invariants)) if names.invariants else ()

    def outcome_of(world: World) -> Any:
        if failure.invariant == "equal-digest":
            return play_twice(world)
        return play(world, checks=checks)

    def fails(world: World) -> bool:
        violation = outcome_of(world).violation
        return violation is not None and violation.invariant == failure.invariant

    world = world_of(failure.seed, names.project, motion=names.motion)
    if not fails(world):
        fail(f"seed {failure.seed} fails in a process with others only: nothing written")
    small = shrink(world, fails, budget_s=_SHRINKING_S)
    violation = outcome_of(small).violation
    file.write_text(source_of_test(small, violation, names.invariants), encoding="utf-8")
    print(f"{file}: {len(small.acts)} of {len(world.acts)} acts, {small.length_ns / 1e9:g} s")
