"""Links over MQTT: a client joins the virtual network of routers as one of them."""

import asyncio
import os
import random
import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from achse.ams import AmsAddress, Command, ConnectionLost, DecodeError, Frame, NetId
from achse.ams.connection import DEFAULT_MAX_LENGTH, Connection
from achse.ams.mqtt import RouterNote, as_tcp_packet
from achse.client.links.link import LinkUser, Onlooker
from achse.router import FIRST_CLIENT_PORT
from achse.transport.mqtt.network import MqttNetwork, MqttSettings, Session
from achse.transport.mqtt.partner_requests import PartnerRequests

JOIN_TIME = 10.0
"""Seconds that the broker has to let us in."""

_LOOK_TIME = 1.0
"""Seconds in which routers announce themselves, to find the only one."""

_MOST_GONE = 10_000
"""Routers that are offline and kept in mind; the oldest is forgotten."""

_UNSENT = 1024 * 1024
"""Bytes that the broker has not taken, at which requests wait."""


class MqttLink:
    """A client's place in a network. What is sent goes to the router of its target."""

    max_packet: int | None = None

    def __init__(self, user: LinkUser, address: AmsAddress) -> None:
        self.address = address
        self.peer_net_id = address.net_id
        self.partners: dict[NetId, RouterNote] = {}
        self.changed = asyncio.Event()
        """Set when we have joined or left, or a router came online."""
        self.network: MqttNetwork
        self._user = user
        self._running: asyncio.Task[None] | None = None
        self._full = False
        self._reason = ""
        self._pending_requests = PartnerRequests()
        self._offline: dict[NetId, None] = {}
        """Routers that say that they are offline."""
        self.came_late = False
        """True if the router to query came online after the first search for it."""

    async def join(self, settings: MqttSettings, session: Session | None) -> None:
        """Enter the network; a broker that refuses is not asked again. Raises ConnectionLost."""
        note = RouterNote(online=True, name=socket.gethostname())
        own = self.address.net_id
        self.network = MqttNetwork(settings, own, note, self, session=session)
        self._running = asyncio.get_running_loop().create_task(self.network.run())
        try:
            async with asyncio.timeout(JOIN_TIME):
                await self.changed.wait()
            if self._reason:
                raise ConnectionLost(f"{settings} does not let us in: {self._reason}")
        except TimeoutError:
            await self._leave()
            raise ConnectionLost(f"{settings} does not answer") from None
        except BaseException:
            await self._leave()
            raise

    async def find_partner(self, net_id: NetId | None, seconds: float = _LOOK_TIME) -> NetId:
        """Return the router to ask: that one, or the only one there is. Raises ConnectionLost."""
        try:
            async with asyncio.timeout(seconds):
                while net_id not in self.partners and (net_id is not None or not self.partners):
                    self.changed.clear()
                    await self.changed.wait()
        except TimeoutError:
            pass
        if net_id is None and len(self.partners) == 1:
            return next(iter(self.partners))
        if net_id is None:
            there = ", ".join(map(str, sorted(self.partners))) or "none"
            raise ConnectionLost(f"say which router by net_id; there are: {there}")
        return net_id

    # of the network ---------------------------------------------------------------------------

    def joined(self) -> None:
        self.changed.set()

    def parted(self, reason: str) -> None:
        self._reason = reason
        self.changed.set()
        if self._running is not None:
            self._running.cancel()
            self._running = None
            self._user.lost(self, reason)

    def came(self, net_id: NetId, note: RouterNote) -> None:
        anew = net_id == self.peer_net_id and net_id not in self.partners
        self.partners[net_id] = note
        self._offline.pop(net_id, None)
        self.changed.set()
        if anew:  # it knows nothing of what was subscribed to before
            self.came_late = True
            self._lose(f"{net_id} has come")

    def left(self, net_id: NetId) -> None:
        """Remove a router that is offline, and answer the requests that wait for it."""
        known = self.partners.pop(net_id, None) is not None
        self._offline[net_id] = None
        if len(self._offline) > _MOST_GONE:
            del self._offline[next(iter(self._offline))]
        self._fail(net_id)
        if known and net_id == self.peer_net_id:
            self._lose(f"{net_id} is offline")

    def _lose(self, reason: str) -> None:
        if self._running is not None:
            self.close()
            self._user.lost(self, reason)

    def received(self, message: bytes) -> None:
        try:
            events = list(Connection().receive(as_tcp_packet(message, DEFAULT_MAX_LENGTH)))
        except DecodeError:
            return
        self._pending_requests.answered(message)
        for event in events:
            if isinstance(event, Frame) and event.target[:6] == self.address.net_id:
                self._user.received(event)

    # out --------------------------------------------------------------------------------------

    def send(self, frame: Frame) -> None:
        """Send within this turn of the loop. After a loss frames vanish; the session knows."""
        backwards = frame.is_response or frame.command == Command.NOTIFICATION
        self._pending_requests.add(frame)
        if self._offline and NetId(frame.target[:6]) in self._offline:
            asyncio.get_running_loop().call_soon(self._fail, NetId(frame.target[:6]))
            return
        self.network.send(NetId(frame.target[:6]), frame.encode_tcp()[6:], back=backwards)
        full = self.network.unsent > _UNSENT
        if full != self._full:
            self._full = full
            self._user.buffer_changed(self, full)
            if full:
                asyncio.get_running_loop().call_later(0.01, self._look)

    def _fail(self, net_id: NetId) -> None:
        for reply in self._pending_requests.fail(net_id):
            self._user.received(reply)

    def _look(self) -> None:
        if self.network.unsent > _UNSENT // 2:
            asyncio.get_running_loop().call_later(0.01, self._look)
        elif self._full:
            self._full = False
            self._user.buffer_changed(self, False)

    def close(self) -> None:
        """Leave the network: others see it at once."""
        running, self._running = self._running, None
        if running is not None:
            running.cancel()
            _leaving.add(running)
            running.add_done_callback(_leaving.discard)

    async def _leave(self) -> None:
        running, self._running = self._running, None
        if running is not None:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)

    async def wait_closed(self) -> None:
        """Return at once: a connection to a broker excludes no other."""

    def abort(self) -> None:
        """End at once, as if lost."""
        self.parted("aborted")


_leaving: set[asyncio.Task[None]] = set()
"""Tasks that still say goodbye."""


class MqttDialer:
    """Opens links into the network of `settings`.

    `source` is our AMS address, whose NetId must be unique there; None makes up one that
    begins with 10. `net_id` is the router that is asked unless a request says another.
    """

    def __init__(
        self,
        settings: MqttSettings,
        *,
        source: AmsAddress | None = None,
        session: Session | None = None,
    ) -> None:
        self.settings = settings
        self.session = session
        self.source = source or AmsAddress.of(
            NetId(bytes((10, *os.urandom(3), 1, 1))), random.randrange(FIRST_CLIENT_PORT, 0x1_0000)
        )
        self.net_id: NetId | None = None
        self._last: MqttLink | None = None

    @property
    def peer(self) -> str:
        return str(self.settings)

    async def open(self, user: LinkUser) -> MqttLink:
        """Join; raises ConnectionLost if the broker is not there, or no router is online."""
        # one that has come is there: a slow broker is not left again before it has said so
        seconds = JOIN_TIME if self._last is not None and self._last.came_late else _LOOK_TIME
        link = self._last = MqttLink(user, self.source)
        await link.join(self.settings, self.session)
        try:
            link.peer_net_id = await link.find_partner(self.net_id, seconds)
        except BaseException:
            link.close()
            raise
        return link


@asynccontextmanager
async def routers_of(
    settings: MqttSettings, seconds: float = _LOOK_TIME, *, session: Session | None = None
) -> AsyncIterator[dict[NetId, RouterNote]]:
    """Yield the online routers of a network, after a search of `seconds`. Raises ConnectionLost."""
    link = MqttLink(Onlooker(), MqttDialer(settings).source)
    await link.join(settings, session)
    try:
        await asyncio.sleep(seconds)
        yield link.partners
    finally:
        link.close()
        await asyncio.sleep(0)
