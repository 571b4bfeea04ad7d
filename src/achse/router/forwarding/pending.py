"""Requests under way over one connection: those without an answer, by client and target.

What one client has under way is bounded, so that the requests of others are not behind minutes of
its own: the connection carries them one after the other.

AMS has no hop count: a request that comes back while it is pending goes in circles.
"""

from collections import deque
from collections.abc import Callable, Iterator

from achse.ams import Flags, Frame
from achse.codes import ReturnCode
from achse.router.forwarding.forwarded_client import ClientLoad, ForwardedClient
from achse.router.forwarding.ledger import ResourceChange

_PENDING = 1 << 14
"""Highest number of pending requests; beyond, the oldest is forgotten for one of a client that has
a window of them. So a host that fills the table takes the window of no other."""

_CHANGE_LOST_NS = 600_000_000_000
"""Time after which a request that fetches or releases a resource may be forgotten: an answer that
is only late brings a resource that nobody would release."""

_CLIENT_PENDING = 1 << 12
"""Highest number of pending requests of one client; one more is refused."""

_CLIENT_BYTES = 1 << 22
"""Bytes of them and of their answers; beyond, a client that has one under way is refused."""

_ALL_BYTES = 1 << 26
"""The same of all clients; beyond, requests that are not small are refused."""

SMALL_REQUEST = 1 << 12
"""Bytes of a request and its answer that are not load. A client that has nothing else under way may
ask for so much at any time."""

_LOST_NS = 10_000_000_000
"""A client that may ask nothing for so long no longer waits for its answers: they are lost."""

_ROUNDS = 2
"""The same request came from the same client this often, unanswered: the next one is a circle."""

_ROUND_NS = 1_000_000_000
"""A client that sends the same again after this time has given up waiting; a circle is faster."""

_REQUEST = int(Flags.ADS_COMMAND)

_EXCHANGES = 256
"""Exchanges of one client; with one more those without pending requests are dropped."""


class PendingRequest:
    """A request without an answer; one object may describe several requests that are alike."""

    __slots__ = ("change", "command", "flags", "session", "size", "time")

    def __init__(
        self,
        session: ForwardedClient,
        command: int,
        flags: int,
        change: ResourceChange | None,
        time: int,
        size: int,
    ) -> None:
        self.session = session
        self.command = command
        self.flags = flags
        self.change = change
        self.time = time
        self.size = size
        """Bytes of the request and its answer."""

    def refuse(self, target: bytes, invoke_id: int, code: ReturnCode) -> Frame | None:
        """Return the answer `code` to the client; None if it is disconnected."""
        session = self.session
        if session.is_disconnected:
            return None
        head = (target, session.source, self.command, self.flags)
        answer = Frame(*head, 0, invoke_id).reply(error=code.number)
        answer.via = session.client
        return answer


class PendingExchange:
    """Pending requests of one client to one target."""

    __slots__ = ("further", "live", "requests", "session", "spare", "target")

    def __init__(self, session: ForwardedClient, target: bytes) -> None:
        self.session = session
        self.target = target
        self.requests: dict[int, PendingRequest] = {}
        """By invoke id."""
        self.further: dict[int, deque[PendingRequest]] = {}
        """Requests with the invoke id of a pending one."""
        self.spare: PendingRequest | None = None
        """Request that is used again while no other is pending."""
        self.live = True
        """False once its client or the connection has ended."""

    def pop(self, invoke_id: int) -> PendingRequest | None:
        """Remove the oldest request with this invoke id, and return it."""
        request = self.requests.pop(invoke_id, None)
        further = self.further.get(invoke_id) if self.further else None
        if further:
            self.requests[invoke_id] = further.popleft()
            if not further:
                del self.further[invoke_id]
        return request

    def __iter__(self) -> Iterator[tuple[int, PendingRequest]]:
        yield from self.requests.items()
        for invoke_id, requests in self.further.items():
            yield from ((invoke_id, request) for request in requests)


def _may_be_forgotten(request: PendingRequest, now: int) -> bool:
    """True for a request whose late answer brings nothing that has to be released."""
    return request.change is None or now - request.time >= _CHANGE_LOST_NS


class PendingRequests:
    """All pending requests over one connection.

    `forgot` is called with the client of each request that is forgotten for want of room,
    `answered` with a load of which requests wait and one more is answered.
    """

    def __init__(
        self,
        forgot: Callable[[ForwardedClient], object],
        answered: Callable[[ClientLoad], object] = lambda load: None,
    ) -> None:
        self._forgot = forgot
        self._answered = answered
        self.exchanges: dict[bytes, PendingExchange] = {}
        """By alias and target, as answers are addressed."""
        self.size = 0
        """Bytes of the requests that count as load."""
        self.different = 0
        """Pending requests with different addresses or invoke ids."""
        self._full_until = 0
        """Time until which no request may be forgotten, ns."""

    def __len__(self) -> int:
        return self.different + sum(
            sum(map(len, each.further.values())) for each in self.exchanges.values() if each.further
        )

    def __contains__(self, key: tuple[bytes, bytes, int]) -> bool:
        """True if a request with this alias, target and invoke id is pending."""
        alias, target, invoke_id = key
        exchange = self.exchanges.get(alias + target)
        return exchange is not None and invoke_id in exchange.requests

    def exchange(self, session: ForwardedClient, target: bytes) -> PendingExchange:
        """Return the exchange of a client with a target."""
        exchange = session.exchanges.get(target)
        if exchange is None:
            if len(session.exchanges) >= _EXCHANGES:
                for each in [each for each in session.exchanges.values() if not each.requests]:
                    self._drop(each)
            target = bytes(target)
            exchange = session.exchanges[target] = PendingExchange(session, target)
            self.exchanges[session.alias + target] = exchange
        return exchange

    def _drop(self, exchange: PendingExchange) -> None:
        exchange.live = False
        del exchange.session.exchanges[exchange.target]
        self.exchanges.pop(exchange.session.alias + exchange.target, None)

    def drop(self, session: ForwardedClient) -> None:
        """Forget the exchanges of a client for which nothing more comes."""
        for exchange in list(session.exchanges.values()):
            self._drop(exchange)

    def is_too_much(self, session: ForwardedClient, size: int, now: int, congested: bool) -> bool:
        """True if a request of this size has to be refused, for what is under way."""
        load = self._load(session, now)
        if size > SMALL_REQUEST and (congested or (self.size and self.size + size > _ALL_BYTES)):
            return True
        return bool(load.count) and (
            congested or load.count >= _CLIENT_PENDING or load.size + size > _CLIENT_BYTES
        )

    def _load(self, session: ForwardedClient, now: int) -> ClientLoad:
        load = session.load
        if load.count and now - load.time >= _LOST_NS:
            self.size -= load.size - load.waiting_size
            load.count, load.size = len(load.waiting), load.waiting_size
        return load

    def room(self, session: ForwardedClient, now: int, count: int) -> int:
        """Return bytes that so many further requests of a client may have, with their answers."""
        load = self._load(session, now)
        if self.different + count > _PENDING or load.count + count > _CLIENT_PENDING:
            return 0
        return min(_CLIENT_BYTES - load.size, _ALL_BYTES - self.size)

    def enter(
        self, exchange: PendingExchange, invoke_id: int, command: int, size: int, now: int
    ) -> bool:
        """Remember one request that changes nothing; False if that is left to `add`."""
        session, requests = exchange.session, exchange.requests
        load = session.load
        count, share = load.count, load.share
        if (
            invoke_id in requests
            or count >= share.window
            or (count and load.size + size > share.window_bytes)
            or load.waiting
            or (count and now - load.time >= _LOST_NS)
            or load.size + size > _CLIENT_BYTES
            or self.size + size > _ALL_BYTES
            or self.different >= _PENDING
        ):
            return False
        record = exchange.spare
        if requests or record is None or record.command != command:
            record = PendingRequest(session, command, _REQUEST, None, now, size)
            exchange.spare = record
        else:
            record.time, record.size = now, size
        requests[invoke_id] = record
        self.different += 1
        self.size += size
        load.time = now
        load.count = count + 1
        load.size += size
        return True

    def add(
        self, session: ForwardedClient, frame: Frame, request: PendingRequest, circles: bool
    ) -> ReturnCode | None:
        """Remember a request until its answer comes. What refuses it, None if it may go."""
        exchange, now = self.exchange(session, frame.target), request.time
        invoke_id = frame.invoke_id
        first = exchange.requests.get(invoke_id)
        if first is None:
            full = self.different >= _PENDING and session.load.count >= session.load.share.window
            if full and not self._forget_oldest(now, circles):
                return ReturnCode.ROUTER_MAILBOX_FULL
            exchange.requests[invoke_id] = request
            self.different += 1
        else:
            further = exchange.further.get(invoke_id, _NONE)
            if (
                circles
                and sum(now - each.time < _ROUND_NS for each in (first, *further)) >= _ROUNDS
            ):
                return ReturnCode.TARGET_MACHINE_NOT_FOUND
            if len(further) + 1 >= _PENDING:
                if not _may_be_forgotten(first, now):
                    return ReturnCode.ROUTER_MAILBOX_FULL
                exchange.pop(invoke_id)
                self.answered(first, 1, first.size)
                self._forgot(session)
            exchange.further.setdefault(invoke_id, deque()).append(request)
        if request.change is not None:
            session.load.fetching += request.change.fetches
        self.sent(session, 1, request.size, now)
        return None

    def _forget_oldest(self, now: int, circles: bool) -> bool:
        """Forget the oldest request; False if with `circles` it is too young for that, or if an
        answer has to come."""
        if circles and now < self._full_until:
            return False
        exchange: PendingExchange | None = None
        first = now + 1
        for each in self.exchanges.values():
            request = next(iter(each.requests.values()), None)
            if request is None or request.time >= first:
                continue
            further = each.further.get(next(iter(each.requests)), _NONE)
            if all(_may_be_forgotten(one, now) for one in (request, *further)):
                exchange, first = each, request.time
        if exchange is None:
            return False
        invoke_id, oldest = next(iter(exchange.requests.items()))
        if circles and now - oldest.time < _ROUND_NS:
            self._full_until = oldest.time + _ROUND_NS
            return False
        del exchange.requests[invoke_id]
        self.different -= 1
        for request in (oldest, *exchange.further.pop(invoke_id, ())):
            self.answered(request, 1, request.size)
        self._forgot(exchange.session)
        return True

    def sent(self, session: ForwardedClient, count: int, size: int, now: int) -> None:
        """Count requests of a client under way, of `size` bytes with their answers."""
        load = session.load
        load.time = now
        load.count += count
        load.size += size
        self.size += size

    def pop(self, exchange: PendingExchange, invoke_id: int) -> PendingRequest | None:
        """Remove the oldest request with this invoke id, and return it."""
        request = exchange.pop(invoke_id)
        if request is not None:
            if invoke_id not in exchange.requests:
                self.different -= 1
            self.answered(request, 1, request.size)
        return request

    def added(self, count: int) -> None:
        """Count requests entered into exchanges; negative: removed."""
        self.different += count

    def answered(self, request: PendingRequest, count: int, size: int) -> None:
        """Subtract answered requests like `request` from the load of their client."""
        load = request.session.load
        if request.change is not None:
            load.fetching -= request.change.fetches
        if load.count > count:
            size = min(size, load.size)
            load.count -= count
            load.size -= size
            self.size -= size
        elif load.count:
            self.size -= load.size - load.waiting_size
            load.count, load.size = len(load.waiting), load.waiting_size
        if load.waiting:
            self._answered(load)

    def stop(self) -> None:
        """Let nothing go that is not looked at: the connection ends."""
        for exchange in self.exchanges.values():
            exchange.live = False

    def end(self, code: ReturnCode | None) -> list[Frame]:
        """Forget all; return the answer `code`, if there is one, to each request."""
        answers = [
            answer
            for exchange in self.exchanges.values()
            for invoke_id, request in exchange
            if code is not None
            and (answer := request.refuse(exchange.target, invoke_id, code)) is not None
        ]
        self.stop()
        self.exchanges.clear()
        self.size = self.different = self._full_until = 0
        return answers


_NONE: deque[PendingRequest] = deque()
