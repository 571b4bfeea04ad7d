"""Connections break off, are refused, or close each other."""

import asyncio
import contextlib

import pytest

from achse.station import Station

NAME = b"MAIN.nCounter\0"


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


@pytest.mark.parametrize(
    ("client", "left"), [("", 0), ("127.0.0.1", 0), ("127.0.0.2", 1), ("10.0.0.9.1.1", 1)]
)
async def test_connections_of_a_client_break_off(station: Station, client: str, left: int) -> None:
    async with station.running("127.0.0.1", 0, speed=0) as running:
        reader, writer = await asyncio.open_connection("127.0.0.1", running.tcp_port)
        while not running.listener.connections:  # noqa: ASYNC110
            await asyncio.sleep(0)
        station.faults.add("drop_link", client=client)
        if not left:
            with contextlib.suppress(ConnectionResetError):
                assert await reader.read(1) == b""
        assert len(running.listener.connections) == left
        writer.close()


async def test_a_second_connection_closes_the_first(station: Station) -> None:
    station.faults.add("one_connection")
    async with station.running("127.0.0.1", 0, speed=0) as running:
        first = await asyncio.open_connection("127.0.0.1", running.tcp_port)
        second = await asyncio.open_connection("127.0.0.1", running.tcp_port)
        with contextlib.suppress(ConnectionResetError):
            assert await first[0].read(1) == b""
        for _, writer in (first, second):
            writer.close()
