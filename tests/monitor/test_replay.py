"""A recording is served again: to clients of ours, and to pyads."""

import logging
import struct
from collections.abc import Callable
from typing import Any

import pytest

from achse.ams import Command
from achse.monitor.recording import Recording
from achse.monitor.replay import Replay
from achse.testing import Live, LiveStation, ManualClock, free_host


@pytest.fixture
def recording(traffic: Any) -> Recording:
    handle = traffic.handle("GVL.nInt")
    for value in (1, 2, 3):
        traffic.plc.put(0xF005, handle, "<h", value)
        traffic.plc.read(0xF005, handle, 2)
    traffic.plc.subscribe(0xF005, traffic.handle("MAIN.nCounter"), 4, cycle_s=0.01)
    traffic.station.advance(0.03)
    traffic.nc.read(0x4001, 0x02, 31)
    return Recording(traffic.captures())


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock()


@pytest.fixture
def replay(recording: Recording, clock: ManualClock) -> Replay:
    return Replay(recording, clock)


def _handle(plc: Any, name: bytes) -> int:
    return int.from_bytes(plc.exchange(0xF003, 0, 4, name), "little")


def test_answers_come_in_their_order_and_the_last_again(replay: Replay, client_of: Any) -> None:
    plc = client_of(replay.router, 851)
    handle = _handle(plc, b"gvl.NINT")
    assert [plc.get(0xF005, handle, "<h") for _ in range(5)] == [1, 2, 3, 3, 3]
    assert client_of(replay.router, 501).read(0x4001, 0x02, 31) == b"X".ljust(31, b"\0")


def test_sums_and_their_parts_are_answered_alike(replay: Replay, client_of: Any) -> None:
    plc = client_of(replay.router, 851)
    handle = _handle(plc, b"GVL.nInt\0")
    parts = struct.pack("<6I", 0xF005, handle, 2, 0xF005, handle, 2)
    assert plc.exchange(0xF080, 2, 12, parts) == struct.pack("<IIhh", 0, 0, 1, 2)


def test_samples_come_when_they_came(replay: Replay, clock: ManualClock, client_of: Any) -> None:
    plc = client_of(replay.router, 851)
    plc.subscribe(0xF005, _handle(plc, b"MAIN.nCounter\0"), 4, cycle_s=0.001)
    got = []
    for _ in range(6):
        got += [int.from_bytes(data, "little") for _, data in plc.samples()]
        clock.advance(0.001)
        replay.tick()
    assert got == [0, 0, 1, 2, 3, 3]  # recorded 1, 2, 3 and 4 ms after the subscription


def test_what_was_never_requested_is_reported_once(
    replay: Replay, client_of: Any, refused: Any, caplog: pytest.LogCaptureFixture
) -> None:
    plc = client_of(replay.router, 851)
    with caplog.at_level(logging.WARNING):
        for _ in range(2):
            with refused(0x701):
                plc.exchange(0xF003, 0, 4, b"GVL.nUint\0")
    assert caplog.text.count("not in the recording") == 1
    with refused(0x710):
        plc.read(0xF005, 4711, 2)


def test_state_and_name_are_those_of_the_target(traffic: Any, client_of: Any) -> None:
    from achse.ams.commands import EmptyRequest

    traffic.plc.ask(Command.READ_DEVICE_INFO, EmptyRequest())
    replay = Replay(Recording(traffic.captures()), ManualClock())
    info = client_of(replay.router, 851).ask(Command.READ_DEVICE_INFO, EmptyRequest())
    assert (info.name, info.build) == ("Plc30 App", 4024)


def test_pyads_meets_the_recorded_target(witness: Callable[[str], None]) -> None:
    witness("pyads")
    import pyads

    from achse.router.tap import Taps

    def use(host: str, net_id: str) -> list[Any]:
        with pyads.Connection(net_id, 851, host) as plc:
            plc.set_timeout(3_600_000)
            answers = [plc.read_device_info()[0], plc.read_state()]
            plc.write_by_name("GVL.nInt", 7, pyads.PLCTYPE_INT)
            answers.append(plc.read_by_name("GVL.nInt"))
            answers.append(plc.read_list_by_name(["GVL.nUint", "GVL.fReal"]))
            return answers

    with LiveStation() as station:
        taps = Taps(station.station.router, station.station.clock)
        tap = station.run(taps.open)
        live = use(station.host, station.net_id)
        recording = Recording(station.run(tap.take, 1 << 24))
    host = free_host()

    import contextlib
    from collections.abc import AsyncIterator

    @contextlib.asynccontextmanager
    async def open() -> AsyncIterator[tuple[str, int]]:
        async with Replay(recording).serving(host) as listener:
            yield listener.host, listener.port

    with Live(open):
        assert use(host, str(recording.net_id)) == live


def test_time_goes_on_while_the_clock_of_the_computer_jumps(
    recording: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    replay = Replay(recording)
    before = replay._clock()
    for hours in (-5, 5):
        monkeypatch.setattr("time.time_ns", lambda hours=hours: before + hours * 3600 * 10**9)
        assert 0 <= replay._clock() - before < 600 * 10**9
