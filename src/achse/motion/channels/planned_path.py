"""The path that a loaded program will take, found without motion and a little at a time.

A copy of R parameters, tools and zero shifts is used, so that nothing of the channel changes. Each
move is taken as done at once; what the PLC or other programs change on the way is not known.
"""

from copy import deepcopy
from enum import IntEnum
from math import ceil, radians
from typing import NamedTuple

from achse.gcode.canon import ArcMove, LineMove
from achse.gcode.errors import GcodeError
from achse.gcode.interpretation.interpreter import Interpreter, RunState
from achse.gcode.interpretation.machine_data import MachineData
from achse.gcode.text.program import PartProgram
from achse.gcode.vectors import PathPoint

MOST_POINTS = 10_000
"""Points of a path at most; what comes later is not planned."""

_MOST_LINES = 50_000
"""Lines that run at most: a loop without motion is given up then."""

_LINES_AT_ONCE = 100
_MOVES_AT_ONCE = 32
"""Most moves of one `go_on`: it has its time between two cycles."""

_STEP = radians(6.0)
"""Angle between two points of an arc."""


class PlanState(IntEnum):
    """Progress of the plan."""

    UNFINISHED = 0
    """There is more: call `go_on` again."""
    WHOLE = 1
    """To the end of the program."""
    CUT = 2
    """The program goes on behind the last point, too far to be planned."""
    FAULT = 3
    """At the last point the program has an error."""


class PlannedPoint(NamedTuple):
    """The end of an element of the path, mm; the first point is where the axes are."""

    x: float
    y: float
    z: float
    rapid: bool
    """True if the element that ends here is driven by G00."""
    block: int
    """Counter of its block (`achse.gcode.canon.Origin`), 0 of the first point."""


class PlannedPath:
    """The path of one program from where the axes are. `go_on` until `state` says that it ends."""

    def __init__(
        self,
        program: PartProgram,
        data: MachineData,
        positions: PathPoint,
        auxiliary: tuple[float, ...],
        default_program: PartProgram | None = None,
    ) -> None:
        own = deepcopy(data)
        own.single_block = False
        self.begin = (*positions, *auxiliary)
        """Positions of the axes at the begin, mm."""
        self.points = [PlannedPoint(*positions, rapid=True, block=0)]
        self.state = PlanState.UNFINISHED
        self._run = Interpreter(program, own, positions, auxiliary, default_program)

    def go_on(self) -> None:
        """Plan some blocks more."""
        try:
            self._plan()
        except GcodeError:
            self.state = PlanState.FAULT
        if self.state is PlanState.UNFINISHED and (
            len(self.points) >= MOST_POINTS or self._run.steps >= _MOST_LINES
        ):
            self.state = PlanState.CUT

    def _plan(self) -> None:
        run = self._run
        until = run.steps + _LINES_AT_ONCE
        for _ in range(_MOVES_AT_ONCE):
            command = run.advance(until - run.steps)
            if isinstance(command, LineMove | ArcMove):
                self._apply(command)
            elif command is None and run.state in (RunState.DECODER_STOP, RunState.SINGLE_STOP):
                run.go_ahead(self.points[-1][:3])
            elif command is None and run.state is not RunState.RUNNING:
                self.state = PlanState.WHOLE
                return
            if run.steps >= until:
                return

    def _apply(self, move: LineMove | ArcMove) -> None:
        count = 1 if isinstance(move, LineMove) else max(2, ceil(move.angle / _STEP))
        rapid = isinstance(move, LineMove) and move.rapid
        room = MOST_POINTS - len(self.points)
        for number in range(1, min(count, room) + 1):
            point = move.end if number == count else move.at(number / count)
            if point != self.points[-1][:3]:
                self.points.append(PlannedPoint(*point, rapid, move.origin.counter))
