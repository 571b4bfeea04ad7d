"""A fair queue: peers with much to do are served a slice at a time, each host in its turn.

What a peer sends is done at once, unless that takes longer than a slice: then nothing more is read
from it, and it waits in the line of its host. The lines are served in turns between two looks at
the sockets. So a peer that asks for little is answered soon, however much others ask for, on
however many connections.
"""

import time
from collections import deque
from collections.abc import Callable
from typing import Protocol

SLICE_S = 0.002
"""Time for one peer before another one's turn comes; a single request may take longer."""

TURN_S = 0.010
"""Time for all that wait, before the loop looks at its sockets again."""


class Worker(Protocol):
    """A peer with requests that wait."""

    peer_host: str

    def work(self, until: float) -> bool:
        """Do what waits, one request at least, until this moment; True when all is done."""
        ...


class FairQueue:
    """Schedule that serves the hosts in turns; `clock` returns seconds."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.clock = clock
        self._waiting: dict[str, deque[Worker]] = {}
        """By host, the next one first."""
        self._due = False

    def __len__(self) -> int:
        return sum(map(len, self._waiting.values()))

    def serve(self, worker: Worker, later: Callable[[Callable[[], None]], object]) -> bool:
        """Let `worker` begin; False if it has to wait, with something left to do.

        `later(function)` has the function called behind the loop's next look at its sockets.
        """
        queue = self._waiting.get(worker.peer_host)
        if queue is None:
            if worker.work(self.clock() + SLICE_S):
                return True
            queue = self._waiting.setdefault(worker.peer_host, deque())
        queue.append(worker)
        self._go_on(later)
        return False

    def _go_on(self, later: Callable[[Callable[[], None]], object]) -> None:
        if not self._due:
            self._due = True
            later(lambda: self._turn(later))

    def _turn(self, later: Callable[[Callable[[], None]], object]) -> None:
        """Serve those that wait, the hosts in turns, as long as a turn lasts."""
        self._due = False
        now = self.clock()
        end = now + TURN_S
        while self._waiting and now < end:
            host, queue = next(iter(self._waiting.items()))
            worker = queue.popleft()
            if not worker.work(now + SLICE_S):
                queue.append(worker)
            del self._waiting[host]
            if queue:
                self._waiting[host] = queue  # behind the others
            now = self.clock()
        if self._waiting:
            self._go_on(later)
