"""Zero shifts of a channel: G54..G57 with a coarse and a fine part, G58 and G59; and their file.

Source: 002 §6.4.2, channel parameter 0x00010K0L: K 1 X, 2 Y, 3 Z; L 1 G54 fine, 2 G54 coarse, …,
8 G57 coarse, 9 G58, 0xA G59.
"""

from collections.abc import Iterable
from enum import IntEnum
from math import isfinite
from pathlib import Path

from achse.gcode.vectors import PathPoint


class ZeroShift(IntEnum):
    """The rows of a shift table; the number is L of the parameter's offset."""

    G54_FINE = 1
    G54_COARSE = 2
    G55_FINE = 3
    G55_COARSE = 4
    G56_FINE = 5
    G56_COARSE = 6
    G57_FINE = 7
    G57_COARSE = 8
    G58 = 9
    G59 = 10


class ShiftFileError(ValueError):
    """A file of zero shifts has a line that is not one."""


class ZeroShifts:
    """Values in mm by row and axis (0 X, 1 Y, 2 Z). Numbers that are not finite are refused."""

    def __init__(self) -> None:
        self._values = {row: [0.0, 0.0, 0.0] for row in ZeroShift}
        self.changes = 0
        """Counts changes, so that readers see that there is something new."""

    def __getitem__(self, place: tuple[ZeroShift, int]) -> float:
        row, axis = place
        return self._values[row][axis]

    def __setitem__(self, place: tuple[ZeroShift, int], value: float) -> None:
        if not isfinite(value):
            raise ValueError(f"expected a finite zero shift, got {value}")
        row, axis = place
        self._values[row][axis] = value
        self.changes += 1

    def clear(self) -> None:
        """Set all shifts to 0 (channel function 0x27)."""
        for values in self._values.values():
            values[:] = (0.0, 0.0, 0.0)
        self.changes += 1

    def adjustable(self, number: int) -> PathPoint:
        """Sum of fine and coarse part of G54..G57, mm."""
        fine = ZeroShift(2 * (number - 54) + 1)
        coarse = ZeroShift(fine + 1)
        x, y, z = (a + b for a, b in zip(self._values[fine], self._values[coarse], strict=True))
        return (x, y, z)

    def programmed(self, number: int) -> PathPoint:
        """G58 or G59, mm."""
        x, y, z = self._values[ZeroShift.G58 if number == 58 else ZeroShift.G59]
        return (x, y, z)

    def program(self, number: int, axis: int, value: float) -> None:
        """Set the shift of `G58 X…` or `G59 X…`, mm."""
        self[ZeroShift.G58 if number == 58 else ZeroShift.G59, axis] = value

    def text(self) -> str:
        """Return the file: one line for each row, `G54F x y z`. The vendor's form is not
        published."""
        return "".join(
            f"{_NAMES[row]} " + " ".join(repr(value) for value in values) + "\n"
            for row, values in self._values.items()
        )

    def read(self, text: str) -> None:
        """Load the values of a file. Rows that it does not have stay. All or nothing."""
        shifts = dict(_rows(text.splitlines()))
        for row, values in shifts.items():
            self._values[row][:] = values
        self.changes += 1

    def save(self, path: Path) -> None:
        """Write the file (channel function 0x20)."""
        path.write_text(self.text(), encoding="ascii")

    def load(self, path: Path) -> None:
        """Read the file (channel function 0x21)."""
        self.read(path.read_text(encoding="latin-1"))


def _rows(lines: Iterable[str]) -> Iterable[tuple[ZeroShift, list[float]]]:
    for number, line in enumerate(lines, 1):
        words = line.partition(";")[0].split()
        if not words:
            continue
        try:
            row = _ROWS[words[0].upper()]
            values = [float(word) for word in words[1:]]
        except (KeyError, ValueError):
            row, values = ZeroShift.G58, []
        if len(values) != 3 or not all(map(isfinite, values)):
            raise ShiftFileError(f"line {number}: expected a name like G54F and three numbers")
        yield row, values


_NAMES = {row: row.name.replace("_FINE", "F").replace("_COARSE", "G") for row in ZeroShift}
"""G54F, G54G, …, as the manual writes them: G for coarse (grob)."""
_ROWS = {name: row for row, name in _NAMES.items()}
