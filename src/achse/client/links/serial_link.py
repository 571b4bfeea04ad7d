"""Links over a serial port: no router on this side, no port service, packets of 255 bytes."""

import asyncio
import logging
import random
from typing import cast

from achse.ams import AmsAddress, Frame, NetId
from achse.ams.serial import MAX_PACKET
from achse.client.links.link import LinkUser
from achse.router import FIRST_CLIENT_PORT, LOOPBACK_NET_ID
from achse.transport.serial.carrier import SerialCarrier
from achse.transport.serial.port import SerialPort, open_serial_port

log = logging.getLogger("achse.client")

OUR_NET_ID = NetId("127.0.0.1.1.2")
"""NetId of the client on a serial line: no router assigns one there, and it has only two ends."""


class SerialLink(asyncio.Protocol):
    """A client's end of a serial line. What the line cannot carry is answered here."""

    max_packet: int | None = MAX_PACKET
    peer_net_id = LOOPBACK_NET_ID
    """NetId that every router uses for itself."""

    def __init__(self, user: LinkUser, port: SerialPort, address: AmsAddress) -> None:
        self.address = address
        self._user = user
        self._port = port
        self._transport: asyncio.Transport | None = None
        self._carrier: SerialCarrier | None = None
        self._full = False
        self._ended = asyncio.Event()
        """The port is closed."""

    # asyncio ---------------------------------------------------------------------------------

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast(asyncio.Transport, transport)
        self._carrier = SerialCarrier(
            *(asyncio.get_running_loop(), self._transport.write, self._user.received),
            baud=self._port.baud,
            changed=self._changed,
        )

    def data_received(self, data: bytes) -> None:
        if self._carrier is not None:
            self._carrier.receive(data)

    def connection_lost(self, exc: Exception | None) -> None:
        if self._carrier is not None:
            self._carrier.close()
        self._ended.set()
        transport, self._transport = self._transport, None
        if transport is not None:
            self._user.lost(self, str(exc or "the serial port is gone"))

    def _changed(self) -> None:
        """Let requests wait in the session while the line has two seconds of work."""
        assert self._carrier is not None
        limit = self._carrier.congested_at
        full = self._carrier.unsent > (limit // 2 if self._full else limit)
        if full != self._full:
            self._full = full
            self._user.buffer_changed(self, full)

    # out -------------------------------------------------------------------------------------

    def send(self, frame: Frame) -> None:
        """Send within this turn of the loop. After a loss frames vanish; the session knows."""
        if self._transport is not None and self._carrier is not None:
            self._carrier.send(frame)

    def close(self) -> None:
        """End at once: flushing a port without a reader would take for ever."""
        transport, self._transport = self._transport, None
        if transport is not None:
            transport.abort()

    async def wait_closed(self) -> None:
        """Wait until the port is closed: it is this program's alone, and a thread closes it."""
        await self._ended.wait()

    def abort(self) -> None:
        """End at once, as if lost."""
        if self._transport is not None:
            self._transport.abort()


class SerialDialer:
    """Opens links over `port`. `source` is our AMS address; None makes one up."""

    def __init__(self, port: SerialPort, *, source: AmsAddress | None = None) -> None:
        self.port = port
        self.source = source

    @property
    def peer(self) -> str:
        return str(self.port)

    async def open(self, user: LinkUser) -> SerialLink:
        """Open the port; raises OSError if it is not there or another program uses it."""
        source = self.source or AmsAddress.of(
            OUR_NET_ID, random.randrange(FIRST_CLIENT_PORT, 0x1_0000)
        )
        link = SerialLink(user, self.port, source)
        await open_serial_port(self.port, lambda: link)
        return link
