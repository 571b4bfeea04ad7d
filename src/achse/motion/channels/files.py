"""Files of a channel: tools, zero shifts, snapshots, the default program (002 §6.4.2.3)."""

import json
from collections.abc import Callable
from copy import deepcopy
from math import isfinite

from achse.codes import NcError
from achse.gcode.interpretation.machine_data import MachineData
from achse.gcode.state.offsets import ShiftFileError
from achse.gcode.state.registers import OWN_REGISTERS
from achse.gcode.state.tool_table import ToolFileError
from achse.gcode.text.program import PartProgram
from achse.motion.channels.store import ProgramStore
from achse.motion.checks import OK

_REGISTERS, _SHIFTS, _TOOLS = 1, 2, 4
SNAPSHOT_PARTS = _REGISTERS | _SHIFTS | _TOOLS
"""Bits of a snapshot's mask."""


class ChannelFiles:
    """Saves and loads what a channel has beside its program."""

    def __init__(self, channel_id: int, data: MachineData, store: ProgramStore | None) -> None:
        self._id = channel_id
        self._data = data
        self.store = store or ProgramStore()

    def save_shifts(self) -> int:
        """Zero shifts into `<id>.zero` (0x20)."""
        return self.store.save(f"{self._id}.zero", self._data.shifts.text())

    def load_shifts(self) -> int:
        """Zero shifts from their file (0x21); 0x4110 without one."""
        return self._load(f"{self._id}.zero", self._data.shifts.read)

    def save_tools(self) -> int:
        """Tools into `<id>.wz` (0x22)."""
        return self.store.save(f"{self._id}.wz", self._data.tools.text())

    def load_tools(self) -> int:
        """Tools from their file (0x23); 0x4110 without one."""
        return self._load(f"{self._id}.wz", self._data.tools.read)

    def _load(self, name: str, read: Callable[[str], None]) -> int:
        text = self.store.read(name)
        if text is None:
            return NcError.PROGRAM_OPEN
        try:
            read(text)
        except (ShiftFileError, ToolFileError):
            return NcError.LOADING_PARAMETER
        return OK

    def save_snapshot(self, name: str, mask: int) -> int:
        """R parameters (1), zero shifts (2), tools (4) into a file (0x24)."""
        if not _is_name(name) or mask & ~SNAPSHOT_PARTS:
            return NcError.CHANNEL_START_PARAMETER
        parts: dict[str, object] = {}
        if mask & _REGISTERS:
            parts["registers"] = self._data.registers.own
        if mask & _SHIFTS:
            parts["shifts"] = self._data.shifts.text()
        if mask & _TOOLS:
            parts["tools"] = self._data.tools.text()
        return self.store.save(name, json.dumps(parts))

    def load_snapshot(self, name: str, mask: int) -> int:
        """Return the parts that the mask names, from a file (0x25); all or nothing."""
        if not _is_name(name) or mask & ~SNAPSHOT_PARTS:
            return NcError.CHANNEL_START_PARAMETER
        text = self.store.read(name)
        if text is None:
            return NcError.PROGRAM_OPEN
        try:
            parts = json.loads(text)
            registers = [float(each) for each in parts.get("registers", ())]
            if registers and len(registers) != OWN_REGISTERS:
                return NcError.LOADING_PARAMETER
            if not all(map(isfinite, registers)):
                return NcError.LOADING_PARAMETER
            if mask & _TOOLS and "tools" in parts:
                deepcopy(self._data.tools).read(parts["tools"])  # refused before anything changes
            if mask & _SHIFTS and "shifts" in parts:
                self._data.shifts.read(parts["shifts"])
            if mask & _TOOLS and "tools" in parts:
                self._data.tools.read(parts["tools"])
        except (ValueError, TypeError, AttributeError):
            return NcError.LOADING_PARAMETER
        if mask & _REGISTERS and registers:
            self._data.registers.own[:] = registers
        return OK

    def default_program(self) -> PartProgram | None:
        """`DefaultGCode<id>.def`, which runs before each program; None if there is none."""
        name = f"DefaultGCode{self._id}.def"
        text = self.store.read(name)
        return None if text is None else PartProgram(text, name)


def _is_name(name: str) -> bool:
    """Return True if it is a plain file name."""
    return bool(name) and not set(name) & set('/\\:*?"<>|') and name not in (".", "..")
