"""The log in the browser: messages of the logger, as lines."""

import asyncio
from collections.abc import Callable
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from achse.devices.logger import LogMessage, MessageType
from achse.web.journal import message_of

Shows = Callable[..., Any]


async def test_messages_come_as_lines(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        watch = (await page.done("watch", topic="log"))["watch"]
        logger = it.server.watched.device(100)
        for _ in range(100):  # until the subscription is there
            await logger.write_raw(1, int(MessageType.WARNING), b"<b>jammed</b>\0")
            await asyncio.sleep(0)
            if watch in page.newest or not page.seen.empty():
                break
        [line, *_] = await page.value(watch)
    assert (line["level"], line["text"], line["source"]) == ("warning", "<b>jammed</b>", "ADS")
    assert line["time"] > 0


@given(st.binary(max_size=80))
def test_any_bytes_are_a_line_or_not(data: bytes) -> None:
    line = message_of(data)
    assert line is None or isinstance(line["text"], str)


@given(
    filetime=st.integers(1, 2**64 - 1),
    kind=st.integers(0, 255),
    port=st.integers(0, 0xFFFF),
    sender=st.text("abcÄ", max_size=15),
    text=st.text("xyz<>&é", max_size=100),
)
def test_a_message_is_decoded(filetime: int, kind: int, port: int, sender: str, text: str) -> None:
    line = message_of(LogMessage(filetime, kind, port, sender, text).encode())
    assert line is not None
    assert (line["text"], line["port"]) == (text, port)
    assert line["source"] == (sender or f"port {port}")
