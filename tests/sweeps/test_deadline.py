"""A run that takes too long is ended wherever in Python it is, and nothing of it is left."""

import asyncio
import itertools
import os
import subprocess
import sys
import threading
from collections.abc import Callable

import pytest

from achse.sweeps import deadline
from achse.sweeps.deadline import RunTooLong, within
from achse.sweeps.plan import SweepPlan
from achse.sweeps.scenario import Scenario, play


def endless() -> None:
    for _ in itertools.count():
        pass


def stubborn() -> None:
    for _ in range(3):
        try:
            endless()
        except BaseException:  # swallows it
            continue


def within_asyncio() -> None:
    async def main() -> None:
        for _ in itertools.count():
            await asyncio.sleep(0)

    asyncio.run(main())


def in_a_callback() -> None:
    """asyncio swallows what its callbacks raise."""

    async def main() -> None:
        asyncio.get_running_loop().call_soon(endless)
        await asyncio.sleep(0)
        await asyncio.sleep(0)
        endless()

    asyncio.run(main())


def something_else() -> None:
    try:
        endless()
    except BaseException:
        raise ValueError("over") from None


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("run", [endless, stubborn, within_asyncio, in_a_callback, something_else])
def test_what_takes_too_long_is_ended(
    run: Callable[[], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(deadline, "_AGAIN", 0.01)
    with pytest.raises(RunTooLong), within(0.01):
        run()
    total = sum(range(100_000))  # nothing comes up later
    assert total == 4_999_950_000


def test_what_ends_in_time_gives_what_it_gives() -> None:
    with within(3600.0):
        pass
    with within(None):
        pass
    with pytest.raises(ValueError, match="mine"), within(3600.0):
        raise ValueError("mine")


PROFILED = """
import resource, sys
from achse.sweeps import deadline
from achse.sweeps.deadline import RunTooLong, within

resource.setrlimit(resource.RLIMIT_CPU, (20, 20))
deadline._AGAIN = 0.001
for limit in (3600.0, 0.01, 0.02):
    try:
        with within(limit):
            while limit < 1.0:
                pass
    except RunTooLong:
        pass
calls = []
sys.setprofile(lambda frame, event, argument: calls.append(event))
len(calls)
(lambda: None)()
sys.setprofile(None)
print(len(calls) > 1)
"""


def test_a_process_can_be_profiled_afterwards() -> None:
    """With Python's flag of a pending exception left set, its first traced call never ends."""
    done = subprocess.run([sys.executable, "-c", PROFILED], capture_output=True, text=True)
    assert (done.stdout, done.returncode) == ("True\n", 0), done.stderr


def test_a_row_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(deadline, "_AGAIN", 0.01)
    source = "def run(*, seed):\n    while seed == 0:\n        pass\n    return {'x': seed}\n"
    rows = play(Scenario(source, "a.py"), list(SweepPlan(seeds=2)), 0.5)
    assert [row["error"] for row in rows] == ["RunTooLong: more than 0.5 s", ""]


def test_a_process_that_does_not_hear_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    gone: list[int] = []

    def gone_with(code: int) -> None:
        gone.append(code)
        released.set()

    released = threading.Event()
    monkeypatch.setattr(deadline, "_AGAIN", 0.01)
    monkeypatch.setattr(deadline, "_GRACE", 0.02)
    monkeypatch.setattr(os, "_exit", gone_with)

    def deaf() -> None:
        while not released.is_set():
            try:
                released.wait()
            except RunTooLong:
                continue

    with pytest.raises(RunTooLong), within(0.01, own_process=True):
        deaf()
    assert gone
