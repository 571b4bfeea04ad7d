"""Two interfaces of a redundant bus as one link: copies go out by both, whole frames come back."""

import time
from collections import deque
from collections.abc import Callable

from achse.ethercat.master.redundancy import SURE, Redundancy
from achse.station.buses.frame_link import FrameLink

_INDEX_AT = 17
"""Of the first datagram, which is that of the frame."""
_TURN_S = 0.00005
"""Time of listening to one interface before the other, s."""


class RedundantLink:
    """Sends and receives as one `FrameLink`; `redundancy` is that of the master.

    What is to be had of a frame with a copy missing comes when `patience_ns` have passed since it
    was sent. A link may be None: no copy goes out or comes there. `clock` gives ns.
    """

    def __init__(
        self,
        first: FrameLink | None,
        second: FrameLink | None,
        redundancy: Redundancy,
        *,
        patience_ns: int = 0,
        clock: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        self.links: list[FrameLink | None] = [first, second]
        self.clock = clock
        self._whole: deque[bytes] = deque()
        self._sent_ns: dict[int, int] = {}
        """Send time of each frame, by index; 256 at most."""
        self._last: FrameLink | None = None
        """Link at which the last copy came."""
        self.begin(redundancy, patience_ns)

    def begin(self, redundancy: Redundancy, patience_ns: int) -> None:
        """Go on for another master, or for a search; what is under way is dropped."""
        self.redundancy = redundancy
        self.patience_ns = patience_ns
        self._whole.clear()
        self._sent_ns.clear()

    @property
    def arrived_ns(self) -> int:
        """Arrival time of the last copy, by the clock of `time.time_ns`; 0 before the first."""
        return self._last.arrived_ns if self._last is not None else 0

    def send(self, frame: bytes) -> bool:
        """Send both copies; False if no interface takes one."""
        copies = self.redundancy.copies(frame)
        self._sent_ns[frame[_INDEX_AT]] = self.clock()
        sent = False
        for adapter, link in enumerate(self.links):
            if link is None:
                self.redundancy.missing[adapter] = SURE
            else:
                sent |= link.send(copies[adapter])
        return sent

    def receive(self, timeout_s: float) -> bytes | None:
        """Return the next whole frame; None if none came within `timeout_s`, 0 looks only."""
        left = timeout_s
        end_ns = self.clock() + round(timeout_s * 1e9)
        while not self._whole:
            if self._take(0.0) or self._whole:
                continue
            if left <= 0.0:
                self._give_up(max(self.clock(), end_ns))
                break
            self._take(min(left, _TURN_S) / 2)
            left -= _TURN_S
        return self._whole.popleft() if self._whole else None

    def _give_up(self, now_ns: int) -> None:
        """Pass on frames whose other copy is missing for long enough."""
        ring = self.redundancy
        if ring.halves:
            before = now_ns - self.patience_ns
            late = [index for index in ring.halves if self._sent_ns.get(index, before) <= before]
            self._whole.extend(ring.flush(late))

    def _take(self, timeout_s: float) -> bool:
        """Receive at either interface; return True if a frame came."""
        came = False
        for adapter, link in enumerate(self.links):
            copy = None if link is None else link.receive(timeout_s)
            if link is not None and copy is not None:
                came = True
                self._last = link
                whole = self.redundancy.take(copy, adapter)
                if whole is not None:
                    self._whole.append(whole)
        return came
