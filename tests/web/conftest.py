"""A station in virtual time, and pages that talk to its web server without sockets."""

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from typing import Any

import pytest

from achse.client import connect
from achse.station import Station
from achse.web.server import WebServer
from achse.web.settings import WebSettings

"""Seconds until a test that waits for a message has failed."""


class OpenPage:
    """The page's end of a WebSocket in this process."""

    def __init__(self, host: str = "127.0.0.1") -> None:
        self.host = host
        self._inwards: asyncio.Queue[str | None] = asyncio.Queue()
        self.seen: asyncio.Queue[str | bytes] = asyncio.Queue()
        self.reads = asyncio.Event()
        self.reads.set()
        self._last = 0
        self.newest: dict[int, Any] = {}
        """The last value of each watch."""

    # the server's side

    async def receive(self) -> str | None:
        return await self._inwards.get()

    async def send(self, message: str | bytes) -> None:
        await self.reads.wait()
        self.seen.put_nowait(message)

    # the page's side

    def say(self, text: str | None) -> None:
        self._inwards.put_nowait(text)

    async def message(self) -> Any:
        """The next message, JSON decoded."""
        message = await self.seen.get()
        decoded = json.loads(message) if isinstance(message, str) else message
        if isinstance(decoded, dict) and decoded.get("event") == "data":
            self.newest[decoded["watch"]] = decoded["value"]
        return decoded

    async def until(self, right: Callable[[Any], bool]) -> Any:
        """The next message that is right; others are thrown away."""
        while not right(message := await self.message()):
            pass
        return message

    async def ask(self, name: str, /, **arguments: Any) -> dict[str, Any]:
        """Call, and wait for the answer."""
        self._last += 1
        number = self._last
        self.say(json.dumps({"id": number, "call": name, "with": arguments}))
        answer: dict[str, Any] = await self.until(
            lambda each: isinstance(each, dict) and each.get("id") == number
        )
        return answer

    async def done(self, name: str, /, **arguments: Any) -> Any:
        """The result of a call that must be done."""
        answer = await self.ask(name, **arguments)
        assert "error" not in answer, answer
        return answer["result"]

    async def refused(self, name: str, /, **arguments: Any) -> dict[str, Any]:
        """The error of a call that must be refused."""
        answer = await self.ask(name, **arguments)
        assert "error" in answer, answer
        error: dict[str, Any] = answer["error"]
        return error

    async def value(self, watch: int, right: Callable[[Any], bool] = lambda value: True) -> Any:
        """The newest value of a watch if it is right, else the next that is."""
        while watch not in self.newest or not right(self.newest[watch]):
            await self.message()
        return self.newest[watch]


class Shown:
    """A station whose time a task lets pass, and its web server."""

    def __init__(self, station: Station, server: WebServer) -> None:
        self.station = station
        self.server = server

    @asynccontextmanager
    async def page(self, page: OpenPage | None = None) -> AsyncIterator[OpenPage]:
        """One open page."""
        page = page or OpenPage()
        serving = asyncio.create_task(self.server.serve(page))
        try:
            yield page
        finally:
            page.say(None)
            await serving


@asynccontextmanager
async def shown_station(
    station: Station | None = None, settings: WebSettings | None = None, **options: Any
) -> AsyncIterator[Shown]:
    station = station or Station.demo()

    async def pass_time() -> None:
        while True:
            station.advance(0.01)
            await asyncio.sleep(0)

    async with connect(station.router, port=851, keep_alive=None) as client:
        server = WebServer(client, settings, pause=lambda seconds: asyncio.sleep(0), **options)
        assert server.handlers is not None
        server.handlers.scopes.poll = 0.0
        time = asyncio.create_task(pass_time())
        try:
            yield Shown(station, server)
        finally:
            time.cancel()
            await asyncio.gather(time, return_exceptions=True)
            await server.close()


@pytest.fixture
def shown() -> Callable[..., AbstractAsyncContextManager[Shown]]:
    """`async with shown() as it, it.page() as page:` a station, its server, an open page."""
    return shown_station
