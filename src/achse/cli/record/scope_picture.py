"""Recordings in a terminal: curves, and a live picture with its progress."""

import math
from collections import deque
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from achse.cli.plot import Panel, plot

if TYPE_CHECKING:
    from rich.console import Group
    from rich.live import Live

    from achse.client.scope import ScopeRows
    from achse.scope.data import ScopeData, ScopeTrack

PANELS = 4
"""Curves above each other."""

POINTS = 400
"""Of one curve: two for each column of a wide terminal."""


def lines_of(data: "ScopeData", width: int = 72, height: int = 7) -> list[str]:
    """Return the first curves of a recording, each over its own time."""
    lines: list[str] = []
    for track in data.tracks[:PANELS]:
        times, values = _thinned(track)
        title = f"{track.channel.name} {track.channel.unit}".strip()
        lines += plot(times, [Panel(title, values)], width=width, height=height)
    return lines


def _thinned(track: "ScopeTrack") -> tuple[list[float], list[float]]:
    """Points enough for a terminal: of each stretch the least and the greatest, in their order."""
    times, values = track.times, [float(value) for value in track.values]
    pairs = [pair for pair in zip(times, values, strict=True) if math.isfinite(pair[1])]
    stride = max(len(pairs) // (POINTS // 2), 1)
    points: list[tuple[float, float]] = []
    for first in range(0, len(pairs), stride):
        part = pairs[first : first + stride]
        low, high = min(part, key=lambda pair: pair[1]), max(part, key=lambda pair: pair[1])
        points += sorted({low, high})
    return [time for time, _ in points], [value for _, value in points]


class ScopePicture:
    """Live picture of a recording; nothing without a terminal."""

    def __init__(self, groups: list[dict[str, Any]], seconds: float | None, *, live: bool) -> None:
        self._groups = groups
        self._seconds = seconds
        self._is_live = live
        self._live: Live | None = None
        self._time = 0.0
        self._samples = 0
        self._curves: dict[tuple[int, int], deque[tuple[float, float]]] = {}
        for number, group in enumerate(groups):
            for place in range(len(group["channels"])):
                if len(self._curves) < PANELS:
                    self._curves[number, place] = deque(maxlen=POINTS)

    def __enter__(self) -> Self:
        if self._is_live:
            from rich.live import Live

            self._live = Live(self.picture(), refresh_per_second=10, transient=True)
            self._live.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._live is not None:
            self._live.stop()

    def add(self, rows: "ScopeRows") -> None:
        """Take rows as they came, each a few points of its curves."""
        from achse.client.scope import block_of
        from achse.scope.data import ScopeData

        group = self._groups[rows.group]
        self._samples += rows.size * len(group["channels"])
        self._time = max(self._time, (rows.first + rows.size) * group["step_ns"] / 1e9)
        if self._live is None:
            return
        data = ScopeData("", (block_of(group, rows.first, rows.rows),))
        begin = rows.first * group["step_ns"] / 1e9
        for place, track in enumerate(data.tracks):
            curve = self._curves.get((rows.group, place))
            if curve is not None:
                times, values = _thinned(track)
                curve.extend((begin + t, value) for t, value in zip(times, values, strict=True))
        self._live.update(self.picture())

    def picture(self) -> "Group":
        """Curves above a line of progress."""
        from rich.console import Group
        from rich.progress_bar import ProgressBar
        from rich.text import Text

        lines: list[str] = []
        for (number, place), curve in self._curves.items():
            channel = self._groups[number]["channels"][place]
            times, values = [time for time, _ in curve], [value for _, value in curve]
            lines += plot(times, [Panel(channel["name"], values)], height=5)
        title = f"{self._time:.1f} s, {self._samples} samples"
        parts: list[Any] = [Text("\n".join(lines), no_wrap=True), Text(title)]
        if self._seconds:
            parts.append(ProgressBar(self._seconds, min(self._time, self._seconds), width=60))
        return Group(*parts)
