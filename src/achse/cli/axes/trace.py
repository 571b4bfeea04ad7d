"""A trace: position, velocity and following error of an axis over time, and its picture."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from achse.cli.plot import Panel, plot

if TYPE_CHECKING:
    from rich.text import Text

COLUMNS = (
    "set_position",
    "actual_position",
    "set_velocity",
    "actual_velocity",
    "following_error",
)
"""Record fields kept of each sample."""

TICKS_PER_SECOND = 10_000_000
"""A FILETIME counts 100 ns."""


@dataclass
class Trace:
    """Samples of an axis; times in seconds since the first of them."""

    unit: str
    times: list[float] = field(default_factory=list)
    columns: dict[str, list[float]] = field(default_factory=lambda: {name: [] for name in COLUMNS})
    _begin: int | None = None

    def add(self, filetime: int, values: Mapping[str, Any]) -> float:
        """Keep a sample; gives its time."""
        if self._begin is None:
            self._begin = filetime
        time = (filetime - self._begin) / TICKS_PER_SECOND
        self.times.append(time)
        for name, column in self.columns.items():
            column.append(values[name])
        return time

    def keep_since(self, time: float) -> None:
        """Drop what is older."""
        old = next((n for n, moment in enumerate(self.times) if moment >= time), len(self.times))
        del self.times[:old]
        for column in self.columns.values():
            del column[:old]

    def __getitem__(self, name: str) -> list[float]:
        return self.columns[name]

    def peak(self, name: str) -> float:
        """Return the largest magnitude in a column, 0 without samples."""
        return max(map(abs, self.columns[name]), default=0.0)

    def lines(self, width: int, height: int = 9) -> list[str]:
        """Return the picture: actual position above actual velocity."""
        panels = (
            Panel(f"position {self.unit}", self["actual_position"]),
            Panel(f"velocity {self.unit}/s", self["actual_velocity"]),
        )
        return plot(self.times, panels, width=width, height=height)

    def text(self, width: int, height: int = 9) -> "Text":
        """Return the picture in colours."""
        from rich.text import Text

        text = Text("\n".join(self.lines(width, height)), no_wrap=True)
        text.highlight_regex(r"[│┤└─┬]+", "dim")
        text.highlight_regex(r"[⠁-⣿]+", "cyan")
        return text
