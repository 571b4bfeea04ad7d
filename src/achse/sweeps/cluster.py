"""A sweep: runs go to the workers of a Dask cluster in pieces, rows come back and are kept."""

import contextlib
import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from achse.sweeps.plan import Run, SweepError, SweepParameter, SweepPlan, Value
from achse.sweeps.scenario import Row, Scenario, digest_of, play
from achse.sweeps.store import SweepStore, need_sweep
from achse.sweeps.workers import dask_workers, prepare_workers

_PIECES_PER_WORKER = 32
"""Pieces that each worker gets at least: the last ones to finish leave little idle."""

_LONGEST_PIECE = 200
Progress = Callable[[int, int], object]
"""Called with how many runs are done, and of how many."""


@dataclass(frozen=True)
class Sweep:
    """Result of a sweep.

    - `rows`: one for each run, in order: `run`, parameters, `seed`, results, `error`, `seconds`;
    - `digest`: SHA-256 of the rows without their times: equal on any computer and in any order of
      the runs;
    - `seconds`: duration of the sweep; `workers`: number of workers at its end.
    """

    rows: Sequence[Row]
    digest: str
    seconds: float
    workers: int
    file: Path | None = None

    @property
    def failed(self) -> Sequence[Row]:
        """The runs that raised."""
        return [row for row in self.rows if row["error"]]

    @property
    def efficiency(self) -> float:
        """The time that runs took, as a share of what the workers had; of the whole sweep."""
        used = sum(float(row["seconds"]) for row in self.rows)
        return used / (self.seconds * self.workers) if self.seconds else 1.0


def sweep(
    scenario: str | Path,
    parameters: Mapping[str, Sequence[Value]] | None = None,
    *,
    seeds: int = 1,
    function: str = "run",
    file: str | Path | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    longest: float | None = None,
    progress: Progress | None = None,
) -> Sweep:
    """Run `function(*, <parameters>, seed)` of the file `scenario` for every combination.

    - `parameters`: values of each; `seeds`: 0 … seeds - 1 with every combination;
    - `file`: where the rows go (Parquet). A sweep that was interrupted goes on where it was;
    - `workers`: processes on this computer, by default one for each core; 0 runs in this process;
    - `scheduler`: the address of a Dask scheduler (`tcp://host:8786`) instead;
    - `longest`: seconds that a run may take, then it has failed;
    - `progress(done, all)`: called as runs are done.

    Raises SweepError, OSError. A run that raises does not end the sweep: see `Sweep.failed`.
    """
    plan = SweepPlan(
        [SweepParameter(name, tuple(values)) for name, values in (parameters or {}).items()], seeds
    )
    if longest is not None and not 0 < longest < math.inf:
        raise SweepError(f"the longest time of a run is a number of seconds, got {longest}")
    began = time.monotonic()
    if workers != 0 or file is not None:
        need_sweep()
    if workers != 0 and scheduler is None:
        prepare_workers()
    loaded = Scenario.load(Path(scenario), function)
    report = progress or (lambda _done, _all: None)
    with contextlib.ExitStack() as stack:
        store = None if file is None else stack.enter_context(SweepStore(Path(file), loaded, plan))
        rows = [] if store is None else store.begin()
        done = {int(row["run"]) for row in rows}
        remaining = [run for run in plan if run.number not in done]
        report(len(rows), len(plan))
        count = workers or 1
        if remaining:
            count, played = stack.enter_context(
                _played(loaded, remaining, longest, workers, scheduler)
            )
            for piece in played:
                rows += piece
                if store is not None:
                    store.add(piece)
                report(len(rows), len(plan))
        rows.sort(key=lambda row: int(row["run"]))
        if store is not None:
            store.finish(rows)
    seconds = time.monotonic() - began
    return Sweep(rows, digest_of(rows), seconds, count, None if file is None else Path(file))


@contextlib.contextmanager
def _played(
    scenario: Scenario,
    runs: Sequence[Run],
    longest: float | None,
    workers: int | None,
    scheduler: str | None,
) -> Iterator[tuple[int, Iterator[list[Row]]]]:
    """Yield the number of workers, and an iterator over the rows of runs, piece by piece."""
    if workers == 0 and scheduler is None:
        yield 1, (play(scenario, piece, longest) for piece in _cut(runs, 1))
        return
    with dask_workers(workers, scheduler) as client:
        yield client.count, client.play(scenario, _cut(runs, client.count), longest)


def _cut(runs: Sequence[Run], workers: int) -> list[Sequence[Run]]:
    """Pieces of some length: as many as keep all workers busy, as few as that allows."""
    size = max(1, min(_LONGEST_PIECE, len(runs) // (workers * _PIECES_PER_WORKER) or 1))
    return [runs[start : start + size] for start in range(0, len(runs), size)]
