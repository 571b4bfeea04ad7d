"""Stations in their own process, and strangers that talk to them."""

import json
import socket
import struct
import subprocess
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

import achse
from tests.conftest import WITNESSES
from tests.interop import waiting

if TYPE_CHECKING:
    import pyads

NPM = Path(__file__).parent / "npm"
TCP_PORT = 48898


@pytest.fixture(scope="session")
def start_station(
    start_station: Callable[..., AbstractContextManager[Any]],
) -> Callable[..., AbstractContextManager[Any]]:
    """`start_station` of all tests; here a wait fails when the station has ended."""

    @contextmanager
    def start(*arguments: str, real: bool = False) -> Iterator[Any]:
        with start_station(*arguments, real=real) as running, waiting.needed(running.process):
            yield running

    return start


@pytest.fixture(scope="module")
def station(
    start_station: Callable[..., AbstractContextManager[Any]],
) -> Iterator[Any]:
    """The demo station in its own process, shared by the tests of one file."""
    with start_station() as running:
        yield running


PATIENT_MS = 600_000
"""Time-out of requests: a guard against hanging. On a busy machine the 5 s of pyads may pass."""


NO_LATE_REQUESTS = {"deleteUnknownSubscriptions": False}
"""Setting of ads-client. Else it deletes a subscription once more when a sample comes after the
answer to its delete; while it disconnects, nobody answers, and Node runs until PATIENT_MS."""


@pytest.fixture(autouse=True, scope="session")
def patient_clients() -> Iterator[None]:
    """Requests of pyads and of our own clients have PATIENT_MS, unless a test says otherwise."""
    with pytest.MonkeyPatch.context() as patch:
        for connect in (achse.connect, achse.blocking.connect):
            defaults = connect.__kwdefaults__
            assert defaults is not None
            assert defaults["timeout"] == 5.0
            patch.setitem(defaults, "timeout", PATIENT_MS / 1e3)
        if WITNESSES["pyads"]():
            import pyads

            opens = pyads.Connection.open

            def open_patiently(connection: "pyads.Connection") -> None:
                opens(connection)
                if connection._port is not None:
                    connection.set_timeout(PATIENT_MS)

            patch.setattr(pyads.Connection, "open", open_patiently)
        yield


def close_port(connection: "pyads.Connection") -> None:
    """End the subscriptions of a connection, while there is a route for that."""
    import pyads.pyads_ex

    if connection._port is not None:
        pyads.pyads_ex.adsPortCloseEx(connection._port)
        connection._port = None


class _KeptCallbacks(dict[Any, Any]):
    """pyads frees a callback with its subscription, while a last sample may still call it."""

    def pop(self, key: Any, default: Any = None) -> Any:
        return self.get(key, default)


@pytest.fixture(autouse=True, scope="session")
def kept_callbacks() -> Iterator[None]:
    """Whatever ends a subscription of pyads, its callback stays: the process would end."""
    with pytest.MonkeyPatch.context() as patch:
        if WITNESSES["pyads"]():
            import pyads.pyads_ex

            patch.setattr(pyads.pyads_ex, "callback_store", _KeptCallbacks())
        yield


@pytest.fixture
def pyads_connection(witness: Callable[[str], None]) -> Iterator[Callable[..., "pyads.Connection"]]:
    """`pyads_connection(station, 851)` opens a pyads connection, closed when the test ends.

    pyads keeps one route per NetId and drops it when the first of its connections is closed;
    therefore all stay open until the end. A connection drops its route before its port: a
    subscription that is left then, as in a test that failed, makes its library read freed memory.
    Therefore ports go first.
    """
    witness("pyads")
    import pyads

    with ExitStack() as connections:

        def connect(station: Any, port: int, host: str | None = None) -> pyads.Connection:
            opened = connections.enter_context(
                pyads.Connection(station.net_id, port, host or station.host)
            )
            connections.callback(close_port, opened)
            return opened

        yield connect


@pytest.fixture
def plc(station: Any, pyads_connection: Callable[..., "pyads.Connection"]) -> "pyads.Connection":
    """pyads on the station's PLC."""
    return pyads_connection(station, 851)


@pytest.fixture(scope="session")
def until() -> Callable[[Callable[[], object]], None]:
    """`until(lambda: …)` returns once the condition holds."""
    return waiting.until


@pytest.fixture
def pass_station_time(
    station: Any, pyads_connection: Callable[..., "pyads.Connection"]
) -> Callable[[float], None]:
    """`pass_station_time(0.05)` returns when so many seconds have passed for the station's NC."""
    import pyads

    def wait(seconds: float) -> None:
        nc = pyads_connection(station, 501)
        stamps: list[int] = []

        def note(notification: Any, _: Any) -> None:
            stamps.append(nc.parse_notification(notification, None, True)[1])

        attributes = pyads.NotificationAttrib(
            4, pyads.ADSTRANS_SERVERCYCLE, max_delay=0, cycle_time=10
        )
        axis_state = (0x4101, 0)
        handles = nc.add_device_notification(axis_state, attributes, note)
        waiting.until(lambda: stamps and stamps[-1] - stamps[0] >= seconds * 1e7)
        nc.del_device_notification(*handles)

    return wait


@pytest.fixture
def node(witness: Callable[[str], None]) -> Callable[..., Any]:
    """`node("variables.mjs", station, "direct")` runs a script of npm/ and returns its result.

    In router mode ads-client registers a port with the router; in direct mode it brings its own
    NetId and port, as from another machine.
    """
    witness("ads-client")

    def run(script: str, station: Any, mode: str, host: str | None = None) -> Any:
        settings = {
            "routerAddress": host or station.host,
            "routerTcpPort": station.port,
            "targetAmsNetId": station.net_id,
            "targetAdsPort": 851,
            "timeoutDelay": PATIENT_MS,
            **NO_LATE_REQUESTS,
        }
        if mode == "direct":
            settings |= {"localAmsNetId": "192.0.2.7.1.1", "localAdsPort": 32750}
        finished = subprocess.run(
            ["node", script, json.dumps(settings)],
            cwd=NPM,
            capture_output=True,
            text=True,
        )
        assert finished.returncode == 0, finished.stderr + finished.stdout
        return json.loads(finished.stdout)

    return run


class Tap:
    """A wire tap between clients and a station: relays TCP and writes what passed as a capture.

    The capture has one TCP segment per AMS frame, however the pieces came: no privilege is needed,
    nothing is lost at the start or end, and tshark, which reads only the first frame of a segment
    when a notification begins it, sees all.
    """

    def __init__(self, host: str, station: Any) -> None:
        self.host = host
        self._packets: list[bytes] = []
        self._station = (station.host, station.port)
        self._lock = threading.Lock()
        self._sockets = [socket.create_server((host, station.port))]
        self._threads: list[threading.Thread] = []
        self._run(self._accept)

    def close(self) -> None:
        """Close every connection and stop listening."""
        for each in self._sockets:
            with suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
            each.close()
        for thread in self._threads:
            thread.join()

    def _run(self, work: Callable[..., None], *arguments: Any) -> None:
        thread = threading.Thread(target=work, args=arguments, daemon=True)
        self._threads.append(thread)
        thread.start()

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                client, (_, port) = self._sockets[0].accept()
                station = socket.create_connection(self._station)
                self._sockets += [client, station]
                passed = {client: 1, station: 1}
                self._run(self._relay, client, station, (port, TCP_PORT), passed)
                self._run(self._relay, station, client, (TCP_PORT, port), passed)

    def _relay(
        self,
        source: socket.socket,
        sink: socket.socket,
        ports: tuple[int, int],
        passed: dict[socket.socket, int],
    ) -> None:
        stream = b""
        with suppress(OSError):
            while data := source.recv(32768):
                frames, stream = _frames(stream + data)
                with self._lock:
                    for frame in frames:
                        self._packets.append(_ip(*ports, passed[source], passed[sink], frame))
                        passed[source] += len(frame)
                sink.sendall(data)
            sink.shutdown(socket.SHUT_WR)

    def write(self, path: Path) -> None:
        """Write the capture as pcap, one packet per µs."""
        with self._lock, path.open("wb") as file:
            file.write(struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 0x40000, 101))  # raw IP
            for number, packet in enumerate(self._packets):
                file.write(struct.pack("<IIII", 0, number, len(packet), len(packet)) + packet)


def _frames(stream: bytes) -> tuple[list[bytes], bytes]:
    """The whole AMS/TCP frames at the start of the stream, and what is left of it."""
    frames: list[bytes] = []
    while len(stream) >= 6 and len(stream) >= (size := 6 + struct.unpack_from("<I", stream, 2)[0]):
        frames.append(stream[:size])
        stream = stream[size:]
    return frames, stream


def _ip(source: int, target: int, sequence: int, acknowledged: int, data: bytes) -> bytes:
    loopback = bytes([127, 0, 0, 1])
    ip = struct.pack(">BBHHHBBH", 0x45, 0, 40 + len(data), 0, 0, 64, 6, 0) + loopback + loopback
    tcp = struct.pack(
        ">HHIIBBHHH", source, target, sequence, acknowledged, 0x50, 0x18, 0xFFFF, 0, 0
    )
    return ip + tcp + data


@pytest.fixture
def tap(station: Any, free_host: Callable[[], str]) -> Iterator[Tap]:
    """A wire tap in front of the station: dial `tap.host` instead of `station.host`."""
    running = Tap(free_host(), station)
    yield running
    running.close()
