"""Requests of the router itself, in the names of its clients: releases, and queries.

What a client leaves at a target is released when the client has gone. An answer to such a request
ends at the router.
"""

from collections import deque
from collections.abc import Callable, Iterator
from functools import partial

from achse.ams import Frame
from achse.router.forwarding.forwarded_client import ForwardedClient
from achse.router.forwarding.ledger import Resource

_RELEASES_AT_ONCE = 64
"""Releases of resources that are sent without waiting for an answer."""

_FIRST_ID = 0x8000_0000
"""Invoke ids of the router begin here."""

Key = tuple[bytes, bytes, int]
"""Alias, target and invoke id."""


class RouterRequests:
    """Requests of the router on one connection, and the resources that wait to be released.

    `send` sends a request. `later` calls back after a second: releases that are unanswered by then
    are not waited for. `is_used` returns True for an invoke id that a request of the client has,
    `is_held` for a resource that the target has given to another client since. `rest` is called
    with a session that waits for one answer less, `released` with each resource that is released.
    """

    def __init__(
        self,
        send: Callable[[Frame], object],
        later: Callable[[Callable[[], object]], object],
        *,
        is_used: Callable[[Key], bool],
        is_held: Callable[[Resource], bool],
        rest: Callable[[ForwardedClient], object],
        released: Callable[[ForwardedClient, Resource], object],
    ) -> None:
        self._send = send
        self._later = later
        self._is_used, self._is_held, self._rest = is_used, is_held, rest
        self._report_released = released
        self._answered: dict[Key, Callable[[Frame], object]] = {}
        """Receivers of answers."""
        self._to_release: deque[tuple[ForwardedClient, Resource]] = deque()
        self._unanswered = 0
        """Releases of the last second without an answer."""
        self._waiting = False
        """True while `later` is to call back."""
        self._next_id = _FIRST_ID

    @property
    def to_release(self) -> Iterator[tuple[ForwardedClient, Resource]]:
        """Resources whose release was not sent yet."""
        return iter(self._to_release)

    def send_request(
        self,
        session: ForwardedClient,
        target: bytes,
        command: int,
        data: bytes,
        answered: Callable[[Frame], None],
    ) -> None:
        """Send a request as a client."""
        invoke_id = self._free_id(session, target)
        self._answered[session.alias, bytes(target), invoke_id] = answered
        session.releasing += 1
        self._send(Frame(target, session.alias, command, 4, 0, invoke_id, data))

    def settle(self, session: ForwardedClient, answer: Frame) -> bool:
        """Return True if this is an answer to a request of the router; it was taken note of."""
        key = (session.alias, bytes(answer.source), answer.invoke_id)
        answered = self._answered.pop(key, None)
        if answered is None:
            return False
        session.releasing -= 1
        answered(answer)
        self._rest(session)
        return True

    def release_all(self, session: ForwardedClient) -> None:
        """Release all that a client left."""
        for resource, count in session.resources.items():
            self._to_release.extend([(session, resource)] * count)
            session.releasing += count
        session.resources.clear()
        self._release()

    def _release(self) -> None:
        """Send the next releases."""
        while self._to_release and self._unanswered < _RELEASES_AT_ONCE:
            session, resource = self._to_release.popleft()
            if self._is_held(resource):
                session.releasing -= 1
                self._rest(session)
                continue
            invoke_id = self._free_id(session, resource.target)
            self._answered[session.alias, resource.target, invoke_id] = partial(
                self._released, session, resource
            )
            self._unanswered += 1
            self._send(resource.release(session.alias, invoke_id))
        if self._to_release and not self._waiting:
            self._waiting = True
            self._later(self._go_on)

    def _released(self, session: ForwardedClient, resource: Resource, answer: Frame) -> None:
        self._report_released(session, resource)
        self._unanswered = max(self._unanswered - 1, 0)
        self._release()

    def _go_on(self) -> None:
        """Wait no longer for the answers of the last second."""
        self._waiting = False
        self._unanswered = 0
        self._release()

    def _free_id(self, session: ForwardedClient, target: bytes) -> int:
        """Return an invoke id that no request of this alias has."""
        while True:
            invoke_id = self._next_id
            self._next_id = invoke_id + 1 if invoke_id < 0xFFFF_FFFF else _FIRST_ID
            key = (session.alias, bytes(target), invoke_id)
            if key not in self._answered and not self._is_used(key):
                return invoke_id

    def clear(self) -> None:
        """Forget all: the connection has ended."""
        self._answered.clear()
        self._to_release.clear()
        self._unanswered = 0
