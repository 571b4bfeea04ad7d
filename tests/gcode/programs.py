"""Part programs that tests run, and short forms of what comes out."""

from achse.codes import NcError
from achse.gcode.canon import ArcMove, Canonical, LineMove
from achse.gcode.errors import GcodeError
from achse.gcode.interpretation.interpreter import Interpreter, RunState
from achse.gcode.interpretation.machine_data import MachineData
from achse.gcode.state.tool_table import ToolParameter
from achse.gcode.text.program import PartProgram
from achse.gcode.vectors import PathPoint


def commands(text: str, data: MachineData | None = None) -> list[Canonical]:
    """All commands of a program that ends by itself."""
    interpreter = Interpreter(PartProgram(text, "part.nc"), data)
    results = list(interpreter)
    assert interpreter.state is RunState.ENDED
    return results


def moves(text: str, data: MachineData | None = None) -> list[LineMove | ArcMove]:
    """Its moves only."""
    return [each for each in commands(text, data) if isinstance(each, LineMove | ArcMove)]


def ends(text: str, data: MachineData | None = None) -> list[PathPoint]:
    """Where its moves end, to a nanometre."""
    return [
        (round(x, 6) + 0.0, round(y, 6) + 0.0, round(z, 6) + 0.0)
        for x, y, z in (move.end for move in moves(text, data))
    ]


def refused(text: str, data: MachineData | None = None) -> GcodeError:
    """The error at which a program stops."""
    interpreter = Interpreter(PartProgram(text, "part.nc"), data)
    try:
        for _ in range(2000):
            if interpreter.advance() is None and interpreter.state is not RunState.RUNNING:
                break
    except GcodeError as error:
        if interpreter.state is RunState.FAILED and error.code in NcError:
            return error
    raise AssertionError(f"not refused: {interpreter.state}")


def with_tool(radius: float = 2.0, length: float = 0.0) -> MachineData:
    """A machine whose tool 1 is an end mill."""
    data = MachineData()
    tool = data.tools[1]
    tool[ToolParameter.TYPE] = 20
    tool[ToolParameter.RADIUS] = radius
    tool[ToolParameter.LENGTH] = length
    return data
