"""The variables and types of a PLC as a symbol file, for writing a `.tmc`."""

from achse.iec import GlobalVariables, Variable
from achse.iec.describe import types_shown
from achse.iec.variables import Address, Image
from achse.plc.memory import Area
from achse.plc.program import PlacedVariable
from achse.plc.runtime import PlcRuntime
from achse.st.symbolfiles import FileTask, FileVariable, SymbolFile

_LETTERS = {
    Area.INPUT: "I",
    Area.OUTPUT: "Q",
    Area.FLAG: "M",
    Area.RETAIN: "R",
    Area.DATA: "D",
}


def symbol_file(plc: PlcRuntime, name: str = "") -> SymbolFile:
    """Everything that `plc` declares, at its places; `name` is that of the project."""
    numbers = {task: number for number, task in enumerate(plc.tasks)}
    variables = [
        FileVariable(
            placed.name,
            _declared(placed),
            numbers[plc.task_of(unit)],
            isinstance(unit.instance, GlobalVariables),
        )
        for unit in plc.units
        for placed in unit.variables
        if not placed.variable.hidden
    ]
    variables += [FileVariable(placed.name, _declared(placed)) for placed in plc.statics]
    return SymbolFile(
        name or plc.project,
        variables,
        types_shown(item.declared.type for item in variables),
        [FileTask(task.name, task.cycle_ns, task.priority) for task in plc.tasks],
        plc.port,
        plc.pointer_size,
    )


def _declared(placed: PlacedVariable) -> Variable[object, object]:
    variable = placed.variable
    own: Variable[object, object] = variable.copy()
    own.name = placed.name
    own.address = Address(
        _LETTERS[placed.area], "" if placed.bit is None else "X", placed.offset, placed.bit
    )
    if variable.initial is not None:
        own.initial = Image(variable.initial_bytes())
    return own
