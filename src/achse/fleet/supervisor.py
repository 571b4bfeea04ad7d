"""The processes of a fleet: started, watched, started again when they end, stopped."""

import asyncio
import contextlib
import json
import logging
import math
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from enum import StrEnum
from pathlib import Path
from typing import Any

from achse.fleet.log_file import LogFile
from achse.fleet.plan import FleetPlan, FleetStation
from achse.fleet.policy import RestartPolicy
from achse.station.configuration.types import ConfigError

log = logging.getLogger("achse.fleet")

_SILENT_S = 15.0
"""Without figures for so long a process that runs is shown as silent."""

_LOOK_S = 5.0
_SILENT_LOOKS = 12
"""Looks in a row at which a running process had nothing to report: then it hangs."""

_LAST_LINES_S = 5.0
"""Last lines of an ended process are awaited so long: its children may keep its stderr open."""

_END_WITHIN_S = 20.0
"""Seconds from the request to end until a process is killed."""

Command = Callable[[Sequence[int], int | None], Sequence[str]]


class ProcessState(StrEnum):
    """State of a process of a fleet, as JSON has it."""

    WAITING = "waiting"
    STARTING = "starting"
    RUNNING = "running"
    AGAIN = "again"
    """It is to be started again."""
    FAILED = "failed"
    ENDED = "ended"


class FleetProcess:
    """One process and its stations."""

    def __init__(self, place: int, stations: Sequence[FleetStation], core: int | None) -> None:
        self.place = place
        """0 and up."""
        self.stations = stations
        self.core = core
        self.state = ProcessState.WAITING
        self.pid = 0
        self.reports: dict[int, dict[str, Any]] = {}
        """The newest figures of each station."""
        self.heard_s = 0.0
        self.heard = 0
        """Lines that it has said."""
        self.ready = asyncio.Event()
        """All stations are ready, or the process has failed."""
        self.go_on = asyncio.Event()
        """A restart was ordered."""
        self.ordered = False
        self.child: asyncio.subprocess.Process | None = None

    @property
    def has_failed(self) -> bool:
        """True if it is not started again."""
        return self.state is ProcessState.FAILED

    @property
    def numbers(self) -> list[int]:
        return [station.number for station in self.stations]


class FleetSupervisor:
    """Runs the processes of a fleet from `run` until `stop`.

    `command(numbers, core)` is the command line of a process that serves these stations, ends when
    its stdin ends, and reports on stdout in JSON lines, see `achse.fleet.worker`. What it
    writes to stderr comes through a pipe into a file in `logs`. Every `look_s` seconds the
    supervisor looks, and kills processes that reported nothing for `_SILENT_LOOKS` looks.
    """

    def __init__(
        self,
        plan: FleetPlan,
        command: Command,
        logs: Path,
        *,
        clock: Callable[[], float] = time.monotonic,
        look_s: float = _LOOK_S,
    ) -> None:
        self._look_s = look_s
        self.plan = plan
        self._command = command
        self._logs = logs
        self._clock = clock
        cores = usable_cores(plan)
        self.processes = [
            FleetProcess(place, group, cores[place % len(cores)] if cores else None)
            for place, group in enumerate(plan.groups())
        ]
        window_s = plan.config.restart_window / 1e9
        self._policies = [RestartPolicy(plan.config.restarts, window_s) for _ in self.processes]
        self._files = [LogFile(self.log_of(each.numbers[0])) for each in self.processes]
        self._stopping = asyncio.Event()
        self._starting = asyncio.Semaphore(2 * (os.cpu_count() or 1))
        """So many start at the same time: more would only wait for each other."""

    def log_of(self, number: int) -> Path:
        """Return the log of the process of a station. Raises ConfigError."""
        self.plan.station(number)
        place = (number - 1) // self.plan.config.stations_per_process
        return self._logs / f"process-{place + 1}.log"

    def stop(self) -> None:
        """End all processes, in order; `run` returns when they are gone."""
        self._stopping.set()

    async def run(self) -> None:
        """Keep all processes running until `stop`."""
        self._logs.mkdir(mode=0o700, parents=True, exist_ok=True)
        try:
            async with asyncio.TaskGroup() as tasks:
                looking = tasks.create_task(self._look())
                keeping = [tasks.create_task(self._keep(each)) for each in self.processes]
                await asyncio.wait(keeping)
                looking.cancel()
        finally:
            for process in self.processes:
                if process.child is not None and process.child.returncode is None:
                    process.child.kill()

    @property
    def stopping(self) -> bool:
        """True once `stop` was called."""
        return self._stopping.is_set()

    async def ready(self) -> None:
        """Wait until all stations are ready, or have failed or ended."""
        await asyncio.gather(*(process.ready.wait() for process in self.processes))

    async def restart(self, numbers: Iterable[int] = ()) -> list[int]:
        """End the processes of these stations (of all) and start them again, and wait for that.

        Gives the stations that it concerned: those of the same process among them.
        """
        requested = set(numbers)
        chosen = [each for each in self.processes if not requested or requested & set(each.numbers)]
        for process in chosen:
            process.ready.clear()
            process.ordered = True
            self._policies[process.place].forget()
            process.go_on.set()
            self._request_end(process)
        await asyncio.gather(*(process.ready.wait() for process in chosen))
        return [number for process in chosen for number in process.numbers]

    async def _look(self) -> None:
        """Kill what hangs, so that it is started again."""
        silent = dict.fromkeys(self.processes, (0, 0))
        while True:
            await asyncio.sleep(self._look_s)
            for process in self.processes:
                heard, looks = silent[process]
                looks = (
                    looks + 1
                    if process.heard == heard and process.state is ProcessState.RUNNING
                    else 0
                )
                silent[process] = process.heard, looks
                child = process.child
                if looks >= _SILENT_LOOKS and child is not None and child.returncode is None:
                    names = ", ".join(station.name for station in process.stations[:3])
                    log.warning("%s: says nothing any more, killed", names)
                    silent[process] = process.heard, 0
                    _kill(child)

    # one process ------------------------------------------------------------------------------

    async def _keep(self, process: FleetProcess) -> None:
        policy = self._policies[process.place]
        while not self._stopping.is_set():
            was_ready, code = await self._run_once(process)
            process.pid = 0
            if self._stopping.is_set():
                break
            if process.ordered:
                continue
            pause = policy.ended(self._clock()) if was_ready else None
            names = ", ".join(station.name for station in process.stations[:3])
            if pause is None:
                process.state = ProcessState.FAILED
                process.ready.set()
                log.error("%s: ended with %s, and is not started again", names, code)
            else:
                process.state = ProcessState.AGAIN
                log.warning("%s: ended with %s, started again in %.1f s", names, code, pause)
            await self._pause(process, math.inf if pause is None else pause)
        if not process.has_failed:
            process.state = ProcessState.ENDED
        process.ready.set()

    async def _pause(self, process: FleetProcess, seconds: float) -> None:
        """Wait so long, or until an order comes."""
        waiting = [
            asyncio.create_task(process.go_on.wait()),
            asyncio.create_task(self._stopping.wait()),
        ]
        timeout = None if math.isinf(seconds) else seconds
        await asyncio.wait(waiting, timeout=timeout, return_when=asyncio.FIRST_COMPLETED)
        for task in waiting:
            task.cancel()

    async def _run_once(self, process: FleetProcess) -> tuple[bool, str]:
        """Start it and read its messages until it ends; return if it was ready, and how it
        ended."""
        async with self._starting:
            if self._stopping.is_set():
                return False, "nothing"
            process.state, process.ordered = ProcessState.STARTING, False
            process.go_on.clear()
            process.reports.clear()
            ready: set[int] = set()
            try:
                child, logged = await self._start(process)
            except OSError as failure:
                return False, str(failure)
            process.child, process.pid = child, child.pid
            end = asyncio.create_task(self._end_on_request(process, child))
            while len(ready) < len(process.stations) and (line := await _line(child)):
                self._hear(process, line, ready)
            if len(ready) == len(process.stations):
                process.state = ProcessState.RUNNING
                process.ready.set()
        while line := await _line(child):
            self._hear(process, line, ready)
        code = await child.wait()
        end.cancel()
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(logged.wait(), _LAST_LINES_S)
        how = f"signal {-code}" if code < 0 else f"exit code {code}"
        return len(ready) == len(process.stations), how

    async def _start(
        self, process: FleetProcess
    ) -> tuple[asyncio.subprocess.Process, asyncio.Event]:
        """Start it: the child, and the event that all is logged that it wrote to stderr.

        The pipe is our own: `wait` of a child waits for children of the child that keep the
        pipes of asyncio open. Raises OSError.
        """
        command = self._command(process.numbers, process.core)
        reads, writes = os.pipe()
        try:
            child = await asyncio.create_subprocess_exec(
                *command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=writes,
                **_own_group(),
            )
        except BaseException:
            os.close(reads)
            raise
        finally:
            os.close(writes)
        return child, self._files[process.place].follow(reads)

    def _hear(self, process: FleetProcess, line: bytes, ready: set[int]) -> None:
        try:
            message = json.loads(line)
            number = message.pop("station")
            if message.pop("event") == "ready":
                ready.add(number)
            process.reports.setdefault(number, {}).update(message)
        except (ValueError, KeyError, TypeError, AttributeError):
            log.info("process %d says %.200r", process.place + 1, line)
            return
        process.heard_s = self._clock()
        process.heard += 1

    def _request_end(self, process: FleetProcess) -> None:
        child = process.child
        if child is None or child.returncode is not None or child.stdin is None:
            return
        with contextlib.suppress(OSError, RuntimeError):
            child.stdin.close()
        killer = asyncio.get_running_loop().call_later(_END_WITHIN_S, _kill, child)
        waiting = asyncio.ensure_future(child.wait())
        waiting.add_done_callback(lambda _: killer.cancel())

    async def _end_on_request(
        self, process: FleetProcess, child: asyncio.subprocess.Process
    ) -> None:
        await self._stopping.wait()
        if process.child is child:
            self._request_end(process)

    # what is shown ----------------------------------------------------------------------------

    def rows(self) -> list[dict[str, Any]]:
        """Return a row for each station; memory is that of its process."""
        return [
            self._row(process, station)
            for process in self.processes
            for station in process.stations
        ]

    def _row(self, process: FleetProcess, station: FleetStation) -> dict[str, Any]:
        figures = (
            process.reports.get(station.number, {}) if process.state is ProcessState.RUNNING else {}
        )
        state: str = process.state
        if state == ProcessState.RUNNING:
            silent = self._clock() - process.heard_s > _SILENT_S
            state = "silent" if silent else figures.get("state", state)
        cycles = figures.get("cycles", 0)
        return {
            "station": station.number,
            "name": station.name,
            "net_id": str(station.net_id),
            "address": figures.get("address", ""),
            "process": process.place + 1,
            "pid": process.pid or None,
            "core": process.core,
            "state": state,
            "speed": station.speed,
            "time_s": figures.get("time_s"),
            "tick_s": figures.get("tick_s"),
            "cycle_s": figures["computed_s"] / cycles if cycles else None,
            "cycles": cycles,
            "late": figures.get("late"),
            "memory_bytes": figures.get("memory_bytes"),
            "axes": figures.get("axes"),
            "moving": figures.get("moving"),
            "errors": figures.get("errors"),
            "requests": figures.get("requests"),
            "online": figures.get("online", False),
            "partners": figures.get("partners"),
            "restarts": self._policies[process.place].restarts,
        }


def usable_cores(plan: FleetPlan) -> list[int]:
    """Return the cores that processes are pinned to in turn; none where the system cannot.

    Raises ConfigError for a core that is not there.
    """
    cores = plan.config.cores
    if cores == "none" or sys.platform != "linux":
        return []
    ours = sorted(os.sched_getaffinity(0))
    if isinstance(cores, str):
        return ours
    for core in cores:
        if core not in ours:
            there = ", ".join(map(str, ours))
            raise ConfigError(f"{plan.line('cores')}cores: there are {there}, got {core}")
    return list(cores)


def _own_group() -> dict[str, Any]:
    """Ctrl-C in a terminal reaches the supervisor alone, which ends the others in order."""
    if sys.platform == "win32":
        return {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    return {"start_new_session": True}


async def _line(child: asyncio.subprocess.Process) -> bytes:
    assert child.stdout is not None
    try:
        return await child.stdout.readline()
    except ValueError:  # longer than anything we say
        return b"\n"


def _kill(child: asyncio.subprocess.Process) -> None:
    with contextlib.suppress(ProcessLookupError):
        child.kill()
