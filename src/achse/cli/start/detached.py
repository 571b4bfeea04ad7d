"""`achse run --detach`, `achse wait`, `achse stop`: stations that run without a terminal.

Such a station keeps a record of itself, locked as long as it lives, in a folder of the user's:
ACHSE_RUNTIME_DIR, else below XDG_RUNTIME_DIR, else in the user's cache, and where there is no home
that can be written, below the folder for temporary files. A record that no process has locked
is that of a station that has ended otherwise.
"""

import contextlib
import json
import os
import signal
import stat
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer

from achse.cli.failure import fail, in_json
from achse.cli.interrupts import ending
from achse.cli.options import EndWithin
from achse.cli.output import print_json
from achse.cli.target import ROUTER, Json, endpoint
from achse.transport.file_lock import lock_file

_RECORDS = "ACHSE_DETACHED"
"""Environment variable of a station that is to keep a record: the folder for it."""

_LOOK_S = 0.02
"""Between two looks whether something has come or gone."""

_KEEP_LOGS_S = 7 * 24 * 3600.0
"""Logs of stations that have ended are kept so long."""

_SHOWN_LINES = 20
"""Of the log of a station that did not start."""

_TAKEN = "detached-"


class DetachedStation(NamedTuple):
    """The record of a station that runs without a terminal."""

    pid: int
    name: str
    host: str
    tcp_port: int
    net_id: str
    log: str
    pid_namespace: str = ""
    """PID namespace that `pid` counts in, `pid:[4026531836]`; empty where there are none."""

    @property
    def address(self) -> str:
        return (
            f"[{self.host}]:{self.tcp_port}" if ":" in self.host else f"{self.host}:{self.tcp_port}"
        )

    def is_called(self, word: str) -> bool:
        """Return True if `word` is its name, its address, its TCP port, its NetId or its process
        id."""
        names = (self.name.casefold(), self.address, str(self.tcp_port), self.net_id, str(self.pid))
        return word.casefold() in names

    def __str__(self) -> str:
        return f"{self.name} at {self.address}, process {self.pid}"

    def terminate(self) -> None:
        """Ask the process to end. Raises `ProcessLookupError` if it is not visible from here."""
        os.kill(self._pid_here(), signal.SIGTERM)

    def enter_network(self) -> None:
        """Use the network namespace of the process from now on, to reach its address.

        Nothing happens if it is ours, or cannot be seen from here. Raises `OSError` if it may not
        be entered.
        """
        try:
            namespace = Path("/proc") / str(self._pid_here()) / "ns" / "net"
            other = namespace.readlink() != Path("/proc/self/ns/net").readlink()
        except OSError:  # no namespaces here, it has ended, or it is another user's
            return
        if other:
            _use_namespace(namespace)

    def _pid_here(self) -> int:
        """Return the process id in our PID namespace, also of a station in a container below
        ours."""
        if self.pid_namespace in ("", _pid_namespace()):
            return self.pid
        for process in Path("/proc").glob("[0-9]*"):
            try:
                if str((process / "ns" / "pid").readlink()) != self.pid_namespace:
                    continue
                status = (process / "status").read_text(encoding="utf-8", errors="replace")
            except OSError:  # it has ended, or is another user's
                continue
            numbers = next(line for line in status.splitlines() if line.startswith("NSpid:"))
            if int(numbers.split()[-1]) == self.pid:
                return int(process.name)
        raise ProcessLookupError(f"no process {self.pid} in {self.pid_namespace} is visible here")


def _pid_namespace() -> str:
    """Return the PID namespace of this process; empty where there are none."""
    try:
        return str(Path("/proc/self/ns/pid").readlink())
    except OSError:
        return ""


def _use_namespace(namespace: Path) -> None:
    """Enter a namespace. Raises OSError."""
    import ctypes  # os.setns is there from Python 3.12 on

    library = ctypes.CDLL(None, use_errno=True)
    with namespace.open("rb") as file:
        if library.setns(file.fileno(), 0):
            number = ctypes.get_errno()
            raise OSError(number, os.strerror(number))


def register(app: typer.Typer) -> None:
    """Add the commands of this module to `app`."""
    app.command()(wait)
    app.command()(stop)


def runtime_folder() -> Path:
    """Return the folder of the records; it is made for this user alone if missing, or the command
    ends."""
    chosen = os.environ.get("ACHSE_RUNTIME_DIR")
    base = os.environ.get("XDG_RUNTIME_DIR") or os.environ.get("LOCALAPPDATA")
    if chosen:
        return _create_folder(Path(chosen))
    if base and os.access(base, os.W_OK):
        return _create_folder(Path(base) / "achse")
    try:
        folder = Path.home() / ".cache" / "achse" / "run"
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        if os.access(folder, os.W_OK):
            return folder
    except (OSError, RuntimeError):  # read-only, or a user without a home, as in containers
        pass
    if sys.platform == "win32":
        return _create_folder(Path(tempfile.gettempdir()) / "achse")
    user = os.getuid()
    folder = _create_folder(Path(tempfile.gettempdir()) / f"achse-{user}")
    state = folder.lstat()
    if not stat.S_ISDIR(state.st_mode) or state.st_uid != user or state.st_mode & 0o022:
        fail(
            f"{folder} belongs to another user; set another one: ACHSE_RUNTIME_DIR", name="NOT_OURS"
        )
    return folder


def _create_folder(folder: Path) -> Path:
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as failure:
        why = f"{folder}: {failure.strerror}, and records of stations are kept there"
        fail(f"{why} (another folder: ACHSE_RUNTIME_DIR)", name="CANNOT_WRITE")
    return folder


# the station's side ------------------------------------------------------------------------------


@contextlib.contextmanager
def recorded(name: str, host: str, tcp_port: int, net_id: str) -> Iterator[None]:
    """Meanwhile a detached station has its record, which it holds locked. Others have none."""
    folder = os.environ.pop(_RECORDS, None)
    if folder is None:
        yield
        return
    log = str(_log_of(Path(folder), os.getpid()))
    pid = os.getpid()
    station = DetachedStation(pid, name, host, tcp_port, net_id, log, _pid_namespace())
    file = _record_of(Path(folder), station.pid)
    being_made = file.with_suffix(".new")
    with being_made.open("w", encoding="utf-8") as record:
        lock_file(record)
        json.dump(station._asdict(), record)
        record.flush()
        being_made.rename(file)  # whole and locked from its first moment
        try:
            yield
        finally:
            file.unlink(missing_ok=True)


def _record_of(folder: Path, pid: int) -> Path:
    return folder / f"{_TAKEN}{pid}.json"


def _log_of(folder: Path, pid: int) -> Path:
    return folder / f"{_TAKEN}{pid}.log"


# start, wait and stop ----------------------------------------------------------------------------


def detached_stations() -> list[DetachedStation]:
    """Return the running stations, by process id; remove records of others, and old logs."""
    stations = []
    folder = runtime_folder()
    for file in folder.glob(f"{_TAKEN}*.json"):
        try:
            with file.open("r+", encoding="utf-8") as record:
                if not lock_file(record):
                    stations.append(DetachedStation(**json.load(record)))
                    continue
            file.unlink(missing_ok=True)
        except (OSError, ValueError, TypeError):  # it ends in this moment, or is not a record
            continue
    running = {_log_of(folder, station.pid) for station in stations}
    for log in folder.glob(f"{_TAKEN}*.log"):
        with contextlib.suppress(OSError):
            if log not in running and time.time() - log.stat().st_mtime > _KEEP_LOGS_S:
                log.unlink()
    return sorted(stations)


def start(arguments: Sequence[str], seconds: float) -> None:
    """Start `achse run` with these arguments, wait until it is ready, and print its place."""
    try:
        folder = runtime_folder()
        detached_stations()
        log = folder / f"{_TAKEN}new-{os.getpid()}.log"
        with log.open("wb") as output:
            process = subprocess.Popen(
                [sys.executable, "-m", "achse", "run", *arguments],
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=output,
                env=os.environ | {_RECORDS: str(folder)},
                **own_session(),
            )
        log = log.rename(_log_of(folder, process.pid))
    except OSError as failure:
        fail(f"{failure.filename or 'achse run'}: {failure.strerror}")
    record = _record_of(folder, process.pid)
    end = time.monotonic() + seconds
    with ending(lambda _: process.terminate()):  # Ctrl-C meanwhile: nothing is left behind
        _await_record(record, process, log, end, seconds)
    process.returncode = 0  # no wait for it: it is meant to go on
    station = DetachedStation(**json.loads(record.read_text(encoding="utf-8")))
    _report(station, f"achse ready net_id={station.net_id} tcp={station.address}")


def _await_record(
    record: Path, process: "subprocess.Popen[bytes]", log: Path, end: float, seconds: float
) -> None:
    """Wait until the station has its record; report its last output if it ends instead."""
    while not record.exists():
        if process.poll() is not None:
            said = log.read_text(encoding="utf-8", errors="replace").splitlines()
            log.unlink(missing_ok=True)
            fail("\n".join(said[-_SHOWN_LINES:]) or "the station ended at once", name="NOT_STARTED")
        if time.monotonic() > end:
            process.terminate()
            fail(f"not ready after {seconds:g} s, ended; its log: {log}", name="TIMEOUT")
        time.sleep(_LOOK_S)


def own_session() -> dict[str, Any]:
    """Return the options for a process that survives its terminal and gets no Ctrl-C from it."""
    if sys.platform == "win32":
        flags = subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.DETACHED_PROCESS
        return {"creationflags": flags}
    return {"start_new_session": True}


def _report(station: DetachedStation, sentence: str) -> None:
    if in_json():
        print_json(station._asdict())
    else:
        print(f"{sentence} process={station.pid} log={station.log}")


Which = Annotated[
    str | None,
    typer.Argument(
        metavar="[STATION]",
        help="Name, host:port, TCP port, NetId or process id of a detached station.",
        show_default=False,
    ),
]


def wait(
    which: Which = None,
    host: Annotated[
        str, typer.Option(envvar="ACHSE_HOST", help="Where any other station listens.")
    ] = "127.0.0.1",
    tcp_port: Annotated[
        int, typer.Option(envvar=ROUTER[0], min=1, max=65535, help="Its TCP port.")
    ] = ROUTER[1],
    timeout: Annotated[float, typer.Option(min=0.0, help="At most so long, s.")] = 30.0,
    as_json: Json = False,
) -> None:
    """Wait until a station, or any ADS router, answers and is in RUN; exit code 1 if it is not."""
    if which is not None:
        station = _only(which)
        host, tcp_port = station.host, station.tcp_port
        try:
            station.enter_network()
        except OSError as failure:
            why = failure.strerror or failure
            fail(f"{station}, is in another network namespace: {why}; wait there", name="NOT_OURS")
    else:
        host, tcp_port = endpoint(host, tcp_port)
    where = f"{host}:{tcp_port}"
    begin = time.monotonic()
    from achse.cli.interrupts import Interrupted, run

    try:
        answer = run(_answer(host, tcp_port, begin + timeout))
    except Interrupted as interrupted:
        raise typer.Exit(interrupted.exit_code) from None
    if answer != "RUN":
        fail(f"{where} is not ready after {timeout:g} s: {answer}", name="TIMEOUT")
    seconds = round(time.monotonic() - begin, 3)
    if as_json:
        print_json({"host": host, "tcp_port": tcp_port, "state": answer, "seconds": seconds})
    else:
        print(f"{where} is ready")


async def _answer(host: str, tcp_port: int, end: float) -> str:
    """`RUN`, or what was there instead when the time was over."""
    import asyncio

    from achse.ams import AdsError, AdsState
    from achse.client import connect
    from achse.client.links.link import TcpDialer

    system = 10_000
    while True:
        left = max(end - time.monotonic(), 0.05)
        try:
            async with (
                asyncio.timeout(left),
                connect(
                    TcpDialer(host, tcp_port),
                    port=system,
                    timeout=left,
                    reconnect=False,
                    watch_symbols=False,
                ) as client,
            ):
                state, _ = await client.state()
                if state == AdsState.RUN:
                    return "RUN"
                seen = f"it is in {getattr(state, 'name', state)}"
        except AdsError as refusal:
            seen = str(refusal)
        except TimeoutError:
            seen = "no answer"
        if time.monotonic() >= end:
            return seen
        await asyncio.sleep(_LOOK_S)


def stop(
    which: Which = None,
    every: Annotated[bool, typer.Option("--all", help="All detached stations.")] = False,
    timeout: EndWithin = 30.0,
    as_json: Json = False,
) -> None:
    """End a detached station, in order: persistent data are saved. Without a name the only one."""
    if every and which is not None:
        raise typer.BadParameter("either a station or --all", param_hint="--all")
    stations = detached_stations() if every else [_only(which)]
    for station in stations:
        try:
            station.terminate()
        except ProcessLookupError:
            if station.pid_namespace != _pid_namespace():
                fail(f"{station}, runs in another container: stop it there", name="NOT_OURS")
    end = time.monotonic() + timeout
    while left := [each for each in detached_stations() if each in stations]:
        if time.monotonic() > end:
            names = "; ".join(map(str, left))
            fail(
                f"still there after {timeout:g} s: {names}; its log: {left[0].log}", name="TIMEOUT"
            )
        time.sleep(_LOOK_S)
    if as_json:
        print_json([station._asdict() for station in stations])
        return
    for station in stations:
        print(f"{station.name} at {station.address} has ended")
    if not stations:
        print("no detached station runs")


def _only(which: str | None) -> DetachedStation:
    """Return the detached station of that name, or the only one."""
    stations = detached_stations()
    matches = [each for each in stations if which is None or each.is_called(which)]
    if len(matches) == 1:
        return matches[0]
    listed = "; ".join(map(str, stations)) or "none"
    folder = runtime_folder()
    said = f"no detached station {which!r}; there are: {listed} (records in {folder})"
    if matches:
        said = f"which one? say its process id, or --all: {'; '.join(map(str, matches))}"
    elif which is None:
        said = f"no detached station runs: no records in {folder} (`achse run --detach` starts one)"
    return fail(said, name="NOT_FOUND")
