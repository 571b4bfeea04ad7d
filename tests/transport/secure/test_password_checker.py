"""Passwords are checked one after the other, whatever becomes of a request."""

import asyncio
from typing import Any

import pytest

from achse.transport.secure import password_checker, password_queue
from achse.transport.secure.password_checker import PasswordChecker, _Wish


@pytest.fixture(autouse=True)
def no_pauses(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(password_queue, "_PACE", 0.0)


async def test_each_gets_its_verdict_and_a_fault_of_one_is_its_own(
    caplog: pytest.LogCaptureFixture,
) -> None:
    calls: list[Any] = []
    decided = asyncio.Event()

    async def decide(request: str, host: str, right: bool) -> None:
        if request == "breaks":
            raise RuntimeError("no disk")
        calls.append((request, host, right))
        if len(calls) == 2:
            decided.set()

    checker = PasswordChecker(lambda user, password: (user, password) == ("me", "1"), decide)
    assert checker.put("a", "me", "1", "breaks")
    assert checker.put("b", "me", "1", "first")
    assert checker.put("c", "me", "2", "second")
    await decided.wait()
    assert sorted(calls) == [("first", "b", True), ("second", "c", False)]
    assert "a request of a with a password broke" in caplog.text
    await checker.close()
    await checker.close()


async def test_check_that_breaks_is_logged_and_the_next_one_made(
    caplog: pytest.LogCaptureFixture,
) -> None:
    decided: asyncio.Queue[tuple[str, bool]] = asyncio.Queue()

    async def decide(request: str, host: str, right: bool) -> None:
        decided.put_nowait((request, right))

    def check(user: str, password: str) -> bool:
        if user == "breaks":
            raise RuntimeError("no memory")
        return True

    checker = PasswordChecker(check, decide)
    assert checker.put("a", "breaks", "1", "first")
    assert checker.put("b", "me", "1", "second")
    assert await decided.get() == ("second", True)
    assert "a request of a with a password broke" in caplog.text
    assert "no memory" in caplog.text
    await checker.close()


async def test_there_is_room_for_so_many_hosts() -> None:
    async def decide(request: int, host: str, right: bool) -> None:
        """Nobody waits."""

    checker = PasswordChecker(lambda user, password: False, decide)
    taken = [checker.put(f"h{number}", "me", "1", number) for number in range(300)]
    assert all(taken)  # one that comes later takes the place of another
    tasks = list(checker._tasks)
    assert len(checker) == password_queue._HOSTS
    await checker.close()
    assert tasks
    assert all(task.done() for task in tasks)


async def test_a_password_that_was_wrong_is_not_checked_again() -> None:
    """60 senders with an old password, some at the newcomer's own address, cost one check."""
    checked: list[str] = []
    answers: list[tuple[str, bool]] = []
    done, all_refused = asyncio.Event(), asyncio.Event()

    def check(user: str, password: str) -> bool:
        checked.append(password)
        return password == "new"

    async def decide(request: int, host: str, right: bool) -> None:
        answers.append((host, right))
        if right:
            done.set()
        elif len(answers) == 60:
            all_refused.set()

    checker = PasswordChecker(check, decide)
    for number in range(60):
        assert checker.put(f"h{number}", "me", "old", number)
    await all_refused.wait()
    for number in range(600):
        assert checker.put(f"h{number % 60}", "ME", "old", number)
    assert checker.put("h7", "me", "new", 0)
    for number in range(60):
        assert checker.put("h7", "Me", "old", number)
    await done.wait()
    for _ in range(10):
        await asyncio.sleep(0)
    assert len(checker._tasks) == 1, "the one that checks"
    assert checked == ["old", "new"]
    assert sum(not right for _, right in answers) == 60 + 660
    await checker.close()


async def test_4096_wrong_passwords_are_remembered() -> None:
    async def decide(request: int, host: str, right: bool) -> None:
        raise AssertionError

    checker = PasswordChecker(lambda user, password: False, decide)
    wishes = [_Wish("me", str(number), number) for number in range(4097)]
    for wish in wishes:
        checker._remember(wish)
    assert [checker._is_wrong(wish) for wish in (*wishes[:2], wishes[-1])] == [False, True, True]
    assert len(checker._wrong) == 4096


async def test_what_was_wrong_is_forgotten_in_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(password_checker, "_KNOWN_WRONG", 3)
    monkeypatch.setattr(password_queue, "_FREE", 1000)
    checked: list[str] = []

    def check(user: str, password: str) -> bool:
        checked.append(password)
        return False

    answers: asyncio.Queue[int] = asyncio.Queue()

    async def decide(request: int, host: str, right: bool) -> None:
        answers.put_nowait(request)

    checker = PasswordChecker(check, decide)
    for number in (1, 2, 3, 1, 4, 2, 4, 1):
        checker.put("h", "me", str(number), number)
        assert await answers.get() == number
    assert checked == ["1", "2", "3", "4", "1"]
    await checker.close()
