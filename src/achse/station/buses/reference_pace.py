"""Following the reference clock of a bus: how much later or earlier the next cycle begins.

SYNC0 of the drives has a fixed place in the cycles of the first drive's clock, whose time each
cyclic frame brings back. A controller (PI) keeps the frames at the place where that time is a
multiple of the cycle, whatever the computer's clock does.

Source: "master follows the reference clock", as masters in software do it.
"""

_GAIN, _RESET = 16, 1024
"""Divisors: a deviation is halved in some ten cycles, a drift is learned in some hundred."""
_SPAN = 32
"""A deviation counts as this part of the cycle at most: one late frame moves next to nothing."""
_FASTEST = 1000
"""The learned drift is this part of the cycle at most, 1000 ppm."""
_FORGET_NS = 1_000_000_000
"""So long without a reading, and nothing is known of the clock any more."""
_SETTLED = 50
"""Readings in a row near the place until it counts as kept."""


class ReferencePace:
    """The controller of one bus with a cycle of `cycle_ns`; nothing in it reads a clock."""

    def __init__(self, cycle_ns: int) -> None:
        self.cycle_ns = cycle_ns
        self.deviation_ns = 0
        """Of the last frame from its place: above 0 it was late. At most half a cycle."""
        self.settled = False
        """True if the frames keep their phase."""
        self._rate = self._rest = 0.0
        self._before = 0
        self._silent = self._near = 0
        self._patience = max(_FORGET_NS // cycle_ns, 1)

    @property
    def drift_ppm(self) -> float:
        """Measured rate by which the computer's clock runs faster than the reference, ppm."""
        return 1e6 * self._rate / self.cycle_ns

    def take(self, reference_ns: int) -> int:
        """Return the delay of the next cycle, ns: above 0 it begins later.

        `reference_ns` is the time of the reference when the last frame passed it; 0, or the time of
        the last call: no frame came. The delay is at most 0.3 % of the cycle.
        """
        fresh = reference_ns not in (0, self._before)
        self._before = reference_ns
        if not fresh:
            return self._without()
        self._silent = 0
        cycle = self.cycle_ns
        late = reference_ns % cycle
        if 2 * late > cycle:
            late -= cycle
        self.deviation_ns = late
        span = cycle // _SPAN
        near = -span <= late <= span
        self._near = self._near + 1 if near else 0
        self.settled = self._near >= _SETTLED or (self.settled and self._near > 0)
        counted = max(-span, min(span, late))
        if near:
            most = cycle / _FASTEST
            self._rate = max(-most, min(most, self._rate - counted / _RESET))
        return self._whole(self._rate - counted / _GAIN)

    def _without(self) -> int:
        """Nothing came: go on at the pace that was learned, for a while."""
        self._silent += 1
        if self._silent > self._patience:
            self._rate = self._rest = 0.0
            self._near, self.settled = 0, False
            return 0
        return self._whole(self._rate)

    def _whole(self, by_ns: float) -> int:
        """In whole ns; what is left over is for the next cycle."""
        wanted = by_ns + self._rest
        whole = round(wanted)
        self._rest = wanted - whole
        return whole
