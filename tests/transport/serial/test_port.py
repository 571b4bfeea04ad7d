"""Serial ports by name and settings."""

import asyncio
import builtins
import re
from typing import Any

import pytest

from achse.extras import install_command
from achse.transport.serial.port import SerialPort, SerialPortError, open_serial_port
from tests.transport.lines import cable


@pytest.mark.parametrize(
    ("text", "port"),
    [
        ("/dev/ttyS0", SerialPort("/dev/ttyS0")),
        ("serial:COM3", SerialPort("COM3", 38_400, "none", 1)),
        ("serial:/dev/ttyUSB0?baud=9600", SerialPort("/dev/ttyUSB0", 9_600)),
        ("serial:a?parity=even&stop_bits=2&baud=1", SerialPort("a", 1, "even", 2)),
        ("serial:socket://host:4000?baud=115200", SerialPort("socket://host:4000", 115_200)),
    ],
)
def test_a_port_by_its_name(text: str, port: SerialPort) -> None:
    assert SerialPort.parse(text) == port


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("serial:", "a name like"),
        ("serial:a\0b", "a name like"),
        ("serial:loop://", "or socket://host:port, got 'loop://'"),
        ("serial:rfc2217://host:1", "or socket://host:port"),
        ("serial:a?baud=fast", "baud is a number, got 'fast'"),
        ("serial:a?baud=0", "1..4000000 baud, got 0"),
        ("serial:a?baud=99999999", "1..4000000 baud"),
        ("serial:a?baud=", "baud is a number, got ''"),
        ("serial:a?parity=mark", "none, even or odd, got 'mark'"),
        ("serial:a?stop_bits=3", "1 or 2 stop bits, got 3"),
        ("serial:a?bits=7", "not 'bits'"),
    ],
)
def test_what_is_no_port(text: str, message: str) -> None:
    with pytest.raises(SerialPortError, match=message):
        SerialPort.parse(text)


async def test_a_port_that_is_not_there_is_an_error() -> None:
    with pytest.raises(OSError, match="nowhere"):
        await open_serial_port(SerialPort("/dev/nowhere"), asyncio.Protocol)


async def test_a_port_that_another_has_is_an_error() -> None:
    with cable() as line:
        port = SerialPort(line.left)
        first = await open_serial_port(port, asyncio.Protocol)
        with pytest.raises(OSError, match="another program has it"):
            await open_serial_port(port, asyncio.Protocol)
        first.abort()
        (await open_serial_port(port, asyncio.Protocol)).abort()


async def test_without_the_extra_the_error_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    real = builtins.__import__

    def refuse(name: str, *rest: Any, **named: Any) -> Any:
        if name == "serial_asyncio_fast":
            raise ImportError(name)
        return real(name, *rest, **named)

    monkeypatch.setattr(builtins, "__import__", refuse)
    with pytest.raises(OSError, match=re.escape(install_command("serial"))):
        await open_serial_port(SerialPort("/dev/ttyS0"), asyncio.Protocol)


async def test_who_is_cancelled_while_it_opens_a_port_leaves_none() -> None:
    """At every step of the way: the port can be had again."""
    with cable() as line:
        port = SerialPort(line.left)
        for scheduler in range(12):
            opening = asyncio.ensure_future(open_serial_port(port, asyncio.Protocol))
            for _ in range(scheduler):
                await asyncio.sleep(0 if scheduler < 6 else 0.002)
            opening.cancel()
            (result,) = await asyncio.gather(opening, return_exceptions=True)
            if isinstance(result, asyncio.Transport):
                result.abort()
            (await open_serial_port(port, asyncio.Protocol)).abort()


@pytest.mark.parametrize(
    "device", ["/dev/null", "/", "/etc/hostname", "socket://x", "socket://127.0.0.1:1"]
)
async def test_what_is_no_serial_port_is_an_error(device: str) -> None:
    with pytest.raises(OSError, match=r"."):
        await open_serial_port(SerialPort(device), asyncio.Protocol)
