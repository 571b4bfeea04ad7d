"""A loop in a thread."""

import asyncio
import os
import sys
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


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no fork")
def test_loop_in_a_forked_process_is_refused_instead_of_waiting_forever() -> None:
    loop = LoopThread()
    process = os.fork()
    if process == 0:
        try:
            loop.run(_name())
        except RuntimeError as error:
            loop.stop()
            os._exit(7 if "after a fork" in str(error) and not loop.is_running else 1)
        finally:
            os._exit(1)
    assert os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]) == 7
    assert loop.run(_name()) == "achse client"
    loop.stop()
