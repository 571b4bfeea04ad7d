"""The serial ports that a station serves: each has a peer at its other end.

A port that is lost, or not there yet, is opened again with growing pauses.
"""

import asyncio
import contextlib
import logging
from collections.abc import Iterable
from typing import NamedTuple, cast

from achse.ams import NetId
from achse.ams.serial import MAX_PACKET
from achse.router import Router
from achse.transport.connections.fair_queue import FairQueue
from achse.transport.connections.peer import Peer
from achse.transport.connections.send_budget import SendBudget
from achse.transport.reason import reason
from achse.transport.serial.carrier import SerialCarrier, SerialTransport
from achse.transport.serial.port import SerialPort, SerialPortError, open_serial_port

log = logging.getLogger("achse.serial")

_FIRST_PAUSE, _LONGEST_PAUSE = 0.1, 5.0
"""Seconds between attempts to open a port, doubled each time."""


class ServedPort(NamedTuple):
    """A serial port, and the NetId that is reached by it, if it is known."""

    port: SerialPort
    net_id: NetId | None = None


class ServedSerialPorts:
    """Serves serial ports for a router, from `start` to `close`; owner of the peers there.

    Every device on the cable is let in: no routes are checked, no ports registered.
    """

    routes_required = False
    max_length = MAX_PACKET

    def __init__(
        self,
        router: Router,
        ports: Iterable[ServedPort],
        *,
        max_backlog: int = 64 * 1024 * 1024,
        send_budget: SendBudget | None = None,
        fair_queue: FairQueue | None = None,
    ) -> None:
        self.router = router
        self.max_backlog = max_backlog
        self.send_budget = send_budget or SendBudget()
        self.fair_queue = fair_queue or FairQueue()
        self.loop: asyncio.AbstractEventLoop
        self._ports = list(ports)
        self._keepers: list[asyncio.Task[None]] = []
        self._open: dict[Peer, asyncio.Event] = {}

    @property
    def connected(self) -> int:
        """Number of ports that are open now."""
        return len(self._open)

    async def start(self) -> None:
        """Open the ports. Raises SerialPortError for one that cannot be opened now."""
        self.loop = asyncio.get_running_loop()
        try:
            for served in self._ports:
                try:
                    closed = await self._serve(served)
                except OSError as failure:
                    message = f"serial port {served.port.device}: {reason(failure)}"
                    raise SerialPortError(message) from None
                self._keepers.append(self.loop.create_task(self._keep(served, closed)))
        except BaseException:
            await self.close()
            raise

    async def close(self) -> None:
        """Close all ports, and drop unsent bytes."""
        for keeper in self._keepers:
            keeper.cancel()
        await asyncio.gather(*self._keepers, return_exceptions=True)
        self._keepers.clear()
        for served in self._ports:
            if served.net_id is not None:
                self.router.remove_route(served.net_id)
        ends = list(self._open.items())
        for peer, _ in ends:
            peer.abort()
        for _, closed in ends:
            await closed.wait()

    async def _serve(self, served: ServedPort) -> asyncio.Event:
        """Open one port; the event is set once it is closed."""
        closed = asyncio.Event()
        peer = _SerialPeer(self)
        await open_serial_port(served.port, lambda: _Connection(self, peer, served))
        self._open[peer] = closed
        if served.net_id is not None:
            self.router.add_route(served.net_id, peer)
        log.info("serving serial port %s", served.port)
        return closed

    async def _keep(self, served: ServedPort, closed: asyncio.Event) -> None:
        """Reopen the port each time that it is closed, for ever."""
        while True:
            await closed.wait()
            log.warning(
                "serial port %s is lost; it is opened again as soon as it is there",
                served.port.device,
            )
            pause = _FIRST_PAUSE
            while True:
                await asyncio.sleep(pause)
                with contextlib.suppress(OSError):
                    closed = await self._serve(served)
                    break
                pause = min(pause * 2, _LONGEST_PAUSE)

    # owner of the peers ------------------------------------------------------------------------

    def serves_ports(self, host: str) -> bool:
        """Frames on a serial line carry no port service."""
        return False

    def opened(self, peer: Peer) -> None:
        """Note that its port is open."""

    def closed(self, peer: Peer) -> None:
        """Note that the port of `peer` is closed."""
        closed = self._open.pop(peer, None)
        if closed is not None:
            closed.set()


class _SerialPeer(Peer):
    """The far end of a cable, which sees no end of a connection."""

    def drop_client(self, target: str) -> None:
        """Do nothing: the port stays open."""


class _Connection(asyncio.Protocol):
    """Protocol of one port: passes the events of asyncio to its peer."""

    def __init__(self, owner: ServedSerialPorts, peer: Peer, served: ServedPort) -> None:
        self._owner = owner
        self._peer = peer
        self._served = served
        self._carrier: SerialCarrier | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        line = cast(asyncio.Transport, transport)
        self._carrier = carrier = SerialCarrier(
            *(self._owner.loop, line.write, lambda frame: self._peer.receive(frame.encode_tcp())),
            baud=self._served.port.baud,
            changed=self._peer.count,
        )
        end = SerialTransport(carrier, line.abort, line.abort)
        self._peer.peer = self._served.port.device
        self._peer.begin(end, congested=carrier.congested_at)

    def data_received(self, data: bytes) -> None:
        if self._carrier is not None:
            self._carrier.receive(data)

    def connection_lost(self, exc: Exception | None) -> None:
        if self._carrier is not None:
            self._carrier.give_up()
            self._carrier.close()
        self._peer.ended()
