"""Passwords are checked one after the other, whatever becomes of a request."""

import asyncio
from typing import Any

import pytest

from achse.transport import password_queue
from achse.transport.password_checker import PasswordChecker


@pytest.fixture(autouse=True)
def no_pauses(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(password_queue, "_PACE", 0.0)


async def test_each_gets_its_verdict_and_a_fault_of_one_is_its_own(
    caplog: pytest.LogCaptureFixture,
) -> None:
    found: list[Any] = []
    decided = asyncio.Event()

    async def decide(request: str, host: str, right: bool) -> None:
        if request == "breaks":
            raise RuntimeError("no disk")
        found.append((request, host, right))
        if len(found) == 2:
            decided.set()

    checker = PasswordChecker(lambda user, password: (user, password) == ("me", "1"), decide)
    assert checker.put("a", "me", "1", "breaks")
    assert checker.put("b", "me", "1", "first")
    assert checker.put("c", "me", "2", "second")
    await decided.wait()
    assert sorted(found) == [("first", "b", True), ("second", "c", False)]
    assert "a request of a with a password broke" in caplog.text
    await checker.close()
    await checker.close()


async def test_there_is_room_for_so_many_hosts() -> None:
    async def decide(request: int, host: str, right: bool) -> None:
        """Nobody waits."""

    checker = PasswordChecker(lambda user, password: False, decide)
    taken = [checker.put(f"h{number}", "me", "1", number) for number in range(300)]
    assert sum(taken) == password_queue._HOSTS
    await checker.close()
