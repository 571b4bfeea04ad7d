"""Orders over TCP: carried out with the key, refused without."""

import asyncio
from collections.abc import Mapping
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.fleet.orders import OrderError, OrderPort, give_order

KEY = "secret"


async def carry(order: str, details: Mapping[str, Any]) -> Any:
    if order == "fail":
        raise OrderError("it cannot be")
    return [order, dict(details)]


async def test_an_order_is_answered_and_a_refusal_reported() -> None:
    port = OrderPort(KEY, carry)
    await port.open()
    try:
        assert await give_order(port.port, KEY, "go", far=3) == ["go", {"far": 3}]
        with pytest.raises(OrderError, match="it cannot be"):
            await give_order(port.port, KEY, "fail")
        with pytest.raises(OrderError, match="the key is wrong"):
            await give_order(port.port, "guessed", "go")
        for garbage in (b"\n", b"{}\n", b"[1]\n", b"\xff\n", b"7\n", b"[" * 5000 + b"\n"):
            reader, writer = await asyncio.open_connection("127.0.0.1", port.port)
            writer.write(garbage)
            assert b"expected a JSON object" in await reader.readline()
            writer.close()
        reader, writer = await asyncio.open_connection("127.0.0.1", port.port)
        writer.write(b"x" * 70_000)  # longer than any order
        assert await reader.read() == b""
        writer.close()
    finally:
        await port.close()
    with pytest.raises(OSError, match=r"."):
        await give_order(port.port, KEY, "go")


async def test_a_supervisor_that_ends_meanwhile() -> None:
    async def hang_up(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.readline()
        writer.close()

    async with await asyncio.start_server(hang_up, "127.0.0.1", 0) as server:
        port = server.sockets[0].getsockname()[1]
        with pytest.raises(OrderError, match="ended meanwhile"):
            await give_order(port, KEY, "go")


@given(
    key=st.text(max_size=20),
    order=st.text(max_size=20),
    value=st.recursive(
        st.none() | st.integers() | st.text(max_size=5), lambda inner: st.lists(inner, max_size=3)
    ),
)
def test_any_order(key: str, order: str, value: Any) -> None:
    async def ask() -> Any:
        port = OrderPort(KEY, carry)
        await port.open()
        try:
            return await give_order(port.port, key, order, value=value)
        finally:
            await port.close()

    if key == KEY and order != "fail":
        assert asyncio.run(ask()) == [order, {"value": value}]
    else:
        with pytest.raises(OrderError):
            asyncio.run(ask())
