"""Lines in a row, taken at once: the quick way of programs with very many very short lines.

A CAM system writes `N100 X10.001 Y2.5` a hundred thousand times. Such lines, one behind the other,
become one `LineRun` instead of a command each; what they mean is the same (`Interpreter.advance`).
"""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

from achse.gcode.canon import LineMove, Origin
from achse.gcode.text.program import PartProgram
from achse.gcode.vectors import PathPoint

_NUMBER = r"([-+]?(?:\d{1,12}(?:\.\d{0,15}+)?|\.\d{1,15}+))\s*+"
_BARE: Callable[[str], "re.Match[str] | None"] = re.compile(
    rf"\s*+(?:N\s*+\d{{1,9}}\s*+)?(?:X\s*+{_NUMBER})?(?:Y\s*+{_NUMBER})?(?:Z\s*+{_NUMBER})?"
).fullmatch


@dataclass(slots=True)
class LineRun:
    """Lines of one path velocity, none of them rapid or with an exact stop; at least one."""

    program: PartProgram
    first_line: int
    """Line of the program, from 0, that the first one is in; the others follow it."""
    start: PathPoint
    """Position at which the first line begins."""
    ends: Sequence[PathPoint]
    """Positions of X, Y, Z at the end of each line, mm, those of the axes."""
    auxiliary: tuple[float, ...]
    """Q1..Q5, which stay where they are."""
    velocity: float
    """mm/s."""
    counter: int = 0
    """Blocks that ran up to the first one (`Origin.counter`)."""
    taken: int = field(default=0, compare=False)
    """Number of its lines passed on for execution."""

    def __len__(self) -> int:
        return len(self.ends)

    def origin(self, number: int) -> Origin:
        """Return the origin of a line; `number` counts from 0."""
        line = self.first_line + number
        program = self.program
        word = program.block(line).number
        return Origin(program.name, line + 1, program.starts[line], word, self.counter + number)

    def moves(self) -> Iterator[LineMove]:
        """Yield the same as single commands."""
        start, velocity = self.start, self.velocity
        for number, end in enumerate(self.ends):
            yield LineMove(self.origin(number), start, end, self.auxiliary, velocity, velocity)
            start = end


def read_points(
    lines: Sequence[str], begin: Sequence[float], incremental: bool, limit: float
) -> list[PathPoint]:
    """Return the programmed points of the first lines that have nothing but numbers for X, Y and Z
    in this order, a block number before them at most. It ends before a point beyond the limit,
    mm."""
    points: list[PathPoint] = []
    add = points.append
    x, y, z = begin
    for text in lines:
        match = _BARE(text)
        if match is None:
            break
        first, second, third = match.groups()
        if incremental:
            a = x + float(first) if first else x
            b = y + float(second) if second else y
            c = z + float(third) if third else z
        else:
            a = float(first) if first else x
            b = float(second) if second else y
            c = float(third) if third else z
        if not (first or second or third):
            break
        if not (-limit <= a <= limit and -limit <= b <= limit and -limit <= c <= limit):
            break
        x, y, z = a, b, c
        add((x, y, z))
    return points
