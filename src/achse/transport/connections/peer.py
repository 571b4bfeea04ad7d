"""The peer at the far end of a connection, without a socket: bytes in, frames out, and back.

Learning, buffering and forwarding are decided here. A `ByteTransport` carries the bytes, and a
`Scheduler` calls back at a time: a TCP transport and its loop, a serial line, a test.

Source: 000 §3.2.
"""

import logging
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import Any

from achse.ams import (
    AmsAddress,
    Command,
    Connection,
    DecodeError,
    Event,
    Flags,
    Frame,
)
from achse.codes import ReturnCode
from achse.router.forwarding import Forwarding
from achse.router.forwarding.forwarded_client import ForwardedClient
from achse.router.forwarding.journal import LinkJournal
from achse.router.forwarding.restoring import LinkMemory
from achse.router.rights import ALL_RIGHTS, NO_RIGHTS, Right
from achse.router.routes import Admission, Route
from achse.transport.connections.byte_transport import ByteTransport, PeerOwner
from achse.transport.connections.circles import CircleWarning
from achse.transport.connections.known.frames import KnownFrames
from achse.transport.connections.known.single import HEAD, SMALL_PORTION
from achse.transport.connections.port_service import serve_ports
from achse.transport.connections.repeated import REQUEST_SIZE, RepeatedReads
from achse.transport.connections.sender_rights import SenderRights, missing_route
from achse.transport.connections.senders import Senders
from achse.transport.connections.writer import CONGESTED, PeerWriter

log = logging.getLogger("achse.tcp")


_NO_RESPONSE = int(Flags.NO_RESPONSE)

_UNANSWERED = int(Flags.RESPONSE | Flags.NO_RESPONSE)

_LINGER = 5.0
"""Seconds a closed connection has to take the rest of what was sent to it."""


class Peer(PeerWriter):
    """The far end of one connection; for the router it is an endpoint.

    The owner of the transport calls `begin` once it is connected, `receive` with bytes, `count`
    when the size of its write buffer changes, `close` at the end of the input, and `ended` when the
    transport is closed. Frames for the peer are gathered and written once per turn. A peer that
    does not read is cut off when more than `max_backlog` bytes wait for it.
    """

    _code_at_end: ReturnCode | None = None
    """Answer to pending requests when the transport is closed; None: their clients time out."""

    _memory: LinkMemory | None = None
    """Clients of this connection until the next one is there; None: they are not kept."""

    _journal: LinkJournal | None = None
    """Symbol handles of clients at the far end; None: they are not kept."""

    _ends_subscription = False
    """True if the next answer has to follow the delayed notifications."""

    _unchanged = True
    """True if frames are passed on without changes to their addresses."""

    def __init__(self, owner: PeerOwner) -> None:
        super().__init__(owner)
        self.router = owner.router
        self._stream = Connection(owner.max_length)
        self.senders = Senders()
        self.last_source = b""
        self.rights = SenderRights()
        self._comes_from_router = False
        self.is_spoofing = False
        """True if the last sender gave an address that belongs to a port of another endpoint."""
        self._forwarding: Forwarding | None = None
        """Requests of other clients, from the first one until the transport is closed."""
        self._repeated = RepeatedReads(owner.router)
        self._known_frames: KnownFrames | None = None
        """Frames that are not decoded, from the first forwarded request on."""
        self._singles: dict[bytes, Callable[[bytes], bool]] = {}
        """Functions that pass on a known frame that comes alone, as `KnownFrames.singles`."""
        self._circles = CircleWarning()
        self._events: Iterator[Event | None] = iter(())
        """Received events that are not processed yet."""
        self._undone = 0
        """Bytes of that at most."""
        self._partial = False
        """True while a packet lacks its end."""
        self._late: list[bytes] = []
        """Chunks that the transport delivers after it was paused."""
        self._paused = False
        self.registered: list[AmsAddress] = []
        """Local ports that the peer holds."""
        self.peer, self.peer_host = "?", ""
        self.socket: Any = None
        """The socket below its transport, if there is one."""

    # the transport -----------------------------------------------------------------------------

    def begin(
        self,
        transport: ByteTransport,
        host: str = "",
        port: int = 0,
        *,
        congested: int = CONGESTED,
        counts: bool = False,
    ) -> None:
        """Send bytes by `transport` from now on; its far end is at `host`:`port`, if known.

        With more than `congested` bytes in its write buffer, notifications are kept back. With
        `counts` it calls `count` as soon as written bytes wait.
        """
        self._transport = transport
        self.direct_write = transport.write if counts else self.write
        self._congested = congested
        self.connected = True
        if host:
            self.peer_host = host
            self.peer = f"{host}:{port}"
        self.owner.opened(self)

    def ended(self) -> None:
        """Clear all: the transport is closed."""
        self._transport = None
        self._leave()
        self.owner.closed(self)
        forwarding, self._forwarding = self._forwarding, None
        if forwarding is None:
            return
        clients, answers = forwarding.end(self._code_at_end)
        for answer in answers:
            self.router.deliver(answer)
        for session in clients:
            self._report_loss(session)

    def receive(self, data: bytes) -> None:
        """Take bytes as they come."""
        single = self._singles.get(data[HEAD])
        if single is not None and not self._partial and not self._undone and single(data):
            return
        if not self.connected:
            return
        if self._undone:
            self._late.append(data)
            self._undone += len(data)
            return
        if len(data) <= SMALL_PORTION:
            if self._known_frames is not None and not self._partial:
                done = self._known_frames.pass_on_portion(data)
                if done == len(data):
                    return
                if done:
                    data = data[done:]
            whole = len(data) >= REQUEST_SIZE and not self._stream.pending
            if whole and self._unchanged and not self.rights:
                answers, done = self._repeated.answer(data, self.last_source)
                if done:
                    self.router.client_figures.count_requests(
                        self.last_source, done // REQUEST_SIZE
                    )
                    self.write_buffer.put(answers)
                    if done == len(data):
                        self._flush()
                        return
                    data = data[done:]
            self._do(self._events_of(data), None)
            return
        self._events, self._undone = self._events_of(data), len(data)
        if not self.owner.fair_queue.serve(self, self.owner.loop.call_soon):
            self.count()
            if self._transport is not None:
                self._transport.pause_reading()
                self._paused = True

    def work(self, until: float) -> bool:
        """Do what came and waits, until this moment; True when all is done."""
        done = self._do(self._events, until)
        if done and self._late:
            self._events, self._late = self._events_of(b"".join(self._late)), []
            return False
        if done and self._undone:
            self._undone = 0
            self.count()
            if self._paused and self._transport is not None:
                self._transport.resume_reading()
            self._paused = False
        return done or not self.connected

    def _events_of(self, data: bytes) -> Iterator[Event | None]:
        known = self._known_frames
        return self._stream.receive(data) if known is None else known.events(data)

    def _do(self, events: Iterator[Event | None], until: float | None) -> bool:
        """Do what came, until this moment if there is one; True when all is done."""
        router = self.router
        self._receiving = True
        try:
            for event in events:
                if isinstance(event, Frame):
                    event.origin = self
                    if event.source != self.last_source and not self._learn(event.source):
                        return False
                    if (self.rights or self.is_spoofing) and self._refuse(event):
                        continue
                    backwards = event.is_response or event.command == Command.NOTIFICATION
                    if backwards and not self._comes_back(event):
                        continue
                    try:
                        router.deliver(event)
                    except Exception:  # a fault of one frame is not one of its connection
                        self._apologize(event)
                elif event is not None:
                    serve_ports(self, event)
                if not self.connected:
                    return False
                if until is not None and self.owner.fair_queue.clock() >= until:
                    return False
            return True
        except DecodeError as failure:
            self.turn_out("%s", failure)
            return False
        finally:
            self._receiving = False
            self._flush()
            self._partial = bool(self._stream.pending)
            if self._counted or self._partial:
                self.count()

    def _comes_back(self, frame: Frame) -> bool:
        """False for answers and notifications that end here, as those in the name of others."""
        forwarding = self._forwarding
        if not self.answers(frame.source):
            self.router.lost_frames += 1
            return False
        return forwarding is None or forwarding.come_back(frame)

    def answers(self, source: bytes) -> bool:
        """True if requests to `source` go by this connection, so that answers may come by it."""
        server = self.router.server_at(source)
        return self._forwarding is not None if server is None else server in (self, self.owner)

    def _apologize(self, frame: Frame) -> None:
        """Log an internal error over this frame, and answer its sender."""
        log.exception(
            "a frame of %s to %s could not be delivered",
            *(AmsAddress(frame.source), AmsAddress(frame.target)),
            extra=frame.sender,
        )
        backwards = frame.is_response or frame.command == Command.NOTIFICATION
        if not backwards and not frame.flags & _NO_RESPONSE:
            self.deliver(frame.reply(error=ReturnCode.INTERNAL_ERROR.number))

    def _leave(self) -> None:
        """Remove the peer: it is unreachable and has no resources from here on."""
        was_open = self.connected
        self.connected = False
        if self._forwarding is not None:
            self._forwarding.requests.stop()
        self.write_buffer.clear()
        self._events, self._undone = iter(()), 0
        self._late.clear()
        self._stream.drop()
        self._repeated.clear()
        if self._known_frames is not None:
            self._known_frames.clear()
        for source in self.senders:
            self.router.forget(source, self)
        self.senders.clear()
        while self.registered:
            self.router.unregister(self.registered.pop().port)
        self.count()
        if was_open:
            self.router.close_way(self)

    # addresses -------------------------------------------------------------------------------

    def _learn(self, source: bytes) -> bool:
        """Note where `source` is; False if it may not come here and the connection ends."""
        router = self.router
        self.last_source = source
        self.is_spoofing = (router.local_endpoint(source) or self) is not self
        ours = router.is_local(source[:6]) and self.owner.serves_ports(self.peer_host)
        if not self.senders and log.isEnabledFor(logging.INFO):
            facts = {"client": self.client, "peer": self.peer}
            log.info("%s has come, client %s", self.peer, facts["client"], extra=facts)
        if source not in self.senders and not ours:
            admission = self._effective_admission(source[:6])
            self.rights.assign(source, self._rights_of(source[:6], admission))
            if admission is Admission.UNKNOWN and self.owner.routes_required:
                self.turn_out("%s", missing_route(source[:6], self.peer_host))
                return False
        self.router.learn(source, self)
        oldest = self.senders.add(source)
        if oldest is not None:
            self.rights.forget(oldest)
            self.router.crowd_out(oldest, self)
        return True

    def _admission(self, net_id: bytes) -> Admission:
        """Return the admission of frames from `net_id` over this connection."""
        return self.router.routes.admission(net_id, self.peer_host)

    def _effective_admission(self, net_id: bytes) -> Admission:
        """Return the admission; strangers behind a router with a route have no rights."""
        admission = self._admission(net_id)
        if admission is not Admission.UNKNOWN or not self.owner.routes_required:
            return admission
        if not self._comes_from_router:
            known = map(self._admission, self._far_net_ids())
            self._comes_from_router = Admission.ROUTED in known
        return Admission.ONE_WAY if self._comes_from_router else admission

    def _far_net_ids(self) -> Iterable[bytes]:
        """Return NetIds of which the router at the far end may have one."""
        return (bytes(route.net_id) for route in self.router.routes)

    def _rights_of(self, net_id: bytes, admission: Admission) -> Right:
        """Return the rights of frames from `net_id` with this admission."""
        return self.router.routes.rights(net_id, admission)

    def review_access(self, route: Route) -> None:
        """End each sender that may do less now, because this route came, went or changed.

        So nothing goes on that it had subscribed to or opened when it might more. Its rights end at
        once, the connection behind the answer: the request that changed the route may be its own.
        """
        all_of_them, self._comes_from_router = self._comes_from_router, False
        for source in [each for each in self.senders if all_of_them or each[:6] == route.net_id]:
            net_id, client = source[:6], AmsAddress(source).net_id
            admission = self._effective_admission(net_id)
            stranger = admission is Admission.UNKNOWN and self.owner.routes_required
            rights = NO_RIGHTS if stranger else self._rights_of(net_id, admission)
            if self.rights.assign(source, rights) or stranger:
                self.owner.loop.call_soon(partial(self._end_access, client))
                return

    def _end_access(self, client: object) -> None:
        """End the connection of a client that may do less now, unless it has ended since."""
        if self.connected:
            self.turn_out("%s may less than before: the route has changed", client)

    def _refuse(self, frame: Frame) -> bool:
        """Refuse a request for which its sender has no right."""
        is_spoofing = self.is_spoofing and self.router.is_local(frame.target[:6])
        missing = ALL_RIGHTS if is_spoofing else self.rights.missing(frame)
        if not missing:
            return False
        self.router.denied += 1
        self.router.client_figures.count_requests(frame.source)
        self.router.client_figures.count_error(frame.source)
        if is_spoofing:
            self.rights.report_spoofing(frame.source, self.peer)
        else:
            self.rights.report(frame.source, missing, self.peer)
        if not frame.flags & _UNANSWERED and frame.command != Command.NOTIFICATION:
            self.deliver(frame.reply(error=ReturnCode.DEVICE_ACCESS_DENIED.number))
        return True

    # requests of others ------------------------------------------------------------------------

    @property
    def forwarding(self) -> Forwarding | None:
        """Requests of other clients over this connection; None before the first one."""
        return self._forwarding

    def _forward(self, frame: Frame) -> Frame | None:
        """Return the frame to send for a request of another client; None if it does not go.

        A request for a port of ours cannot circle: the server behind this connection registered it.
        """
        router, client = self.router, frame.origin or self.router.local_endpoint(frame.source)
        if client is None:
            return frame
        congested, quiet = self.congested, frame.flags & _NO_RESPONSE
        if not getattr(client, "connected", True) or (congested and quiet):
            return None
        now = int(self.owner.loop.time() * 1e9)
        circles = frame.origin is not None and not router.is_local(frame.target[:6])
        congested = congested and frame.origin is not None
        if self._forwarding is None:
            self._forwarding = self._make_forwarding()
        outcome = self._forwarding.request(client, frame, now, circles=circles, congested=congested)
        if isinstance(outcome, Frame):
            self._may_know(self)
            self._may_know(client)
            return outcome
        if outcome is ReturnCode.TARGET_MACHINE_NOT_FOUND:
            self._circles.report(frame, self.peer, now)
        if not frame.flags & _NO_RESPONSE:
            router.deliver(frame.reply(error=outcome.number))
        return None

    def _make_forwarding(self) -> Forwarding:
        clock = self.owner.loop.time if self.router.source_nat else None
        calls = self._send_own, self._after_a_second
        return Forwarding(*(self.router, *calls, clock, self._memory, self._put_all, self._journal))

    def _may_know(self, peer: object) -> None:
        """Let `peer` pass on known frames without decoding."""
        if isinstance(peer, Peer) and peer._known_frames is None and peer._unchanged:
            peer._known_frames = KnownFrames(peer, peer._stream)
            peer._singles = peer._known_frames.singles

    def takes_known(self) -> bool:
        """True if frames may be put here as they leave."""
        return self.connected and self._unchanged

    def room_for_notifications(self) -> int:
        return super().room_for_notifications() if self._unchanged else 0

    def comes_from(self, source: bytes) -> bool:
        """Note the sender of known frames; False if they have to be decoded."""
        if source != self.last_source and not self._learn(source):
            return False
        return not self.is_spoofing

    @property
    def limited(self) -> bool:
        """True if a sender of this connection may not everything."""
        return bool(self.rights)

    def _send_own(self, frame: Frame) -> None:
        """Send a request of the router itself."""
        if self.connected:
            self._put(frame.encode_tcp())

    def _put_all(self, packets: list[bytes]) -> None:
        for packet in packets:
            self._put(packet)

    def _after_a_second(self, callback: Callable[[], object]) -> None:
        self.owner.loop.call_at(self.owner.loop.time() + 1.0, callback)

    def _report_loss(self, session: ForwardedClient) -> None:
        """Report that the subscriptions of a client are invalid, and end its connection."""
        for hint in session.end_hints():
            self.router.deliver(hint)
        if isinstance(session.client, Peer):
            session.client.drop_client(self.peer)

    def drop_client(self, target: str) -> None:
        """End the connection: the target has lost the subscriptions and handles of its client."""
        if self.connected:
            self.warn("its subscriptions and handles at %s ended with the connection there", target)
            self.close()

    # writing -----------------------------------------------------------------------------------

    def deliver(self, frame: Frame) -> bool:
        """Send `frame` to the peer; False if the connection is gone.

        A request for a peer that leaves too much unread is answered with 0x502 instead.
        """
        if not self.connected:
            return False
        if not frame.flags & 1 and frame.command != Command.NOTIFICATION:
            if (forwarded := self._forward(frame)) is None:
                return True
            frame = forwarded
            packet = frame.encode_tcp()
            if self._forwarding is None or not self._forwarding.waits(frame, packet):
                self._put(packet)
            return True
        packet = frame.encode_tcp()
        if frame.command == Command.ADD_NOTIFICATION and frame.is_response:
            self.write_buffer.added(self.owner.loop.time())
        elif frame.command == Command.NOTIFICATION:
            if self._delay(packet):
                return True
        elif self.write_buffer.delayed_size and (self._ends_subscription or _is_deleted(frame)):
            self._ends_subscription = False
            if self.write_buffer.delay_answer(packet):
                self.count()
                return True
        self._put(packet)
        return True

    def subscription_ended(self) -> None:
        """Send the next answer, the end of a subscription, behind the delayed samples."""
        self._ends_subscription = self.write_buffer.due is not None

    @property
    def unprocessed(self) -> int:
        """Bytes of packets that lack their end, and of events that wait."""
        return self._stream.pending + self._undone

    def break_off(self, frame: Frame) -> None:
        """Send the first half of `frame`, then end the connection: a cable pulled in between."""
        packet = frame.encode_tcp()
        self.write_buffer.put(packet[: len(packet) // 2])
        self.close()

    @property
    def client(self) -> str:
        """The AMS address that the peer last sent from, or else registered; "" if neither."""
        address = self.last_source or next(iter(self.registered), b"")
        return str(AmsAddress(address)) if address else ""

    def warn(self, reason: str, *details: object) -> None:
        """Log the reason of the end of this connection, with its client."""
        client = self.client
        name = f"{self.peer}, client {client}" if client else self.peer
        facts = {"client": client, "peer": self.peer}
        log.warning("closing %s: " + reason, name, *details, extra=facts)

    def turn_out(self, reason: str, *details: object) -> None:
        """Log the reason, and close the connection."""
        self.warn(reason, *details)
        self.close()

    def give_up(self) -> ByteTransport:
        """Return the transport for another use: this peer reads and writes nothing more."""
        transport, self._transport = self._transport, None
        assert transport is not None
        self._leave()
        return transport

    def abort(self) -> None:
        """Close at once; what waits for the peer is lost."""
        self._leave()
        if self._transport is not None:
            self._transport.abort()

    def close(self) -> None:
        """Send what is due and close; a peer that does not take it in time is cut off."""
        self._flush()
        if self.connected and self._transport is not None:
            self._leave()
            self._transport.close()
            if self._transport.get_write_buffer_size():
                scheduler = self.owner.loop
                scheduler.call_at(scheduler.time() + _LINGER, self.abort)


def _is_deleted(frame: Frame) -> bool:
    """Return True for the answer that a notification is deleted."""
    return frame.command == Command.DELETE_NOTIFICATION and frame.data == _DONE


_DONE = bytes(4)
"""Answer without an error."""
