"""The slaves' side of cable redundancy: a line between two interfaces, served as one link."""

import select
import time
from collections.abc import Sequence
from typing import Protocol

from achse.ethercat.ring_segment import RingSegment
from achse.transport.ethernet import Answer

_BREATH_S = 0.001
"""A link that fails again and again does not keep the processor busy."""


class RingEnd(Protocol):
    """One interface, as `achse.transport.ethernet.EthernetLink`."""

    def fileno(self) -> int: ...

    def send(self, frame: bytes) -> bool: ...

    def receive(self, timeout_s: float) -> bytes | None: ...

    def close(self) -> None: ...


class Plug(Protocol):
    """Interface of the link at an end, as `achse.transport.link_state.LinkState`."""

    @property
    def up(self) -> bool: ...

    def close(self) -> None: ...


class RingEnds:
    """Both ends of `segment` as a `Link`; its answers are those of `process`.

    `plugs` say whether the interfaces have their links: slaves see a cable that is cut, and let
    frames turn round there.
    """

    losses = 0
    """The segment knows by itself."""

    def __init__(
        self,
        segment: RingSegment,
        ends: Sequence[RingEnd],
        plugs: Sequence[Plug],
    ) -> None:
        self._segment = segment
        self._ends = tuple(ends)
        self._plugs = tuple(plugs)
        self._poll = select.poll()
        for end in self._ends:
            self._poll.register(end.fileno(), select.POLLIN)
        self._came = self._goes = 0
        """End at which the processed frame came in, and end at which it leaves."""

    def process(self, frame: bytes) -> bytes | None:
        """Return the frame that leaves the ring for the frame that `exchange` has received."""
        came = self._segment.process_from(self._came, frame)
        if came is None:
            return None
        reply, self._goes = came
        return reply

    def exchange(self, answer: Answer, timeout_s: float) -> bool:
        """Answer what is at both ends; False if nothing came within `timeout_s`."""
        ready = self._poll.poll(round(timeout_s * 1e3))
        for adapter, plug in enumerate(self._plugs):
            self._segment.connect(adapter, plug.up)
        some = False
        for adapter, end in enumerate(self._ends):
            frame = end.receive(0.0)
            if frame is None:
                continue
            some = True
            self._came = adapter
            reply = answer(frame)
            if reply is not None:
                self._ends[self._goes].send(reply)
        if ready and not some:
            time.sleep(_BREATH_S)
        return some

    def fileno(self) -> int:
        """Return the file descriptor of the first end."""
        return self._ends[0].fileno()

    def close(self) -> None:
        """Close both ends."""
        for end, plug in zip(self._ends, self._plugs, strict=True):
            end.close()
            plug.close()
