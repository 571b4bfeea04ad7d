"""`#set …#` and `#skip …#`: values that the path keeps, checked by their rows."""

from achse.codes import NcError
from achse.gcode.canon import Origin, PathParameter, PathSetting
from achse.gcode.errors import WordRefused
from achse.gcode.state.registers import Registers
from achse.gcode.text.blocks import HashCall
from achse.gcode.text.formula import TermKind
from achse.gcode.text.words import PATH_PARAMETERS

_MAIN_AXES = 3


def refused_call(call: HashCall, message: str) -> WordRefused:
    """Return the refusal of a command in # #."""
    return WordRefused(NcError.PROGRAM_SYNTAX_RUNNING, message, call.name)


def path_setting(call: HashCall, registers: Registers, origin: Origin) -> PathSetting:
    """Return the setting of `#set name(…)#` or `#skip VirtualMovements(n)#`, its values in
    range."""
    values = tuple(each.evaluate(registers) for each in call.arguments)
    if call.verb == "SKIP":
        if call.name != "VIRTUALMOVEMENTS" or len(values) != 1 or values[0] < 0.0:
            raise refused_call(call, "expected #skip VirtualMovements(n)#")
        return PathSetting(origin, PathParameter.SKIP_VIRTUAL_MOVEMENTS, values)
    row = PATH_PARAMETERS.get(call.name)
    if row is None:
        raise refused_call(call, "this parameter is unknown")
    if len(values) != len(row.ranges) or not all(
        low <= value <= high for value, (low, high) in zip(values, row.ranges, strict=True)
    ):
        raise refused_call(call, f"expected {row.parameter.value}")
    return PathSetting(origin, row.parameter, values)


def position_registers(call: HashCall, registers: Registers) -> tuple[int, ...]:
    """Return the R parameters of `#get PathAxesPos(R1;R2;R3)#`, which take positions of X, Y and
    Z."""
    numbers = []
    for each in call.arguments:
        term = each.first
        if each.rest or term.kind is not TermKind.REGISTER or not isinstance(term.value, float):
            raise refused_call(call, "expected R parameters")
        numbers.append(int(term.value))
    if call.name != "PATHAXESPOS" or len(numbers) != _MAIN_AXES:
        raise refused_call(call, "expected #get PathAxesPos(R1;R2;R3)#")
    for number in numbers:
        _ = registers[number]
    return tuple(numbers)
