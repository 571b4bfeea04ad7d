"""Accepting connections at listening sockets, also when the process has no descriptors left.

asyncio logs each of up to 1,024 failures of accept a second, uvloop none, and closes connections
without a word. Here they wait in the backlog, and the log has one line.
"""

import asyncio
import errno
import os
import socket
from collections.abc import Callable, Iterable

from achse.transport.reason import reason

_AT_ONCE = 64
"""Connections accepted between two looks of the loop at its sockets."""

_RETRY = 1.0
"""Seconds after a failure until the next attempt."""

_SOON = 0.05
"""The same where connections were closed to make room, s."""

_SILENCE = 60.0
"""Seconds after a line in the log until a further failure is worth another one."""


class Acceptor:
    """Accepts at `sockets`, which are bound, with a protocol of `factory` for each connection.

    `failed(why)` is called once when accepting fails, `recovered()` when it works again. Without
    descriptors `make_room` is called, which returns True if it closes connections. Raises
    OSError if a socket cannot listen. Not for Windows, whose loop watches no descriptors.
    """

    def __init__(
        self,
        sockets: Iterable[socket.socket],
        factory: Callable[[], asyncio.Protocol],
        backlog: int,
        failed: Callable[[str], None],
        recovered: Callable[[], None],
        make_room: Callable[[], bool],
    ) -> None:
        self._loop = asyncio.get_running_loop()
        self._factory = factory
        self._failed = failed
        self._recovered = recovered
        self._make_room = make_room
        self._has_failed = False
        self._silent_until = 0.0
        self._retries: dict[socket.socket, asyncio.TimerHandle] = {}
        self._tasks: set[asyncio.Task[None]] = set()
        self._sockets: list[socket.socket] = []
        try:
            for each in sockets:
                own = socket.socket(fileno=os.dup(each.fileno()))
                self._sockets.append(own)
                own.setblocking(False)
                own.listen(backlog)
                self._watch(own)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Accept no more."""
        for retry in self._retries.values():
            retry.cancel()
        for each in self._sockets:
            self._loop.remove_reader(each)
            each.close()
        self._retries.clear()
        self._sockets.clear()

    def _watch(self, listening: socket.socket) -> None:
        self._retries.pop(listening, None)
        self._loop.add_reader(listening, self.accept, listening)

    def accept(self, listening: socket.socket) -> None:
        """Accept what waits at one of the sockets."""
        for _ in range(_AT_ONCE):
            try:
                connection, _ = listening.accept()
            except (BlockingIOError, InterruptedError, ConnectionAbortedError):
                return
            except OSError as failure:
                self._pause(listening, failure)
                return
            if self._has_failed:
                self._has_failed = False
                self._recovered()
            connection.setblocking(False)
            task = self._loop.create_task(self._hand_over(connection))
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)

    async def _hand_over(self, connection: socket.socket) -> None:
        try:
            await self._loop.connect_accepted_socket(self._factory, connection)
        except OSError:  # it is gone already
            connection.close()

    def _pause(self, listening: socket.socket, failure: OSError) -> None:
        """Look at this socket again in a while: it stays readable."""
        self._loop.remove_reader(listening)
        without_descriptors = failure.errno in (errno.EMFILE, errno.ENFILE)
        pause = _SOON if without_descriptors and self._make_room() else _RETRY
        self._retries[listening] = self._loop.call_later(pause, self._watch, listening)
        now = self._loop.time()
        if not self._has_failed and now >= self._silent_until:
            self._has_failed = True
            self._silent_until = now + _SILENCE
            self._failed(reason(failure))
