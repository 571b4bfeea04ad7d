"""A relay lets everything through and sees what is AMS."""

import asyncio
import logging
from collections.abc import Callable

import pytest

import achse
from achse.monitor import relay as relay_module
from achse.monitor.relay import Relay
from achse.router.tap import Captured
from achse.station import Station


def test_a_client_behind_it_works_and_is_seen(client_of: object) -> None:
    seen: list[Captured] = []

    async def main() -> int:
        station = Station.demo()
        async with station.running("127.0.0.1", 0, speed=20.0) as running:
            relay = Relay(running.host, running.tcp_port, seen.append)
            await relay.open("127.0.0.1", 0)
            async with achse.connect(f"{relay.host}:{relay.port}") as plc:
                await plc.write("GVL.nInt", 5)
                value = await plc.read("GVL.nInt")
                async with plc.subscribe("MAIN.nCounter", cycle_time=0.01) as samples:
                    async for _ in samples:
                        break
            await relay.close()
        return int(value)

    assert asyncio.run(main()) == 5
    commands = {(capture.frame.command, capture.inwards) for capture in seen}
    assert {(9, True), (9, False), (3, True), (2, True), (6, True), (8, False)} <= commands
    assert all(capture.peer.startswith("127.0.0.1:") for capture in seen)


async def _through(
    serve: Callable[[asyncio.StreamReader, asyncio.StreamWriter], None], data: bytes
) -> tuple[bytes, list[Captured]]:
    seen: list[Captured] = []

    async def echo(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.write(await reader.read())
        writer.close()

    target = await asyncio.start_server(echo, "127.0.0.1", 0)
    relay = Relay("127.0.0.1", target.sockets[0].getsockname()[1], seen.append)
    await relay.open("127.0.0.1", 0)
    reader, writer = await asyncio.open_connection(relay.host, relay.port)
    writer.write(data)
    writer.write_eof()
    came = await reader.read()
    writer.close()
    await relay.close()
    target.close()
    return came, seen


def test_what_is_no_ams_goes_through_unseen(caplog: pytest.LogCaptureFixture) -> None:
    data = b"GET / HTTP/1.1\r\n\r\n"
    with caplog.at_level(logging.WARNING):
        came, seen = asyncio.run(_through(lambda *_: None, data))
    assert (came, seen) == (data, [])
    assert "not AMS" in caplog.text


def test_a_target_that_is_not_there_closes_the_client(caplog: pytest.LogCaptureFixture) -> None:
    async def main() -> bytes:
        relay = Relay("127.0.0.1", 1, lambda _: None)
        await relay.open("127.0.0.1", 0)
        reader, writer = await asyncio.open_connection(relay.host, relay.port)
        data = await reader.read()
        writer.close()
        await relay.close()
        return data

    assert asyncio.run(main()) == b""
    assert "does not let" in caplog.text


def test_what_cannot_be_shown_goes_through_all_the_same(caplog: pytest.LogCaptureFixture) -> None:
    def broken(capture: Captured) -> None:
        raise RecursionError

    async def main() -> object:
        station = Station.demo()
        async with station.running("127.0.0.1", 0) as running:
            relay = Relay(running.host, running.tcp_port, broken)
            await relay.open("127.0.0.1", 0)
            async with achse.connect(f"{relay.host}:{relay.port}") as plc:
                value = await plc.read("GVL.nInt")
            await relay.close()
        return value

    assert asyncio.run(main()) == -16
    assert "not shown any more" in caplog.text


def test_there_is_room_for_so_many_and_no_more(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(relay_module, "_MOST", 2)

    async def main() -> list[bytes]:
        async def hello(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            writer.write(b"!")
            await reader.read()
            writer.close()

        target = await asyncio.start_server(hello, "127.0.0.1", 0)
        relay = Relay("127.0.0.1", target.sockets[0].getsockname()[1], lambda _: None)
        await relay.open("127.0.0.1", 0)
        heard, writers = [], []
        for _ in range(3):
            reader, writer = await asyncio.open_connection(relay.host, relay.port)
            writers.append(writer)
            heard.append(await reader.read(1))
        for writer in writers:
            writer.close()
        await relay.close()
        target.close()
        return heard

    assert asyncio.run(main()) == [b"!", b"!", b""]
