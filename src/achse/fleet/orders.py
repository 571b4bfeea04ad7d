"""Orders to a supervisor from another process of the same user: a line of JSON, and its answer.

They go over TCP on this computer; a key that only the user can read authenticates the sender.
"""

import asyncio
import contextlib
import hmac
import json
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

_HOST = "127.0.0.1"
_LONGEST = 16 * 1024 * 1024
_FIRST_WORDS_S = 5.0
"""Time that a connection has to send its order, s."""

Carry = Callable[[str, Mapping[str, Any]], Awaitable[Any]]


class OrderError(Exception):
    """An order was not carried out; the reason as a sentence."""


class OrderPort:
    """Listens from `open` to `close`; `carry(order, details)` gives what is answered.

    `carry` raises OrderError for what cannot be done.
    """

    def __init__(self, key: str, carry: Carry) -> None:
        self._key = key
        self._carry = carry
        self._server: asyncio.Server | None = None
        self.port = 0

    async def open(self) -> None:
        """Take a free port."""
        self._server = await asyncio.start_server(self._serve, _HOST, 0, limit=64 * 1024)
        self.port = self._server.sockets[0].getsockname()[1]

    async def close(self) -> None:
        """Take no more orders."""
        if self._server is not None:
            self._server.close()
            self._server = None

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            async with asyncio.timeout(_FIRST_WORDS_S):
                line = await reader.readline()
            writer.write(json.dumps(await self._answer(line)).encode() + b"\n")
            await writer.drain()
        except (OSError, ValueError, TimeoutError):
            pass  # it said nothing, or is gone
        finally:
            writer.close()
            with contextlib.suppress(OSError):
                await writer.wait_closed()

    async def _answer(self, line: bytes) -> dict[str, Any]:
        try:
            message = json.loads(line)
            key, order = str(message.pop("key")), str(message.pop("order"))
        except (ValueError, KeyError, AttributeError, TypeError, RecursionError):
            return {"error": "expected a JSON object with key and order"}
        if not hmac.compare_digest(key.encode(), self._key.encode()):
            return {"error": "the key is wrong"}
        try:
            return {"answer": await self._carry(order, message)}
        except OrderError as fault:
            return {"error": str(fault)}


async def give_order(port: int, key: str, order: str, **details: Any) -> Any:
    """Return the answer to an order. Raises OrderError; OSError if no supervisor listens."""
    reader, writer = await asyncio.open_connection(_HOST, port, limit=_LONGEST)
    try:
        writer.write(json.dumps({"key": key, "order": order} | details).encode() + b"\n")
        await writer.drain()
        line = await reader.readline()
    except ValueError as fault:
        raise OrderError(f"the answer is too long: {fault}") from None
    finally:
        writer.close()
    try:
        answer = json.loads(line)
    except ValueError:
        raise OrderError("the supervisor ended meanwhile") from None
    if "error" in answer:
        raise OrderError(answer["error"])
    return answer["answer"]
