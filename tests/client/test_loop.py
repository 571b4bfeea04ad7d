"""A loop in a thread."""

import asyncio
import threading

import pytest

from achse.client.loop import LoopThread


async def _name() -> str:
    await asyncio.sleep(0)
    return threading.current_thread().name


def test_it_runs_coroutines_in_its_thread_until_it_is_stopped() -> None:
    loop = LoopThread()
    assert loop.run(_name()) == "achse client"
    loop.stop()
    loop.stop()
    with pytest.raises(RuntimeError, match="closed"):
        loop.run(_name())


def test_errors_come_back() -> None:
    async def broken() -> None:
        raise KeyError("x")

    loop = LoopThread()
    with pytest.raises(KeyError):
        loop.run(broken())
    loop.stop()
