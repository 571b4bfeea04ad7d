"""A session: one link kept alive, every request and subscription that uses it.

Requests of any number of targets share the link and are distinguished by invoke id. After a loss
the session dials again with growing pauses; requests made meanwhile wait for it within their time
limit, those under way fail with `ConnectionLost`, since it is unknown whether they were done.
"""

import asyncio
import contextlib
import logging
from collections.abc import Awaitable, Callable, Coroutine, Iterator
from typing import Any, NamedTuple, Protocol

from achse.ams import (
    AdsError,
    AmsAddress,
    Command,
    ConnectionLost,
    DecodeError,
    Frame,
    NetId,
    NotificationStream,
    RequestTimeout,
    RouterError,
)
from achse.ams.commands import RESULT
from achse.client.links.link import ClientLink, Dialer
from achse.client.session.requests import Requests, describe_request
from achse.codes import ReturnCode
from achse.transport.reason import reason

log = logging.getLogger("achse.client")

NOBODY_LISTENS = "; start a station with `achse run --detach`, or name another host and port"
"""Advice for a connection that is refused."""

_OTHER_LOOP = (
    "this client belongs to another event loop: connect in the loop that uses it"
    " (each asyncio.run makes a new one); achse.blocking serves several threads"
)

_NOT_FOUND = (
    ReturnCode.TARGET_PORT_NOT_FOUND.number,
    ReturnCode.TARGET_MACHINE_NOT_FOUND.number,
)

Advance = Callable[[float], Awaitable[object] | object]
"""Lets so many seconds of a station's virtual time pass."""


class Backoff(NamedTuple):
    """Pauses between attempts, seconds: `first`, each `factor` times longer, up to `limit`."""

    first: float = 0.1
    limit: float = 5.0
    factor: float = 2.0

    def pauses(self) -> Iterator[float]:
        """Yield the pauses, without end."""
        pause = self.first
        while True:
            yield min(pause, self.limit)
            pause = min(pause * self.factor, self.limit)


DEFAULT_BACKOFF = Backoff()

MAX_DISOWNED = 65_536
"""Unknown subscriptions ended per link; a peer that sends more of them is not worth the memory."""


class Listener(Protocol):
    """Takes the samples of one notification handle."""

    def feed(self, filetime: int, data: bytes) -> None:
        """Pass on one sample; `data` is empty if the target says that the handle is dead."""
        ...


class Renewable(Protocol):
    """User of a link that has to be set up again on the next link."""

    @property
    def target(self) -> AmsAddress: ...

    def interrupt(self) -> None:
        """Discard all that was set up; called at the loss, before anything new can happen."""
        ...

    def renew(self) -> None:
        """Set up again; called when there is a link, must not wait."""
        ...

    def symbols_changed(self) -> None:
        """Note that the target's symbols are others now (online change, download); must not
        wait."""
        ...

    async def leave(self) -> None:
        """Give back what the target holds for it; called while there is still a link."""
        ...

    def end(self, error: ConnectionLost | None) -> None:
        """End without a further link; `error` is the reason unless the user closed it."""
        ...


class _AtOnce:
    """A waiter that looks at the answer the moment it comes, before the frames behind it."""

    __slots__ = ("_future", "_look")

    def __init__(self, future: "asyncio.Future[Frame]", look: "Callable[[Frame], None]") -> None:
        self._future = future
        self._look = look

    def done(self) -> bool:
        return self._future.done()

    def set_result(self, frame: Frame, /) -> None:
        try:
            self._look(frame)
        except AdsError as error:
            self._future.set_exception(error)
        else:
            self._future.set_result(frame)

    def set_exception(self, error: Exception, /) -> None:
        self._future.set_exception(error)


class Session:
    """The bookkeeping of one connection; targets are thin views on it.

    `timeout` (seconds) bounds dialling; `backoff` None means that a loss is final. `keep_alive`
    (seconds, None: never) is how often each target with subscriptions is asked for its state, so
    that one that fell silent or left is noticed. `advance`: how to let the time of a station pass
    that stands until then; what waits for an axis does it.
    """

    def __init__(
        self,
        dialer: Dialer,
        *,
        timeout: float = 5.0,
        backoff: Backoff | None = DEFAULT_BACKOFF,
        keep_alive: float | None = 5.0,
        advance: Advance | None = None,
    ) -> None:
        self.advance = advance
        self.dialer = dialer
        self.timeout = timeout
        self.backoff = backoff
        self.keep_alive = keep_alive
        self.assumed_net_id: NetId | None = None
        """NetId derived from the peer's IP address because the peer returned none."""
        self.requests = Requests()
        self.losses = 0
        """Number of times that the link was lost."""
        self._loop = asyncio.get_running_loop()
        self._link: ClientLink | None = None
        self._ready: ClientLink | None = None
        self._opened = asyncio.Event()
        self._why = "not opened"
        self._closed = False
        self._timer: asyncio.TimerHandle | None = None
        self._renewables: dict[Renewable, None] = {}
        self._listeners: dict[bytes, dict[int, Listener]] = {}
        self._disowned: set[tuple[bytes, int]] = set()
        self._told_drop = False
        self._tasks: set[asyncio.Task[None]] = set()
        self._keeper: asyncio.Task[None] | None = None

    # life ------------------------------------------------------------------------------------

    async def open(self) -> ClientLink:
        """Dial once; raises `ConnectionLost` if that fails."""
        try:
            async with asyncio.timeout(self.timeout):
                link = await self.dialer.open(self)
        except TimeoutError:
            raise ConnectionLost(
                f"{self.dialer.peer} did not answer within {self.timeout:g} s"
            ) from None
        except (OSError, UnicodeError, AdsError) as error:
            why = str(reason(error) if isinstance(error, OSError) else error)
            if isinstance(error, ConnectionRefusedError):
                why += NOBODY_LISTENS
            raise ConnectionLost(f"cannot connect to {self.dialer.peer}: {why}") from error
        self._link = self._ready = link
        self._opened.set()
        return link

    async def leave(self) -> None:
        """Give back everything that targets hold for us."""
        await asyncio.gather(*[renewable.leave() for renewable in reversed(self._renewables)])

    async def close(self) -> None:
        """End the link and everything on it. Further requests raise `ConnectionLost`."""
        link = self._link
        if not self._closed:
            self._why = "closed"
            self._end_with(None)
        if link is not None:
            await link.wait_closed()
        tasks = list(self._tasks)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    def _end_with(self, error: ConnectionLost | None) -> None:
        self._closed = True
        link, self._link, self._ready = self._link, None, None
        self._opened.set()
        for renewable in list(self._renewables):
            renewable.end(error)
        self._renewables.clear()
        self._listeners.clear()
        self.requests.fail(self._lost_during)
        if self._timer is not None:
            self._timer.cancel()
        if link is not None:
            link.close()

    @property
    def closed(self) -> bool:
        return self._closed

    @property
    def link(self) -> ClientLink | None:
        """The link, None while there is none."""
        return self._link

    def check_loop(self) -> None:
        """Raise RuntimeError in another event loop than that of the session: a wait for an
        answer would never end there."""
        if asyncio.get_running_loop() is not self._loop:
            raise RuntimeError(_OTHER_LOOP)

    def spawn(self, job: Coroutine[Any, Any, None]) -> "asyncio.Task[None]":
        """Run `job` as part of the session: it is cancelled when the session ends."""
        task = self._loop.create_task(job)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    def _lost_during(self, what: str) -> ConnectionLost:
        return ConnectionLost(f"{what}: connection to {self.dialer.peer} lost: {self._why}")

    # the link's side -------------------------------------------------------------------------

    def received(self, frame: Frame) -> None:
        """Note that a frame came from the link."""
        if frame.command == Command.NOTIFICATION:
            # Some targets send it as a response (state flags 0x0005); it has no other meaning.
            self._distribute(frame)
        elif not frame.flags & 1 or not self.requests.answer(frame):
            self._drop(frame)

    def _drop(self, frame: Frame) -> None:
        """Drop an unexpected frame: the first is logged, `Requests.unasked` counts answers."""
        if not self._told_drop:
            self._told_drop = True
            log.info("dropping this and further unexpected frames: %s", frame)

    def lost(self, link: ClientLink, reason: str) -> None:
        """Note that the link ended: fail what is under way, dial again."""
        if link is not self._link or self._closed:
            return
        log.info("connection to %s lost: %s", self.dialer.peer, reason)
        self._link = self._ready = None
        self._why = reason
        self.losses += 1
        self._opened.clear()
        self._listeners.clear()
        self._disowned.clear()
        for renewable in list(self._renewables):
            renewable.interrupt()
        self.requests.fail(self._lost_during)
        if self.backoff is None:
            self._end_with(self._lost_during("subscription"))
        else:
            self.spawn(self._dial_again(self.backoff))

    def buffer_changed(self, link: ClientLink, full: bool) -> None:
        """Stop or continue sending: the link's write buffer is full, or has room again."""
        if link is self._link:
            if full:
                self._ready = None
                self._opened.clear()
            else:
                self._ready = link
                self._opened.set()

    async def _dial_again(self, backoff: Backoff) -> None:
        for pause in backoff.pauses():
            await asyncio.sleep(pause)
            try:
                await self.open()
            except ConnectionLost as error:
                self._why = str(error)
            else:
                break
        log.info("connected to %s again", self.dialer.peer)
        for renewable in list(self._renewables):
            renewable.renew()

    # requests --------------------------------------------------------------------------------

    async def exchange(
        self,
        target: AmsAddress,
        command: int,
        data: bytes,
        time_limit: float,
        look: Callable[[Frame], None] | None = None,
    ) -> Frame:
        """Send one request and wait for its response.

        `look` sees the response at once, before any frame behind it. Raises `RouterError` for an
        error in the AMS header, `RequestTimeout`, `ConnectionLost`.
        """
        self.check_loop()
        deadline = self._loop.time() + time_limit
        link = self._ready
        if link is None:
            link = await self._next_link(deadline, time_limit)
        request = Frame(target, link.address, command, 4, 0, 0, data)
        answer: asyncio.Future[Frame] = self._loop.create_future()
        self.requests.add(request, answer if look is None else _AtOnce(answer, look), deadline)
        if self._timer is None or deadline < self._timer.when():
            self._set_timer(deadline)
        link.send(request)
        response = await answer
        if response.error:
            raise self._refusal(response.error, request)
        return response

    def _refusal(self, code: int, request: Frame) -> RouterError:
        """Return the error of a request that reached no device; one for a guessed NetId says so."""
        error = RouterError(code, describe_request(request))
        assumed = self.assumed_net_id
        if assumed is not None and code in _NOT_FOUND and request.target[:6] == assumed:
            error.hint = (
                f"; the NetId {assumed} was assumed from the IP address of {self.dialer.peer},"
                " which returned none over UDP: name its NetId with --net-id, in Python net_id="
            )
        return error

    async def _next_link(self, deadline: float, time_limit: float) -> ClientLink:
        try:
            async with asyncio.timeout_at(deadline):
                while (link := self._ready) is None:
                    if self._closed:
                        break
                    await self._opened.wait()
        except TimeoutError:
            if self._link is not None:
                raise RequestTimeout(f"{self.dialer.peer} takes no more requests") from None
            raise ConnectionLost(
                f"no connection to {self.dialer.peer} within {time_limit:g} s: {self._why}"
            ) from None
        if link is None:
            raise ConnectionLost(f"the connection to {self.dialer.peer} is over: {self._why}")
        return link

    def _set_timer(self, deadline: float) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer = self._loop.call_at(deadline, self._expire)

    def _expire(self) -> None:
        self._timer = None
        self.requests.expire(self._loop.time())
        deadline = self.requests.next_deadline
        if deadline is not None:
            self._set_timer(deadline)

    # subscriptions ---------------------------------------------------------------------------

    def keep(self, renewable: Renewable) -> None:
        """Interrupt and renew `renewable` with the link, until `drop`."""
        self._renewables[renewable] = None
        if self._keeper is None and self.keep_alive is not None:
            self._keeper = self.spawn(self._keep_alive(self.keep_alive))

    def drop(self, renewable: Renewable) -> None:
        """Undo `keep`."""
        self._renewables.pop(renewable, None)
        if not self._renewables and self._keeper is not None:
            self._keeper.cancel()
            self._keeper = None

    def symbols_changed(self, target: AmsAddress) -> None:
        """Notify all users of `target` that its symbols have changed."""
        for renewable in [r for r in self._renewables if r.target == target]:
            renewable.symbols_changed()

    def listen(self, source: bytes, handle: int, listener: Listener) -> None:
        """Hand samples of `handle` of the device `source` to `listener`."""
        self._listeners.setdefault(source, {})[handle] = listener
        self._disowned.discard((source, handle))

    def unlisten(self, source: bytes, handle: int) -> None:
        """Undo `listen`."""
        self._listeners.get(source, {}).pop(handle, None)

    def _distribute(self, frame: Frame) -> None:
        listeners = self._listeners.get(frame.source, {})
        try:
            stream = NotificationStream.decode(frame.data)
        except DecodeError as error:
            log.warning("a notification of %s is dropped: %s", AmsAddress(frame.source), error)
            return
        for filetime, samples in stream.stamps:
            for handle, data in samples:
                listener = listeners.get(handle)
                if listener is None:
                    self._disown(frame.source, handle)
                else:
                    listener.feed(filetime, data)

    def _disown(self, source: bytes, handle: int) -> None:
        """End an unknown subscription: of an earlier link, or abandoned half way."""
        if (source, handle) not in self._disowned and len(self._disowned) < MAX_DISOWNED:
            self._disowned.add((source, handle))
            self.spawn(self._end(AmsAddress(source), handle))

    async def _end(self, target: AmsAddress, handle: int) -> None:
        with contextlib.suppress(AdsError):
            await self.exchange(
                target, Command.DELETE_NOTIFICATION, RESULT.pack(handle), self.timeout
            )

    async def _keep_alive(self, period: float) -> None:
        while True:
            await asyncio.sleep(period)
            if self._link is None:
                continue
            for target in {renewable.target for renewable in self._renewables}:
                await self._check(target)

    async def _check(self, target: AmsAddress) -> None:
        link = self._link
        try:
            await self.exchange(target, Command.READ_STATE, b"", self.timeout)
        except RequestTimeout:
            if link is not None and link is self._link:
                log.warning("%s is silent, closing the link to %s", target, self.dialer.peer)
                link.abort()
        except RouterError as error:
            log.info("%s left: %s", target, error)
            for renewable in [r for r in self._renewables if r.target == target]:
                renewable.interrupt()
                renewable.renew()
        except ConnectionLost:
            pass
