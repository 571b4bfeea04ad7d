"""Jogging by a dead-man's key: an axis goes on only as long as its page says so."""

import asyncio
import contextlib
from typing import NamedTuple

from achse.ams import AdsError
from achse.client.nc import RemoteAxis

HELD_FOR = 0.75
"""Seconds after which a key that is not pressed again counts as let go."""


class JogKey(NamedTuple):
    """Direction and velocity of jogging by a key."""

    positive: bool
    fast: bool
    velocity: float | None
    """Units per second; None: the velocity for jogging that the axis has."""


class _Held:
    """An axis that a page jogs."""

    def __init__(self, axis: RemoteAxis, key: JogKey) -> None:
        self.axis, self.key = axis, key
        self.timer: asyncio.TimerHandle | None = None


class Jogging:
    """The axes that one page jogs; each is halted when its key is let go or the page goes."""

    def __init__(self) -> None:
        self._axes: dict[int, _Held] = {}
        self._halting: set[asyncio.Task[None]] = set()

    @property
    def axes(self) -> list[int]:
        """Axes that are jogged now."""
        return list(self._axes)

    async def press(self, number: int, axis: RemoteAxis, key: JogKey) -> None:
        """Jog, or go on: a key that stays the same starts nothing again."""
        pressed = self._axes.get(number)
        if pressed is None or pressed.key != key:
            pressed = self._axes[number] = _Held(axis, key)
            try:
                await _start(axis, key)
            except BaseException:
                self._axes.pop(number, None)
                raise
        if pressed.timer is not None:
            pressed.timer.cancel()
        if self._axes.get(number) is pressed:
            loop = asyncio.get_running_loop()
            pressed.timer = loop.call_later(HELD_FOR, self._let_go, number)

    async def release(self, number: int, axis: RemoteAxis) -> None:
        """Halt: the key is released."""
        self._forget(number)
        await axis.halt(wait=False)

    def _forget(self, number: int) -> None:
        pressed = self._axes.pop(number, None)
        if pressed is not None and pressed.timer is not None:
            pressed.timer.cancel()

    def _let_go(self, number: int) -> None:
        pressed = self._axes.get(number)
        if pressed is not None:
            self._forget(number)
            task = asyncio.ensure_future(_halted(pressed.axis))
            self._halting.add(task)
            task.add_done_callback(self._halting.discard)

    async def end(self) -> None:
        """Halt the axes that the page jogs: it disconnects."""
        for number in list(self._axes):
            self._let_go(number)
        await asyncio.gather(*self._halting)


async def _start(axis: RemoteAxis, key: JogKey) -> None:
    if key.velocity is not None:
        await axis.move_velocity(key.velocity if key.positive else -key.velocity, wait=False)
    else:
        await axis.jog("+" if key.positive else "-", speed="fast" if key.fast else "slow")


async def _halted(axis: RemoteAxis) -> None:
    with contextlib.suppress(AdsError):
        await axis.halt(wait=False)
