"""Workers of Dask: a cluster of this computer that starts and ends quickly, or one that is there.

On POSIX systems the workers are forks of one small process that has imported what runs need: it
does so once, beside everything else that starts, and whatever the number of cores.
"""

import contextlib
import logging
import multiprocessing
import os
from collections.abc import Iterator, Sequence
from typing import Any

from achse.sweeps.plan import Run, SweepError
from achse.sweeps.scenario import Row, Scenario, failed_row, play

_log = logging.getLogger("achse.sweeps")
_DEATHS = 1
"""Workers that may die over one piece until it is suspected; then its runs are played apart."""

_FORKED_WITH = ["distributed.nanny", "achse.station", "achse.client", "achse.sweeps"]
"""Modules that the fork server imports before it starts workers."""

_SOMEBODY_WITHIN = 15
"""Seconds that a scheduler has to answer, and to have a worker."""

_GONE = "its worker has died {} times: it was killed, had no memory left, or the run did not end"


class Workers:
    """Plays pieces of a sweep on the workers of a Dask client."""

    def __init__(self, client: Any, count: int) -> None:
        self._client = client
        self.count = count
        """Number of workers."""

    def play(
        self, scenario: Scenario, pieces: Sequence[Sequence[Run]], longest: float | None
    ) -> Iterator[list[Row]]:
        """Yield the rows of pieces as they are done. What a worker had that died goes to another.

        Where workers die again and again the piece is played run by run, and those that still have
        no rows one after the other: a run is blamed only for deaths of its own. Raises SweepError
        if the scheduler is lost.
        """
        suspects: list[Run] = []
        yield from self._together(scenario, pieces, longest, suspects)
        alone, suspects = [[run] for run in suspects], []
        yield from self._together(scenario, alone, longest, suspects)
        for run in sorted(suspects):
            guilty: list[Run] = []
            yield from self._together(scenario, [[run]], longest, guilty)
            for each in guilty:
                yield [failed_row(each, "WorkerDied: " + _GONE.format(_DEATHS + 1))]

    def _together(
        self,
        scenario: Scenario,
        pieces: Sequence[Sequence[Run]],
        longest: float | None,
        dead: list[Run],
    ) -> Iterator[list[Row]]:
        """Pieces all at once; the runs of those over which workers died are put to `dead`."""
        import distributed

        as_completed: Any = distributed.as_completed
        tasks = {
            self._client.submit(
                play, scenario, list(piece), longest, own_process=True, pure=False
            ): piece
            for piece in pieces
        }
        for future in as_completed(list(tasks)):
            piece = tasks.pop(future)
            try:
                rows: list[Row] = future.result()
            except distributed.KilledWorker:
                dead += piece
                continue
            except SweepError:
                raise
            except Exception as failure:
                message = f"{type(failure).__name__}: {failure}"[:500]
                raise SweepError(f"the workers cannot play this: {message}") from failure
            finally:
                future.release()
            yield rows


@contextlib.contextmanager
def dask_workers(count: int | None, scheduler: str | None) -> Iterator[Workers]:
    """Workers of the scheduler at this address, or so many processes of this computer.

    `count` None: one for each core. Raises SweepError.
    """
    if count is not None and count < 0:
        raise SweepError(f"workers are 0 or more, got {count}")
    method = prepare_workers() if scheduler is None else "spawn"
    import dask
    import distributed

    settings = {
        "distributed.scheduler.allowed-failures": _DEATHS,
        "distributed.worker.daemon": False,  # a scenario may start processes of its own
        "distributed.worker.multiprocessing-method": method,
        "distributed.worker.profile.enabled": False,  # it takes a tenth of short runs
        "distributed.admin.system-monitor.interval": "10s",
    }
    make_client: Any = distributed.Client
    with contextlib.ExitStack() as stack, dask.config.set(settings):
        if scheduler is None:
            cluster = _local(count)
            stack.callback(_close, cluster)
            client = stack.enter_context(make_client(cluster))
        else:
            try:
                client = stack.enter_context(make_client(scheduler, timeout=_SOMEBODY_WITHIN))
                client.wait_for_workers(1, timeout=_SOMEBODY_WITHIN)
            except (OSError, TimeoutError, ValueError) as failure:
                raise SweepError(
                    f"no Dask scheduler with workers at {scheduler}: {failure}"
                ) from None
        yield Workers(client, max(1, len(client.scheduler_info(n_workers=-1)["workers"])))


def _local(count: int | None) -> Any:
    import distributed

    make: Any = distributed.LocalCluster
    return make(
        n_workers=count,
        threads_per_worker=1,
        dashboard_address=None,
        scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},  # 8787 may be another sweep's
        silence_logs=logging.CRITICAL,
        env=dict(os.environ),  # as it is now; the process they fork from may be older
    )


def _close(cluster: Any) -> None:
    """End a cluster of this computer; where Dask cannot end a part of it, the rows are not lost.

    A worker that died in the last run is being started again while its cluster ends, and Dask then
    raises whatever it met. The second attempt ends what the first one left.
    """
    for _ in range(2):
        try:
            cluster.close()
            return
        except Exception:
            _log.warning("Dask did not end its cluster in order", exc_info=True)
            cluster.status = type(cluster.status).failed  # of which close does the rest


def prepare_workers() -> str:
    """Begin to start what workers of this computer are forked from; how they will be started.

    It goes on beside what this process does next, such as its own imports.
    """
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return "spawn"
    from multiprocessing import forkserver

    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(_FORKED_WITH)
    forkserver.ensure_running()
    return "forkserver"
