"""A good client beside each attack: it is answered in time, its samples are complete.

A station in a process of its own, an attacker in another one, and pyads, which knows nothing of
either. How long a request took is counted without the time in which station or client waited for a
processor: what a busy machine adds is not the station's fault, and no test fails for it.
"""

import asyncio
import json
import queue
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, suppress
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import pytest

import achse
from achse.ams import (
    AmsAddress,
    Command,
    Connection,
    DeviceError,
    Frame,
    NetId,
    RequestTimeout,
    TcpCommand,
)
from achse.ams.commands import EmptyRequest
from achse.ams.discovery import RouteRequest
from achse.router.access import hash_password
from achse.transport.udp import change_route, scan

ATTACKS = Path(__file__).parent / "hostile" / "attacks.py"

IN_TIME_S = 0.050
ROUNDS = 2
"""A late answer in one round may be chance; what an attack can do it does in each."""

PATIENCE_S = 600.0
"""A guard against hanging; no result depends on it."""

MEGABYTE = 1 << 20
ROOM = 48 * MEGABYTE
"""Memory beyond the limits: what the allocator does not give back."""

CONFIG = """
name = "attacked"
[router]
{router}
[system]
root = "files"
[limits]
buffered_bytes = 16777216
unread_bytes = 4194304
all_queue_bytes = 16777216
[[axis]]
id = 1
name = "X"
[[plc]]
globals = ["achse.station.demo:GVL"]
[[plc.task]]
cycle = "10ms"
programs = ["achse.station.demo:MAIN"]
[[route]]
name = "kept"
net_id = "7.7.7.7.1.1"
host = "{kept}"
"""

USERS = f'users = {{ Administrator = "{hash_password("1")}" }}'

LIMITED = 3 * 16 * MEGABYTE
"""What is held, queued and kept for taps together."""


def waited_s(task: Path) -> float:
    """How long a thread had work and no processor (Linux)."""
    with suppress(OSError):  # it has ended
        return int((task / "schedstat").read_text().split()[1]) / 1e9
    return 0.0


class Good:
    """pyads with a request after the other and samples of every cycle of the PLC."""

    def __init__(self, plc: Any, process: int) -> None:
        self.plc = plc
        self.station = Path(f"/proc/{process}")
        self.samples: list[tuple[int, int]] = []
        self._watch()

    def _watch(self) -> None:
        import pyads

        attributes = pyads.NotificationAttrib(4, pyads.ADSTRANS_SERVERCYCLE, 0.0, 0.01)

        @self.plc.notification(pyads.PLCTYPE_UDINT, timestamp_as_filetime=True)
        def take(handle: int, name: str, stamp: int, value: int) -> None:
            self.samples.append((stamp, value))

        self.handles = self.plc.add_device_notification("MAIN.nCounter", attributes, take)
        self.plc.read(0x4020, 100, pyads.PLCTYPE_UDINT)

    def close(self) -> None:
        with suppress(Exception):
            self.plc.del_device_notification(*self.handles)

    def ask(self) -> float:
        """Seconds from a request to its answer, without waiting for processors."""
        import pyads

        began, waited = time.monotonic(), self._waited()
        self.plc.read(0x4020, 100, pyads.PLCTYPE_UDINT)
        return time.monotonic() - began - (self._waited() - waited)

    def _waited(self) -> float:
        """All threads of both: one that holds the interpreter's lock keeps the others waiting."""
        processes = (Path("/proc/self"), self.station)
        return sum(waited_s(task) for each in processes for task in (each / "task").iterdir())

    def memory(self) -> int:
        """Bytes of the station that are in memory."""
        for line in (self.station / "status").read_text().splitlines():
            if line.startswith("VmRSS:"):
                return int(line.split()[1]) * 1024
        return 0


class Round(NamedTuple):
    """What the good client saw of one attack."""

    worst_s: float
    requests: int
    memory: int


class Attacker:
    """The process that attacks when told to."""

    def __init__(self, name: str, place: dict[str, Any]) -> None:
        self.process = subprocess.Popen(
            [sys.executable, str(ATTACKS), name],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self._lines: queue.Queue[str] = queue.Queue()
        self.rounds = 0
        threading.Thread(target=self._read, daemon=True).start()
        self._write_line(json.dumps(place))
        assert self._lines.get(timeout=PATIENCE_S) == "ready"

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self._lines.put(line.strip())
        self._lines.put("")

    def _write_line(self, text: str) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(text + "\n")
        self.process.stdin.flush()

    def begin(self) -> None:
        self.rounds += 1
        self._write_line("go")

    def going_on(self) -> bool:
        """Whether attacks that have begun have not ended."""
        while self.ended() is not None:
            pass
        return self.rounds > 0

    def ended(self) -> dict[str, Any] | None:
        """What it saw, once it is done."""
        with suppress(queue.Empty):
            line = self._lines.get_nowait()
            assert line, "the attacker broke"
            self.rounds -= 1
            seen: dict[str, Any] = json.loads(line)
            return seen
        return None

    def close(self) -> None:
        self.process.kill()
        self.process.communicate()


class Scene:
    """Station, good client, attackers."""

    def __init__(self, station: Any, good: Good, place: dict[str, Any]) -> None:
        self.station, self.good, self.place = station, good, place
        self.attackers: list[Attacker] = []
        self.before = good.memory()
        for _ in range(50):
            good.ask()

    def attack(self, name: str, *, grows: int = 0, rounds: int = ROUNDS, **more: Any) -> Any:
        """Attack until a round went well; what the attacker saw in the last one.

        `grows` are bytes that the attack may take beyond the limits.
        """
        attacker = Attacker(name, self.place | more)
        self.attackers.append(attacker)
        seen: list[Round] = []
        for _ in range(rounds):
            done, report = self._round(attacker)
            seen.append(done)
            if done.worst_s <= IN_TIME_S:
                break
        late = [f"{each.worst_s * 1e3:.0f} ms" for each in seen]
        assert min(each.worst_s for each in seen) <= IN_TIME_S, f"late answers: {late}"
        grown = max(each.memory for each in seen) - self.before
        allowed = LIMITED + ROOM + grows
        assert grown <= allowed, f"{grown >> 20} MB more, {allowed >> 20} MB are allowed"
        self.check_samples()
        return report

    def _round(self, attacker: Attacker) -> tuple[Round, dict[str, Any]]:
        good = self.good
        attacker.begin()
        delays: list[float] = []
        memory = 0
        while True:
            report = attacker.ended()
            delays.append(good.ask())
            memory = max(memory, good.memory())
            if report is not None:
                break
            time.sleep(0.001)
        return Round(max(delays), len(delays), memory), report

    def check_samples(self) -> None:
        """Every cycle of the PLC is there, one behind the other, up to the present."""
        good = self.good
        deadline = time.monotonic() + PATIENCE_S
        newest = good.plc.read_by_name("MAIN.nCounter")
        while not good.samples or good.samples[-1][1] < newest:
            assert time.monotonic() < deadline, "samples do not come any more"
            time.sleep(0.01)
        values = [value for _, value in list(good.samples)]
        gaps = [(a, b) for a, b in pairwise(values) if b != a + 1]
        assert gaps == [], f"{len(gaps)} gaps in {len(values)} samples"

    def pace(self, seconds: float) -> Callable[[], float]:
        """From now on: station time per time in which the station had a processor or slept."""
        began, waited, first = time.monotonic(), waited_s(self.good.station), self.good.samples[-1]

        def ratio() -> float:
            ran = time.monotonic() - began - (waited_s(self.good.station) - waited)
            return (self.good.samples[-1][0] - first[0]) / 1e7 / max(ran, seconds)

        return ratio

    def close(self) -> None:
        for attacker in self.attackers:
            attacker.close()
        self.good.close()


@pytest.fixture
def scene(
    tmp_path: Path,
    start_station: Callable[..., AbstractContextManager[Any]],
    pyads_connection: Callable[..., Any],
    free_host: Callable[[], str],
) -> Iterator[Callable[..., Scene]]:
    """`scene()`: a station with limits, pyads on it, and where attackers find it."""
    opened: list[Scene] = []
    running: list[AbstractContextManager[Any]] = []

    def open_scene(*, router: str = "", host: str | None = None) -> Scene:
        (tmp_path / "files").mkdir()
        file = tmp_path / "attacked.toml"
        file.write_text(CONFIG.format(router=router, kept=host or free_host()))
        context = start_station(str(file))
        station = context.__enter__()
        running.append(context)
        good = Good(pyads_connection(station, 851), station.process.pid)
        place = {
            "host": station.host, "port": station.port, "net_id": station.net_id,
            "attacker": free_host(), "udp_port": 48899,
        }  # fmt: skip
        opened.append(Scene(station, good, place))
        return opened[-1]

    yield open_scene
    for each in opened:
        each.close()
    for context in running:
        context.__exit__(None, None, None)


def asked_from(host: str, station: Any, port: int = 10000) -> Frame:
    """The answer to one request over a new connection from another address of this computer."""
    with socket.create_connection(
        (station.host, station.port), PATIENCE_S, source_address=(host, 0)
    ) as connection:
        source = AmsAddress(f"{host}.1.1:40000")
        target = AmsAddress(f"{station.net_id}:{port}")
        request = Frame(target, source, Command.READ_STATE, data=EmptyRequest().encode())
        connection.sendall(request.encode_tcp())
        stream = Connection()
        while data := connection.recv(4096):
            for event in stream.receive(data):
                assert isinstance(event, Frame)
                return event
    raise AssertionError("the connection was closed without an answer")


def test_taps(scene: Callable[..., Scene]) -> None:
    report = scene().attack("taps")
    assert report["taps"] <= 32


def test_logging(scene: Callable[..., Scene]) -> None:
    """Nobody reads its stderr, which is a pipe; at the end SIGTERM ends it all the same."""
    scene().attack("logging")


def test_routes(scene: Callable[..., Scene]) -> None:
    attacked = scene(router=USERS)
    report = attacked.attack("routes", victim=f"{attacked.station.net_id}:851")
    assert (report["answers"] > 100, report["granted"]) == (True, 0)
    with achse.blocking.connect(attacked.station.host, port=10000, watch_symbols=False) as system:
        entry = system.read_raw(803, 0, 1024)
        assert b"kept\0" in entry
        with pytest.raises(DeviceError):
            system.read_raw(803, 1, 1024)


def test_buffered_bytes(scene: Callable[..., Scene]) -> None:
    scene().attack("buffered_bytes")


def test_subscriptions_of_clients_that_vanish(scene: Callable[..., Scene]) -> None:
    attacked = scene()
    report = attacked.attack("subscriptions")
    assert report["rounds"] > 0
    deadline = time.monotonic() + PATIENCE_S
    with achse.blocking.connect(attacked.station.host, port=26000, watch_symbols=False) as own:
        while True:
            statistics = json.loads(own.read_raw(0xFA03, 0, 1 << 20))
            left = sum(device["subscriptions"] for device in statistics["devices"])
            if left <= 1:
                break
            assert time.monotonic() < deadline, f"{left} subscriptions are left"
            time.sleep(0.05)
    assert attacked.attack("returning")["foreign"] == 0


def test_samples_at_cycle_0(scene: Callable[..., Scene]) -> None:
    attacked = scene()
    ratio = attacked.pace(1.0)
    attacked.attack("samples", grows=256 * MEGABYTE)
    assert ratio() > 0.9


def test_connections_of_one_host(scene: Callable[..., Scene], free_host: Callable[[], str]) -> None:
    attacked = scene(router="max_connections = 500\nmax_connections_per_host = 200")
    attacked.attack("connections")
    assert asked_from(free_host(), attacked.station).error == 0


def test_datagrams(scene: Callable[..., Scene]) -> None:
    """Garbage and guesses crowd nobody out: a search is answered, so is who knows the password."""
    attacked = scene(router=USERS)
    attacked.attack("datagrams")
    for _ in range(10):
        attacked.attackers[-1].begin()
    known = RouteRequest("good", NetId("8.8.8.8.1.1"), "8.8.8.8", "Administrator", "1")

    async def get_in() -> int:
        while attacked.attackers[-1].going_on():
            with suppress(RequestTimeout):
                return await change_route(attacked.station.host, known, seconds=3.0)
        return -1

    assert asyncio.run(get_in()) == 0, "not while the attack went on"
    host = attacked.station.host
    deadline = time.monotonic() + PATIENCE_S
    while not (answers := asyncio.run(scan([host], all_of_them=False))):
        assert time.monotonic() < deadline, "searches are not answered"
    assert [str(info.net_id) for info, _ in answers] == [attacked.station.net_id]


def test_files(scene: Callable[..., Scene], tmp_path: Path) -> None:
    attacked = scene()
    many = tmp_path / "files" / "many"
    many.mkdir()
    for number in range(30_000):
        (many / f"{number}.txt").touch()
    report = attacked.attack("files")
    assert report["answers"] > 0


def test_client_ports(scene: Callable[..., Scene], free_host: Callable[[], str]) -> None:
    attacked = scene()
    report = attacked.attack("ports")
    assert report["ports"] > 0
    with socket.create_connection(
        (attacked.station.host, attacked.station.port), PATIENCE_S, source_address=(free_host(), 0)
    ) as connection:
        connection.sendall(struct.pack("<HIH", TcpCommand.PORT_CONNECT, 2, 0))
        answer = connection.recv(64)
    assert answer[:6] == struct.pack("<HI", TcpCommand.PORT_CONNECT, 8), "no port is left"


def test_loops_of_routes(
    scene: Callable[..., Scene],
    tmp_path: Path,
    start_station: Callable[..., AbstractContextManager[Any]],
    free_host: Callable[[], str],
) -> None:
    """Two stations, each of which believes that the other one leads to 7.7.7.7.1.1."""
    there = SimpleNamespace(host=free_host())
    attacked = scene(host=there.host)
    other = tmp_path / "other.toml"
    other.write_text(
        f"""
        [[route]]
        name = "round"
        net_id = "7.7.7.7.1.1"
        host = "{attacked.station.host}"
        """
    )
    with start_station(str(other), "--host", there.host, "--net-id", f"{there.host}.1.1"):
        attacked.attack("loops", nowhere="7.7.7.7.1.1")
