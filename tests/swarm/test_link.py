"""The link: bytes arrive in order after their delay, wherever they are cut."""

import asyncio
import random

import pytest

from achse.ams import AmsAddress, Command, Connection, Frame, NetId
from achse.station import Station
from achse.swarm.link import NetworkLink, StationScheduler
from achse.swarm.worlds.world import DrawnClient
from achse.transport.tcp.listener import TcpListener

CLIENT = AmsAddress.of(NetId("5.6.7.8.1.1"), 40_000)


class Far:
    """Keeps what arrives."""

    def __init__(self) -> None:
        self.stream = Connection()
        self.frames: list[Frame] = []
        self.lost_count = 0

    def receive(self, data: bytes) -> None:
        self.frames += [each for each in self.stream.receive(data) if isinstance(each, Frame)]

    def lost(self) -> None:
        self.lost_count += 1


def connect(part: DrawnClient) -> tuple[Station, NetworkLink, Far, TcpListener]:
    station, far = Station.demo(), Far()
    scheduler = StationScheduler(station)
    listener = TcpListener(station.router)
    listener.begin(scheduler)
    station.admit(listener)
    return station, NetworkLink(listener, scheduler, part, far, 50_000, lambda: None), far, listener


@pytest.mark.parametrize("seed", range(6))
def test_requests_are_answered_in_order_after_the_delay(seed: int) -> None:
    dice = random.Random(seed)
    delay = dice.choice((0, 1_000_000, 50_000_000))
    part = DrawnClient("watch", delay, dice.choice((0, 7, 40)), False)
    station, link, far, _ = connect(part)
    target = AmsAddress.of(station.router.net_id, 851)
    for invoke in range(20):
        link.send(Frame(target, CLIENT, Command.READ_STATE, 4, 0, invoke).encode_tcp())
    if delay:
        station.advance(1.9 * delay / 1e9)
        assert not far.frames
    station.advance(0.1 + delay / 1e9)
    assert [frame.invoke_id for frame in far.frames] == list(range(20))


@pytest.mark.parametrize("orderly", [True, False])
def test_station_learns_that_a_client_has_left(orderly: bool) -> None:
    station, link, far, listener = connect(DrawnClient("watch", 1_000_000, 0, False))
    assert len(listener.connections) == 1
    link.hang_up(orderly=orderly)
    station.advance(0.01)
    assert link.ended
    assert not listener.connections
    assert not far.lost_count


def test_client_learns_that_the_station_has_closed() -> None:
    station, link, far, _ = connect(DrawnClient("watch", 1_000_000, 0, False))
    station.faults.add("drop_link")
    station.advance(0.01)
    assert link.ended
    assert far.lost_count == 1


def test_client_that_does_not_read_leaves_bytes_on_the_link() -> None:
    station, link, far, _ = connect(DrawnClient("watch", 0, 0, False))
    link.read(False)
    target = AmsAddress.of(station.router.net_id, 851)
    link.send(Frame(target, CLIENT, Command.READ_STATE, 4, 0, 1).encode_tcp())
    station.advance(0.01)
    assert not far.frames
    assert link.get_write_buffer_size() > 0
    link.read(True)
    assert len(far.frames) == 1
    assert link.get_write_buffer_size() == 0


def test_lines_without_sockets_are_let_in_from_begin_until_close() -> None:
    station, far = Station.demo(), Far()
    scheduler, listener = StationScheduler(station), TcpListener(station.router)
    part = DrawnClient("watch", 0, 0, False)
    assert not NetworkLink(listener, scheduler, part, far, 1, lambda: None).peer.connected
    listener.begin(scheduler)
    assert NetworkLink(listener, scheduler, part, far, 2, lambda: None).peer.connected
    asyncio.run(listener.close())
    assert not NetworkLink(listener, scheduler, part, far, 3, lambda: None).peer.connected
