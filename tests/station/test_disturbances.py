"""What each kind of fault does, seen by a client inside the process, in virtual time."""

import struct
from typing import Any

import pytest

from achse.ams import Command, DeviceError, Frame
from achse.ams.commands import ReadRequest
from achse.client import connect
from achse.station import Station

NAME = b"MAIN.nCounter\0"


@pytest.fixture
def station() -> Station:
    return Station.demo()


class Client:
    """Sends requests without waiting and keeps what comes."""

    def __init__(self, station: Station, port: int = 851) -> None:
        self.router = station.router
        self.address = self.router.register(0, self)
        self.target = self.address.of(self.router.net_id, port)
        self.frames: list[Frame] = []

    def deliver(self, frame: Frame) -> bool:
        self.frames.append(frame)
        return True

    def send(self, number: int, command: int = Command.READ_STATE, data: bytes = b"") -> None:
        self.router.deliver(Frame(self.target, self.address, command, 4, 0, number, data))

    def read(self, number: int, group: int, offset: int) -> None:
        self.send(number, Command.READ, ReadRequest(group, offset, 4).encode())

    @property
    def numbers(self) -> list[int]:
        """The invoke ids that came since the last look."""
        frames, self.frames = self.frames, []
        return [frame.invoke_id for frame in frames]


@pytest.fixture
def client(station: Station) -> Client:
    return Client(station)


def test_drop_hits_what_it_selects_and_no_more(station: Station, client: Client) -> None:
    active = station.faults.add("drop", command="read", group=0x4020, offset=8, count=2)
    for number, (group, offset) in enumerate([(0x4020, 8), (0x4020, 4), (0x4040, 8)] * 3):
        client.read(number, group, offset)
    assert client.numbers == [1, 2, 4, 5, 6, 7, 8]
    assert (active.hits, active.state) == (2, "over")


def test_each_nth_frame(station: Station, client: Client) -> None:
    station.faults.add("drop", every=3)
    for number in range(1, 10):
        client.send(number)
    assert client.numbers == [1, 2, 4, 5, 7, 8]


@pytest.mark.parametrize(("side", "written"), [("answer", 7), ("request", 0)])
def test_a_lost_answer_was_carried_out_and_a_lost_request_was_not(
    station: Station, client: Client, client_of: Any, side: str, written: int
) -> None:
    station.faults.add("drop", command="write", side=side)
    client.send(1, Command.WRITE, struct.pack("<4I", 0x4020, 0, 4, 7))
    assert client.numbers == []
    assert client_of(station.router, 851).get(0x4020, 0, "<I") == written


def test_delay_is_station_time(station: Station, client: Client) -> None:
    station.faults.add("delay", by=0.05, count=1)
    client.send(1)
    client.send(2)
    assert client.numbers == [2]
    station.advance(0.048)
    assert client.numbers == []
    station.advance(0.002)
    assert client.numbers == [1]


def test_duplicate(station: Station, client: Client) -> None:
    station.faults.add("duplicate", count=1)
    client.send(1)
    client.send(2)
    assert client.numbers == [1, 1, 2]


def test_reorder_swaps_neighbours_and_lets_a_lonely_one_go(
    station: Station, client: Client
) -> None:
    station.faults.add("reorder", by=0.02)
    for number in (1, 2, 3):
        client.send(number)
    assert client.numbers == [2, 1]
    station.advance(0.02)
    assert client.numbers == [3]


def test_truncate_and_wrong_invoke_id(station: Station, client: Client) -> None:
    station.faults.add("truncate", size=3, count=1)
    client.send(1)
    assert client.frames[0].data == bytes.fromhex("00000000 05")
    assert client.numbers == [1]
    station.faults.add("wrong_invoke_id", count=1)
    client.send(2)
    assert client.numbers == [2 ^ 0x8000_0000]


def test_an_error_on_a_command_has_the_full_length(station: Station, client: Client) -> None:
    station.faults.add("error", command="read_state", code=0x745)
    client.send(1)
    assert client.frames[0].data == struct.pack("<II", 0x745, 0)
    station.faults.clear()
    station.faults.add("router_error", code=7)
    client.send(2)
    assert (client.frames[1].error, client.frames[1].data) == (7, b"")


def test_a_fault_of_one_client_spares_the_others(station: Station, client: Client) -> None:
    other = Client(station)
    station.faults.add("drop", client=str(client.address))
    client.send(1)
    other.send(2)
    assert (client.numbers, other.numbers) == ([], [2])


def test_notifications_can_be_dropped(station: Station, client_of: Any) -> None:
    plc = client_of(station.router, 851)
    plc.subscribe(0x4020, 0, 4, cycle_s=0.01)
    plc.samples()
    station.faults.add("drop", command="notification", count=3)
    station.advance(0.1)
    assert len(plc.samples()) == 7


def test_an_error_on_a_symbol_meets_name_handle_address_and_sums(
    station: Station, client_of: Any
) -> None:
    plc = client_of(station.router, 851)
    (handle,) = struct.unpack("<I", plc.exchange(0xF003, 0, 4, NAME))
    group, offset, size = struct.unpack("<III", plc.exchange(0xF007, 0, 12, NAME))
    station.faults.add("error", symbol="main.ncounter", code=0x706)
    asks = {
        "name": lambda: plc.exchange(0xF004, 0, 4, NAME),
        "handle": lambda: plc.read(0xF005, handle, 4),
        "address": lambda: plc.read(group, offset, size),
        "within": lambda: plc.read(group, offset - 8, 16),
        "write": lambda: plc.write(0xF005, handle, bytes(4)),
        "watch": lambda: plc.subscribe(0xF005, handle, 4),
    }
    for what, ask in asks.items():
        with pytest.raises(DeviceError) as refusal:
            ask()
        assert (what, refusal.value.code) == (what, 0x706)
    parts = struct.pack("<6I", 0xF005, handle, 4, 0x4020, 0, 4)
    assert plc.exchange(0xF080, 2, 16, parts) == struct.pack("<4I", 0x706, 0, 0, 0)
    assert len(plc.read(group, offset + size, 4)) == 4
    station.faults.clear()
    assert len(plc.read(0xF005, handle, 4)) == 4


def test_an_error_on_a_service_that_the_device_does_not_have(
    station: Station, client_of: Any, refused: Any
) -> None:
    plc = client_of(station.router, 851)
    station.faults.add("error", port=851, group=0x1234, code=0x70A, count=1)
    with refused(0x70A):
        plc.read(0x1234, 0, 4)
    with refused(0x701):
        plc.read(0x1234, 0, 4)


def test_online_change_makes_handles_stale_and_keeps_values(
    station: Station, client_of: Any, refused: Any
) -> None:
    plc = client_of(station.router, 851)
    handle = struct.unpack("<I", plc.exchange(0xF003, 0, 4, NAME))[0]
    station.advance(0.1)
    (version,) = plc.read(0xF008, 0, 1)
    station.faults.add("online_change")
    with refused(0x711):
        plc.read(0xF005, handle, 4)
    assert plc.read(0xF008, 0, 1) == bytes((version + 1,))
    assert plc.exchange(0xF004, 0, 4, NAME) == struct.pack("<I", 10)


def test_download_starts_from_initial_values_without_notifications(
    station: Station, client_of: Any
) -> None:
    plc = client_of(station.router, 851)
    plc.subscribe(0x4020, 0, 4, cycle_s=0.01)
    station.advance(0.1)
    plc.samples()
    station.faults.add("download")
    assert plc.exchange(0xF004, 0, 4, NAME) == bytes(4)
    station.advance(0.1)
    assert plc.samples() == []
    assert plc.exchange(0xF004, 0, 4, NAME) == struct.pack("<I", 10)


def test_a_slow_cycle_loses_cycles_and_counts_them(station: Station, client_of: Any) -> None:
    plc = client_of(station.router, 851)
    station.faults.add("slow_cycle", factor=4, lasting=0.4)
    station.advance(0.4)
    assert plc.exchange(0xF004, 0, 4, NAME) == struct.pack("<I", 10)
    task = station.plcs[851].tasks[0]
    assert (task.exceed_count, task.last_exec_ns) == (10, 40_000_000)
    station.advance(0.4)
    assert task.exceed_count <= 11
    assert struct.unpack("<I", plc.exchange(0xF004, 0, 4, NAME))[0] in range(46, 51)


def test_slow_cycles_one_upon_the_other_end_in_the_configured_one(station: Station) -> None:
    station.faults.add("slow_cycle", factor=2, lasting=1.0)
    station.advance(0.5)
    station.faults.add("slow_cycle", factor=4, lasting=1.0)
    seen = []
    for _ in range(3):
        seen.append(station.plcs[851].tasks[0].stretch)
        station.advance(0.6)
    assert seen == [4, 4, 1]


def test_what_stands_goes_on_after_a_restart(
    station: Station, client_of: Any, refused: Any
) -> None:
    station.faults.add("slow_cycle", factor=4)
    station.faults.add("error", symbol="MAIN.nCounter", code=0x706)
    station.faults.add("error", port=851, group=0x1234, code=0x70A)
    station.faults.add("truncate", symbol="GVL.nInt", size=2)
    station.restart()
    station.advance(1)
    plc = client_of(station.router, 851)
    with refused(0x706):
        plc.exchange(0xF004, 0, 4, NAME)
    with refused(0x70A):
        plc.read(0x1234, 0, 4)
    assert station.plcs[851].tasks[0].stretch == 4
    client = Client(station)
    place = plc.exchange(0xF007, 0, 12, b"GVL.nInt\0")[:8]
    client.read(1, *struct.unpack("<II", place))
    assert len(client.frames[0].data) == 10
    station.faults.clear()
    assert len(plc.exchange(0xF004, 0, 4, NAME)) == 4
    with refused(0x701):
        plc.read(0x1234, 0, 4)
    assert station.plcs[851].tasks[0].stretch == 1


async def test_an_error_on_a_symbol_selects_clients_by_the_host_they_are_at() -> None:
    station = Station.demo()
    station.faults.add("error", symbol="GVL.nInt", client="127.0.0.1", code=0x706, count=1)
    station.faults.add("error", symbol="GVL.nInt", client="127.0.0.9", code=0x707)
    async with (
        station.running("127.0.0.1", 0, speed=0) as running,
        connect(f"127.0.0.1:{running.tcp_port}", watch_symbols=False) as plc,
    ):
        with pytest.raises(DeviceError, match="0x706"):
            await plc.read("GVL.nInt")
        assert await plc.read("GVL.nInt") == -16


async def test_links_refused_from_the_start_and_twice_are_taken_again_in_the_end() -> None:
    station = Station.demo()
    station.faults.add("refuse_links", lasting=1.0)
    station.faults.add("one_connection")
    async with station.running("127.0.0.1", 0, speed=0) as running:
        limits = []
        for _ in range(3):
            limits.append((running.listener.accepting, running.listener.strict))
            station.advance(0.6)
            station.faults.add("refuse_links", lasting=0.3)
        assert limits == [(False, True)] * 3
        station.advance(0.4)
        station.faults.clear()
        assert (running.listener.accepting, running.listener.strict) == (True, False)


def test_the_way_to_clear_faults_is_spared(station: Station) -> None:
    station.faults.add("drop")
    own = Client(station, 26_000)
    own.send(1)
    assert own.numbers == [1]  # refused or answered, but not lost
