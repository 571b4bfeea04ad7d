"""Stations that serve serial ports: asked over one, asking over one, a port that goes and comes."""

import asyncio
import contextlib
import os
import random
from pathlib import Path

import pytest

from achse.ams import AdsError, DeviceError, NetId, RequestTimeout, RouterError
from achse.client import connect
from achse.router import Router
from achse.station import ConfigError, Station
from achse.station.configuration.station_file import parse
from achse.station.running.statistics import statistics
from achse.transport.serial.port import SerialPort
from achse.transport.serial.ports import ServedPort, ServedSerialPorts
from tests.transport.lines import cable, noisy, until

FAR = "5.7.7.7.1.1"
CODE = """
PROGRAM MAIN
VAR
    nCounter : DINT := 7;
    aBig : ARRAY[0..499] OF DINT;
    sText : STRING(250) := 'serial';
END_VAR
END_PROGRAM
"""


def station(tmp_path: Path, own_net_id: str, **serial: object) -> Station:
    (tmp_path / "main.st").write_text(CODE)
    document = {
        "router": {"net_id": own_net_id},
        "plc": [{"port": 851, "sources": "main.st"}],
        "serial": [serial] if serial else [],
    }
    return Station(parse(document, "a.toml"), base=tmp_path)


async def test_a_client_queries_a_station_over_a_serial_port(tmp_path: Path) -> None:
    with cable() as line:
        served = station(tmp_path, FAR, port=line.left, baud=115_200)
        async with (
            served.running("127.0.0.1", 0),
            connect(f"serial:{line.right}?baud=115200") as plc,
        ):
            assert await plc.read("MAIN.nCounter") == 7
            await plc.write("MAIN.nCounter", -3)
            assert (await plc.read_many(["MAIN.nCounter", "MAIN.aBig[3]"]))["MAIN.nCounter"] == -3
            await plc.write("MAIN.aBig[499]", 99)
            assert (await plc.read("MAIN.aBig"))[499] == 99  # 2000 bytes, in pieces
            assert await plc.read("MAIN.sText") == "serial"
            with pytest.raises(DeviceError, match="0x705"):
                await plc.write("MAIN.aBig", [1] * 500)
            with pytest.raises(DeviceError, match="0x705"):
                await plc.symbols()
            async with plc.subscribe("MAIN.nCounter", cycle_time=0.01) as samples:
                assert (await anext(samples)).value == -3
                await plc.write("MAIN.nCounter", 5)
                assert (await anext(samples)).value == 5
            with pytest.raises(RouterError, match="0x6"):
                await plc.at_port(999).state()
            [client] = statistics(served)["clients"]
            assert client["requests"] > 10
            assert client["errors"] >= 1
            assert line.left in client["peer"]


async def test_a_router_forwards_between_tcp_and_serial(tmp_path: Path) -> None:
    """A TCP client asks the near station for the far one, which is at the end of a serial line."""
    near_path, far_path = tmp_path / "near", tmp_path / "far"
    near_path.mkdir()
    far_path.mkdir()
    with cable() as line:
        far = station(far_path, FAR, port=line.left, baud=115_200)
        near = station(near_path, "5.1.1.1.1.1", port=line.right, baud=115_200, net_id=FAR)
        async with (
            far.running("127.0.0.1", 0),
            near.running("127.0.0.1", 0) as running,
            connect(f"127.0.0.1:{running.tcp_port}", net_id=FAR) as plc,
        ):
            assert await plc.read("MAIN.nCounter") == 7
            with pytest.raises(DeviceError, match="0x705"):
                await plc.read_raw(0x4040, 0, 1000)
            async with plc.subscribe("MAIN.nCounter", cycle_time=0.01) as samples:
                assert (await anext(samples)).value == 7
        async with (
            near.running("127.0.0.1", 0) as running,
            connect(f"127.0.0.1:{running.tcp_port}", net_id=FAR, timeout=3600) as plc,
        ):
            with pytest.raises(RouterError, match="0x745"):  # nobody is at the other end
                await plc.state()


async def test_a_bad_line_loses_no_request_without_a_word(tmp_path: Path) -> None:
    dice = random.Random(1)
    with cable(noisy(dice, 0.03, 0.03, 0.03)) as line:
        served = station(tmp_path, FAR, port=line.left, baud=115_200)
        async with (
            served.running("127.0.0.1", 0),
            connect(f"serial:{line.right}?baud=115200", watch_symbols=False) as plc,
        ):
            for value in range(15):
                with contextlib.suppress(RequestTimeout, RouterError):
                    await plc.write_raw(0x4040, 0, bytes([value] * dice.randrange(4, 200)))
                    assert (await plc.read_raw(0x4040, 0, 1))[0] == value


async def test_a_flood_over_the_line_leaves_tcp_clients_alone(tmp_path: Path) -> None:
    with cable() as line:
        served = station(tmp_path, FAR, port=line.left)
        async with (
            served.running("127.0.0.1", 0) as running,
            connect(f"127.0.0.1:{running.tcp_port}") as plc,
        ):
            end = os.open(line.right, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
            try:
                for _ in range(200):
                    try:
                        os.write(end, random.Random(2).randbytes(2000) + b"\x01\xa5\0\0\0\xff" * 50)
                    except BlockingIOError:
                        await asyncio.sleep(0)
                    assert await plc.read("MAIN.nCounter") == 7
            finally:
                os.close(end)


async def test_a_port_that_cannot_be_opened_is_an_error_at_the_start(tmp_path: Path) -> None:
    served = station(tmp_path, FAR, port="/dev/nowhere")
    with pytest.raises(ConfigError, match="serial port /dev/nowhere"):
        async with served.running("127.0.0.1", 0):
            pass


async def test_a_port_that_went_is_opened_again() -> None:
    router = Router(NetId(FAR))
    far = NetId("5.4.4.4.1.1")
    with cable() as line:
        ports = ServedSerialPorts(router, [ServedPort(SerialPort(line.left), far)])
        await ports.start()
        assert ports.connected == 1
        (peer,) = ports._open
        peer.abort()
        await until(lambda: peer not in ports._open and ports.connected)
        assert ports.connected == 1
        await ports.close()
        assert ports.connected == 0
        with pytest.raises(AdsError):
            async with connect(router, net_id=far) as gone:
                await gone.state()
