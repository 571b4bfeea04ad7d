"""Two interfaces of a redundant bus as one link: copies go out by both, whole frames come back."""

from collections import deque

from achse.ethercat.master.redundancy import Redundancy
from achse.station.bus_link import FrameLink

__all__ = ["RedundantLink"]

_TURN_S = 0.00005
"""How long one interface is listened to before the other."""


class RedundantLink:
    """Sends and receives as one `FrameLink`; `redundancy` is that of the master.

    A frame of which one copy is missing when the time is over comes as far as it got.
    """

    def __init__(self, first: FrameLink, second: FrameLink, redundancy: Redundancy) -> None:
        self._links = first, second
        self._redundancy = redundancy
        self._whole: deque[bytes] = deque()
        self._halves: frozenset[int] = frozenset()
        """Frames of which one copy was here at the last look that found nothing."""
        self.arrived_ns = 0
        """When the last copy arrived, by the clock of `time.time_ns`."""

    def send(self, frame: bytes) -> bool:
        """Send both copies; False if no interface takes one."""
        copies = self._redundancy.copies(frame)
        sent = [link.send(copy) for link, copy in zip(self._links, copies, strict=True)]
        return any(sent)

    def receive(self, timeout_s: float) -> bytes | None:
        """The next whole frame; None if none came within `timeout_s`, 0 looks only."""
        left = timeout_s
        while not self._whole:
            came = self._take(0.0)
            if self._whole:
                break
            if came:
                continue
            if left <= 0.0:
                self._give_up(waited=timeout_s > 0.0)
                break
            self._take(min(left, _TURN_S) / 2)
            left -= _TURN_S
        return self._whole.popleft() if self._whole else None

    def _give_up(self, *, waited: bool) -> None:
        """Nothing comes now: frames of which a copy is missing, if that was so at the last look."""
        ring = self._redundancy
        self._whole.extend(ring.flush(None if waited else self._halves))
        self._halves = ring.halves

    def _take(self, timeout_s: float) -> bool:
        """Take what comes at either interface; whether something did."""
        came = False
        for link in self._links:
            copy = link.receive(timeout_s)
            if copy is not None:
                came = True
                self.arrived_ns = link.arrived_ns
                whole = self._redundancy.take(copy)
                if whole is not None:
                    self._whole.append(whole)
        return came
