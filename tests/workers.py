"""Run the tests in forked workers: `pytest --workers auto`.

The tree is collected once. Each worker is a fork of the process that has collected it, so imports,
parsed sources and loaded kernels are shared. A worker receives the tests of a file at a time; one
that has grown ends, and a new fork takes its place. Without `--workers`, or where processes cannot
fork, the tests run in this process.
"""

import contextlib
import gc
import mmap
import os
import resource
import signal
import sys
import tempfile
import time
import traceback
from collections import defaultdict, deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, Pipe, wait
from pathlib import Path
from random import Random
from typing import Any

import pytest

from tests import warm_commands
from tests.background import CHECKS, Background

GROWTH_KB = 285_000
"""Memory that a worker may add to that of the process it was forked from, kB."""

ALLOCATIONS = 10_000
"""Objects more than before after which Python searches young ones for garbage; it is 700 at first,
and searching is 6 % of the time of tests that make whole stations."""

SEARCHES = 2
"""Searches of all objects after which a worker keeps those that are left out of further ones."""

HANG_S = 900.0
"""Time without a report after which a worker is killed, s: the guard of the whole run."""

LARGE = 2000
"""Tests from which on the kernels are compiled before the workers start."""

ROOT = Path(__file__).parents[1]
SHARING = (ROOT / "tests" / "interop" / "browser", ROOT / "tests" / "house")
"""Folders whose tests share what is dear: a browser, and all modules parsed."""

PROGRAMS = {ROOT / "tests" / "docs", ROOT / "tests" / "benchmarks"}
"""Folders whose tests run programs in Python, by a process that has loaded achse."""

SLOW = ROOT / "tests" / "data" / "slow_files.txt"
"""Slow files with their CPU seconds: the dearest starts first."""

BACKGROUND = pytest.StashKey[Background]()
"""The process that worked beside the collection."""

CPU = pytest.StashKey[dict[str, float]]()
"""CPU seconds of each test, its child processes included; for benchmarks/test_times.py."""


def resident_kb() -> int:
    """Return the memory of this process, kB; 0 where the system does not report it."""
    try:
        pages = int(Path("/proc/self/statm").read_bytes().split()[1])
    except OSError:
        return 0
    return pages * os.sysconf("SC_PAGE_SIZE") // 1024


def cpu_seconds() -> float:
    """Return the CPU time of this process and its ended children, s."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def forked_seconds() -> float:
    """Return the CPU time of commands that the shared server has forked for this process, s."""
    return sum(warm_commands.CPU) if warm_commands.SHARED in os.environ else 0.0


def batches(items: list[pytest.Item]) -> deque[list[int]]:
    """Return the indices of the items that belong together, the dearest first.

    Those of a file belong together, and those of a folder that shares something dear.
    """
    seconds: defaultdict[Path, float] = defaultdict(float)
    for name, cpu in map(str.split, SLOW.read_text(encoding="utf-8").splitlines()):
        seconds[batch_of(ROOT / name)] += float(cpu)
    by_batch: dict[Path, list[int]] = {}
    for index, item in enumerate(items):
        by_batch.setdefault(batch_of(item.path), []).append(index)
    if items and items[0].config.option.shuffle is not None:
        return deque(by_batch.values())
    return deque(by_batch[path] for path in sorted(by_batch, key=lambda path: -seconds[path]))


def batch_of(file: Path) -> Path:
    """Return the file, or its folder if the tests of that belong together."""
    return file.parent if file.parent in SHARING else file


def full_searches() -> int:
    """Return how often Python has searched all objects for garbage."""
    return int(gc.get_stats()[-1]["collections"])


def _stay_frozen() -> None:
    """In place of `gc.unfreeze`, which `achse run` calls at its end, also within a test.

    Each further search would walk over two million objects of the collected tree, 1.5 s long, and
    make the worker's own copy of their memory.
    """


class RunningTest:
    """Index of the test that a worker runs, in memory that it shares with the parent.

    So the parent knows which test a lost worker left, without a message at each start.
    """

    def __init__(self) -> None:
        self._memory = mmap.mmap(-1, 8)
        self.index = -1

    @property
    def index(self) -> int:
        """The test; -1 between tests."""
        return int.from_bytes(self._memory[:], sys.byteorder, signed=True)

    @index.setter
    def index(self, value: int) -> None:
        self._memory[:] = value.to_bytes(8, sys.byteorder, signed=True)


class Child:
    """The worker's side: runs batches, sends reports."""

    def __init__(
        self, session: pytest.Session, connection: Connection, running: RunningTest
    ) -> None:
        self.session = session
        self.connection = connection
        self.running = running
        self.reports: list[dict[str, Any]] = []
        """Of the test that runs."""

    def run(self) -> None:
        """Run batches until the parent has no more or this process has grown."""
        plugins = self.session.config.pluginmanager
        plugins.unregister(name="terminalreporter")
        plugins.register(self, "workers-child")
        capture: Any = plugins.getplugin("capturemanager")
        if capture.is_globally_capturing() or capture._global_capturing is not None:
            capture.stop_global_capturing()  # its file belongs to the parent
            capture.start_global_capturing()
            capture.suspend_global_capture()
        limit = resident_kb() + GROWTH_KB
        batch: list[int] | None = self.connection.recv()
        gc.set_threshold(ALLOCATIONS)
        gc.unfreeze = _stay_frozen
        searches = full_searches()
        while batch:
            if full_searches() > searches + SEARCHES:
                gc.collect()
                gc.freeze()  # parsed libraries and the like stay until the worker ends
                searches = full_searches()
            following = None
            for index, after in zip(batch, [*batch[1:], -1], strict=True):
                if after < 0:
                    # The next file decides which fixtures stay.
                    self.connection.send(("next", resident_kb() < limit))
                    following = self.connection.recv()
                    after = following[0] if following else -1
                self.test(index, after)
            batch = following
        self.connection.send(("end", resource.getrusage(resource.RUSAGE_SELF).ru_maxrss))

    def test(self, index: int, after: int) -> None:
        item = self.session.items[index]
        following = self.session.items[after] if after >= 0 else None
        self.running.index = index
        before = cpu_seconds() + forked_seconds()
        item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
        self.connection.send(
            ("finish", index, cpu_seconds() + forked_seconds() - before, self.reports)
        )
        self.running.index = -1
        self.reports = []

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        config = self.session.config
        data = config.hook.pytest_report_to_serializable(config=config, report=report)
        self.reports.append(data)


@dataclass
class Worker:
    """The parent's side of a worker."""

    process: int
    connection: Connection
    running: RunningTest
    heard: float
    ended: bool = False


@dataclass
class Runner:
    """Forks workers, hands out batches, passes reports on."""

    session: pytest.Session
    count: int
    waiting: deque[list[int]]
    workers: dict[Connection, Worker] = field(default_factory=dict)
    forks: int = 0
    largest_kb: int = 0
    cpu: dict[str, float] = field(default_factory=dict)

    def run(self) -> None:
        try:
            while True:
                while self.waiting and len(self.workers) < self.count:
                    self.fork()
                if not self.workers:
                    return
                self.listen()
                if self.session.shouldfail:
                    raise self.session.Failed(self.session.shouldfail)
                if self.session.shouldstop:
                    raise self.session.Interrupted(self.session.shouldstop)
        finally:
            for worker in self.workers.values():
                os.kill(worker.process, signal.SIGTERM)
                os.waitpid(worker.process, 0)

    def fork(self) -> None:
        ours, theirs = Pipe()
        running = RunningTest()
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        process = os.fork()
        if not process:
            code = 1
            try:
                signal.signal(signal.SIGTERM, signal.SIG_DFL)
                ours.close()
                for connection in self.workers:
                    connection.close()
                os.environ["ACHSE_TEST_WORKER"] = str(self.forks)
                Child(self.session, theirs, running).run()
                code = 0
            except BaseException:
                traceback.print_exc(file=sys.__stderr__)
            finally:
                os._exit(code)
        theirs.close()
        self.forks += 1
        self.workers[ours] = Worker(process, ours, running, time.monotonic())
        ours.send(self.waiting.popleft())

    def listen(self) -> None:
        for ready in wait(list(self.workers), timeout=10.0):
            assert isinstance(ready, Connection)
            worker = self.workers[ready]
            worker.heard = time.monotonic()
            try:
                message = ready.recv()
            except (EOFError, ConnectionResetError):
                self.lost(worker)
                continue
            getattr(self, f"on_{message[0]}")(worker, *message[1:])
        for worker in list(self.workers.values()):
            if time.monotonic() - worker.heard > HANG_S:
                os.kill(
                    worker.process, signal.SIGABRT
                )  # the fault handler of pytest prints where it was

    def on_finish(
        self, worker: Worker, index: int, cpu: float, reports: list[dict[str, Any]]
    ) -> None:
        config, hook = self.session.config, self.session.config.hook
        test = self.session.items[index].nodeid
        self.cpu[test] = cpu
        read = hook.pytest_report_from_serializable
        parsed = [read(config=config, data=data) for data in reports]
        location = parsed[0].location  # of the item itself it would be searched for once more
        hook.pytest_runtest_logstart(nodeid=test, location=location)
        for report in parsed:
            hook.pytest_runtest_logreport(report=report)
        hook.pytest_runtest_logfinish(nodeid=test, location=location)

    def on_next(self, worker: Worker, able: bool) -> None:
        worker.connection.send(self.waiting.popleft() if able and self.waiting else None)

    def on_end(self, worker: Worker, peak_kb: int) -> None:
        self.largest_kb = max(self.largest_kb, peak_kb)
        worker.ended = True

    def lost(self, worker: Worker) -> None:
        """Remove a worker that closed its connection; fail the test that it left unfinished."""
        del self.workers[worker.connection]
        worker.connection.close()
        code = os.waitstatus_to_exitcode(os.waitpid(worker.process, 0)[1])
        if worker.ended:
            return
        test = worker.running.index
        if test < 0:
            raise RuntimeError(f"a worker ended between tests, exit code {code}")
        item = self.session.items[test]
        report = pytest.TestReport(
            nodeid=item.nodeid,
            location=item.location,
            keywords={},
            outcome="failed",
            longrepr=f"the worker ended during this test, exit code {code}",
            when="call",
        )
        item.ihook.pytest_runtest_logreport(report=report)
        rest = [each for each in self.batch_with(test) if each > test]
        if rest:
            self.waiting.appendleft(rest)

    def batch_with(self, test: int) -> list[int]:
        """Return the tests of the batch that has this one."""
        batch = batch_of(self.session.items[test].path)
        items = enumerate(self.session.items)
        return [index for index, item in items if batch_of(item.path) == batch]


def number_of_workers(text: str) -> int:
    """Convert the option: a number, or `auto` for two more than this process has processors."""
    if text != "auto":
        return int(text)
    processors = (
        len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    )
    return processors + 2  # many tests wait for programs


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--shuffle",
        type=int,
        metavar="SEED",
        help="run the files, and the tests of each file, in a random order",
    )
    parser.addoption(
        "--workers",
        type=number_of_workers,
        default=0,
        metavar="N",
        help="run the tests in N forked processes (auto: two more than processors)",
    )


def whole_tier(config: pytest.Config) -> str | None:
    """Return `all` or `quick` if this run is of all tests or of all quick ones, in workers."""
    option = config.option
    chosen = config.args_source is not config.ArgsSource.TESTPATHS or option.keyword
    if chosen or not option.workers or option.collectonly or not hasattr(os, "fork"):
        return None
    return {"": "all", "quick": "quick"}.get(option.markexpr)


@pytest.hookimpl(wrapper=True)
def pytest_collection(session: pytest.Session) -> Iterator[None]:
    """Collect without garbage collection: what is collected stays until the end."""
    if tier := whole_tier(session.config):
        background = Background(CHECKS if tier == "all" else ())
        session.config.stash[BACKGROUND] = background
        session.config.add_cleanup(background.end)
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Put the tests in a random order if `--shuffle` says so; those of a file stay together."""
    seed: int | None = config.option.shuffle
    if seed is None:
        return
    draw = Random(seed)
    files: dict[Path, list[pytest.Item]] = {}
    for item in items:
        files.setdefault(item.path, []).append(item)
    for each in files.values():
        draw.shuffle(each)
    order = list(files)
    draw.shuffle(order)
    items[:] = [item for path in order for item in files[path]]


@contextlib.contextmanager
def own_temporary_folder(session: pytest.Session) -> Iterator[None]:
    """Give the run a folder for temporary files; it fails if something of achse stays in there.

    Folders of pytest stay where they are looked for.
    """
    before = os.environ.get("TMPDIR")
    os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", tempfile.gettempdir())
    with tempfile.TemporaryDirectory(prefix="achse-run-", ignore_cleanup_errors=True) as folder:
        os.environ["TMPDIR"] = tempfile.tempdir = folder
        os.environ["ACHSE_STATE_DIR"] = f"{folder}/state"
        try:
            yield
        finally:
            tempfile.tempdir = None
            del os.environ["TMPDIR"], os.environ["ACHSE_STATE_DIR"]
            if before is not None:
                os.environ["TMPDIR"] = before
        if left := sorted(each.name for each in Path(folder).glob("achse-*")):
            report = pytest.TestReport(
                nodeid="tests/workers.py::nothing_stays_in_the_temporary_folder",
                location=("tests/workers.py", None, "nothing_stays_in_the_temporary_folder"),
                keywords={},
                outcome="failed",
                longrepr=f"{', '.join(left)} stayed in the temporary folder",
                when="call",
            )
            session.config.hook.pytest_runtest_logreport(report=report)


@contextlib.contextmanager
def shared_servers(python: bool) -> Iterator[None]:
    """Processes that have loaded achse and fork for all workers: for commands, and for Python.

    Each takes seconds of CPU time to load; they load side by side.
    """
    from tests import warm_python

    with contextlib.ExitStack() as stack:
        commands, programs = (
            Path(stack.enter_context(tempfile.TemporaryDirectory())) for _ in range(2)
        )
        ready = None
        if python and warm_commands.is_supported():
            ready = stack.enter_context(warm_python.starting(programs))
        stack.enter_context(warm_commands.warm_commands(commands))
        shared = {warm_commands.SHARED: str(commands)}
        if ready is not None:
            ready()
            shared[warm_python.SHARED] = str(programs)
        os.environ.update(shared)
        try:
            yield
        finally:
            for name in shared:
                del os.environ[name]


RUNNER = pytest.StashKey[Runner]()


@pytest.hookimpl(tryfirst=True)
def pytest_runtestloop(session: pytest.Session) -> bool | None:
    count: int = session.config.option.workers
    if not count or not hasattr(os, "fork") or session.config.option.collectonly:
        return None
    if session.testsfailed and not session.config.option.continue_on_collection_errors:
        return None  # pytest itself says so
    if len(session.items) > LARGE:
        from achse.st.declared.standard import standard_libraries
        from tests.prebuilt import build

        if background := session.config.stash.get(BACKGROUND, None):
            background.wait_for_kernels()
        build()
        standard_libraries()  # parsed once, not in each worker
        gc.freeze()
    runner = session.config.stash[RUNNER] = Runner(session, count, batches(session.items))
    session.config.stash[CPU] = runner.cpu
    with contextlib.ExitStack() as stack:
        if background := session.config.stash.get(BACKGROUND, None):
            stack.callback(background.end)
        stack.enter_context(own_temporary_folder(session))
        if len(session.items) > LARGE:
            folders = {item.path.parent for item in session.items}
            stack.enter_context(shared_servers(python=not folders.isdisjoint(PROGRAMS)))
        runner.run()
    return True


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Report what the run cost."""
    runner = terminalreporter.config.stash.get(RUNNER, None)
    if runner is None:
        return
    own = resident_kb()
    terminalreporter.write_line(
        f"{runner.forks} workers, the largest {runner.largest_kb // 1024} MB "
        f"({own // 1024} MB of them shared), CPU {cpu_seconds():.0f} s"
    )
