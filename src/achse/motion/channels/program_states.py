"""ProgramStates: what a channel with an interpreter shows; ProgramChannel changes it."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from achse.gcode.canon import Origin
from achse.gcode.interpretation.interpreter import Interpreter
from achse.gcode.interpretation.machine_data import MachineData
from achse.gcode.interpretation.search import SearchResult
from achse.gcode.state.registers import Registers
from achse.gcode.text.program import PartProgram
from achse.motion.channels.channel import NcChannel
from achse.motion.channels.feeder import Feeder
from achse.motion.channels.files import ChannelFiles
from achse.motion.channels.parameters import ChannelParameters
from achse.motion.channels.planned_path import PlannedPath
from achse.motion.channels.program_fault import PlaceKind, ProgramFault, StoppedPlace
from achse.motion.channels.states import TRANSITIONS, InterpreterEvent, InterpreterState
from achse.motion.channels.waits import WAITS, WaitReason
from achse.motion.groups.group import AxisGroup
from achse.motion.groups.path_group import PathGroup


class ProgramStates(NcChannel):
    """A channel with the states of its interpreter and of the program that is loaded."""

    def __init__(
        self,
        parameters: ChannelParameters,
        groups: Iterable[AxisGroup],
        shared_registers: list[float] | None = None,
    ) -> None:
        super().__init__(parameters, groups)
        self.group = next((g for g in self.groups if isinstance(g, PathGroup)), None)
        self.data = MachineData(
            registers=Registers(shared_registers), m_rules=dict(parameters.m_rules)
        )
        self.files = ChannelFiles(self.channel_id, self.data, parameters.store)
        self.state = InterpreterState.IDLE
        self.waiting: WaitReason | None = WaitReason.LOAD
        """Reason why no blocks are interpreted; None while they are."""
        self.program: PartProgram | None = None
        self.interpreter: Interpreter | None = None
        self.feeder: Feeder | None = None
        self.search_result: SearchResult | None = None
        self.fault: ProgramFault | None = None
        """The fault that ended the program, until a start or reset."""
        self.default_g_code = 0
        self.trace_mode = self.feeder_log_enable = 0
        self.plans = 0
        """Counts up with each other planned path."""
        self._file: Path | None = None
        self._began_at: tuple[float, ...] = ()
        """Positions as the program began."""
        self._planned_path: PlannedPath | None = None

    def happens(self, event: InterpreterEvent) -> None:
        """Change the state as the table of transitions says; nothing without a row."""
        self.state = TRANSITIONS.get((self.state, event), self.state)

    def wait(self, reason: WaitReason) -> None:
        """Wait for something; the state shows it. Nothing changes while it waits for it already."""
        if self.waiting is reason:
            return
        self.waiting = reason
        begins = WAITS[reason].begins
        if begins is not None:
            self.happens(begins)

    def end_wait(self) -> None:
        """Go on with blocks, or with the next wait of the table."""
        if self.waiting is None:
            return
        row, self.waiting = WAITS[self.waiting], None
        if row.ends is not None:
            self.happens(row.ends)
        if row.then is not None:
            self.wait(row.then)

    @property
    def program_name(self) -> str:
        """Name of the loaded program."""
        return "" if self.program is None else self.program.name

    def line_at(self, index: int) -> str:
        """Return the line of the loaded program at a text index; empty behind the end."""
        program = self.program
        if program is None or not 0 <= index < len(program.text):
            return ""
        return program.original(program.line_of(index))

    @property
    def path_origin(self) -> Origin | None:
        """The block that the path is on, or at which the program waits or has failed."""
        if self.search_result is not None and self.state is InterpreterState.SEARCHING:
            return self.search_result.origin
        if self.feeder is not None:
            return self.feeder.origin
        return None if self.fault is None else self.fault.origin

    @property
    def place(self) -> StoppedPlace | None:
        """The found block at which the program waits, or the block at fault; None elsewhere."""
        result, fault = self.search_result, self.fault
        if result is not None and self.state is InterpreterState.SEARCHING:
            return StoppedPlace(PlaceKind.FOUND, result.origin, result.position)
        return None if fault is None else StoppedPlace(PlaceKind.FAULT, fault.origin, fault.stopped)

    @property
    def path_index(self) -> int:
        """Text index of `path_origin`."""
        origin = self.path_origin
        return 0 if origin is None else origin.index

    @property
    def interpreter_index(self) -> int:
        """Text index of the block that was interpreted last."""
        return 0 if self.interpreter is None else self.interpreter.origin.index

    @property
    def block_number(self) -> int:
        """N word of `path_origin`."""
        origin = self.path_origin
        return 0 if origin is None else origin.block

    @property
    def block_counter(self) -> int:
        """Blocks that were interpreted since the start."""
        return 0 if self.interpreter is None else self.interpreter.blocks

    @property
    def path_block(self) -> int:
        """Counter of the block that the path is on; 0 before it moves."""
        origin = None if self.feeder is None else self.feeder.origin
        return 0 if origin is None else origin.counter

    def planned_path(self) -> PlannedPath | None:
        """Return the path that the loaded program takes, or took; None without a program.

        Before the start it begins where the axes are, and changes with R parameters at a start.
        """
        group, program = self.group, self.program
        if group is None or program is None:
            return None
        if self.state is InterpreterState.READY:
            if self._planned_path is not None and self._planned_path.begin != group.positions:
                self._planned_path = None
            begin = group.positions
        else:
            begin = self._began_at or group.positions
        if self._planned_path is None:
            x, y, z, *auxiliary = begin
            data = replace(self.data, subroutines=self.files.store.subroutines(self._file))
            default = self.files.default_program() if self.default_g_code else None
            self.plans += 1
            self._planned_path = PlannedPath(program, data, (x, y, z), tuple(auxiliary), default)
        return self._planned_path
