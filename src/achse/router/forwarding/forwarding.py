"""Forwarding: the requests of many clients over one connection, each from an address of its own.

Clients often share an AMS address: every pyads on a host has the same NetId and port. A session is
one client connection with one source address. The target sees its alias: the address itself for
the first session that uses it, the same NetId with another port for each further one. With
`source_nat` every alias has the NetId of the router, so that a target needs one route. Answers and
notifications are addressed to the alias, so they find the session that asked, at any time. What a
client leaves at a target is released when its connection or its port is closed.

Source: the router of the vendor gives each of its local programs a port of its own (reference
traffic, port connect 0x1000); a subscription belongs to an AMS address.
"""

from collections.abc import Callable, Iterator

from achse.ams import AmsAddress, Command, Endpoint, Flags, Frame
from achse.codes import ReturnCode
from achse.router.forwarding.forwarded_client import ForwardedClient
from achse.router.forwarding.journal import LinkJournal
from achse.router.forwarding.latency import MEASURED, Latencies
from achse.router.forwarding.ledger import (
    Resource,
    ResourceAction,
    ResourceChange,
    ResourceKind,
)
from achse.router.forwarding.orphans import EARLIER, OrphanRelease
from achse.router.forwarding.pending import PendingExchange, PendingRequest, PendingRequests
from achse.router.forwarding.resource_requests import change_of, without
from achse.router.forwarding.restoring import LinkMemory, Restoration, version_request
from achse.router.forwarding.router_requests import RouterRequests
from achse.router.forwarding.sessions import ClientPorts, Sessions
from achse.router.forwarding.windows import Windows

_NO_RESPONSE = int(Flags.NO_RESPONSE)

_READS = (int(Command.READ), int(Command.READ_WRITE))

_ROUNDS, _ROUND_NS = 48, 1_000_000_000
"""Sessions of a connection that all began with the same request within this time: it goes in
circles. Less than a window, so that it does not wait there."""

_PATIENCE, _RESTORED_WITHIN = 5, 60
"""Seconds in which a target has to answer something, and all, that makes resources again."""

_RELEASED_WITHIN = 30
"""Seconds in which a target has to answer all that releases orphaned handles."""

_UNKNOWN = b"?"
"""Symbol version that is queried, and no answer has come yet."""


class Forwarding:
    """Requests of many clients over one connection, and their answers.

    `send` sends a request of the router itself. `later` calls back after a second: releases that
    are unanswered by then are not waited for, and late samples of a client that is gone have come.
    """

    def __init__(
        self,
        router: ClientPorts,
        send: Callable[[Frame], object],
        later: Callable[[Callable[[], object]], object],
        clock: Callable[[], float] | None = None,
        memory: LinkMemory | None = None,
        write: Callable[[list[bytes]], object] | None = None,
        journal: LinkJournal | None = None,
    ) -> None:
        """With `write`, which sends packets, what is beyond the window of a client waits. With
        `clock` (seconds, as the times of requests) latencies are counted; with `memory`
        resources are remembered so that they can be made again; symbol handles are entered into
        `journal`."""
        self._memory = memory
        self._journal = journal
        self._versions: set[bytes] = set()
        """Devices whose symbol version was queried on this connection."""
        self._router = router
        self._clock = clock
        self._later = later
        self._sessions = Sessions(router, later, self._freed)
        self.windows = Windows(write or _nowhere, later)
        self.requests = PendingRequests(self._sessions.rest, self.windows.go_on)
        self._subscribers: dict[Resource, ForwardedClient] = {}
        """Client of each subscription."""
        self._own = RouterRequests(
            *(send, later),
            is_used=self.requests.__contains__,
            is_held=self._subscribers.__contains__,
            rest=self._sessions.rest,
            released=self._note_release,
        )
        self._orphans: OrphanRelease | None = None
        self._restorations: list[Restoration] = []
        self._listening = False
        self.returned = 0
        """Answers and notifications that came so far."""
        self.refused = 0
        """Requests that were refused because too many were pending."""
        self.latencies = Latencies()
        """Latencies of every sixteenth answer."""

    def __len__(self) -> int:
        """Sessions for which something may come."""
        return len(self._sessions)

    @property
    def pending(self) -> int:
        """Requests without an answer."""
        return len(self.requests)

    @property
    def clients(self) -> Iterator[ForwardedClient]:
        """Sessions of clients that are there."""
        return (each for each in self._sessions if not each.is_disconnected)

    @property
    def resources(self) -> Iterator[tuple[ForwardedClient, Resource]]:
        """All resources of clients, those of disconnected clients included."""
        for session in self._sessions:
            yield from ((session, resource) for resource in session.resources)
        yield from self._own.to_release

    # requests --------------------------------------------------------------------------------

    def request(
        self,
        client: Endpoint,
        frame: Frame,
        now: int,
        *,
        circles: bool = True,
        congested: bool = False,
    ) -> Frame | ReturnCode:
        """Return the frame to send for a request of `client`, or what refuses it.

        `now` in ns. With `circles`: 0x7 if it goes in circles, 0x502 if too many requests are
        unanswered to detect that. 0x502 also if too much of the client is under way (anything
        while the far end is `congested`), 0x508 if there are no ports for further aliases or the
        client keeps as many resources as it may, 0x701 if it fetches a resource without an answer.

        A handle of another client's subscription is replaced by 0 where it is to be deleted.
        """
        session = self._session(client, frame)
        if isinstance(session, ReturnCode):
            return session
        if session.restored_from is not None:
            return ReturnCode.HOST_UNREACHABLE  # its handles are not known yet
        if session.handles is not None:
            frame = _with(frame, session.handles.request(frame))
        change = change_of(frame)
        data = frame.data
        if change is not None:
            foreign = [each for each in change.actions if self._is_foreign(session, change, each)]
            if foreign:
                data = without(data, foreign)
                change = (
                    None if len(foreign) == len(change.actions) else change_of(_with(frame, data))
                )
        if change is not None and self._keeps_too_much(session, change):
            self.refused += 1
            return ReturnCode.ROUTER_NO_MORE_QUEUES
        if frame.flags & _NO_RESPONSE:
            for action in () if change is None else change.actions:
                if action.handle is None:  # its handle would be unknown
                    return ReturnCode.SERVICE_NOT_SUPPORTED
                if change is not None:
                    self._discard(session, Resource(action.kind, change.target, action.handle))
        else:
            size = _size_with_answer(frame)
            if self.requests.is_too_much(session, size, now, congested):
                self.refused += 1
                return ReturnCode.ROUTER_MAILBOX_FULL
            if circles and not session.exchanges and self._goes_round(session, frame, size, now):
                return ReturnCode.TARGET_MACHINE_NOT_FOUND
            request = PendingRequest(session, frame.command, frame.flags, change, now, size)
            refusal = self.requests.add(session, frame, request, circles)
            if refusal is not None:
                return refusal
            if change is not None and self._journal is not None and change.fetches_handle:
                self._journal.add_requester(session.alias, change.target)
        if session.alias == frame.source and data is frame.data:
            return frame
        forwarded = _with(frame, data)
        forwarded.source = session.alias
        return forwarded

    def _session(self, client: Endpoint, frame: Frame) -> ForwardedClient | ReturnCode:
        source = frame.source
        session = self._sessions.find(client, source)
        if session is not None:
            return session
        holder = self._sessions.at(source)
        key = (source, frame.target, frame.invoke_id)
        if holder is not None and holder.alias != holder.source and key in self.requests:
            return ReturnCode.TARGET_MACHINE_NOT_FOUND  # our own request has come back
        self._listen()
        return self._sessions.begin(client, source) or ReturnCode.ROUTER_NO_MORE_QUEUES

    def _goes_round(self, session: ForwardedClient, frame: Frame, size: int, now: int) -> bool:
        """True if the first request of a session is that of many new ones of its connection.

        A request that goes in circles through routers which give each client an alias comes from
        another address each time.
        """
        latest = self._sessions.latest(session.client, _ROUNDS + 1)[1:]
        for each in latest:
            exchange = each.exchanges.get(frame.target)
            request = None if exchange is None else exchange.requests.get(frame.invoke_id)
            if (
                request is None
                or (request.command, request.size) != (frame.command, size)
                or now - request.time >= _ROUND_NS
            ):
                return False
        return len(latest) == _ROUNDS

    def _keeps_too_much(self, session: ForwardedClient, change: ResourceChange) -> bool:
        """True if a request fetches more than the connection of a client may keep."""
        further = change.fetches
        if not further:
            return False
        known = sum(len(each.resources) for each in self._sessions.of_client(session.client))
        load = session.load
        return known + load.fetching + further > load.share.resources

    def _is_foreign(
        self, session: ForwardedClient, change: ResourceChange, action: ResourceAction
    ) -> bool:
        """True if a subscription is to be deleted that another client holds."""
        if action.handle is None or action.kind is not ResourceKind.SUBSCRIPTION:
            return False
        resource = Resource(action.kind, change.target, action.handle)
        return self._subscribers.get(resource, session) is not session

    def waits(self, frame: Frame, packet: bytes) -> bool:
        """True if a request, which is `packet` on the wire, is kept until others are answered."""
        session = self._sessions.at(frame.source)
        if session is None or self.windows.is_open(session.load):
            return False
        count = 0 if frame.flags & _NO_RESPONSE else 1
        size = _size_with_answer(frame) if count else 0
        return not self.windows.admit(session.load, packet, count, size)

    def exchange(self, client: Endpoint, source: bytes, target: bytes) -> PendingExchange | None:
        """Return the exchange of a client that has asked this target before."""
        session = self._sessions.find(client, source)
        if session is None or session.handles is not None:
            return None
        return session.exchanges.get(target)

    def sent(self, session: ForwardedClient, count: int, size: int, now: int) -> None:
        """Count requests that were entered into an exchange: they are under way now."""
        self.requests.added(count)
        self.requests.sent(session, count, size, now)

    def answered(self, request: PendingRequest, count: int, size: int) -> None:
        """Count requests like this one that were removed from an exchange: they are answered."""
        before = self.returned
        self.returned += count
        measured = self.returned // MEASURED - before // MEASURED
        if measured and self._clock is not None:
            self.latencies.add(int(self._clock() * 1e9) - request.time, measured)
        self.requests.added(-count)
        self.requests.answered(request, count, size)
        self._sessions.rest(request.session)

    def measure(self, request: PendingRequest) -> None:
        """Count the latency of a request that is answered now."""
        if self._clock is not None:
            self.latencies.add(int(self._clock() * 1e9) - request.time)

    def rest(self, session: ForwardedClient) -> None:
        """Keep a session for a while if nothing more comes for it."""
        self._sessions.rest(session)

    # answers and notifications ---------------------------------------------------------------

    def come_back(self, frame: Frame) -> bool:
        """Address an answer or a notification to its client; False if it ends here.

        That is so for answers to releases, and for what comes for a client that is gone. A frame
        for an address that is not an alias stays as it is.
        """
        self.returned += 1
        session = self._sessions.at(frame.target)
        if session is None:
            return True
        if frame.flags & 1 and self._settle(session, frame):
            return False
        if session.is_disconnected:
            return False
        if session.handles is not None and frame.command == Command.NOTIFICATION:
            frame.data = session.handles.samples(frame.source, frame.data)
        frame.target = session.source
        frame.via = session.client
        return True

    def _settle(self, session: ForwardedClient, answer: Frame) -> bool:
        """Take note of an answer; True if it is one to a request of ours."""
        if self._own.settle(session, answer):
            return True
        exchange = session.exchanges.get(answer.source)
        request = None if exchange is None else self.requests.pop(exchange, answer.invoke_id)
        if request is not None:
            if request.change is not None and not answer.error:
                self._apply(session, request.change, answer.data)
                if session.handles is not None:
                    answer.data = session.handles.answer(request.change, answer.data)
            if self.returned % MEASURED == 0:
                self.measure(request)
            self._sessions.rest(session)
        return False

    def _apply(self, session: ForwardedClient, change: ResourceChange, answer: bytes) -> None:
        """Add and remove the resources that an answer returns or releases."""
        for action, resource in change.outcomes(answer):
            if action.handle is None:
                self._enter(session, resource, action.recipe)
            else:
                self._discard(session, resource)

    def _enter(self, session: ForwardedClient, resource: Resource, recipe: bytes) -> None:
        """Enter a resource that the target allocated."""
        if resource.kind is ResourceKind.SUBSCRIPTION:
            before = self._subscribers.get(resource)
            if before is not None:  # the target has forgotten it, and gives the number again
                before.resources.pop(resource, None)
                self._sessions.rest(before)
            self._subscribers[resource] = session
            session.subscribed = True
        count = session.resources.get(resource, 0)
        session.resources[resource] = 1 if resource.kind is ResourceKind.FILE else count + 1
        memory = self._memory
        if recipe and memory is not None and memory.applies(session.client, session.source):
            session.recipes[resource] = recipe
            self._note_version(session, resource.target)
        if resource.kind is ResourceKind.SYMBOL_HANDLE and self._journal is not None:
            self._journal.fetched(session.alias, resource.target, resource.handle)
        if session.is_disconnected:
            self._give_back(session)

    def _note_release(self, session: ForwardedClient, resource: Resource) -> None:
        """Note that a target has released what a client had, or does not know it."""
        if resource.kind is ResourceKind.SYMBOL_HANDLE and self._journal is not None:
            self._journal.released(session.alias, resource.target, resource.handle)

    def _note_version(self, session: ForwardedClient, target: bytes) -> None:
        """Read the symbol version of a device, once."""
        memory, target = self._memory, bytes(target)
        if memory is None or target in self._versions or session.is_disconnected:
            return
        self._versions.add(target)
        memory.versions.setdefault(target, _UNKNOWN)

        def came(answer: Frame) -> None:
            memory.versions[target] = b"" if answer.error else answer.data

        self._send_request(session, target, Command.READ, version_request(), came)

    def _discard(self, session: ForwardedClient, resource: Resource) -> None:
        """Discard a resource that `session` released, which may not be the one that fetched it."""
        if resource not in session.resources:
            if resource.kind is not ResourceKind.SYMBOL_HANDLE:
                return
            others = (each for each in self._sessions if resource in each.resources)
            holder = next(others, None)
            if holder is None:
                return
            session = holder
        self._note_release(session, resource)
        session.resources[resource] -= 1
        if not session.resources[resource]:
            del session.resources[resource]
            session.recipes.pop(resource, None)
            if session.handles is not None:
                session.handles.forget(resource)
            self._subscribers.pop(resource, None)
            self._sessions.rest(session)

    def _freed(self, session: ForwardedClient) -> None:
        """Free the alias of a session: nothing more comes for it, others may have it."""
        if self._journal is not None:
            self._journal.forget_client(session.alias)
        self.requests.drop(session)

    # clients that go -------------------------------------------------------------------------

    def _listen(self) -> None:
        if not self._listening:
            self._listening = True
            self._router.on_way_closed(self._way_closed, self._uses)
            self._router.on_port_closed(self._port_closed)

    def _uses(self, client: Endpoint) -> bool:
        """True if a client waits for answers of the targets, or holds something there."""
        return any(not session.idle for session in self._sessions.of_client(client))

    def _way_closed(self, client: Endpoint) -> None:
        for session in self._sessions.of_client(client):
            self._leave(session)

    def _port_closed(self, address: AmsAddress) -> None:
        for source in self._router.local_aliases(address):
            for session in self._sessions.of_source(source):
                if session.registered:
                    self._leave(session)

    def _leave(self, session: ForwardedClient) -> None:
        self._sessions.forget(session)
        session.is_disconnected = True
        for exchange in session.exchanges.values():
            exchange.live = False
        self._give_back(session)
        self._sessions.rest(session)

    def _give_back(self, session: ForwardedClient) -> None:
        """Release all that a client left."""
        for resource in session.resources:
            self._subscribers.pop(resource, None)
        self._own.release_all(session)

    def _send_request(
        self,
        session: ForwardedClient,
        target: bytes,
        command: int,
        data: bytes,
        answered: Callable[[Frame], None],
    ) -> None:
        """Send a request of the router as a client."""
        self._own.send_request(session, target, command, data, answered)

    # a new connection ------------------------------------------------------------------------

    def release_orphans(self, done: Callable[[], object]) -> None:
        """Release what ended connections left at the target, before all else."""
        sessions: dict[bytes, ForwardedClient | None] = {}

        def session_of(alias: bytes) -> ForwardedClient | None:
            if alias not in sessions:
                sessions[alias] = self._sessions.begin(EARLIER, alias, alias)
            return sessions[alias]

        def ended() -> None:
            self._orphans = None
            for session in filter(None, sessions.values()):
                self._leave(session)
            done()

        journal = self._journal
        if journal is None or not journal.handles():
            done()
            return
        work = self._orphans = OrphanRelease(journal, session_of, self._send_request, ended)
        work.begin()
        self._look_at(work, _RELEASED_WITHIN, _PATIENCE, 0)

    # resources made again ------------------------------------------------------------------------

    def restore(
        self,
        old: ForwardedClient,
        lost: Callable[[Resource], object],
        done: Callable[[bool], object],
    ) -> bool:
        """Make the resources of a client of the last connection again; False if it is gone.

        `lost` and `done` as of `Restoration`.
        """
        client, memory, source = old.client, self._memory, old.source
        gone = old.registered and self._router.local_endpoint(source) is not client
        if memory is None or gone or not getattr(client, "connected", True):
            return False
        if self._sessions.find(client, source) is not None:
            return False
        self._listen()
        new = self._sessions.begin(client, source, old.alias)
        if new is None:
            return False

        def ended(success: bool) -> None:
            self._restorations.remove(work)
            if not success and not new.is_disconnected:
                self._leave(new)
            done(success)

        if self._journal is not None:
            for each in dict.fromkeys(each.target for each in old.resources):
                self._journal.add_requester(new.alias, each)
        work = Restoration(old, new, memory, self._send_request, self._enter, lost, ended)
        self._restorations.append(work)
        work.begin()
        self._look_at(work, _RESTORED_WITHIN, _PATIENCE, 0)
        return True

    def _look_at(
        self, work: Restoration | OrphanRelease, seconds: int, patience: int, answers: int
    ) -> None:
        """Give up work that takes too long, or for which nothing comes any more."""
        if work.answers > answers:
            patience = _PATIENCE
        now = work.answers
        if seconds and patience:
            self._later(lambda: self._look_at(work, seconds - 1, patience - 1, now))
        else:
            work.give_up()

    # the end of the connection ---------------------------------------------------------------

    def end(self, code: ReturnCode | None) -> tuple[list[ForwardedClient], list[Frame]]:
        """Forget all: the connection has ended.

        Return the sessions that had resources at its far end, and the answer `code`, if there is
        one, to each request that is unanswered.
        """
        lost = [each for each in self._sessions if each.holds and not each.is_disconnected]
        answers = self.requests.end(code)
        self.windows.clear()
        self._sessions.clear()
        self._subscribers.clear()
        self._own.clear()
        for work in self._restorations:
            work.cancel()
        self._restorations.clear()
        if self._orphans is not None:
            self._orphans.cancel()
        if self._listening:
            self._listening = False
            self._router.ignore_way_closed(self._way_closed)
            self._router.ignore_port_closed(self._port_closed)
        return lost, answers


def _nowhere(packets: list[bytes]) -> None:
    """Send nothing: this table forwards nothing itself."""


def _size_with_answer(request: Frame) -> int:
    """Return the bytes of a request and of the answer that it asks for."""
    data = request.data
    reads = request.command in _READS
    return len(data) + (int.from_bytes(data[8:12], "little") if reads else 0)


def _with(frame: Frame, data: bytes) -> Frame:
    """Return a copy of `frame` with other data."""
    head = (frame.target, frame.source, frame.command, frame.flags, frame.error, frame.invoke_id)
    copy = Frame(*head, data)
    copy.origin = frame.origin
    return copy
