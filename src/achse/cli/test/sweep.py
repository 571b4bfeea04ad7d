"""`achse sweep` runs a scenario thousands of times, over a Dask cluster."""

import statistics
import sys
from collections import defaultdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.failure import fail
from achse.cli.output import on_terminal, print_json, print_table
from achse.cli.target import Json

if TYPE_CHECKING:
    from achse.sweeps import Sweep

_MOST_ROWS = 40
"""Of the summary; the file has all."""

_MOST_REPORTED = 5
"""Runs that failed, with their reason."""


def register(app: typer.Typer) -> None:
    """Add the command to `app`."""
    app.command()(sweep)


def sweep(
    scenario: Annotated[Path, typer.Argument(help="Python file with the function that is run.")],
    param: Annotated[
        list[str] | None,
        typer.Option(help="name=from:to:count, or name=value,value,…", show_default=False),
    ] = None,
    seeds: Annotated[int, typer.Option(min=1, help="Seeds 0 … N-1 with each combination.")] = 1,
    function: Annotated[str, typer.Option(help="The function.")] = "run",
    out: Annotated[
        Path | None,
        typer.Option(
            help="Parquet file for the results; an interrupted sweep goes on.",
            show_default="the scenario's name with .parquet",
        ),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(min=0, help="Processes; 0: this one.", show_default="one for each core"),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(help="A Dask scheduler instead: tcp://host:8786.", show_default=False),
    ] = None,
    longest: Annotated[
        float | None,
        typer.Option(help="Seconds that a run may take; then it has failed.", show_default=False),
    ] = None,
    in_json: Json = False,
) -> None:
    """Run a scenario in virtual time for every combination of parameters and seeds."""
    from achse.sweeps import SweepError, SweepParameter
    from achse.sweeps import sweep as run

    try:
        parameters = [SweepParameter.parse(text) for text in param or ()]
        if len({each.name for each in parameters}) < len(parameters):
            raise SweepError("each parameter once")
    except SweepError as fault:
        raise typer.BadParameter(str(fault), param_hint="--param") from None
    file = out or scenario.with_suffix(".parquet")
    # Ctrl-C ends all at once: what processes shared goes with them, and no process needs a message.
    sys.warnoptions.append("ignore:resource_tracker:UserWarning")
    try:
        with _Progress(in_json) as report:
            result = run(
                scenario,
                {each.name: each.values for each in parameters},
                seeds=seeds,
                function=function,
                file=file,
                workers=workers,
                scheduler=scheduler,
                longest=longest,
                progress=report,
            )
    except SweepError as fault:
        fail(str(fault))
    except OSError as failure:
        fail(f"{failure.filename or file}: {failure.strerror or failure}")
    if in_json:
        print_json(_facts(result))
    else:
        _report(result, [each.name for each in parameters])


def _facts(result: "Sweep") -> dict[str, Any]:
    return {
        "file": str(result.file),
        "runs": len(result.rows),
        "failed": len(result.failed),
        "digest": result.digest,
        "seconds": round(result.seconds, 3),
        "workers": result.workers,
        "efficiency": round(result.efficiency, 3),
    }


class _Progress:
    """A bar on stderr for people; nothing for programs."""

    def __init__(self, quiet: bool) -> None:
        self._quiet = quiet or not on_terminal()
        self._bar: Any = None
        self._task: Any = None

    def __enter__(self) -> "_Progress":
        if not self._quiet:
            from rich.console import Console
            from rich.progress import (
                BarColumn,
                MofNCompleteColumn,
                Progress,
                TextColumn,
                TimeRemainingColumn,
            )

            columns = (
                TextColumn("{task.description}"),
                BarColumn(),
                MofNCompleteColumn(),
                TimeRemainingColumn(),
            )
            self._bar = Progress(*columns, console=Console(stderr=True), transient=True)
            self._task = self._bar.add_task("runs", total=None)
            self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.stop()

    def __call__(self, done: int, total: int) -> None:
        if self._bar is not None:
            self._bar.update(self._task, completed=done, total=total)


def _report(result: "Sweep", names: list[str]) -> None:
    groups: dict[tuple[Any, ...], list[dict[str, Any]]] = defaultdict(list)
    for row in result.rows:
        if not row["error"]:
            groups[tuple(row[name] for name in names)].append(row)
    results = [
        name
        for name in dict.fromkeys(name for rows in groups.values() for row in rows for name in row)
        if name not in (*names, "run", "seed", "error", "seconds")
    ]
    table = [(*names, "runs", *results)]
    for values, rows in list(groups.items())[:_MOST_ROWS]:
        table.append(
            (
                *map(_short, values),
                str(len(rows)),
                *(_summary([row[name] for row in rows if name in row]) for name in results),
            )
        )
    print_table(table)
    if len(groups) > _MOST_ROWS:
        print(f"… {len(groups) - _MOST_ROWS} further combinations are in the file")
    for row in result.failed[:_MOST_REPORTED]:
        print(f"run {row['run']} failed: {row['error']}")
    print(
        f"{len(result.rows)} runs, {len(result.failed)} failed, {result.seconds:.1f} s with"
        f" {result.workers} workers, {100 * result.efficiency:.0f} % of their time in runs"
    )
    print(f"digest {result.digest}")
    print(result.file)


def _short(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _summary(values: list[Any]) -> str:
    """Mean and span of numbers; of others the most frequent."""
    numbers = [value for value in values if isinstance(value, int | float)]
    if not values or len(numbers) < len(values):
        return _short(statistics.mode(values)) if values else ""
    low, high = min(numbers), max(numbers)
    mean = statistics.fmean(numbers)
    return _short(mean) if low == high else f"{mean:.6g} ({_short(low)} … {_short(high)})"
