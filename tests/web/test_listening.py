"""uvicorn with bounds: slow requests, slow readers, too many connections."""

import asyncio
import contextlib
from typing import Any
from unittest import mock

import pytest

from achse.web import listening
from achse.web.listening import listen, server_for


async def answer(scope: Any, receive: Any, send: Any) -> None:
    """The least application."""
    await send({"type": "http.response.start", "status": 200, "headers": []})
    await send({"type": "http.response.body", "body": b"x"})


class Running:
    """A server for an application."""

    def __init__(self, app: Any = answer) -> None:
        self._app = app

    async def __aenter__(self) -> int:
        listener = listen("127.0.0.1", 0)
        self.server = server_for(self._app, 1000)
        self.task = asyncio.create_task(self.server.serve(sockets=[listener]))
        await self.server.ready.wait()
        port: int = listener.getsockname()[1]
        return port

    async def __aexit__(self, *_: object) -> None:
        self.server.should_exit = True
        await self.task


@pytest.mark.parametrize(
    "sent", [b"", b"GET / HT", b"GET / HTTP/1.1\r\nhost: x\r\n\r\nGET / HTTP/1.1\r\nho"]
)
async def test_who_does_not_finish_a_request_is_ended(sent: bytes) -> None:
    with mock.patch.object(listening, "REQUEST_WITHIN", 0.01):
        async with Running() as port:
            reader, writer = await asyncio.open_connection("127.0.0.1", port)
            writer.write(sent)
            try:
                rest = await reader.read()
            except ConnectionResetError:
                rest = b""
            assert rest.count(b"HTTP/1.1 200") in (0, sent.count(b"\r\n\r\n"))
            writer.close()


async def test_a_whole_request_is_answered() -> None:
    async with Running() as port:
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        writer.write(b"GET / HTTP/1.1\r\nhost: x\r\nconnection: close\r\n\r\n")
        assert (await reader.read()).startswith(b"HTTP/1.1 200")
        writer.close()


async def test_of_too_many_connections_the_one_that_waits_longest_ends() -> None:
    with mock.patch.object(listening, "MOST_WAITING", 3):
        async with Running() as port:
            idle = [await asyncio.open_connection("127.0.0.1", port) for _ in range(3)]
            for _ in range(10):
                reader, writer = await asyncio.open_connection("127.0.0.1", port)
                writer.write(b"GET / HTTP/1.1\r\nhost: x\r\nconnection: close\r\n\r\n")
                assert (await reader.read()).startswith(b"HTTP/1.1 200")
                writer.close()
            with contextlib.suppress(ConnectionResetError):
                assert await idle[0][0].read() == b""
            for _, writer in idle:
                writer.close()


async def test_connections_with_a_request_do_not_give_way() -> None:
    go = asyncio.Event()

    async def slow(scope: Any, receive: Any, send: Any) -> None:
        await go.wait()
        await answer(scope, receive, send)

    with mock.patch.object(listening, "MOST_WAITING", 2):
        async with Running(slow) as port:
            busy = [await asyncio.open_connection("127.0.0.1", port) for _ in range(2)]
            for _, writer in busy:
                writer.write(b"GET / HTTP/1.1\r\nhost: x\r\nconnection: close\r\n\r\n")
            await asyncio.sleep(0)
            for _ in range(5):
                reader, writer = await asyncio.open_connection("127.0.0.1", port)
                with contextlib.suppress(ConnectionResetError):
                    assert await reader.read() == b""
                writer.close()
            go.set()
            for reader, writer in busy:
                assert (await reader.read()).startswith(b"HTTP/1.1 200")
                writer.close()


@pytest.mark.parametrize("upgrade", [True, False])
async def test_connections_of_one_host_lock_no_other_out(upgrade: bool) -> None:
    async def page(scope: Any, receive: Any, send: Any) -> None:
        if scope["type"] == "http":
            await answer(scope, receive, send)
            return
        await send({"type": "websocket.accept"})
        while (await receive())["type"] != "websocket.disconnect":
            pass

    request = b"GET / HTTP/1.1\r\nhost: x\r\n"
    socket = (
        b"upgrade: websocket\r\nconnection: upgrade\r\nsec-websocket-version: 13\r\n"
        b"sec-websocket-key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
    )
    with mock.patch.object(listening, "MOST_WAITING", 4):
        async with Running(page) as port:
            flood = []
            for _ in range(4):
                reader, writer = await asyncio.open_connection("127.0.0.1", port)
                if upgrade:
                    writer.write(request + socket + b"\r\n")
                    assert (await reader.readline()).startswith(b"HTTP/1.1 101")
                flood.append(writer)
            for _ in range(2):
                reader, writer = await asyncio.open_connection(
                    "127.0.0.1", port, local_addr=("127.0.0.2", 0)
                )
                writer.write(request + b"connection: close\r\n\r\n")
                assert (await reader.read()).startswith(b"HTTP/1.1 200")
                writer.close()
            for writer in flood:
                writer.close()


@pytest.mark.parametrize("at_once", [True, False])
async def test_broken_body_behind_a_request_leaves_no_error_in_the_log(
    at_once: bool, caplog: pytest.LogCaptureFixture
) -> None:
    async def slow(scope: Any, receive: Any, send: Any) -> None:
        if at_once:
            await answer(scope, receive, send)
            return
        while (await receive())["type"] != "http.disconnect":
            pass
        await answer(scope, receive, send)

    head = b"POST / HTTP/1.1\r\nhost: x\r\ntransfer-encoding: chunked\r\n\r\n"
    async with Running(slow) as port:
        for parts in ((head + b"ZZ\r\n",), (head, b"ZZ\r\n"), (head + b"2\r\nab\r\n", b"\xff\r\n")):
            reader, writer = await asyncio.open_connection("127.0.0.1", port)
            for part in parts:
                writer.write(part)
                await asyncio.sleep(0)
            response = await reader.read()
            assert response.startswith((b"HTTP/1.1 400", b"HTTP/1.1 200"))
            writer.close()
    assert not [record for record in caplog.records if record.levelname == "ERROR"]
