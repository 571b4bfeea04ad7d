"""`connect`: open a session to a router and get the first device behind it."""

import asyncio
import os
from collections.abc import Generator
from types import TracebackType
from typing import Any

from achse.ams import AmsAddress, NetId
from achse.ams.host_port import host_and_port, parse_tcp_port
from achse.client.links.link import (
    GRANT_TIME,
    Dialer,
    Mode,
    RouterDialer,
    TcpDialer,
)
from achse.client.links.mqtt_link import MqttDialer
from achse.client.links.secure_link import SECURE_SCHEME, SecureDialer, SecureTarget
from achse.client.links.serial_link import SerialDialer
from achse.client.session.closing import ClosedByBlock
from achse.client.session.session import Advance, Backoff, Session
from achse.client.target import Target
from achse.router import Router
from achse.transport.mqtt.network import MQTT_SCHEMES, MqttSettings
from achse.transport.serial.port import SCHEME, SerialPort
from achse.transport.tcp.listener import TCP_PORT

GOODBYE_TIME = 1.0
"""Seconds that giving back handles and subscriptions may take at the end."""


class Client(ClosedByBlock, Target):
    """The device `connect` was asked for, and the owner of the session.

    `at_port` gives other devices on the same connection; closing the client closes it for all.
    """

    async def close(self) -> None:
        """Give back subscriptions and handles, then the port, and end the connection.

        A target that does not answer any more holds this up for a second at most.
        """
        try:
            if self.session.link is not None:
                async with asyncio.timeout(GOODBYE_TIME):
                    await self.session.leave()
        except TimeoutError:
            pass
        finally:
            await self.session.close()


class Connecting:
    """Result of `connect`: `async with` it, or `await` it and `close` the client yourself."""

    def __init__(
        self,
        dialer: Dialer,
        net_id: NetId | None,
        port: int,
        timeout: float,
        backoff: Backoff | None,
        keep_alive: float | None,
        watch_symbols: bool,
        advance: Advance | None = None,
    ) -> None:
        self._advance = advance
        self._dialer = dialer
        self._net_id = net_id
        self._port = port
        self._timeout = timeout
        self._backoff = backoff
        self._keep_alive = keep_alive
        self._watch_symbols = watch_symbols
        self._client: Client | None = None

    async def _open(self) -> Client:
        session = Session(
            self._dialer,
            timeout=self._timeout,
            backoff=self._backoff,
            keep_alive=self._keep_alive,
            advance=self._advance,
        )
        link = await session.open()
        if isinstance(self._dialer, TcpDialer):
            session.assumed_net_id = self._dialer.assumed_net_id
        address = AmsAddress.of(self._net_id or link.peer_net_id, self._port)
        return Client(session, address, self._timeout, {}, self._watch_symbols)

    def __getattr__(self, name: str) -> Any:
        """Raise AttributeError; for a name of `Client`, explain that it is not connected yet."""
        if hasattr(Client, name):
            raise AttributeError(
                f"{name}: not connected yet: `async with achse.connect(…) as client:`, or await it;"
                " achse.blocking.connect works without asyncio"
            )
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def __await__(self) -> Generator[Any, None, Client]:
        return self._open().__await__()

    async def __aenter__(self) -> Client:
        self._client = await self._open()
        return self._client

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._client is not None:
            await self._client.close()


def connect(
    host: str | Router | Dialer | SecureTarget | None = None,
    *,
    net_id: str | NetId | None = None,
    port: int = 851,
    source: str | AmsAddress | None = None,
    mode: Mode = "auto",
    timeout: float = 5.0,
    reconnect: Backoff | bool = True,
    keep_alive: float | None = 5.0,
    watch_symbols: bool = True,
    advance: Advance | None = None,
) -> Connecting:
    """Connect to the device at AMS `port` behind a router.

    - `host`: `"name"` or `"name:tcp_port"`; `"serial:/dev/ttyUSB0?baud=38400"` for a serial port
      (`SerialPort.parse`; needs the extra `serial`); a `SecureTarget`, or as text
      `"secure://name?fingerprint=…"` (Secure ADS; needs the extra `secure`);
      `"mqtt://broker/network"` (`MqttSettings.parse`; needs the extra `mqtt`); a `Router` of this
      process; any dialer. None takes ACHSE_HOST and ACHSE_TCP_PORT from the environment, else
      127.0.0.1:48898.
    - `net_id`: where the device is; None means on the router that answers. The NetId of a router
      on another host is then queried over UDP (port 48899, if its TCP port is 48898); without an
      answer within 0.3 s it is derived from its IP address: 192.168.1.20 is 192.168.1.20.1.1.
    - `source`: our own AMS address; None lets the router grant a port or makes one up.
    - `mode`: "router" asks the peer for a port (0x1000, only on the same host), "direct" does not,
      "auto" finds out.
    - `timeout`: seconds per request, and for the connection; `target.within(seconds)` changes it.
    - `reconnect`: pauses between attempts after a loss; False makes a loss final.
    - `keep_alive`: seconds between state requests to devices that we hold handles or subscriptions
      of; None sends none.
    - `watch_symbols`: subscribe to the symbol version (0xF008) of devices whose symbols are used.
    - `advance`: of a station in virtual time, how to let seconds of it pass, as `station.advance`;
      what waits for an axis then steps the station.

    Raises `ConnectionLost` when entered or awaited, if the router does not answer.
    """
    for name, seconds in (("timeout", timeout), ("keep_alive", keep_alive)):
        if (seconds is not None or name == "timeout") and not _is_time(seconds):
            raise ValueError(f"{name}: expected a number of seconds above 0, got {seconds!r:.80}")
    address = None if source is None else AmsAddress(source)
    named = os.environ.get("ACHSE_HOST", "")
    if host is None and named.startswith((SCHEME, SECURE_SCHEME, *MQTT_SCHEMES)):
        host = named
    dialer: Dialer
    if isinstance(host, str) and host.startswith(MQTT_SCHEMES):
        host = MqttDialer(MqttSettings.parse(host), source=address)
    if isinstance(host, SecureTarget):
        dialer = SecureDialer(host, source=address)
    elif isinstance(host, str) and host.startswith(SECURE_SCHEME):
        dialer = SecureDialer(SecureTarget.parse(host), source=address)
    elif isinstance(host, str) and host.startswith(SCHEME):
        dialer = SerialDialer(SerialPort.parse(host), source=address)
    elif host is None or isinstance(host, str):
        name, tcp_port = _endpoint(host)
        grant_time = min(GRANT_TIME, timeout / 2)
        dialer = TcpDialer(name, tcp_port, mode=mode, source=address, grant_time=grant_time)
    elif isinstance(host, Router):
        dialer = RouterDialer(host)
    elif hasattr(host, "open"):
        dialer = host
    else:
        raise TypeError(f"host: expected the name of a host, got {host!r:.80}")
    backoff = reconnect if isinstance(reconnect, Backoff) else Backoff() if reconnect else None
    where = None if net_id is None else NetId(net_id)
    if isinstance(dialer, TcpDialer):
        dialer.needs_net_id = where is None
    if isinstance(dialer, MqttDialer):
        dialer.net_id = where
    return Connecting(dialer, where, port, timeout, backoff, keep_alive, watch_symbols, advance)


def _is_time(seconds: object) -> bool:
    return isinstance(seconds, int | float) and seconds > 0


def _endpoint(host: str | None) -> tuple[str, int]:
    """Return name and TCP port of a host; of None, from the environment."""
    if host is not None:
        return host_and_port(host, TCP_PORT)
    text = os.environ.get("ACHSE_TCP_PORT")
    try:
        tcp_port = TCP_PORT if text is None else parse_tcp_port(text)
    except ValueError as fault:
        raise ValueError(f"ACHSE_TCP_PORT: {fault}") from None
    return host_and_port(os.environ.get("ACHSE_HOST", "127.0.0.1"), tcp_port)
