"""One open page: its calls, what it watches, and what waits to be sent to it."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Mapping
from typing import Any, Protocol

from achse.ams import AdsError, DeviceError
from achse.codes import ReturnCode
from achse.router.rights import Right
from achse.scope.data import ScopeData
from achse.web.arguments import Arguments
from achse.web.contents import PageCall
from achse.web.jogging import Jogging
from achse.web.messages import CallError, dumped, error_of, request_of
from achse.web.send_queue import PageSendQueue
from achse.web.shared_subscriptions import SharedSubscription, SharedSubscriptions

log = logging.getLogger("achse.web")

_CALLS_AT_ONCE = 16
"""Calls of a page under way; the next one is read when one of them is done."""

_WATCHES = 64
"""Largest number of watches of one page."""

_ANSWER_WITHIN = 60.0
"""Seconds that a call may take."""


OpenScope = tuple[Callable[[], Awaitable[None]], Callable[[str], ScopeData]]
"""Functions of an open scope: one ends it, one returns its recording under the given name."""


class Wire(Protocol):
    """The WebSocket of a page."""

    @property
    def host(self) -> str:
        """Address of the computer that shows it; empty if unknown."""
        ...

    async def receive(self) -> str | None:
        """Return the next text; None at the end."""
        ...

    async def send(self, message: str | bytes) -> None:
        """Send a message; waits while the page does not read."""
        ...


class PageEnd(Protocol):
    """The server's end of a page, as calls see it that are about the page itself."""

    @property
    def send_queue(self) -> PageSendQueue: ...

    @property
    def jogging(self) -> Jogging: ...

    @property
    def scopes(self) -> dict[int, OpenScope]: ...

    def next_scope(self) -> int:
        """Return the number of another scope of the page."""
        ...


class Viewer:
    """Serves one page from its opening to its end."""

    def __init__(
        self, calls: Mapping[str, PageCall], subscriptions: SharedSubscriptions, rights: Right
    ) -> None:
        self.send_queue = PageSendQueue()
        self.jogging = Jogging()
        self.scopes: dict[int, OpenScope] = {}
        self._last_scope = 0
        self._calls = calls
        self._subscriptions = subscriptions
        self._rights = rights
        self._watches: dict[int, SharedSubscription] = {}
        self._last_watch = 0
        self._under_way: set[asyncio.Task[None]] = set()
        self._room = asyncio.Semaphore(_CALLS_AT_ONCE)
        self._must_leave = asyncio.Event()

    def give_way(self) -> None:
        """End soon, for a page of another host."""
        self._must_leave.set()

    async def serve(self, wire: Wire) -> bool:
        """Answer until the page is closed; False if it gave way to another."""
        sender = asyncio.create_task(self._send(wire))
        reader = asyncio.create_task(self._read(wire))
        leaving = asyncio.create_task(self._must_leave.wait())
        try:
            await asyncio.wait((sender, reader, leaving), return_when=asyncio.FIRST_COMPLETED)
            return not leaving.done()
        finally:
            tasks = (sender, reader, leaving, *self._under_way)
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            await self._leave()

    async def _leave(self) -> None:
        await self.jogging.end()
        scopes, self.scopes = self.scopes, {}
        for leave, _ in scopes.values():
            await leave()
        for watch, subscription in self._watches.items():
            self._subscriptions.unwatch(subscription, self.send_queue, watch)
        self._watches.clear()

    def next_scope(self) -> int:
        """Return a number from 1 that no open scope of the page has."""
        while True:
            self._last_scope = self._last_scope % 0xFFFF + 1
            if self._last_scope not in self.scopes:
                return self._last_scope

    def tell_connection(self, state: str, text: str) -> None:
        """Report that the target was lost or is back."""
        self.send_queue.put_event(event="connection", state=state, text=text)

    # in and out ------------------------------------------------------------------------------

    async def _send(self, wire: Wire) -> None:
        while True:
            await wire.send(await self.send_queue.take())

    async def _read(self, wire: Wire) -> None:
        while (text := await wire.receive()) is not None:
            await self._room.acquire()
            await self.send_queue.room()
            task = asyncio.create_task(self._answer(text))
            self._under_way.add(task)
            task.add_done_callback(self._under_way.discard)

    async def _answer(self, text: str) -> None:
        number: int | str | None = None
        try:
            number, name, fields = request_of(text)
            async with asyncio.timeout(_ANSWER_WITHIN):
                result = await self._done(name, fields)
            answer = {"id": number, "result": result}
        except (AdsError, ValueError, LookupError, TimeoutError) as failure:
            answer = {"id": number, "error": error_of(failure)}
        except Exception as failure:
            log.exception("a call of a page: %.200s", text)
            answer = {"id": number, "error": error_of(failure)}
        finally:
            self._room.release()
        self.send_queue.put(dumped(answer))

    # calls -----------------------------------------------------------------------------------

    async def _done(self, name: str, fields: dict[str, Any]) -> Any:
        if name == "watch":
            return self._watch(fields)
        arguments = Arguments(fields)
        if name == "unwatch":
            return self._unwatch(arguments.integer("watch"))
        call = self._calls.get(name)
        if call is None:
            raise CallError(f"no call has the name {name!r:.60}")
        if call.needs & ~self._rights:
            raise DeviceError(ReturnCode.DEVICE_ACCESS_DENIED, f"{name}: this page may only look")
        return await (call.do(self, arguments) if call.of_page else call.do(arguments))

    def _watch(self, fields: dict[str, Any]) -> dict[str, int]:
        if len(self._watches) >= _WATCHES:
            raise CallError(f"a page watches up to {_WATCHES} things at once")
        number = self._last_watch + 1
        subscription = self._subscriptions.watch(self.send_queue, number, fields)
        self._last_watch = number
        self._watches[number] = subscription
        return {"watch": number}

    def _unwatch(self, watch: int) -> dict[str, Any]:
        subscription = self._watches.pop(watch, None)
        if subscription is None:
            raise CallError(f"watch: nothing is watched with the number {watch}")
        self._subscriptions.unwatch(subscription, self.send_queue, watch)
        self.send_queue.forget_watch(watch)
        return {}
