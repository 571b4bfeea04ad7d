"""The track of a world: set points of all axes, cycle by cycle, up to its end."""

from collections import deque

from achse.motion import Nc

_MOST = 20_000
"""Cycles that are kept: the last ones."""


class Track:
    """Set positions, velocities and accelerations of the last cycles."""

    def __init__(self, most: int = _MOST) -> None:
        self.names: list[str] = []
        self._rows: deque[tuple[float, ...]] = deque(maxlen=most)

    def take(self, now_ns: int, nc: Nc) -> None:
        """Add the set points after a cycle at this time of the world."""
        row = [now_ns / 1e9]
        for axis in nc:
            now = axis.set
            row += now.position, now.velocity, now.acceleration
        if not self.names:
            self.names = [axis.name for axis in nc]
        self._rows.append(tuple(row))

    def __len__(self) -> int:
        return len(self._rows)

    def columns(self) -> list[list[float]]:
        """Return the times, s, then position, velocity and acceleration of each axis."""
        return [list(column) for column in zip(*self._rows, strict=True)]
