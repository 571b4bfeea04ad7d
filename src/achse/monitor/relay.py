"""A relay between clients and a target, which sees every packet that passes.

Clients dial the relay instead of the target. Bytes go through as they come, port services and all;
what is AMS is shown. What is not goes through unseen.
"""

import asyncio
import contextlib
import logging
import time
from collections.abc import Callable

from achse.ams import Command, Connection, DecodeError, Frame
from achse.router.tap import Captured
from achse.transport.tcp.listener import TCP_PORT

log = logging.getLogger("achse.monitor")

_PIECE = 1 << 18

_MOST = 1024
"""Clients at a time; further ones are closed."""


class Relay:
    """Listens for clients of `target_host`:`target_port` and calls `show` with what passes."""

    def __init__(
        self, target_host: str, target_port: int, show: Callable[[Captured], None]
    ) -> None:
        self._target = (target_host, target_port)
        self._show = show
        self._server: asyncio.Server | None = None
        self._running: set[asyncio.Task[None]] = set()
        self.host = ""
        self.port = 0

    async def open(self, host: str = "127.0.0.1", port: int = TCP_PORT) -> None:
        """Listen; OSError if the port is taken."""
        self._server = await asyncio.start_server(self._serve, host, port, limit=_PIECE)
        self.host, self.port = self._server.sockets[0].getsockname()[:2]

    async def close(self) -> None:
        """Close every connection and stop listening."""
        if self._server is not None:
            self._server.close()
            for task in tuple(self._running):
                task.cancel()
            await asyncio.gather(*self._running, return_exceptions=True)
            await self._server.wait_closed()
            self._server = None

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.current_task()
        assert task is not None
        name = writer.get_extra_info("peername")
        peer = f"{name[0]}:{name[1]}" if name else "?"  # it may be gone already
        if len(self._running) >= _MOST:
            log.warning("no room for %s: %d clients are there", peer, _MOST)
            writer.close()
            return
        self._running.add(task)
        try:
            with contextlib.suppress(asyncio.CancelledError):
                await self._connect(peer, reader, writer)
        finally:
            self._running.discard(task)
            writer.close()

    async def _connect(
        self, peer: str, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        try:
            answers, requests = await asyncio.open_connection(*self._target, limit=_PIECE)
        except OSError as failure:
            log.warning("%s:%d does not let %s in: %s", *self._target, peer, failure)
            return
        try:
            ways = (self._pass(peer, reader, requests), self._pass(peer, answers, writer))
            await asyncio.gather(*ways)
        finally:
            requests.close()

    async def _pass(
        self, peer: str, source: asyncio.StreamReader, sink: asyncio.StreamWriter
    ) -> None:
        stream: Connection | None = Connection()
        with contextlib.suppress(OSError):
            while data := await source.read(_PIECE):
                sink.write(data)
                if stream is not None:
                    try:
                        for event in stream.receive(data):
                            if isinstance(event, Frame):
                                asks = not event.is_response
                                asks = asks and event.command != Command.NOTIFICATION
                                self._show(Captured(time.time_ns(), asks, peer, event.encode()))
                    except DecodeError as failure:
                        log.warning("%s: what passes is not AMS: %s", peer, failure)
                        stream = None
                    except Exception:  # what cannot be shown passes all the same
                        log.exception("%s: what passes is not shown any more", peer)
                        stream = None
                await sink.drain()
        with contextlib.suppress(OSError, RuntimeError):
            if sink.can_write_eof():
                sink.write_eof()
