"""Subscriptions and symbol handles that a router makes again behind a connection that was lost.

Handles are fetched by their names, subscriptions are added as their clients did. If the symbol
version of a device (0xF008) has changed, nothing of it is made again: a name may mean another
variable now.
"""

from collections.abc import Callable
from functools import partial

from achse.ams import Command, Endpoint, Frame
from achse.ams.commands import RESULT, RESULT_LENGTH, ReadRequest, ReadWriteRequest
from achse.codes import ReservedGroup
from achse.router.forwarding.forwarded_client import ForwardedClient
from achse.router.forwarding.handles import HandleMap
from achse.router.forwarding.ledger import Resource, ResourceKind

SendRequest = Callable[[ForwardedClient, bytes, int, bytes, Callable[[Frame], None]], None]
"""Sends a request of the router as a client: target, command, data, what gets the answer."""

_BY_HANDLE = (ReservedGroup.SYMBOL_VALUE_BY_HANDLE, ReservedGroup.SYMBOL_NOTIFICATION)


def version_request() -> bytes:
    """Return the data of a Read of the symbol version."""
    return ReadRequest(ReservedGroup.SYMBOL_VERSION, 0, 4).encode()


class LinkMemory:
    """Clients and symbol versions that a link remembers while it has no connection.

    `applies(client, source)` is True for clients whose resources are to be made again.
    """

    def __init__(
        self, applies: Callable[[Endpoint, bytes], bool] = lambda client, source: True
    ) -> None:
        self.applies = applies
        self.versions: dict[bytes, bytes] = {}
        """Answers with the symbol version, by device."""
        self.sessions: list[ForwardedClient] = []
        """Clients whose resources are to be made again."""

    @property
    def wanted(self) -> bool:
        """True while one of these clients is there."""
        return any(getattr(each.client, "connected", True) for each in self.sessions)

    def uses(self, client: Endpoint) -> bool:
        """True if resources of a client are to be made again."""
        return any(each.client is client for each in self.sessions)

    def forget(self, client: Endpoint) -> None:
        """Note that a client has gone."""
        self.sessions = [each for each in self.sessions if each.client is not client]

    def keep(self, session: ForwardedClient) -> bool:
        """Remember a client of a lost connection; False if its resources cannot be made again."""
        session = session.restored_from or session
        if not self.applies(session.client, session.source):
            return False
        if not session.resources or session.resources.keys() - session.recipes.keys():
            return False
        self.sessions.append(session)
        return True


class Restoration:
    """The work for one client: `old` is what it had, `new` its session on the new connection.

    `enter(session, resource, recipe)` puts a resource into the ledger, `done(True)` is called when
    all is made, or `done(False)` when nothing may be; `lost` with each resource, as the client
    knows it, that the target refuses.
    """

    def __init__(
        self,
        old: ForwardedClient,
        new: ForwardedClient,
        memory: LinkMemory,
        send_request: SendRequest,
        enter: Callable[[ForwardedClient, Resource, bytes], object],
        lost: Callable[[Resource], object],
        done: Callable[[bool], object],
    ) -> None:
        self._old, self._new, self._memory = old, new, memory
        self._send_request, self._enter, self._lost, self._done = send_request, enter, lost, done
        self._handles = HandleMap()
        self._renewed: dict[Resource, int] = {}
        """New handle by the resource as the target had it."""
        self._waiting = 0
        self.answers = 0
        """Answers that have come."""
        self._is_closed = False
        new.handles = self._handles
        new.restored_from = old

    def begin(self) -> None:
        """Compare the symbol versions first."""
        targets = list(dict.fromkeys(each.target for each in self._old.resources))
        self._waiting = len(targets)
        for target in targets:
            self._send_request(
                self._new, target, Command.READ, version_request(), self._version_came
            )

    def cancel(self) -> None:
        """Do nothing more: the connection has ended again."""
        self._is_closed = True

    def give_up(self) -> None:
        """End without success, if it has not ended yet."""
        if not self._is_closed:
            self._is_closed = True
            self._done(False)

    def _version_came(self, answer: Frame) -> None:
        version = b"" if answer.error else answer.data
        if self._memory.versions.setdefault(bytes(answer.source), version) != version:
            self._memory.versions[bytes(answer.source)] = version
            self.give_up()
        self._step(self._fetch)

    def _step(self, following: Callable[[], None]) -> None:
        """Handle an answer; the last one starts the following phase."""
        self._waiting -= 1
        self.answers += 1
        if not self._waiting and not self._is_closed:
            following()

    def _of_kind(self, kind: ResourceKind) -> list[tuple[Resource, int]]:
        return [each for each in self._old.resources.items() if each[0].kind is kind]

    def _known(self, resource: Resource) -> Resource:
        """Return a resource of before as the client knows it."""
        handles = self._old.handles
        known = resource.handle if handles is None else handles.known_as(resource)
        return resource._replace(handle=known)

    def _fetch(self) -> None:
        """Fetch symbol handles by their names."""
        wanted = [(each, self._old.recipes[each])
                  for each, count in self._of_kind(ResourceKind.SYMBOL_HANDLE)
                  for _ in range(count)]  # fmt: skip
        self._waiting = len(wanted)
        if not wanted:
            self._add()
        for resource, name in wanted:
            data = ReadWriteRequest(ReservedGroup.SYMBOL_HANDLE_BY_NAME, 0, 4, name).encode()
            self._send_request(
                *(self._new, resource.target, Command.READ_WRITE, data),
                partial(self._fetched, resource, name),
            )

    def _fetched(self, resource: Resource, name: bytes, answer: Frame) -> None:
        data, handle = answer.data, 0
        whole = not answer.error and len(data) == RESULT_LENGTH.size + RESULT.size
        if whole and not any(data[: RESULT.size]):
            handle = RESULT.unpack_from(data, RESULT_LENGTH.size)[0]
        if handle:
            self._enter(self._new, resource._replace(handle=handle), name)
        self._renewed[resource] = handle
        self._handles.enter(self._known(resource), handle)
        self._step(self._add)

    def _add(self) -> None:
        """Add the subscriptions, by the new handles."""
        wanted = [resource for resource, _ in self._of_kind(ResourceKind.SUBSCRIPTION)]
        self._waiting = len(wanted) + 1
        for resource in wanted:
            body = self._old.recipes[resource]
            if RESULT.unpack_from(body)[0] in _BY_HANDLE:
                symbol = Resource(
                    ResourceKind.SYMBOL_HANDLE, resource.target, RESULT.unpack_from(body, 4)[0]
                )
                handle = self._renewed.get(symbol, 0)
                body = body[:4] + RESULT.pack(handle) + body[8:]
            self._send_request(
                *(self._new, resource.target, Command.ADD_NOTIFICATION, body),
                partial(self._added, resource, body),
            )
        self._step(self._finish)

    def _added(self, resource: Resource, body: bytes, answer: Frame) -> None:
        handle = 0
        if not answer.error and len(answer.data) >= RESULT_LENGTH.size:
            result, handle = RESULT_LENGTH.unpack_from(answer.data)
            handle = 0 if result else handle
        known = self._known(resource)
        self._handles.enter(known, handle)
        if handle:
            self._enter(self._new, resource._replace(handle=handle), body)
        else:
            self._lost(known)
        self._step(self._finish)

    def _finish(self) -> None:
        self._is_closed = True
        self._new.restored_from = None
        if self._handles.is_identity:
            self._new.handles = None
        self._done(True)
