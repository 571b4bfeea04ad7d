"""A sweep: runs go to the workers of a Dask cluster in pieces, rows come back and are kept."""

import contextlib
import logging
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from achse.sweeps.plan import Run, SweepError, SweepParameter, SweepPlan, Value
from achse.sweeps.scenario import Row, Scenario, digest_of, play
from achse.sweeps.store import SweepStore, need_sweep

__all__ = ["Sweep", "sweep"]

_PIECES_PER_WORKER = 32
"""Pieces that each worker gets at least: the last ones to finish leave little idle."""

_LONGEST_PIECE = 200
_DEATHS = 20
"""Workers that may die over one piece until it counts as its fault."""

Progress = Callable[[int, int], object]
"""Called with how many runs are done, and of how many."""


@dataclass(frozen=True)
class Sweep:
    """What a sweep has found.

    - `rows`: one for each run, in order: `run`, parameters, `seed`, results, `error`, `seconds`;
    - `digest`: SHA-256 of the rows without their times: equal wherever and in whatever order they
      ran;
    - `seconds`: that it took; `workers`: how many there were at the end.
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
    progress: Progress | None = None,
) -> Sweep:
    """Run `function(*, <parameters>, seed)` of the file `scenario` for every combination.

    - `parameters`: values of each; `seeds`: 0 … seeds - 1 with every combination;
    - `file`: where the rows go (Parquet). A sweep that was interrupted goes on where it was;
    - `workers`: processes on this computer, one for each core unless told; 0 runs in this process;
    - `scheduler`: the address of a Dask scheduler (`tcp://host:8786`) instead;
    - `progress(done, all)`: called as runs are done.

    Raises SweepError, OSError. A run that raises does not end the sweep: see `Sweep.failed`.
    """
    plan = SweepPlan(
        [SweepParameter(name, tuple(values)) for name, values in (parameters or {}).items()], seeds
    )
    loaded = Scenario.load(Path(scenario), function)
    if workers != 0 or file is not None:
        need_sweep()
    store = None if file is None else SweepStore(Path(file), loaded, plan)
    began = time.monotonic()
    rows = [] if store is None else store.begin()
    done = {int(row["run"]) for row in rows}
    left = [run for run in plan if run.number not in done]
    told = progress or (lambda _done, _all: None)
    told(len(rows), len(plan))
    with _cluster(workers, scheduler) as (count, pieces_of):
        for piece in pieces_of(loaded, _cut(left, count)):
            rows += piece
            if store is not None:
                store.add(piece)
            told(len(rows), len(plan))
    seconds = time.monotonic() - began
    rows.sort(key=lambda row: int(row["run"]))
    if store is not None:
        store.finish(rows)
    return Sweep(rows, digest_of(rows), seconds, count, None if file is None else Path(file))


def _cut(runs: Sequence[Run], workers: int) -> list[Sequence[Run]]:
    """Pieces of some length: as many as keep all workers busy, as few as that allows."""
    size = max(1, min(_LONGEST_PIECE, len(runs) // (workers * _PIECES_PER_WORKER) or 1))
    return [runs[start : start + size] for start in range(0, len(runs), size)]


Pieces = Callable[[Scenario, Sequence[Sequence[Run]]], Iterator[list[Row]]]


@contextlib.contextmanager
def _cluster(workers: int | None, scheduler: str | None) -> Iterator[tuple[int, Pieces]]:
    """How many workers there are, and what has them play pieces."""
    if workers == 0 and scheduler is None:
        yield 1, lambda scenario, pieces: (play(scenario, piece) for piece in pieces)
        return
    import dask
    import distributed

    if workers is not None and workers < 0:
        raise SweepError(f"workers are 0 or more, got {workers}")
    make_cluster: Any = distributed.LocalCluster
    make_client: Any = distributed.Client
    settings = {
        "distributed.scheduler.allowed-failures": _DEATHS,
        "distributed.worker.daemon": False,
    }
    with contextlib.ExitStack() as stack, dask.config.set(settings):
        if scheduler is None:
            cluster = stack.enter_context(
                make_cluster(
                    n_workers=workers,  # None: one for each core
                    threads_per_worker=1,
                    dashboard_address=None,
                    silence_logs=logging.CRITICAL,
                )
            )
            client = stack.enter_context(make_client(cluster))
        else:
            try:
                client = stack.enter_context(make_client(scheduler, timeout=10))
            except (OSError, TimeoutError) as failure:
                raise SweepError(f"no Dask scheduler at {scheduler}: {failure}") from None
        count = max(1, len(client.scheduler_info(n_workers=-1)["workers"]))
        yield count, lambda scenario, pieces: _played(client, scenario, pieces)


def _played(
    client: Any, scenario: Scenario, pieces: Iterable[Sequence[Run]]
) -> Iterator[list[Row]]:
    """Pieces as they are done. What a worker had that died goes to another."""
    import distributed

    as_completed: Any = distributed.as_completed
    waiting = [client.submit(play, scenario, list(piece), pure=False) for piece in pieces]
    for future in as_completed(waiting):
        yield future.result()
