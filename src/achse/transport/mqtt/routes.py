"""A router in a virtual network over MQTT: each partner that is online is a route.

Source: network facts 1.5.
"""

import asyncio
import logging

from achse.ams import Command, DecodeError, Flags, NetId
from achse.ams.connection import DEFAULT_MAX_LENGTH
from achse.ams.frame import AMS_HEADER
from achse.ams.mqtt import RouterNote, as_tcp_packet
from achse.ams.secure import TcpFrames
from achse.codes import ReturnCode
from achse.router import Router
from achse.router.routes import Admission, Route
from achse.transport.connections.fair_queue import FairQueue
from achse.transport.connections.peer import Peer
from achse.transport.connections.send_budget import SendBudget
from achse.transport.mqtt.network import MqttNetwork, MqttSettings, Session

log = logging.getLogger("achse.mqtt")

_MOST_STRANGERS = 64
"""Senders that never said that they are online; each may come from 1024 addresses."""


class _Partner(Peer):
    """A router of the network. When it vanishes, its pending requests are answered with 0x7."""

    _code_at_end = ReturnCode.TARGET_MACHINE_NOT_FOUND

    def __init__(self, owner: "MqttRoutes", net_id: NetId) -> None:
        super().__init__(owner)
        self._routes = owner
        self.net_id = net_id
        self.peer = f"{net_id} by {owner.network.settings}"

    def _admission(self, net_id: bytes) -> Admission:
        """Routes to the partners that the broker admits to the network.

        The other side of a route by Secure ADS does not come so: it is not authenticated here.
        """
        route = self.router.routes.to(net_id)
        one_way = self._routes.network.settings.unidirectional
        if one_way or (route is not None and route.one_way):
            return Admission.ONE_WAY
        secure = route is not None and route.tls is not None
        return Admission.UNKNOWN if secure else Admission.ROUTED

    def drop_client(self, target: str) -> None:
        """Do nothing: a partner has no connection whose end it could see."""


class _MqttTransport:
    """Transport to one partner: packets become messages."""

    def __init__(self, network: MqttNetwork, partner: _Partner) -> None:
        self._network = network
        self._partner = partner
        self._frames = TcpFrames()

    def write(self, data: bytes) -> None:
        for message in self._frames.receive(data):
            _, _, command, flags, *_ = AMS_HEADER.unpack_from(message)
            back = bool(flags & Flags.RESPONSE) or command == Command.NOTIFICATION
            self._network.send(self._partner.net_id, message, back=back)

    def get_write_buffer_size(self) -> int:
        return self._network.unsent

    def close(self) -> None:
        asyncio.get_running_loop().call_soon(self._partner.ended)

    abort = close

    def pause_reading(self) -> None:
        """Do nothing: the connection carries other partners too, so the peer buffers its own
        bytes."""

    def resume_reading(self) -> None: ...


class MqttRoutes:
    """A router's partners in a virtual network, from `start` to `close`; owner of the peers."""

    routes_required = False

    def __init__(
        self,
        router: Router,
        settings: MqttSettings,
        note: RouterNote,
        *,
        max_length: int = DEFAULT_MAX_LENGTH,
        max_backlog: int = 64 * 1024 * 1024,
        send_budget: SendBudget | None = None,
        fair_queue: FairQueue | None = None,
        session: Session | None = None,
    ) -> None:
        self.router = router
        self.max_length = max_length
        self.max_backlog = max_backlog
        self.send_budget = send_budget or SendBudget()
        self.fair_queue = fair_queue or FairQueue()
        self.loop: asyncio.AbstractEventLoop
        self.network = MqttNetwork(settings, NetId(router.net_id), note, self, session=session)
        self.dropped = 0
        """Messages that were not frames, or not for us."""
        self._partners: dict[NetId, _Partner] = {}
        self._strangers: dict[NetId, None] = {}
        self._running: asyncio.Task[None] | None = None
        self._has_reported = False
        self._settled = asyncio.Event()

    def start(self) -> None:
        """Join the network, now or as soon as the broker is there."""
        self.loop = asyncio.get_running_loop()
        self._running = self.loop.create_task(self.network.run())
        self._running.add_done_callback(_log_failure)
        self.router.routes.on_change(self._changed)

    async def settled(self, within: float) -> bool:
        """Wait until it has joined or logged a failure; return False if neither came in time."""
        try:
            await asyncio.wait_for(self._settled.wait(), within)
        except TimeoutError:
            message = "%s: no answer within %g s, it is dialled on"
            log.warning(message, self.network.settings, within)
            self._has_reported = True
            return False
        return True

    def _changed(self, old: Route | None, new: Route | None) -> None:
        """Review the access of senders of a route that has changed."""
        for partner in list(self._partners.values()):
            for route in filter(None, (old, new)):
                partner.review_access(route)

    async def close(self) -> None:
        """Leave it."""
        if self._running is not None:
            self._running.cancel()
            await asyncio.gather(self._running, return_exceptions=True)
            self._running = None
            self.router.routes.ignore(self._changed)
        for net_id in list(self._partners):
            self.left(net_id)

    @property
    def partners(self) -> dict[NetId, RouterNote]:
        """Routers that are online, each with its info message."""
        return self.network.partners

    # of the network ---------------------------------------------------------------------------

    def joined(self) -> None:
        """Note that the network is joined; routes come with the infos."""
        self._has_reported = False
        self._settled.set()

    def parted(self, reason: str) -> None:
        log.log(
            logging.DEBUG if self._has_reported else logging.WARNING,
            "%s: %s",
            self.network.settings,
            reason,
        )
        self._has_reported = True
        self._settled.set()
        for net_id in list(self._partners):
            self.left(net_id)

    def came(self, net_id: NetId, note: RouterNote) -> None:
        partner = self._partner(net_id)
        self._strangers.pop(net_id, None)
        if self.router.routes.to(net_id) is None:
            self.router.add_route(net_id, partner)
        log.info("%s (%s) is online by %s", net_id, note.name, self.network.settings)

    def left(self, net_id: NetId) -> None:
        partner = self._partners.pop(net_id, None)
        if partner is None:
            return
        if self.router.routes.to(net_id) is None:
            self.router.remove_route(net_id)
        self._strangers.pop(net_id, None)
        partner.abort()
        log.info("%s is offline", net_id)

    def received(self, message: bytes) -> None:
        try:
            packet = as_tcp_packet(message, self.max_length)
        except DecodeError as fault:
            self.dropped += 1
            log.debug("%s: %s", self.network.settings, fault)
            return
        if message[:6] != self.router.net_id or self.router.is_local(message[8:14]):
            self.dropped += 1  # what says it comes from us does not come by a broker
            return
        partner = self._sender(NetId(message[8:14]))
        partner.receive(packet)

    def _sender(self, net_id: NetId) -> _Partner:
        """One that never said that it is online is answered all the same."""
        if net_id not in self._partners:
            while len(self._strangers) >= _MOST_STRANGERS:
                self.left(next(iter(self._strangers)))
            self._strangers[net_id] = None
        return self._partner(net_id)

    def _partner(self, net_id: NetId) -> _Partner:
        partner = self._partners.get(net_id)
        if partner is None or not partner.connected:
            partner = self._partners[net_id] = _Partner(self, net_id)
            partner.begin(_MqttTransport(self.network, partner))
        return partner

    # owner of the peers -------------------------------------------------------------------------

    def serves_ports(self, host: str) -> bool:
        return False

    def opened(self, peer: Peer) -> None:
        """Do nothing: each partner is open from the start."""

    def closed(self, peer: Peer) -> None:
        """Handle a partner that was cut off, or has vanished.

        A partner that was cut off is still online: pending requests are answered, the next one is
        sent.
        """
        if isinstance(peer, _Partner) and self._partners.get(peer.net_id) is peer:
            peer.abort()
            note = self.network.partners.get(peer.net_id)
            if note is not None:
                self.came(peer.net_id, note)


def _log_failure(running: "asyncio.Task[None]") -> None:
    if not running.cancelled() and (failure := running.exception()) is not None:
        log.error("the connection to the broker broke: %r", failure)
