"""The application over real sockets: files, headers, the WebSocket, and what must not get in."""

import asyncio
import gzip
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any

import pytest
import wsproto
from wsproto import events

from achse.web.access_guard import SECURITY_HEADERS
from achse.web.app import MOST_BYTES
from achse.web.settings import WebSettings

Shows = Callable[..., Any]


class Browser:
    """Requests to one server."""

    def __init__(self, port: int) -> None:
        self.port = port
        self.host = f"127.0.0.1:{port}"

    async def get(self, path: str, method: str = "GET", **headers: str) -> tuple[int, Any, bytes]:
        """Status, headers and body."""
        reader, writer = await asyncio.open_connection("127.0.0.1", self.port)
        sent = {"host": self.host, "connection": "close"}
        sent |= {name.replace("_", "-"): value for name, value in headers.items()}
        lines = "".join(f"{name}: {value}\r\n" for name, value in sent.items())
        writer.write(f"{method} {path} HTTP/1.1\r\n{lines}\r\n".encode())
        answer = await reader.read()
        writer.close()
        head, _, body = answer.partition(b"\r\n\r\n")
        first, *rest = head.decode().split("\r\n")
        headers_ = {key.lower(): value for key, _, value in (line.partition(": ") for line in rest)}
        return int(first.split()[1]), headers_, body

    @asynccontextmanager
    async def socket(self, path: str = "/ws", **headers: str) -> AsyncIterator["Socket"]:
        reader, writer = await asyncio.open_connection("127.0.0.1", self.port)
        extra = [(name.encode(), value.encode()) for name, value in headers.items()]
        socket = Socket(reader, writer)
        request = events.Request(host=self.host, target=path, extra_headers=extra)
        writer.write(socket.wire.send(request))
        try:
            yield socket
        finally:
            writer.close()


class Socket:
    """A WebSocket of a browser."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.reader, self.writer = reader, writer
        self.wire = wsproto.WSConnection(wsproto.ConnectionType.CLIENT)
        self._events: list[Any] = []

    def send(self, event: Any) -> None:
        self.writer.write(self.wire.send(event))

    async def next(self) -> Any:
        """The next event that is not a ping; None when the connection has ended."""
        while True:
            while self._events:
                event = self._events.pop(0)
                if not isinstance(event, events.Ping):
                    return event
            data = await self.reader.read(65536)
            if not data:
                return None
            self.wire.receive_data(data)
            self._events = list(self.wire.events())


@asynccontextmanager
async def opened(shown: Shows, **settings: Any) -> AsyncIterator[tuple[Any, Browser]]:
    async with shown(settings=WebSettings(port=0, **settings)) as it:
        await it.server.open()
        yield it, Browser(it.server.port)


async def test_pages_carry_their_policy_and_are_not_sent_twice(shown: Shows) -> None:
    async with opened(shown) as (_, browser):
        status, headers, body = await browser.get("/")
        assert (status, body[:15].lower()) == (200, b"<!doctype html>")
        assert {name: headers[name] for name in SECURITY_HEADERS} == SECURITY_HEADERS
        assert "server" not in headers
        status, packed, data = await browser.get("/index.html", accept_encoding="gzip, br")
        assert (packed["content-encoding"], gzip.decompress(data)) == ("gzip", body)
        status, _, nothing = await browser.get("/", if_none_match=headers["etag"])
        assert (status, nothing) == (304, b"")


@pytest.mark.parametrize(
    ("path", "headers", "expected"),
    [
        ("/../pyproject.toml", {}, 404),
        ("/%2e%2e/%2e%2e/etc/passwd", {}, 404),
        ("/..%5c..%5cetc%5cpasswd", {}, 404),
        ("//etc/passwd", {}, 404),
        ("/index.html%00.png", {}, 404),
        ("/download/nothing", {}, 404),
        ("/", {"host": "evil.example"}, 421),
        ("/", {"origin": "http://evil.example"}, 403),
    ],
)
async def test_what_is_not_for_pages(
    shown: Shows, path: str, headers: dict[str, str], expected: int
) -> None:
    async with opened(shown) as (_, browser):
        status, sent_headers, _ = await browser.get(path, **headers)
        assert status == expected
        assert (
            sent_headers["content-security-policy"] == SECURITY_HEADERS["content-security-policy"]
        )


async def test_other_methods_are_refused(shown: Shows) -> None:
    async with opened(shown) as (_, browser):
        for method in ("POST", "PUT", "DELETE", "TRACE"):
            assert (await browser.get("/", method))[0] == 405


async def test_a_page_talks_over_the_websocket(shown: Shows) -> None:
    async with (
        opened(shown) as (_, browser),
        browser.socket(origin=f"http://{browser.host}") as socket,
    ):
        assert isinstance(await socket.next(), events.AcceptConnection)
        socket.send(events.TextMessage('{"id": 1, "call": "hello"}'))
        answer = await socket.next()
        assert '"version"' in answer.data


@pytest.mark.parametrize(
    ("path", "headers", "settings", "expected"),
    [
        ("/ws", {"origin": "http://evil.example"}, {}, 403),
        ("/ws", {"origin": "null"}, {}, 403),
        ("/ws", {}, {"token": "geheim"}, 401),
        ("/ws?token=falsch", {}, {"token": "geheim"}, 401),
    ],
)
async def test_who_does_not_get_a_websocket(
    shown: Shows, path: str, headers: dict[str, str], settings: dict[str, str], expected: int
) -> None:
    async with opened(shown, **settings) as (it, browser), browser.socket(path, **headers) as page:
        refusal = await page.next()
        assert isinstance(refusal, events.RejectConnection)
        assert refusal.status_code == expected
        assert it.server.viewers == 0


async def test_the_token_becomes_a_cookie_and_leaves_the_address(shown: Shows) -> None:
    async with opened(shown, token="geheim") as (it, browser):
        assert it.server.url.endswith("/?token=geheim")
        assert (await browser.get("/"))[0] == 401
        status, headers, _ = await browser.get("/?token=geheim&view=axes")
        assert (status, headers["location"]) == (303, "/?view=axes")
        cookie = headers["set-cookie"]
        assert "HttpOnly" in cookie
        assert "SameSite=strict" in cookie
        named = cookie.partition(";")[0]
        assert (await browser.get("/", cookie=named))[0] == 200
        async with browser.socket(cookie=named) as socket:
            assert isinstance(await socket.next(), events.AcceptConnection)
        _, headers, _ = await browser.get("//evil.example/?token=geheim")
        assert headers["location"].startswith("/evil")


@pytest.mark.parametrize(
    ("frames", "code"),
    [
        ([events.TextMessage("x" * (MOST_BYTES + 1))], 1009),
        ([events.TextMessage("x" * 60_000, message_finished=False)] * 2, 1009),
        ([events.BytesMessage(b"\x01")], 1003),
    ],
)
async def test_frames_that_end_the_connection(shown: Shows, frames: list[Any], code: int) -> None:
    async with opened(shown) as (_, browser), browser.socket() as socket:
        await socket.next()
        for frame in frames:
            socket.send(frame)
        end = await socket.next()
        assert isinstance(end, events.CloseConnection)
        assert end.code == code


@pytest.mark.parametrize(
    "data", [b"\xff\xff\xff\xff", b"\x81\x05hello", b"\x83\x80\0\0\0\0", b"\x81\xff" + b"\xff" * 8]
)
async def test_broken_frames_end_the_connection_and_nothing_else(shown: Shows, data: bytes) -> None:
    async with opened(shown) as (_, browser):
        async with browser.socket() as socket:
            await socket.next()
            socket.writer.write(data)
            socket.writer.write_eof()
            while await socket.reader.read(65536):
                pass
        assert (await browser.get("/"))[0] == 200


async def test_one_page_too_many_gets_the_reason(shown: Shows) -> None:
    async with opened(shown, viewers=1) as (_, browser), browser.socket() as first:
        await first.next()
        first.send(events.TextMessage('{"id": 1, "call": "hello"}'))
        await first.next()
        async with browser.socket() as second:
            await second.next()
            end = await second.next()
            assert (end.code, end.reason) == (1013, "too many pages are open")
