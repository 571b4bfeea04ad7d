"""Data of a machine: each channel has its own unless it is shared on purpose."""

from achse.gcode.interpretation.machine_data import MachineData
from achse.gcode.state.registers import Registers


def test_nothing_is_shared_by_default() -> None:
    first, second = MachineData(), MachineData()
    first.registers[900] = 1.0
    first.tools[1][2] = 5.0
    first.shifts.program(58, 0, 1.0)
    assert second.registers[900] == 0.0
    assert 1 not in second.tools
    assert second.shifts.programmed(58) == (0.0, 0.0, 0.0)
    assert second.inch == 25.4


def test_registers_are_shared_by_their_upper_hundred() -> None:
    first = MachineData()
    second = MachineData(registers=Registers(first.registers.shared))
    first.registers[950] = 3.0
    assert second.registers[950] == 3.0
