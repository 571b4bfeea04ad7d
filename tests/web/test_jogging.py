"""The dead-man's key: an axis halts when nobody holds it."""

import asyncio
import contextlib
from unittest import mock

from achse.web import jogging
from achse.web.jogging import Jogging, JogKey

SLOW = JogKey(True, False, None)


def axis() -> mock.Mock:
    return mock.Mock(jog=mock.AsyncMock(), halt=mock.AsyncMock(), move_velocity=mock.AsyncMock())


async def test_a_key_that_is_repeated_starts_once() -> None:
    keys, remote = Jogging(), axis()
    for _ in range(5):
        await keys.press(1, remote, SLOW)
    remote.jog.assert_awaited_once_with("+", speed="slow")
    assert keys.axes == [1]
    await keys.press(1, remote, JogKey(False, True, None))
    remote.jog.assert_awaited_with("-", speed="fast")
    await keys.press(1, remote, JogKey(False, True, 5.0))
    remote.move_velocity.assert_awaited_once_with(-5.0, wait=False)
    remote.halt.assert_not_awaited()
    await keys.release(1, remote)
    remote.halt.assert_awaited_once_with(wait=False)
    assert keys.axes == []


async def test_a_key_that_is_not_repeated_halts_the_axis() -> None:
    halted = asyncio.Event()
    keys, remote = Jogging(), axis()
    remote.halt.side_effect = lambda wait: halted.set()
    with mock.patch.object(jogging, "HELD_FOR", 0.0):
        await keys.press(1, remote, SLOW)
        await halted.wait()
    assert keys.axes == []


async def test_the_end_of_the_page_halts_what_it_jogs() -> None:
    keys, first, second = Jogging(), axis(), axis()
    await keys.press(1, first, SLOW)
    await keys.press(2, second, SLOW)
    await keys.end()
    first.halt.assert_awaited_once()
    second.halt.assert_awaited_once()


async def test_a_refused_start_holds_nothing() -> None:
    keys, remote = Jogging(), axis()
    remote.jog.side_effect = ValueError
    with contextlib.suppress(ValueError):
        await keys.press(1, remote, SLOW)
    assert keys.axes == []
