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
    """A server for `answer`."""

    async def __aenter__(self) -> int:
        listener = listen("127.0.0.1", 0)
        self.server = server_for(answer, 1000)
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
                found = await asyncio.wait_for(reader.read(), 30)
            except ConnectionResetError:
                found = b""
            assert found.count(b"HTTP/1.1 200") in (0, sent.count(b"\r\n\r\n"))
            writer.close()


async def test_a_whole_request_is_answered() -> None:
    async with Running() as port:
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        writer.write(b"GET / HTTP/1.1\r\nhost: x\r\nconnection: close\r\n\r\n")
        assert (await asyncio.wait_for(reader.read(), 30)).startswith(b"HTTP/1.1 200")
        writer.close()


async def test_one_connection_too_many_is_ended() -> None:
    with mock.patch.object(listening, "MOST_WAITING", 1):
        async with Running() as port:
            first = await asyncio.open_connection("127.0.0.1", port)
            second = await asyncio.open_connection("127.0.0.1", port)
            with contextlib.suppress(ConnectionResetError):
                assert await asyncio.wait_for(second[0].read(), 30) == b""
            first[1].write(b"GET / HTTP/1.1\r\nhost: x\r\n\r\n")
            assert await asyncio.wait_for(first[0].readuntil(b"\r\n"), 30)
            for _, writer in (first, second):
                writer.close()
