"""Serial ports whose far ends go or flood, beside good clients; our client in all its forms."""

import asyncio
import os
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from achse.ams import RouterError
from achse.cli.app import app
from achse.client import blocking, connect
from achse.station import ConfigError, Station
from achse.station.configuration.station_file import parse
from tests.transport.lines import cable, until
from tests.transport.serial.test_ports import FAR, station

FAST = 115_200


async def test_many_tcp_clients_share_one_line(tmp_path: Path) -> None:
    near_path, far_path = tmp_path / "near", tmp_path / "far"
    near_path.mkdir()
    far_path.mkdir()
    with cable() as line:
        far = station(far_path, FAR, port=line.left, baud=FAST)
        near = station(near_path, "5.1.1.1.1.1", port=line.right, baud=FAST, net_id=FAR)
        async with far.running("127.0.0.1", 0), near.running("127.0.0.1", 0) as running:
            host = f"127.0.0.1:{running.tcp_port}"

            async def ask(number: int) -> None:
                async with connect(host, net_id=FAR, timeout=3600, watch_symbols=False) as plc:
                    for value in range(3):
                        data = bytes([number, value, 0, 0])
                        await plc.write_raw(0x4040, 4 * number, data)
                        assert await plc.read_raw(0x4040, 4 * number, 4) == data

            await asyncio.gather(*[ask(number) for number in range(10)])


async def test_a_port_that_goes_while_requests_wait_is_reported_to_their_clients(
    tmp_path: Path,
) -> None:
    """0x745 at once for what nobody has taken, an error as long as the port is gone."""
    with cable() as line:
        near = station(tmp_path, "5.1.1.1.1.1", port=line.right, net_id=FAR)
        async with near.running("127.0.0.1", 0) as running:
            host = f"127.0.0.1:{running.tcp_port}"
            async with connect(host, net_id=FAR, timeout=3600, watch_symbols=False) as plc:
                waiting = [asyncio.ensure_future(plc.read_raw(0x4040, 0, 4)) for _ in range(50)]
                [peer] = running.network.serial._open
                await until(lambda: peer.backlog > 1000)
                transport: Any = peer._transport
                transport._abort()
                for answer in await asyncio.gather(*waiting, return_exceptions=True):
                    assert isinstance(answer, RouterError)
                    assert answer.code == 0x745
            async with connect(host) as here:
                assert await here.read("MAIN.nCounter") == 7


async def test_notifications_faster_than_the_line_end_with_the_latest_value(tmp_path: Path) -> None:
    """What does not fit the line is held back, memory is bounded, others are served."""
    with cable() as line:
        served = station(tmp_path, FAR, port=line.left, baud=FAST)
        async with (
            served.running("127.0.0.1", 0) as running,
            connect(f"127.0.0.1:{running.tcp_port}") as good,
            connect(f"serial:{line.right}?baud={FAST}", timeout=3600) as plc,
        ):
            [peer] = running.network.serial._open
            async with plc.subscribe("MAIN.aBig[0]", cycle_time=0.0) as samples:
                most = 0
                for value in range(400):
                    await good.write("MAIN.aBig[0]", value)
                    most = max(most, peer.buffered_bytes)
                async for sample in samples:
                    if sample.value == 399:
                        break
            assert most < 200_000


def test_commands_and_the_blocking_client_speak_over_a_port(tmp_path: Path) -> None:
    async def serve(served: Station, stop: asyncio.Event, ready: asyncio.Event) -> None:
        async with served.running("127.0.0.1", 0):
            ready.set()
            await stop.wait()

    async def main() -> tuple[Any, ...]:
        with cable() as line:
            served = station(tmp_path, FAR, port=line.left, baud=FAST)
            stop, ready = asyncio.Event(), asyncio.Event()
            task = asyncio.ensure_future(serve(served, stop, ready))
            await ready.wait()
            host = f"serial:{line.right}?baud={FAST}"

            def ask() -> tuple[Any, ...]:
                with blocking.connect(host) as plc:
                    plc.write("MAIN.nCounter", 11)
                    value = plc.read("MAIN.nCounter")
                results = [
                    CliRunner().invoke(app, [*words, "--host", host])
                    for words in (
                        ("ads", "read", "MAIN.nCounter"),
                        ("ads", "write", "MAIN.nCounter", "12"),
                        ("ads", "state", "--identity"),
                        ("ads", "state"),
                    )
                ]
                return (value, *results)

            try:
                return await asyncio.to_thread(ask)
            finally:
                stop.set()
                await task

    value, *results = asyncio.run(main())
    assert value == 11
    for result in results:
        assert result.exit_code == 0, (result.output, result.exception)
    assert "MAIN.nCounter = 11" in results[0].output


@pytest.mark.parametrize(
    ("serial", "message"),
    [
        ([{"port": "a", "parity": "mark"}], "serial[1].parity"),
        ([{"port": "a", "baud": 0}], "1..4000000 baud, got 0"),
        ([{"port": "a", "stop_bits": 3}], "1 or 2 stop bits, got 3"),
        ([{"port": "a"}, {"port": "a"}], "serial.port: each once, got a more than once"),
        ([{"port": "spy://a"}], "or socket://host:port"),
        ([{"port": ""}], "a name like"),
        ([{"port": "a", "net_id": "1"}], "net_id"),
        ([{"port": "a", "speed": 1}], "speed"),
        ([{}], "serial[1].port"),
    ],
)
def test_mistakes_in_the_configuration_are_reported(serial: list[Any], message: str) -> None:
    with pytest.raises(ConfigError) as fault:
        parse({"serial": serial}, "a.toml")
    assert message in str(fault.value)
    assert "Traceback" not in str(fault.value)


async def test_one_port_by_two_names_is_reported(tmp_path: Path) -> None:
    with cable() as line:
        other = tmp_path / "press"
        os.symlink(line.left, other)
        served = station(tmp_path, FAR, port=line.left)
        again = station(tmp_path, "5.1.1.1.1.1", port=str(other))
        async with served.running("127.0.0.1", 0):
            with pytest.raises(ConfigError, match="another program has it"):
                async with again.running("127.0.0.1", 0):
                    pass
