"""Endpoints of the adapter for editors: standard streams, or a TCP port."""

import asyncio
import contextlib
import sys
import threading
from collections.abc import Callable
from typing import Any

from achse.dap.adapter import Adapter
from achse.dap.protocol import DapFrameError, FrameReader, encode_frame
from achse.station.routes.addresses import is_reachable_from_outside

_PIECE = 1 << 16
_MOST_EDITORS = 8
_MOST_WAITING = 1 << 24
"""Bytes that an editor may leave unread."""


async def serve_standard_streams() -> None:
    """Serve the editor that started this program, until it goes."""
    loop = asyncio.get_running_loop()
    incoming: asyncio.Queue[bytes] = asyncio.Queue()
    out = sys.stdout.buffer
    sys.stdout = sys.stderr  # printed text would be taken for a message

    def read() -> None:
        while True:
            piece = sys.stdin.buffer.read1(_PIECE)  # type: ignore[union-attr]
            loop.call_soon_threadsafe(incoming.put_nowait, piece)
            if not piece:
                return

    def write(message: dict[str, Any]) -> None:
        with contextlib.suppress(OSError):
            out.write(encode_frame(message))
            out.flush()

    threading.Thread(target=read, name="achse dap input", daemon=True).start()
    await _converse(incoming.get, write)


class OpenToAllError(Exception):
    """Other computers would reach the port, and that is not allowed."""


async def serve_tcp(
    host: str,
    port: int,
    ready: Callable[[str, int], object] = lambda host, port: None,
    *,
    let_everybody_in: bool = False,
) -> None:
    """Serve editors that connect to a TCP port, until cancelled.

    Any program that connects may run what `launch` names. Raises OSError, and OpenToAllError for
    an address that other computers reach.
    """
    if not let_everybody_in and await is_reachable_from_outside(host):
        raise OpenToAllError(
            f"at {host} other computers may run programs here: allow it by --let-everybody-in"
        )
    editors = 0

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        nonlocal editors
        if editors >= _MOST_EDITORS:
            writer.close()
            return
        editors += 1

        def write(message: dict[str, Any]) -> None:
            if writer.transport.get_write_buffer_size() > _MOST_WAITING:
                writer.transport.abort()
            elif not writer.is_closing():
                writer.write(encode_frame(message))

        async def read() -> bytes:
            try:
                return await reader.read(_PIECE)
            except OSError:
                return b""

        try:
            await _converse(read, write)
            with contextlib.suppress(OSError):
                await writer.drain()
        finally:
            editors -= 1
            writer.close()

    server = await asyncio.start_server(serve, host, port)
    async with server:
        address = server.sockets[0].getsockname()
        ready(address[0], address[1])
        await server.serve_forever()


async def _converse(read: "Callable[[], Any]", write: Callable[[dict[str, Any]], None]) -> None:
    """Serve one editor, from its first byte to its last."""
    frames = FrameReader()
    adapter = Adapter(write)
    try:
        while not adapter.is_over:
            piece = await read()
            if not piece:
                return
            for message in frames.feed(piece):
                await adapter.handle(message)
                if adapter.is_over:
                    return
    except DapFrameError as failure:
        print(f"achse plc debug: {failure}", file=sys.stderr)  # noqa: T201
    finally:
        await adapter.close()
