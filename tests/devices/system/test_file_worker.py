"""The thread of the file services: turns of clients, limits, its end."""

import asyncio
import threading
from collections.abc import Iterator

import pytest

from achse.ams import DeviceError
from achse.devices.system import file_worker
from achse.devices.system.file_worker import FileWorker
from achse.server.deferred import Result


@pytest.fixture
def gate() -> Iterator[threading.Event]:
    """What jobs of the test wait for."""
    event = threading.Event()
    yield event
    event.set()


class Desk:
    """A worker, and the answers in the order in which they came."""

    def __init__(self, gate: threading.Event) -> None:
        self.gate = gate
        self.worker = FileWorker(asyncio.get_running_loop())
        self.done: list[str] = []
        self.answered = asyncio.Event()
        self.wanted = 0

    def ask(self, client: bytes, name: str, size: int = 0) -> None:
        def job() -> bytes:
            assert self.gate.wait(60)
            if name == "bad":
                raise DeviceError(0x70C)
            return name.encode()

        self.wanted += 1
        self.worker.later(client, size, job).start(self.take)

    def take(self, result: Result) -> None:
        try:
            self.done.append(result().decode())
        except DeviceError as refusal:
            self.done.append(hex(refusal.code))
        if len(self.done) == self.wanted:
            self.answered.set()


async def test_clients_take_turns_and_each_keeps_its_order(gate: threading.Event) -> None:
    desk = Desk(gate)
    desk.ask(b"first", "0")
    while desk.worker._waiting:  # noqa: ASYNC110
        await asyncio.sleep(0)
    for client in (b"a", b"b", b"c"):
        for number in range(2):
            desk.ask(client, f"{client.decode()}{number}")
    desk.ask(b"a", "bad")
    gate.set()
    await desk.answered.wait()
    assert desk.done == ["0", "a0", "b0", "c0", "a1", "b1", "c1", "0x70c"]
    desk.worker.stop()
    assert not desk.worker._thread.is_alive()


async def test_what_waits_is_limited(gate: threading.Event) -> None:
    desk = Desk(gate)
    for number in range(65):  # one of them is being done
        desk.ask(b"a", str(number))
        while number == 0 and desk.worker._waiting:  # noqa: ASYNC110
            await asyncio.sleep(0)
    with pytest.raises(DeviceError, match="64 file requests") as refusal:
        desk.ask(b"a", "more")
    assert refusal.value.code == 0x708
    desk.ask(b"b", "1", 64 * 1024 * 1024)
    with pytest.raises(DeviceError):
        desk.ask(b"c", "1", 1)
    desk.wanted -= 2
    gate.set()
    await desk.answered.wait()
    assert len(desk.done) == 66
    desk.ask(b"c", "1", 1)
    desk.worker.stop()


async def test_requests_of_many_addresses_are_limited_together(
    gate: threading.Event, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before, a flood from ever new addresses waited without bound: 45 MB in a second."""
    monkeypatch.setattr(file_worker, "_ALL_CLIENTS", 5)
    desk = Desk(gate)
    desk.ask(b"first", "0")
    while desk.worker._waiting:  # noqa: ASYNC110
        await asyncio.sleep(0)
    for number in range(5):
        desk.ask(b"%d" % number, str(number))
    with pytest.raises(DeviceError, match="0 file requests of the client wait, 5 of all"):
        desk.ask(b"more", "more")
    desk.wanted -= 1
    desk.worker.end_client(b"4", lambda: None)
    desk.wanted -= 1
    gate.set()
    await desk.answered.wait()
    while desk.worker._waiting:  # noqa: ASYNC110
        await asyncio.sleep(0)
    assert (desk.done, desk.worker._count) == (["0", "0", "1", "2", "3"], 0)
    desk.worker.stop()


async def test_results_that_the_loop_has_not_taken_are_limited(
    gate: threading.Event, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before, a loop that was busy for seconds found gigabytes of results."""
    monkeypatch.setattr(file_worker, "_RESULT_BYTES", 2)
    gate.set()
    desk = Desk(gate)
    results: list[int] = []

    def job() -> bytes:
        results.append(desk.worker._result_bytes)
        return b"x"

    desk.wanted = 6
    for _ in range(desk.wanted):
        desk.worker.later(b"a", 0, job).start(desk.take)
    while desk.worker._result_bytes < 2:
        threading.Event().wait(0)
    await desk.answered.wait()
    assert (len(results), max(results), desk.worker._result_bytes) == (6, 1, 0)
    desk.worker.stop()


async def test_a_client_that_is_gone_wants_nothing_more(gate: threading.Event) -> None:
    desk = Desk(gate)
    ended = threading.Event()
    desk.ask(b"other", "1")
    for _ in range(3):
        desk.ask(b"a", "2", 1000)
    desk.worker.end_client(b"a", ended.set)
    desk.wanted = 1
    gate.set()
    await desk.answered.wait()
    assert ended.wait(60)
    assert desk.done[0] == "1"
    assert desk.worker._bytes == 0
    desk.worker.stop()


async def test_a_disk_that_hangs_does_not_hold_up_the_end(
    gate: threading.Event, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("achse.devices.system.file_worker._PATIENCE", 0.01)
    desk = Desk(gate)
    desk.ask(b"a", "1")
    while desk.worker._waiting:  # noqa: ASYNC110
        await asyncio.sleep(0)
    desk.worker.stop()
    assert desk.worker._thread.is_alive()
    assert desk.worker._thread.daemon
