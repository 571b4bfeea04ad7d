"""The web server: opened and closed within a loop that goes on."""

import asyncio
import signal
import socket
import sys
from collections.abc import Callable
from typing import Any
from unittest import mock

import pytest

from achse.transport.own_address import address_for_others
from achse.web.server import WebServer
from achse.web.settings import WebExtraMissing, WebSettings

Shows = Callable[..., Any]


async def test_it_listens_while_it_is_open_and_leaves_signals_alone(shown: Shows) -> None:
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    async with shown(settings=WebSettings(port=0)) as it:
        async with it.server as server:
            assert server.url == f"http://127.0.0.1:{server.port}/"
            assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before
            _, writer = await asyncio.open_connection("127.0.0.1", server.port)
            writer.close()
        with pytest.raises(ConnectionRefusedError):
            await asyncio.open_connection("127.0.0.1", server.port)


async def test_a_port_that_is_taken(shown: Shows) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        settings = WebSettings(port=taken.getsockname()[1])
        async with shown(settings=settings) as it:
            with pytest.raises(OSError, match="in use"):
                await it.server.open()


async def test_elsewhere_there_is_always_a_token(shown: Shows) -> None:
    async with shown(settings=WebSettings(host="0.0.0.0", port=0)) as it, it.server as server:
        address, _, token = server.url.partition("?token=")
        assert len(token) >= 20
        assert address == f"http://{address_for_others('0.0.0.0')}:{server.port}/"
        assert server.host == "0.0.0.0"


async def test_without_the_extra_it_is_named(shown: Shows) -> None:
    absent = {name: None for name in sys.modules if name.startswith(("starlette", "uvicorn"))}
    absent |= {"starlette.applications": None, "achse.web.app": None}
    async with shown() as it:
        assert isinstance(it.server, WebServer)
        with mock.patch.dict(sys.modules, absent), pytest.raises(WebExtraMissing):
            await it.server.open()
        with mock.patch.dict(sys.modules, absent), pytest.raises(WebExtraMissing):
            it.server.app()
