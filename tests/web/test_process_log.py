"""The log of this process in the browser."""

import asyncio
import logging
import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.web.process_log import ProcessLog

Shows = Callable[..., Any]

log = logging.getLogger("achse.mill")


@pytest.fixture
def process_log() -> Iterator[ProcessLog]:
    log = ProcessLog()
    log.attach()
    yield log
    log.detach()


async def test_a_page_has_lines_from_before_and_new_ones(
    shown: Shows, process_log: ProcessLog
) -> None:
    log.info("spindle %d is warm", 1)
    async with shown(process_log=process_log) as it, it.page() as page:
        watch = (await page.done("watch", topic="log"))["watch"]
        lines = await page.value(watch)
        [first] = [each for each in lines if each["source"] == "mill"]
        assert (first["level"], first["text"]) == ("info", "spindle 1 is warm")
        log.debug("not for pages")
        threading.Thread(target=log.error, args=("spindle jammed",)).start()
        lines = await page.value(watch, lambda lines: lines[-1]["source"] == "mill"
                                 and lines[-1]["level"] == "error")  # fmt: skip
        assert lines[-1]["text"] == "spindle jammed"


async def test_what_a_client_writes_to_the_logger_comes_once(
    shown: Shows, process_log: ProcessLog
) -> None:
    async with shown(process_log=process_log) as it, it.page() as page:
        watch = (await page.done("watch", topic="log"))["watch"]
        seen: list[str] = []
        for text in (b"jammed\0", b"end\0"):
            await it.server.watched.device(100).write_raw(1, 2, text)
        while not any("end" in each for each in seen):
            message = await page.message()
            if isinstance(message, dict) and message.get("watch") == watch:
                seen += [each["text"] for each in message["value"]]
    assert sum("jammed" in each for each in seen) == 1


@given(
    level=st.sampled_from([logging.NOTSET, logging.DEBUG, logging.WARNING, logging.ERROR]),
    record=st.sampled_from([logging.DEBUG, logging.INFO, logging.WARNING, logging.CRITICAL]),
    count=st.integers(1, 3),
)
def test_loggers_are_as_before_when_it_ends(level: int, record: int, count: int) -> None:
    logger = logging.getLogger("achse")
    before = logger.level
    logger.setLevel(level)
    try:
        handlers = list(logger.handlers)
        process_log = ProcessLog()
        process_log.attach()
        for _ in range(count):
            log.log(record, "a line")
        lines: list[dict[str, Any]] = []

        async def follow() -> None:
            with process_log.followed(lines.extend):
                pass

        asyncio.run(follow())
        assert len(lines) == (count if record >= logging.INFO else 0)
        process_log.detach()
        process_log.detach()
        assert (logger.level, logger.handlers) == (level, handlers)
    finally:
        logger.setLevel(before)
