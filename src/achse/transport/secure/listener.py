"""Listener of Secure ADS: admission of clients, and the NetIds that they may use.

Source: what each mode checks, network facts 2.3.
"""

import asyncio
import logging
from collections.abc import Iterable
from typing import Any, NamedTuple

from achse.ams import NetId
from achse.ams.secure import (
    SECURE_PORT,
    ConnectBlock,
    ConnectFlags,
    SecureRefusal,
    fingerprint_of,
)
from achse.router import Router
from achse.router.access import Users
from achse.router.routes import Admission, Route, RouteError, RouteTls, TlsKind
from achse.transport.connections.connection import TcpConnection
from achse.transport.connections.peer import Peer
from achse.transport.secure.channel import SecureServer
from achse.transport.secure.handshakes import Handshakes
from achse.transport.secure.own_certificate import names_of
from achse.transport.secure.password_checker import PasswordChecker
from achse.transport.secure.tls import ServerTls, Tls
from achse.transport.tcp.listener import TcpListener

log = logging.getLogger("achse.secure")


class _Proof(NamedTuple):
    """Proof by which a client has shown its identity."""

    fingerprint: str = ""
    """Of its certificate."""
    names: frozenset[str] = frozenset()
    """In a certificate of the authority."""
    identity: str = ""
    """Of its pre-shared key."""

    @classmethod
    def of(cls, tls: Tls) -> "_Proof":
        """Return the proof that the TLS handshake provides."""
        if not tls.certificate:
            return cls(identity=tls.identity)
        names = names_of(tls.certificate) if tls.trusted else frozenset[str]()
        return cls(fingerprint_of(tls.certificate), names)

    def is_for(self, route: Route, router: Router, host: str) -> bool:
        """Return True if the proof, shown from `host`, identifies the other side of this route.

        For a route with a fingerprint only the fingerprint counts. An authority or a key may have
        several clients: then the route's name or key must match, or `host` must be the host of the
        route.
        """
        tls = route.tls
        if tls is not None and tls.fingerprint:
            return tls.fingerprint == self.fingerprint
        named = tls is not None and (
            route.endpoint()[0].casefold() in self.names
            if tls.kind is TlsKind.SHARED_CA
            else tls.identity.casefold() == self.identity.casefold()
        )
        return named or router.routes.comes_from(route, host)


class _SecurePeer(Peer):
    """An authenticated far end: it may use its own NetId only.

    Further NetIds may come by it that have a route with its fingerprint.
    """

    def __init__(self, owner: "SecureListener") -> None:
        super().__init__(owner)
        self._net_id = b""
        self._proof = _Proof()

    def know(self, net_id: NetId, proof: "_Proof") -> None:
        """Store the client's NetId, and its proof."""
        self._net_id, self._proof = bytes(net_id), proof

    @property
    def net_id(self) -> bytes:
        """NetId that the client has named; empty before the client is admitted."""
        return self._net_id

    def _admission(self, net_id: bytes) -> Admission:
        route = self.owner.router.routes.to(net_id)
        if route is not None and route.tls is None:
            if net_id != self._net_id:
                return Admission.UNKNOWN  # the plain route of another host
            return super()._admission(net_id)
        tls = None if route is None else route.tls
        if net_id != self._net_id and (tls is None or not tls.fingerprint):
            return Admission.UNKNOWN
        if route is not None and not self._proof.is_for(route, self.owner.router, self.peer_host):
            return Admission.UNKNOWN
        return Admission.ONE_WAY if route is not None and route.one_way else Admission.ROUTED

    def _far_net_ids(self) -> Iterable[bytes]:
        return (self._net_id,)


_MOST_WAITING = 64 * 1024
"""Bytes from a client that waits for its turn; it is not read on beyond."""


_TOLD_AGAIN, _MOST_TOLD = 5.0, 1024
"""Seconds between two logged refusals of a host; number of hosts that are remembered."""


class SecureListener(TcpListener):
    """Accepts Secure ADS connections for a router. Clients without proof are refused.

    - self-signed: by the fingerprint of a route to the client's NetId; at a first contact user and
      password make that route;
    - shared authority: the certificate comes from it and is for the client's name or address
      (unless `ignore_names`);
    - pre-shared key: any client that has it.

    No client gets a local AMS port by it, or may use this router's own NetId.
    """

    def __init__(
        self,
        router: Router,
        tls: ServerTls,
        users: Users | None = None,
        *,
        name: str = "",
        ignore_names: bool = False,
        **limits: Any,
    ) -> None:
        super().__init__(router, routes_required=True, **limits)
        self._tls = tls
        self._users = users or Users()
        self._answer = ConnectBlock(net_id=NetId(router.net_id), host=name)
        self._ignore_names = ignore_names
        self.handshakes = Handshakes(lambda wait, call: self.loop.call_later(wait, call))
        self._passwords: PasswordChecker[_Question] = PasswordChecker(
            self._users.check, self._decide
        )
        self._refusals_by_host: dict[str, tuple[float, int]] = {}
        """By host: until when the log hears of no further refusals, and how many there were."""
        self.denied = 0
        """Clients that could not be authenticated."""

    async def open(self, host: str = "127.0.0.1", port: int = SECURE_PORT) -> None:
        await super().open(host, port)

    def _changed(self, old: Route | None, new: Route | None) -> None:
        """Close the connections that depend on a route that changed, so that the clients connect
        again."""
        if old is None or (new is not None and _lets_in(old) == _lets_in(new)):
            return
        net_id = bytes(old.net_id)
        for peer in list(self.connections):
            if isinstance(peer, _SecurePeer) and (
                net_id == peer.net_id or any(source[:6] == net_id for source in peer.senders)
            ):
                peer.warn("the route %s has changed", old.name)
                peer.close()

    async def close(self) -> None:
        await self._passwords.close()
        for channel in self.handshakes:
            channel.close()
        await super().close()

    def serves_ports(self, host: str) -> bool:
        return False

    def _connection(self) -> asyncio.Protocol:
        peer = _SecurePeer(self)

        def admitted(block: ConnectBlock, tls: Tls) -> None:
            peer.know(block.net_id, _Proof.of(tls))

        return _Counted(
            *(TcpConnection(peer), self._tls, self._check_access, self._answer),
            admitted=admitted,
            max_length=self.max_length,
            owner=self,
        )

    def _refuse(self, peer: Peer, whose: str = "", name: str = "", limit: int = 0) -> None:
        """Abort without an answer, which cannot be sent before the handshake."""
        self.refused += 1
        peer.warn("no room: [router] %s is %d", name or "connections", limit)
        peer.abort()

    def untold(self, host: str) -> int | None:
        """Return the number of unlogged refusals of a host; None if it is too early to log one."""
        until, others = self._refusals_by_host.get(host, (0.0, 0))
        now = self.loop.time()
        if now < until:
            self._refusals_by_host[host] = until, others + 1
            return None
        if len(self._refusals_by_host) >= _MOST_TOLD:
            self._refusals_by_host.clear()
        self._refusals_by_host[host] = now + _TOLD_AGAIN, 0
        return others

    # admission ------------------------------------------------------------------------------

    def _check_access(
        self, block: ConnectBlock, tls: Tls, host: str
    ) -> "asyncio.Future[SecureRefusal] | SecureRefusal":
        verdict = self._verdict(block, tls, host)
        if verdict is None:
            question = _Question(block, fingerprint_of(tls.certificate), host)
            if not self._passwords.put(host, block.user, block.password, question):
                return SecureRefusal.UNKNOWN_USER
            return question.answer
        self.denied += verdict is not SecureRefusal.NONE
        return verdict

    def _verdict(self, block: ConnectBlock, tls: Tls, host: str) -> SecureRefusal | None:
        """Return the verdict on a client; None if it depends on the check of a password."""
        if block.version != 1:
            return SecureRefusal.VERSION
        if self.router.is_local(bytes(block.net_id)) or not any(block.net_id[:4]):
            return SecureRefusal.UNKNOWN_CERTIFICATE
        if block.flags & ConnectFlags.SELF_SIGNED and tls.certificate:
            if block.user or block.flags & ConnectFlags.ADD_REMOTE:
                return None if self._users and block.password else SecureRefusal.UNKNOWN_USER
            route = self.router.routes.to(bytes(block.net_id))
            known = route.tls.fingerprint if route is not None and route.tls is not None else ""
            if known == fingerprint_of(tls.certificate):
                return SecureRefusal.NONE
            return SecureRefusal.UNKNOWN_CERTIFICATE
        if not tls.trusted or self._is_of_another(block, tls, host):
            return SecureRefusal.UNKNOWN_CERTIFICATE
        if tls.certificate and not self._ignore_names:
            names = names_of(tls.certificate)
            if host not in names and block.host.casefold() not in names:
                return SecureRefusal.NAME_MISMATCH
        return SecureRefusal.NONE

    def _is_of_another(self, block: ConnectBlock, tls: Tls, host: str) -> bool:
        """Return True if the NetId has a route by Secure ADS to another client."""
        route = self.router.routes.to(bytes(block.net_id))
        if route is None or route.tls is None:
            return False
        return not _Proof.of(tls).is_for(route, self.router, host)

    async def _decide(self, question: "_Question", _: str, right: bool) -> None:
        refusal = self._make_known(question) if right else SecureRefusal.UNKNOWN_USER
        self.denied += refusal is not SecureRefusal.NONE
        if not question.answer.done():
            question.answer.set_result(refusal)

    def _make_known(self, question: "_Question") -> SecureRefusal:
        """Keep the fingerprint with the route to this client; a route is made where none is."""
        block, routes = question.block, self.router.routes
        net_id = bytes(block.net_id)
        old = routes.to(net_id)
        tls, rights = RouteTls(fingerprint=question.fingerprint), self._users.rights(block.user)
        if old is not None and (old.tls, old.rights) == (tls, rights):
            return SecureRefusal.NONE
        keeps = bool(block.flags & ConnectFlags.SERVER_INFO)
        try:
            routes.add(
                Route(
                    name=(old.name if old is not None else block.host) or str(block.net_id),
                    net_id=block.net_id,
                    host=old.host if old is not None and keeps else question.host,
                    tls=tls,
                    rights=rights,
                )
            )
        except (RouteError, OSError) as fault:
            log.warning("no route for %s: %s", block.net_id, fault)
            return SecureRefusal.UNKNOWN_CERTIFICATE
        stored = routes.to(net_id)
        if stored is None or stored.tls != tls:
            # a fixed route stays as it is, and is not reported: no client uses it with a password
            log.warning("route %s is fixed and has another fingerprint", block.net_id)
            return SecureRefusal.UNKNOWN_CERTIFICATE
        log.info("%s is known by its fingerprint %s", block.net_id, question.fingerprint)
        return SecureRefusal.NONE


def _lets_in(route: Route) -> tuple[object, ...]:
    """Return the fields of a route that decide about a client's admission and rights."""
    return bytes(route.net_id), route.host, route.tls, route.rights, route.one_way


class _Question:
    """A first contact that waits for the check of its password."""

    def __init__(self, block: ConnectBlock, fingerprint: str, host: str) -> None:
        self.block = block
        self.fingerprint = fingerprint
        self.host = host
        self.answer: asyncio.Future[SecureRefusal] = asyncio.get_running_loop().create_future()


class _Counted(SecureServer):
    """Counts among the handshakes of its listener as soon as it is there, and waits its turn."""

    def __init__(self, *parts: Any, owner: SecureListener, **more: Any) -> None:
        super().__init__(*parts, ended=self._over, **more)
        self._owner = owner
        self._rest = b""
        self._held_up = False

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        if not self._owner.handshakes.begin(self):
            self._owner.refused += 1
            self._end("too many unauthenticated clients")

    def data_received(self, data: bytes) -> None:
        if self._opened:
            super().data_received(data)
        elif self._owner.handshakes.put(self, data) > _MOST_WAITING and self._tcp is not None:
            self._tcp.pause_reading()
            self._held_up = True

    def shake(self, data: bytes) -> None:
        """Continue the handshake, whose turn it is."""
        if self._held_up and self._tcp is not None:
            self._tcp.resume_reading()
            self._held_up = False
        super().data_received(data)

    def give_way(self) -> bool:
        if self._block is not None:
            return False
        self._end("too many newer unauthenticated clients")
        return True

    def _log_end(self, reason: str) -> None:
        if (others := self._owner.untold(self.host)) is not None:
            super()._log_end(reason + (f" ({others} more since the last report)" if others else ""))

    def _over(self, _: SecureServer) -> None:
        self._rest += self._owner.handshakes.end(self)

    def _open(self) -> None:
        super()._open()
        rest, self._rest = self._rest, b""
        if rest:
            super().data_received(rest)
