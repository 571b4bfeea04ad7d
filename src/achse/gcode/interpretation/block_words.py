"""BlockWords: what the words of a block do: modal words, tools, technology and motion."""

from collections.abc import Iterator

from achse.codes import NcError
from achse.gcode.canon import (
    Canonical,
    DwellTime,
    Origin,
    PathParameter,
    PathSetting,
    Technology,
    TechnologyWord,
)
from achse.gcode.errors import WordRefused
from achse.gcode.geometry.compensation import Bottleneck
from achse.gcode.geometry.frame import WorkFrame, rotation
from achse.gcode.interpretation.machine_data import MachineData
from achse.gcode.interpretation.moves import AXIS_LETTERS, MotionWords, PathMaker
from achse.gcode.interpretation.preparation import Preparation
from achse.gcode.state.modal import ModalState
from achse.gcode.state.registers import Registers
from achse.gcode.state.tool_table import TOOL_PLACES
from achse.gcode.text.blocks import ProgramBlock, RotationCall, WordValue
from achse.gcode.text.formula import Arithmetical

_LENGTHS = frozenset(("X", "Y", "Z", "I", "J", "K", "B", "U"))


class BlockWords:
    """Changes the modal state by the words of a block, and yields the commands of its moves."""

    def __init__(
        self, data: MachineData, modal: ModalState, path: PathMaker, bottleneck: Bottleneck
    ) -> None:
        self.data = data
        self.modal = modal
        self.path = path
        self._bottleneck = bottleneck

    def values(self, block: ProgramBlock, prepared: Preparation) -> dict[str, float | None]:
        """Return the values of the block's words in mm; feeds and angles as they are."""
        registers = self.data.registers
        values: dict[str, float | None] = {}
        inches = self.modal.inches if prepared.inches is None else prepared.inches
        factor = self.factor(inches)
        for name, value in block.values.items():
            number = self._number(value, registers)
            if number is not None and name in _LENGTHS and prepared.lengths:
                number *= factor
            values[name] = number
        return values

    def factor(self, inches: bool | None = None) -> float:
        """mm for one programmed unit."""
        return (
            self.data.inch
            if (self.modal.inches if inches is None else inches)
            else self.data.metric
        )

    @staticmethod
    def _number(value: WordValue, registers: Registers) -> float | None:
        return value.evaluate(registers) if isinstance(value, Arithmetical) else value

    def modal_words(
        self, prepared: Preparation, values: dict[str, float | None], origin: Origin
    ) -> Iterator[Canonical]:
        modal, path = self.modal, self.path
        if prepared.plane is not None and prepared.plane is not modal.plane:
            if path.compensation is not None:
                raise WordRefused(
                    NcError.TOOL_COMPENSATION_PLANE_CHANGE,
                    "the plane cannot change while G41 or G42 is active",
                )
            modal.plane = prepared.plane
        if prepared.plane is not None:
            sign = values.get("P")
            if sign is not None and abs(sign) != 1.0:
                raise WordRefused(NcError.PROGRAM_SYNTAX_RUNNING, "expected P1 or P-1", "P")
            modal.infeed = 1.0 if sign is None else sign
        prepared.apply(modal)
        self._bottleneck.active = modal.bottleneck
        if prepared.rotation is not None:
            angles = [values.get(name) or 0.0 for name in AXIS_LETTERS]
            modal.turn(angles, further=prepared.rotation == "AROT")
        if prepared.mirror:
            modal.mirror[:] = [name in values for name in AXIS_LETTERS]
        if prepared.programmed_shift:
            self._programmed_shift(prepared.programmed_shift, values)
        self._tool_data(values)
        feed = values.get("F")
        if feed is not None and not prepared.dwell:
            if feed <= 0.0:
                raise WordRefused(
                    NcError.NCI_VELOCITY_NOT_POSITIVE, "expected a feed greater than 0", "F"
                )
            modal.feed = feed
        path.set_frame(modal.frame(self.data.shifts, self.data.tools))
        if prepared.cutter is not None:
            yield from self._cutter(prepared.cutter)
        if prepared.dynamics:
            value = values["DYNOVR"]
            if value is None or not 0.0 < value <= 1.0:
                raise WordRefused(
                    NcError.PROGRAM_SYNTAX_RUNNING, "expected 0 < DYNOVR <= 1", "DYNOVR"
                )
            yield from path.other(PathSetting(origin, PathParameter.DYNAMIC_OVERRIDE, (value,)))

    def _programmed_shift(self, number: int, values: dict[str, float | None]) -> None:
        if self.modal.shift == 53:
            self.modal.shift = number
        for axis, name in enumerate(AXIS_LETTERS):
            value = values.get(name)
            if value is not None:
                self.data.shifts.program(number, axis, value)

    def _tool_data(self, values: dict[str, float | None]) -> None:
        value = values.get("D")
        if value is None or value == self.modal.tool_data:
            return
        if value != int(value) or not 0.0 <= value <= TOOL_PLACES:
            raise WordRefused(NcError.PROGRAM_SYNTAX_RUNNING, f"expected D0 to D{TOOL_PLACES}", "D")
        if self.path.compensation is not None:
            raise WordRefused(
                NcError.TOOL_COMPENSATION_RADIUS_LOCKED,
                "the tool cannot change while G41 or G42 is active",
                "D",
            )
        self.modal.tool_data = int(value)

    def _cutter(self, code: int) -> Iterator[Canonical]:
        modal, path = self.modal, self.path
        if code == 40:
            yield from path.end_compensation()
        elif code != modal.cutter:
            if path.compensation is not None:
                raise WordRefused(
                    NcError.TOOL_COMPENSATION_GEOMETRY,
                    "a G40 is needed between G41 and G42",
                    f"G{code}",
                )
            if not modal.tool_data:
                raise WordRefused(
                    NcError.TOOL_COMPENSATION_D_WORD, "G41 and G42 need a tool (D)", f"G{code}"
                )
            radius = self.data.tools[modal.tool_data].radius
            if radius <= 0.0:
                raise WordRefused(
                    NcError.TOOL_COMPENSATION_RADIUS,
                    f"tool D{modal.tool_data} has radius {radius:g} mm",
                    f"G{code}",
                )
            # the mirror turns left to right by itself: elements are those of the workpiece
            path.start_compensation(radius, left=code == 41)
        modal.cutter = code

    def technology(self, values: dict[str, float | None], origin: Origin) -> Iterator[Canonical]:
        for word in Technology:
            value = values.get(word.value)
            if value is None:
                continue
            if word is Technology.SPINDLE:
                self.modal.spindle = value
            elif word is Technology.TOOL:
                self.modal.tool = value
            yield from self.path.other(TechnologyWord(origin, word, value))

    def motion(
        self, prepared: Preparation, values: dict[str, float | None], origin: Origin
    ) -> Iterator[Canonical]:
        if prepared.dwell:
            times = [values[name] for name in ("X", "F") if values.get(name) is not None]
            if len(times) != 1 or times[0] is None or not 0.0 <= times[0] <= 1e9:
                raise WordRefused(
                    NcError.PROGRAM_SYNTAX_RUNNING, "expected G04 with X or F: seconds >= 0", "G04"
                )
            yield from self.path.other(DwellTime(origin, times[0]))
        elif prepared.positions:
            words = MotionWords(
                values,
                prepared.in_space,
                self.modal.exact_stop or prepared.exact_stop,
                prepared.delete_distance,
            )
            if words.moves:
                yield from self.path.move(origin, words, self.velocity())
            elif prepared.in_space or "ANG" in values:
                raise WordRefused(
                    NcError.PROGRAM_SYNTAX_RUNNING, "expected positions of axes in this block"
                )

    def velocity(self) -> float:
        """F in mm/s."""
        factor = self.data.inch if self.modal.feed_in_inches else 1.0
        return self.modal.feed * factor / 60.0

    def calculate(self, call: RotationCall) -> None:
        """Apply the active rotation to a point in R parameters (CalcRot, CalcInvRot)."""
        registers = self.data.registers
        x, y, z = (registers[number] for number in call.registers)
        matrix = rotation(self.modal.rotation)
        frame = WorkFrame(turn=matrix)
        point = frame.to_work((x, y, z)) if call.inverse else frame.turned((x, y, z))
        for number, value in zip(call.registers, point, strict=True):
            registers[number] = value
