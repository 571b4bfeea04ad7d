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

import zlib
from collections import deque
from collections.abc import Callable, Iterator
from typing import Protocol

from achse.ams import AmsAddress, Command, Endpoint, Flags, Frame, NetId
from achse.codes import ReturnCode
from achse.router.forwarding.forwarded_client import ForwardedClient
from achse.router.forwarding.latency import Latencies
from achse.router.forwarding.ledger import (
    Resource,
    ResourceAction,
    ResourceChange,
    ResourceKind,
    change_of,
    without,
)
from achse.router.forwarding.pending import PendingExchange, PendingRequest, PendingRequests
from achse.router.forwarding.restoring import LinkMemory, Restoration, version_request

__all__ = ["ClientPorts", "Forwarding"]

_IDLE = 1 << 14
"""Sessions without requests and resources that are remembered; beyond, the oldest is forgotten."""

_RELEASES_AT_ONCE = 64
"""Releases of resources that are sent without waiting for an answer."""

_ALIASES = range(32_768, 65_280)
"""Ports of aliases, as routers give them to clients."""

_NO_RESPONSE = int(Flags.NO_RESPONSE)

_READS = (int(Command.READ), int(Command.READ_WRITE))

_MEASURED = 16
"""The latency of one in so many answers is counted."""

_RESTORED_WITHIN = 5
"""Seconds in which a target has to answer all that makes resources again."""

_UNKNOWN = b"?"
"""Symbol version that is queried, and no answer has come yet."""

_RELEASE_ID = 0x8000_0000
"""Invoke ids of releases begin here."""


class ClientPorts(Protocol):
    """The part of the router that forwarding uses."""

    net_id: NetId
    source_nat: bool

    def local_endpoint(self, address: bytes) -> Endpoint | None: ...

    def local_aliases(self, address: bytes) -> tuple[bytes, ...]: ...

    def on_port_closed(self, listener: Callable[[AmsAddress], None]) -> None: ...

    def ignore_port_closed(self, listener: Callable[[AmsAddress], None]) -> None: ...

    def on_way_closed(
        self, listener: Callable[[Endpoint], None], uses: Callable[[Endpoint], bool] | None = None
    ) -> None: ...

    def ignore_way_closed(self, listener: Callable[[Endpoint], None]) -> None: ...


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
    ) -> None:
        """With `clock` (seconds, as the times of requests) latencies are counted; with `memory`
        resources are remembered so that they can be made again."""
        self._memory = memory
        self._versions: set[bytes] = set()
        """Devices whose symbol version was queried on this connection."""
        self._router = router
        self._clock = clock
        self._send = send
        self._later = later
        self._sessions: dict[bytes, dict[Endpoint, ForwardedClient]] = {}
        """Sessions that are not gone, by source and client."""
        self._by_client: dict[Endpoint, dict[ForwardedClient, None]] = {}
        self._by_alias: dict[bytes, ForwardedClient] = {}
        """All sessions for which something may come."""
        self._idle: dict[ForwardedClient, None] = {}
        self.requests = PendingRequests(self._rest)
        self._subscribers: dict[Resource, ForwardedClient] = {}
        """Client of each subscription."""
        self._to_release: deque[tuple[ForwardedClient, Resource]] = deque()
        self._own: dict[tuple[bytes, bytes, int], Callable[[Frame], object]] = {}
        """Receivers of answers to requests of the router, by alias, target and invoke id."""
        self._restorations: list[Restoration] = []
        self._unanswered = 0
        """Releases of the last second without an answer."""
        self._waiting = False
        """True while `later` is to call back."""
        self._next_port = _ALIASES[zlib.crc32(router.net_id) % len(_ALIASES)]
        self._next_release = _RELEASE_ID
        self._listening = False
        self.returned = 0
        """Answers and notifications that came so far."""
        self.refused = 0
        """Requests that were refused for what is under way."""
        self.latencies = Latencies()
        """Latencies of every sixteenth answer."""

    def __len__(self) -> int:
        """Sessions for which something may come."""
        return len(self._by_alias)

    @property
    def pending(self) -> int:
        """Requests without an answer."""
        return len(self.requests)

    @property
    def clients(self) -> Iterator[ForwardedClient]:
        """Sessions of clients that are there."""
        return (each for each in self._by_alias.values() if not each.gone)

    @property
    def resources(self) -> Iterator[tuple[ForwardedClient, Resource]]:
        """All resources that clients hold, those of clients that are gone included."""
        for session in self._by_alias.values():
            yield from ((session, resource) for resource in session.resources)
        yield from self._to_release

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
        while the far end is `congested`), 0x508 if there are no ports for further aliases, 0x701
        if it fetches a resource without an answer.

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
        if frame.flags & _NO_RESPONSE:
            for action in () if change is None else change.actions:
                if action.handle is None:  # its handle would be unknown
                    return ReturnCode.SERVICE_NOT_SUPPORTED
                if change is not None:
                    self._discard(session, Resource(action.kind, change.target, action.handle))
        else:
            size = _size_with_answer(frame)
            if self.requests.is_too_much(client, size, now, congested):
                self.refused += 1
                return ReturnCode.ROUTER_MAILBOX_FULL
            request = PendingRequest(session, frame.command, frame.flags, change, now, size)
            refusal = self.requests.add(session, frame, request, circles)
            if refusal is not None:
                return refusal
            self._idle.pop(session, None)
        if session.alias == frame.source and data is frame.data:
            return frame
        forwarded = _with(frame, data)
        forwarded.source = session.alias
        return forwarded

    def _session(self, client: Endpoint, frame: Frame) -> ForwardedClient | ReturnCode:
        source = frame.source
        session = self._sessions.get(source, _NOBODY).get(client)
        if session is not None:
            return session
        holder = self._by_alias.get(source)
        key = (source, frame.target, frame.invoke_id)
        if holder is not None and holder.alias != holder.source and key in self.requests:
            return ReturnCode.TARGET_MACHINE_NOT_FOUND  # our own request has come back
        net_id = self._router.net_id if self._router.source_nat else source[:6]
        free = source[:6] == net_id and self._is_free(source, client)
        alias = bytes(source) if free else self._new_alias(net_id)
        if alias is None:
            return ReturnCode.ROUTER_NO_MORE_QUEUES
        return self._begin_session(client, source, alias)

    def _begin_session(self, client: Endpoint, source: bytes, alias: bytes) -> ForwardedClient:
        self._listen()
        registered = self._router.local_endpoint(source) is client
        session = ForwardedClient(client, bytes(source), alias, registered)
        self._sessions.setdefault(session.source, {})[client] = session
        self._by_client.setdefault(client, {})[session] = None
        self._by_alias[alias] = session
        self._rest(session)
        return session

    def _is_free(self, address: bytes, client: Endpoint) -> bool:
        """True if `client` may use `address` at the targets: no other client does."""
        local = self._router.local_endpoint(address)
        return address not in self._by_alias and (local is None or local is client)

    def _new_alias(self, net_id: bytes) -> bytes | None:
        for _ in _ALIASES:
            port = self._next_port
            self._next_port = port + 1 if port + 1 in _ALIASES else _ALIASES[0]
            alias = bytes(AmsAddress.of(net_id, port))
            if alias not in self._by_alias and self._router.local_endpoint(alias) is None:
                return alias
        return None

    def _is_foreign(
        self, session: ForwardedClient, change: ResourceChange, action: ResourceAction
    ) -> bool:
        """True if a subscription is to be deleted that another client holds."""
        if action.handle is None or action.kind is not ResourceKind.SUBSCRIPTION:
            return False
        resource = Resource(action.kind, change.target, action.handle)
        return self._subscribers.get(resource, session) is not session

    def exchange(self, client: Endpoint, source: bytes, target: bytes) -> PendingExchange | None:
        """Return the exchange of a client that has asked this target before."""
        session = self._sessions.get(source, _NOBODY).get(client)
        if session is None or session.handles is not None:
            return None
        return session.exchanges.get(target)

    def sent(self, session: ForwardedClient, count: int, size: int, now: int) -> None:
        """So many requests were entered into an exchange: they are under way now."""
        self.requests.added(count)
        self.requests.sent(session, count, size, now)
        self._idle.pop(session, None)

    def answered(self, request: PendingRequest, count: int, size: int) -> None:
        """So many requests like this one were removed from an exchange: they are answered."""
        before = self.returned
        self.returned += count
        measured = self.returned // _MEASURED - before // _MEASURED
        if measured and self._clock is not None:
            self.latencies.add(int(self._clock() * 1e9) - request.time, measured)
        self.requests.added(-count)
        self.requests.answered(request, count, size)
        self._rest(request.session)

    # answers and notifications ---------------------------------------------------------------

    def come_back(self, frame: Frame) -> bool:
        """Address an answer or a notification to its client; False if it ends here.

        That is so for answers to releases, and for what comes for a client that is gone. A frame
        for an address that is not an alias stays as it is.
        """
        self.returned += 1
        session = self._by_alias.get(frame.target)
        if session is None:
            return True
        if frame.flags & 1 and self._settle(session, frame):
            return False
        if session.gone:
            return False
        if session.handles is not None and frame.command == Command.NOTIFICATION:
            frame.data = session.handles.samples(frame.source, frame.data)
        frame.target = session.source
        frame.via = session.client
        return True

    def _settle(self, session: ForwardedClient, answer: Frame) -> bool:
        """Take note of an answer; True if it is one to a request of ours."""
        key = (session.alias, bytes(answer.source), answer.invoke_id)
        answered = self._own.pop(key, None)
        if answered is not None:
            session.releasing -= 1
            answered(answer)
            self._rest(session)
            return True
        exchange = session.exchanges.get(answer.source)
        request = None if exchange is None else self.requests.pop(exchange, answer.invoke_id)
        if request is not None:
            if request.change is not None and not answer.error:
                self._apply(session, request.change, answer.data)
                if session.handles is not None:
                    answer.data = session.handles.answer(request.change, answer.data)
            if self._clock is not None and self.returned % _MEASURED == 0:
                self.latencies.add(int(self._clock() * 1e9) - request.time)
            self._rest(session)
        return False

    def _apply(self, session: ForwardedClient, change: ResourceChange, answer: bytes) -> None:
        """Enter what an answer brought, and take out what it says was released."""
        for action, resource in change.outcomes(answer):
            if action.handle is None:
                self._enter(session, resource, action.recipe)
            else:
                self._discard(session, resource)

    def _enter(self, session: ForwardedClient, resource: Resource, recipe: bytes) -> None:
        """The target gave out a resource."""
        if resource.kind is ResourceKind.SUBSCRIPTION:
            before = self._subscribers.get(resource)
            if before is not None:  # the target has forgotten it, and gives the number again
                before.resources.pop(resource, None)
                self._rest(before)
            self._subscribers[resource] = session
            session.subscribed = True
        count = session.resources.get(resource, 0)
        session.resources[resource] = 1 if resource.kind is ResourceKind.FILE else count + 1
        if self._memory is not None and recipe:
            session.recipes[resource] = recipe
            self._note_version(session, resource.target)
        if session.gone:
            self._give_back(session)

    def _note_version(self, session: ForwardedClient, target: bytes) -> None:
        """Read the symbol version of a device, once."""
        memory, target = self._memory, bytes(target)
        if memory is None or target in self._versions or session.gone:
            return
        self._versions.add(target)
        memory.versions.setdefault(target, _UNKNOWN)

        def came(answer: Frame) -> None:
            memory.versions[target] = b"" if answer.error else answer.data

        self._ask(session, target, Command.READ, version_request(), came)

    def _discard(self, session: ForwardedClient, resource: Resource) -> None:
        """A resource was released by `session`, which may not be the one that fetched it."""
        if resource not in session.resources:
            if resource.kind is not ResourceKind.SYMBOL_HANDLE:
                return
            others = (each for each in self._by_alias.values() if resource in each.resources)
            holder = next(others, None)
            if holder is None:
                return
            session = holder
        session.resources[resource] -= 1
        if not session.resources[resource]:
            del session.resources[resource]
            session.recipes.pop(resource, None)
            if session.handles is not None:
                session.handles.forget(resource)
            self._subscribers.pop(resource, None)
            self._rest(session)

    def _rest(self, session: ForwardedClient) -> None:
        """Keep a session that is idle for a while; its alias is free once it is gone."""
        if not session.idle:
            return
        if session.gone:
            if session.subscribed:
                self._later(lambda: self._free(session))
            else:
                self._free(session)
            return
        self._idle.pop(session, None)
        self._idle[session] = None
        if len(self._idle) > _IDLE:
            oldest = next(iter(self._idle))
            self._forget(oldest)
            self._free(oldest)

    def _free(self, session: ForwardedClient) -> None:
        """Let others have the alias of a session that is gone."""
        if self._by_alias.get(session.alias) is session:
            del self._by_alias[session.alias]
        self.requests.drop(session)

    def _forget(self, session: ForwardedClient) -> None:
        """The client asks no more by this session."""
        self._idle.pop(session, None)
        sources = self._sessions[session.source]
        del sources[session.client]
        if not sources:
            del self._sessions[session.source]
        sessions = self._by_client[session.client]
        del sessions[session]
        if not sessions:
            del self._by_client[session.client]

    # clients that go -------------------------------------------------------------------------

    def _listen(self) -> None:
        if not self._listening:
            self._listening = True
            self._router.on_way_closed(self._way_closed, self._uses)
            self._router.on_port_closed(self._port_closed)

    def _uses(self, client: Endpoint) -> bool:
        """True if a client waits for answers of the targets, or holds something there."""
        return any(not session.idle for session in self._by_client.get(client, ()))

    def _way_closed(self, client: Endpoint) -> None:
        for session in list(self._by_client.get(client, ())):
            self._leave(session)

    def _port_closed(self, address: AmsAddress) -> None:
        for source in self._router.local_aliases(address):
            for session in list(self._sessions.get(source, _NOBODY).values()):
                if session.registered:
                    self._leave(session)

    def _leave(self, session: ForwardedClient) -> None:
        self._forget(session)
        session.gone = True
        for exchange in session.exchanges.values():
            exchange.live = False
        self._give_back(session)
        self._rest(session)

    def _give_back(self, session: ForwardedClient) -> None:
        """Release all that a client left."""
        for resource, count in session.resources.items():
            self._subscribers.pop(resource, None)
            self._to_release.extend([(session, resource)] * count)
            session.releasing += count
        session.resources.clear()
        self._release()

    def _release(self) -> None:
        """Send the next releases."""
        while self._to_release and self._unanswered < _RELEASES_AT_ONCE:
            session, resource = self._to_release.popleft()
            if resource in self._subscribers:  # the target has given the number to another client
                session.releasing -= 1
                self._rest(session)
                continue
            invoke_id = self._free_id(session, resource.target)
            self._own[session.alias, resource.target, invoke_id] = self._released
            self._unanswered += 1
            self._send(resource.release(session.alias, invoke_id))
        if self._to_release and not self._waiting:
            self._waiting = True
            self._later(self._go_on)

    def _released(self, answer: Frame) -> None:
        self._unanswered = max(self._unanswered - 1, 0)
        self._release()

    def _free_id(self, session: ForwardedClient, target: bytes) -> int:
        """Return an invoke id that no request of this alias has."""
        while True:
            invoke_id = self._next_release
            self._next_release = invoke_id + 1 if invoke_id < 0xFFFF_FFFF else _RELEASE_ID
            key = (session.alias, target, invoke_id)
            if key not in self.requests and key not in self._own:
                return invoke_id

    def _ask(
        self,
        session: ForwardedClient,
        target: bytes,
        command: int,
        data: bytes,
        answered: Callable[[Frame], None],
    ) -> None:
        """Send a request of the router as a client."""
        invoke_id = self._free_id(session, target)
        self._own[session.alias, bytes(target), invoke_id] = answered
        session.releasing += 1
        self._idle.pop(session, None)
        self._send(Frame(target, session.alias, command, 4, 0, invoke_id, data))

    # a new connection ------------------------------------------------------------------------

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
        free = old.registered or self._is_free(old.alias, client)
        alias = old.alias if free else self._new_alias(old.alias[:6])
        if alias is None or client in self._sessions.get(source, _NOBODY):
            return False
        new = self._begin_session(client, source, alias)

        def ended(success: bool) -> None:
            self._restorations.remove(work)
            if not success and not new.gone:
                self._leave(new)
            done(success)

        work = Restoration(old, new, memory, self._ask, self._enter, lost, ended)
        self._restorations.append(work)
        work.begin()
        self._give_up_later(work, _RESTORED_WITHIN)
        return True

    def _give_up_later(self, work: Restoration, seconds: int) -> None:
        if seconds:
            self._later(lambda: self._give_up_later(work, seconds - 1))
        else:
            work.give_up()

    def _go_on(self) -> None:
        """Wait no longer for the answers of the last second."""
        self._waiting = False
        self._unanswered = 0
        self._release()

    # the end of the connection ---------------------------------------------------------------

    def end(self, code: ReturnCode | None) -> tuple[list[ForwardedClient], list[Frame]]:
        """Forget all: the connection has ended.

        Return the sessions that had resources at its far end, and the answer `code`, if there is
        one, to each request that is unanswered.
        """
        lost = [each for each in self._by_alias.values() if each.holds and not each.gone]
        answers = self.requests.end(code)
        for table in (
            self._sessions, self._by_client, self._by_alias, self._idle,
            self._subscribers, self._own,
        ):  # fmt: skip
            table.clear()
        for work in self._restorations:
            work.cancel()
        self._restorations.clear()
        self._to_release.clear()
        self._unanswered = 0
        if self._listening:
            self._listening = False
            self._router.ignore_way_closed(self._way_closed)
            self._router.ignore_port_closed(self._port_closed)
        return lost, answers


_NOBODY: dict[Endpoint, ForwardedClient] = {}


def _size_with_answer(request: Frame) -> int:
    """Return the bytes of a request and of the answer that it asks for."""
    data = request.data
    reads = request.command in _READS
    return len(data) + (int.from_bytes(data[8:12], "little") if reads else 0)


def _with(frame: Frame, data: bytes) -> Frame:
    """A copy of `frame` with other data."""
    head = (frame.target, frame.source, frame.command, frame.flags, frame.error, frame.invoke_id)
    copy = Frame(*head, data)
    copy.origin = frame.origin
    return copy
