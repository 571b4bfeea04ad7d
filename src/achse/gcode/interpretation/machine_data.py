"""Data of a channel beside the program, for the interpreter."""

from dataclasses import dataclass, field

from achse.gcode.geometry.compensation import Bottleneck
from achse.gcode.state.mfunctions import MRules
from achse.gcode.state.offsets import ZeroShifts
from achse.gcode.state.registers import Registers
from achse.gcode.state.tool_table import ToolTable
from achse.gcode.text.program import SubroutineSource


@dataclass
class MachineData:
    """Data of a channel beside the program. Other channels may share and change it."""

    registers: Registers = field(default_factory=Registers)
    shifts: ZeroShifts = field(default_factory=ZeroShifts)
    tools: ToolTable = field(default_factory=ToolTable)
    m_rules: MRules = field(default_factory=dict)
    inch: float = 25.4
    """Factor for G70 (channel parameter 0x12), mm per inch."""
    metric: float = 1.0
    """Factor for G71 (channel parameter 0x13)."""
    bottleneck: Bottleneck = field(default_factory=Bottleneck)
    """Mode and look-ahead (channel parameters 0x50, 0x51); `active` belongs to the program."""
    subroutines: SubroutineSource | None = None
    skip_mask: int = 0
    """Bit n skips blocks that begin with /n."""
    single_block: bool = False
    """Operation mode 0x4000: stop after each block."""
