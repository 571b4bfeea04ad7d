"""Changes of the station's state that clients request: between two of them it runs for a while."""

import math
from collections.abc import Callable
from typing import Protocol

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.server.deferred import Answer, Deferred

LONGEST_RUN_NS = 1_000_000_000
"""A station runs as long as its restart took before a client stops it again, but no longer than
this: clients wait for an answer that long."""

MAX_WAITING = 64
"""Requests that wait for the end of that time; more are refused as busy (0x708)."""


class _ControlledStation(Protocol):
    """The station whose state changes."""

    @property
    def time_ns(self) -> int: ...

    def restart(self) -> None: ...

    def configure(self) -> None: ...

    def shut_down(self, delay_s: float, restart: bool) -> None: ...

    def at(self, due_ns: int, action: Callable[[], None]) -> None: ...


class StateRequests:
    """The control that the system service has over a station.

    A request to leave RUN is answered when the change begins. Those that come while the station is
    kept in RUN begin together at the end of that time, as one change: the last request decides.
    """

    def __init__(self, station: _ControlledStation) -> None:
        self._station = station
        self._free_at_ns: float = -math.inf
        self._change: Callable[[], None] = station.restart
        self._waiting: list[Answer] = []

    def entered_run(self, restart_ns: int) -> None:
        """Keep the station in RUN from now on as long as its restart took, `restart_ns`."""
        self._free_at_ns = self._station.time_ns + min(restart_ns, LONGEST_RUN_NS)

    @property
    def free_at_ns(self) -> float:
        """Station time from which on clients may take the station out of RUN, ns."""
        return self._free_at_ns

    def restart(self) -> None:
        """Restart in RUN. Raises Deferred while the station is kept in RUN, 0x708 if many wait."""
        self._request(self._station.restart)

    def configure(self) -> None:
        """Go to CONFIG. Raises as `restart` does."""
        self._request(self._station.configure)

    def shut_down(self, delay_s: float, restart: bool) -> None:
        """End or restart after a delay in station time."""
        self._station.shut_down(delay_s, restart)

    def _request(self, change: Callable[[], None]) -> None:
        if self._station.time_ns >= self._free_at_ns:
            change()
            return
        if len(self._waiting) >= MAX_WAITING:
            raise DeviceError(ReturnCode.BUSY, f"{MAX_WAITING} requests wait for a change of state")

        def wait(answer: Answer) -> None:
            if not self._waiting:
                self._station.at(int(self._free_at_ns), self._begin)
            self._waiting.append(answer)
            self._change = change

        raise Deferred(wait)

    def _begin(self) -> None:
        waiting, self._waiting = self._waiting, []
        self._change()
        for answer in waiting:
            answer(bytes)
