"""Two serial ports with a cable between them, made of pseudo terminals."""

import asyncio
import contextlib
import os
import pty
import random
import tty
from collections.abc import Callable, Iterator

__all__ = ["Cable", "cable", "noisy", "until"]

Fault = Callable[[bytes], list[bytes]]


class Cable:
    """`left` and `right` are the names of the ports. `fault` says what becomes of what goes by."""

    def __init__(self, fault: Fault = lambda data: [data]) -> None:
        self.fault = fault
        self._fds: list[int] = []
        self._masters: list[int] = []
        names = []
        for _ in range(2):
            master, slave = pty.openpty()
            tty.setraw(slave)
            os.set_blocking(master, False)
            self._fds += [master, slave]  # the slave stays open, or its end would be told
            self._masters.append(master)
            names.append(os.ttyname(slave))
        self.left, self.right = names
        self._loop: asyncio.AbstractEventLoop | None = None

    def plug_in(self) -> None:
        """Carry bytes in the running loop, until `close`."""
        self._loop = asyncio.get_running_loop()
        one, other = self._masters
        self._loop.add_reader(one, self._carry, one, other)
        self._loop.add_reader(other, self._carry, other, one)

    def _carry(self, source: int, target: int) -> None:
        with contextlib.suppress(OSError):
            for piece in self.fault(os.read(source, 4096)):
                os.write(target, piece)

    def close(self) -> None:
        if self._loop is not None and not self._loop.is_closed():
            for master in self._masters:
                self._loop.remove_reader(master)
        for fd in self._fds:
            os.close(fd)


@contextlib.contextmanager
def cable(fault: Fault = lambda data: [data]) -> Iterator[Cable]:
    """A cable in the running loop."""
    cable = Cable(fault)
    cable.plug_in()
    try:
        yield cable
    finally:
        cable.close()


def noisy(dice: random.Random, loss: float, harm: float, twice: float) -> Fault:
    """A fault that loses, changes and doubles what goes by."""

    def fault(data: bytes) -> list[bytes]:
        if dice.random() < loss:
            return []
        if data and dice.random() < harm:
            changed = bytearray(data)
            changed[dice.randrange(len(changed))] ^= dice.randrange(1, 256)
            data = bytes(changed)
        return [data, data] if dice.random() < twice else [data]

    return fault


async def until(holds: Callable[[], object]) -> None:
    """Come back once this is so."""
    while not holds():  # noqa: ASYNC110 - ports and processes tell nobody
        await asyncio.sleep(0.01)
