"""Serial ports: how one is named and set, and how it is opened.

Needs the extra `serial` (pyserial and its asyncio transport), imported when a port is opened.
"""

import asyncio
import errno
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, Self, cast, get_args
from urllib.parse import parse_qsl

from achse.extras import needs_extra

SCHEME = "serial:"
"""Prefix that marks the name of a serial port in a place that also accepts a host."""

Parity = Literal["none", "even", "odd"]

_BAUD_LIMIT = 4_000_000

_ATTEMPTS, _AGAIN = 10, 0.05
"""Number of attempts to open a busy port, and seconds between them: we may have closed it just now,
which takes a while."""


class SerialPortError(ValueError):
    """A serial port that cannot be: what was expected and what came."""


@dataclass(frozen=True, slots=True)
class SerialPort:
    """A serial port and its settings; always eight data bits.

    - `device`: `/dev/ttyUSB0`, `COM3`, or `socket://host:port` of a serial server;
    - `baud`: bits per second, 1..4000000; `parity`; `stop_bits`: 1 or 2.

    Raises SerialPortError.
    """

    device: str
    baud: int = 38_400
    parity: Parity = "none"
    stop_bits: int = 1

    def __post_init__(self) -> None:
        if not self.device or not self.device.isprintable():
            raise SerialPortError(f"a serial port is a name like /dev/ttyUSB0, got {self.device!r}")
        scheme, remote, _ = self.device.partition("://")
        if remote and scheme != "socket":
            raise SerialPortError(
                f"a serial port is a name like /dev/ttyUSB0 or socket://host:port,"
                f" got {self.device!r:.80}"
            )
        if not 0 < self.baud <= _BAUD_LIMIT:
            raise SerialPortError(f"a serial line has 1..{_BAUD_LIMIT} baud, got {self.baud}")
        if self.parity not in get_args(Parity):
            raise SerialPortError(f"parity is none, even or odd, got {self.parity!r:.40}")
        if self.stop_bits not in (1, 2):
            raise SerialPortError(f"a serial line has 1 or 2 stop bits, got {self.stop_bits}")

    @classmethod
    def parse(cls, text: str) -> Self:
        """`serial:/dev/ttyUSB0?baud=9600&parity=even&stop_bits=2`, each setting optional."""
        device, _, settings = text.removeprefix(SCHEME).partition("?")
        known: dict[str, Any] = {}
        for name, value in parse_qsl(settings, keep_blank_values=True):
            if name not in ("baud", "parity", "stop_bits"):
                raise SerialPortError(
                    f"a serial port has baud, parity, stop_bits, not {name!r:.40}"
                )
            if name != "parity" and not (value.isascii() and value.isdigit() and len(value) < 10):
                raise SerialPortError(f"{name} is a number, got {value!r:.40}")
            known[name] = value if name == "parity" else int(value)
        return cls(device, **known)

    def __str__(self) -> str:
        return f"{self.device} at {self.baud} baud"


async def open_serial_port(
    port: SerialPort, protocol: Callable[[], asyncio.Protocol]
) -> asyncio.Transport:
    """Open `port` exclusively; the protocol is connected when this returns.

    Raises OSError, with what to install if that is missing.
    """
    try:
        import serial_asyncio_fast
    except ImportError:
        raise OSError(needs_extra("a serial port", "serial")) from None
    settings: dict[str, Any] = {"baudrate": port.baud, "parity": port.parity[0].upper()}
    if "://" not in port.device:
        settings["exclusive"] = True
    loop = asyncio.get_running_loop()
    for attempt in range(_ATTEMPTS):
        try:
            transport, _ = await serial_asyncio_fast.create_serial_connection(
                *(loop, protocol, port.device),
                stopbits=port.stop_bits,
                **settings,
            )
            break
        except OSError as failure:
            if failure.errno != errno.EAGAIN:
                raise
            if attempt == _ATTEMPTS - 1:
                raise OSError(f"{port.device}: another program has it") from None
            await asyncio.sleep(_AGAIN)
        except ValueError as fault:
            raise OSError(f"{port.device}: {fault}") from None
    connected = loop.create_future()
    loop.call_soon(_set_connected, connected)  # behind `connection_made`
    try:
        await connected
    except asyncio.CancelledError:
        transport.abort()
        raise
    return cast(asyncio.Transport, transport)


def _set_connected(connected: asyncio.Future[None]) -> None:
    if not connected.done():
        connected.set_result(None)
