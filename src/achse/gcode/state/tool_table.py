"""Tools of a channel: D1..D255 with type, length, radius, wear and Cartesian offsets; their file.

Source: tcnci, tool data (parameters 0..10); 002 §6.4.2, channel parameters 0x0002ww00 (number),
0x0003ww00 (type), 0x0004wwnn (parameter nn). Files are named `<channel id>.wz`; the form inside is
not published, ours is one line per tool: D number, then its values.
"""

from collections.abc import Callable
from enum import IntEnum
from math import isfinite
from pathlib import Path

from achse.gcode.vectors import PathPoint

TOOL_PLACES = 255
"""D1..D255; D0 means none."""


class ToolType(IntEnum):
    """Types with a meaning; others are stored as numbers."""

    NONE = 0
    DRILL = 10
    END_MILL = 20


class ToolParameter(IntEnum):
    """Index of a value of a tool; nn of channel parameter 0x0004wwnn is the same number."""

    NUMBER = 0
    TYPE = 1
    LENGTH = 2
    RADIUS = 4
    WEAR_LENGTH = 5
    WEAR_RADIUS = 7
    OFFSET_X = 8
    OFFSET_Y = 9
    OFFSET_Z = 10


PARAMETERS = 15
"""Values that a tool has: number, type and 1..14 of the parameter rows; unnamed ones are stored."""


class ToolFileError(ValueError):
    """A file of tools has a line that is not one."""


class ToolEntry:
    """The values of one tool, by `ToolParameter`. Lengths in mm; wear is added and so negative."""

    def __init__(self, changed: Callable[[], None] | None = None) -> None:
        self.values = [0.0] * PARAMETERS
        self._changed = changed

    def __getitem__(self, parameter: int) -> float:
        return self.values[parameter]

    def __setitem__(self, parameter: int, value: float) -> None:
        if not isfinite(value):
            raise ValueError(f"expected a finite tool parameter, got {value}")
        self.values[parameter] = value
        if self._changed is not None:
            self._changed()

    @property
    def length(self) -> float:
        """Length that counts: length and wear, mm."""
        return self.values[ToolParameter.LENGTH] + self.values[ToolParameter.WEAR_LENGTH]

    @property
    def radius(self) -> float:
        """Radius that counts: radius and wear, mm. A drill has none."""
        if self.values[ToolParameter.TYPE] == ToolType.DRILL:
            return 0.0
        return self.values[ToolParameter.RADIUS] + self.values[ToolParameter.WEAR_RADIUS]

    @property
    def offset(self) -> PathPoint:
        """Cartesian offset, mm."""
        x, y, z = self.values[ToolParameter.OFFSET_X : ToolParameter.OFFSET_Z + 1]
        return (x, y, z)


class ToolTable:
    """Tools by D number. A place that was never written has zeros only."""

    def __init__(self) -> None:
        self._tools: dict[int, ToolEntry] = {}
        self.changes = 0
        """Counts changes, so that readers see that there is something new."""

    def _changed(self) -> None:
        self.changes += 1

    def __getitem__(self, place: int) -> ToolEntry:
        """Return the tool of D1..D255; it is there from the first touch."""
        if not 1 <= place <= TOOL_PLACES:
            raise KeyError(place)
        tool = self._tools.get(place)
        if tool is None:
            tool = self._tools[place] = ToolEntry(self._changed)
        return tool

    def __contains__(self, place: int) -> bool:
        tool = self._tools.get(place)
        return tool is not None and any(tool.values)

    def clear(self) -> None:
        """Set all tools to 0 (channel function 0x26)."""
        self._tools.clear()
        self.changes += 1

    def text(self) -> str:
        """Return the file."""
        return "".join(
            f"D{place} " + " ".join(repr(value) for value in tool.values) + "\n"
            for place, tool in sorted(self._tools.items())
            if any(tool.values)
        )

    def read(self, text: str) -> None:
        """Load a file; tools that it does not have are gone. All or nothing."""
        tools: dict[int, ToolEntry] = {}
        for number, line in enumerate(text.splitlines(), 1):
            words = line.partition(";")[0].split()
            if not words:
                continue
            try:
                place = int(words[0].upper().removeprefix("D"))
                values = [float(word) for word in words[1:]]
            except ValueError:
                place, values = 0, []
            if (
                not 1 <= place <= TOOL_PLACES
                or not 1 <= len(values) <= PARAMETERS
                or not all(map(isfinite, values))
            ):
                raise ToolFileError(
                    f"line {number}: expected D1 to D{TOOL_PLACES} and 1 to {PARAMETERS} numbers"
                )
            tool = tools[place] = ToolEntry(self._changed)
            tool.values[: len(values)] = values
        self._tools = tools
        self.changes += 1

    def save(self, path: Path) -> None:
        """Write the file (channel function 0x22)."""
        path.write_text(self.text(), encoding="ascii")

    def load(self, path: Path) -> None:
        """Read the file (channel function 0x23)."""
        self.read(path.read_text(encoding="latin-1"))
