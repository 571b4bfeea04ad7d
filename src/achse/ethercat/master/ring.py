"""A master and a segment in one process: frames go round at once, in virtual time.

A redundant bus has its frames go out at both ends of a `RingSegment`.

Source: 001 §2.3.
"""

from achse.ethercat.master.master import Master
from achse.ethercat.master.redundancy import Redundancy
from achse.ethercat.ring_segment import RingSegment
from achse.ethercat.segment import Segment

_ROUNDS = 4


class Ring:
    """Exchanges the frames of `master` through `segment`; `rounds` of requests in each cycle."""

    def __init__(self, master: Master, segment: Segment, *, rounds: int = _ROUNDS) -> None:
        self.master = master
        self.segment = segment
        self.rounds = rounds

    def exchange(self, now_ns: int) -> None:
        """Run one cycle: outputs go out, inputs are there afterwards."""
        master, process = self.master, self.segment.process
        self.segment.advance(now_ns)
        frames = master.transmit(now_ns)
        for left in range(self.rounds, 0, -1):
            if master.redundancy is not None and isinstance(self.segment, RingSegment):
                self._both_ways(self.segment, master.redundancy, frames, now_ns)
                frames = []
            for frame in frames:
                reply = process(frame)
                if reply is not None:
                    master.receive(reply, now_ns)
            frames = master.poll(now_ns) if left > 1 else []
            if not frames:
                break

    def _both_ways(
        self, segment: RingSegment, redundancy: Redundancy, frames: list[bytes], now_ns: int
    ) -> None:
        for frame in frames:
            for adapter, copy in enumerate(redundancy.copies(frame)):
                came = segment.process_from(adapter, copy)
                whole = None if came is None else redundancy.take(*came)
                if whole is not None:
                    self.master.receive(whole, now_ns)
        for frame in redundancy.flush():
            self.master.receive(frame, now_ns)

    def run(self, until_ns: int) -> None:
        """Run cycles up to and with `until_ns`."""
        cycle = self.master.bus.cycle_ns
        now = self.master.now_ns
        while now + cycle <= until_ns:
            now += cycle
            self.exchange(now)
