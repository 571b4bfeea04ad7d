"""The far end of a connection that this station dialled: what its requests may here.

The dialled router of a route answers; it may send requests too, for itself and others behind it. It
gets no more by this than by coming itself.
"""

import math
from collections.abc import Callable
from typing import Protocol

from achse.codes import ReturnCode
from achse.router.forwarding import Forwarding
from achse.router.forwarding.forwarded_client import ForwardedClient
from achse.router.forwarding.journal import LinkJournal
from achse.router.forwarding.ledger import Resource
from achse.router.forwarding.restoring import LinkMemory
from achse.router.rights import Right
from achse.router.routes import Admission, Route
from achse.transport.connections.byte_transport import PeerOwner
from achse.transport.connections.peer import Peer


class DialOwner(PeerOwner, Protocol):
    """Owner of a connection that it dialled, and the route for which it did."""

    strict: bool
    """True if senders without a route are refused."""

    memory: LinkMemory | None
    """Clients while there is no connection; None: they are not kept."""

    @property
    def route(self) -> Route: ...

    def remembered(self) -> None:
        """Dial again: resources are kept."""


class DialledPeer(Peer):
    """The other side of a route, at the end of a connection that was dialled for it.

    - Its own NetId has the rights of the route. Another one has those of its own route, where that
      leads to the same place; else what strangers may, and never more than the route.
    - With `strict` strangers are refused (0x723); the connection stays, others use it.
    - Requests from behind a one-way route are refused, whatever their NetId.
    - Requests that are unanswered when the connection ends are answered 0x1B: it is unknown whether
      they were done.
    """

    _code_at_end = ReturnCode.HOST_UNREACHABLE

    def __init__(self, owner: DialOwner) -> None:
        super().__init__(owner)
        self._dialled_by = owner
        self._memory = owner.memory
        journal = owner.router.journal
        if journal is not None:
            self._journal = LinkJournal(journal, owner.route.net_id)

    def ended(self) -> None:
        """Pass on the answers and samples that came before the end, which waited for their turn."""
        self._transport = None
        while self.connected and not self.work(math.inf):
            pass
        super().ended()

    def _report_loss(self, session: ForwardedClient) -> None:
        memory = self._dialled_by.memory
        if memory is not None and memory.keep(session):
            self._dialled_by.remembered()
        else:
            super()._report_loss(session)

    def release_orphans(self, done: Callable[[], object]) -> None:
        """Release the handles that earlier connections left at the target."""
        if self._journal is None or not self._journal.handles():
            done()
            return
        if self._forwarding is None:
            self._forwarding = self._make_forwarding()
        self._forwarding.release_orphans(done)

    def restore(self) -> None:
        """Make the resources of the clients of the last connection again."""
        memory = self._memory
        if memory is None or not memory.sessions:
            return
        if self._forwarding is None:
            self._forwarding = self._make_forwarding()
        sessions, memory.sessions = memory.sessions, []
        for session in sessions:
            self._restore(self._forwarding, session)

    def _restore(self, forwarding: Forwarding, session: ForwardedClient) -> None:
        def lost(resource: Resource) -> None:
            for hint in session.hints_for([resource]):
                self.router.deliver(hint)

        def done(success: bool) -> None:
            if not success:
                super(DialledPeer, self)._report_loss(session)

        if not forwarding.restore(session, lost, done):
            super()._report_loss(session)

    def _admission(self, net_id: bytes) -> Admission:
        dialled = self._dialled_by.route
        if dialled.one_way:
            return Admission.ONE_WAY
        if net_id == dialled.net_id:
            return Admission.ROUTED
        admission = super()._admission(net_id)
        route = self.router.routes.to(net_id)
        if admission is Admission.UNKNOWN and route is not None and _same_proof(route, dialled):
            admission = Admission.ONE_WAY if route.one_way else Admission.ROUTED
        if admission is Admission.UNKNOWN and self._dialled_by.strict:
            return Admission.ONE_WAY
        return admission

    def _rights_of(self, net_id: bytes, admission: Admission) -> Right:
        rights = super()._rights_of(net_id, admission)
        return rights & self._dialled_by.route.rights if admission is Admission.UNKNOWN else rights


def _same_proof(route: Route, dialled: Route) -> bool:
    """Return True if `route` names the certificate that the far end of `dialled` has shown."""
    if route.tls is None or dialled.tls is None:
        return False
    return bool(dialled.tls.fingerprint) and route.tls.fingerprint == dialled.tls.fingerprint
