"""Modal state: what stays valid from block to block."""

from dataclasses import dataclass, field
from math import isfinite

from achse.codes import NcError
from achse.gcode.canon import PathPlane
from achse.gcode.errors import WordRefused
from achse.gcode.geometry.frame import UNTURNED, WorkFrame, rotation
from achse.gcode.state.offsets import ZeroShifts
from achse.gcode.state.tool_table import ToolTable
from achse.gcode.vectors import PathPoint

MODAL_WORDS = 18
"""Words of channel state 0x13."""
_NO_TOOL = (0.0, 0.0, 0.0)


@dataclass(slots=True)
class ModalState:
    """Begins as a program begins: G01, G17, G40, G53, G71, G90, CFC, FCONST, CDOF, CPCON."""

    motion: int = 1
    """0..3: G00, G01, G02, G03."""
    plane: PathPlane = PathPlane.XY
    infeed: float = 1.0
    """Sign of the tool's length on the infeed axis (P)."""
    cutter: int = 40
    shift: int = 53
    exact_stop: bool = False
    inches: bool = False
    feed_in_inches: bool = False
    incremental: bool = False
    feed_mode: str = "CFC"
    linear_feed: bool = False
    bottleneck: bool = False
    correct_centre: bool = True
    mirror: list[bool] = field(default_factory=lambda: [False, False, False])
    rotation: PathPoint = (0.0, 0.0, 0.0)
    """Angles about X, Y, Z in degrees."""
    tool_data: int = 0
    """D."""
    tool: float = 0.0
    """T."""
    spindle: float = 0.0
    """S."""
    feed: float = 0.0
    """F as programmed, mm/min or inch/min."""
    smoothing: float = 0.0
    """Type of vertex smoothing."""

    def turn(self, angles: list[float], *, further: bool) -> None:
        """Turn by angles about X, Y and Z in degrees; `further`: besides those that hold (AROT)."""
        if further:
            angles = [a + b for a, b in zip(angles, self.rotation, strict=True)]
        if not all(map(isfinite, angles)):
            raise WordRefused(
                NcError.FLOATING_POINT_OPERATION, "the sum of the angles is out of range", "AROT"
            )
        self.rotation = (angles[0], angles[1], angles[2])

    def frame(self, shifts: ZeroShifts, tools: ToolTable) -> WorkFrame:
        """Return the frame of the workpiece with all active shifts, rotations, mirrors and tool
        lengths."""
        total = self.zero_shift(shifts)
        angles = self.rotation
        signs = [-1.0 if mirrored else 1.0 for mirrored in self.mirror]
        offset = _NO_TOOL
        if self.tool_data:
            tool = tools[self.tool_data]
            lengths = list(tool.offset)
            lengths[self.plane.axes[2]] += self.infeed * tool.length
            offset = (lengths[0], lengths[1], lengths[2])
        return WorkFrame(
            total,
            rotation(angles) if any(angles) else UNTURNED,
            (signs[0], signs[1], signs[2]),
            offset,
        )

    def zero_shift(self, shifts: ZeroShifts) -> PathPoint:
        """Sum of the active zero shifts in mm; G53 switches all of them off.

        Behind G53, G58 or G59 switches the programmed shifts on again, without G54..G57.
        """
        if self.shift == 53:
            return (0.0, 0.0, 0.0)
        adjustable, first, second = (
            shifts.adjustable(self.shift) if self.shift < 58 else (0.0, 0.0, 0.0),
            shifts.programmed(58),
            shifts.programmed(59),
        )
        x, y, z = (a + b + c for a, b, c in zip(adjustable, first, second, strict=True))
        return (x, y, z)

    def words(self, skip_mask: int = 0) -> tuple[int, ...]:
        """Return the 18 words of channel state 0x13, one for each modal group.

        The order is not printed; ours: motion, plane, cutter, zero shift, exact stop, unit,
        absolute or incremental, feed mode (0 CFC, 1 CFIN, 2 CFTCP), FLIN, CDON, CPCON, mirrored
        axes as bits, D, T, S, skip mask, type of smoothing, 0.
        """
        plane = {PathPlane.XY: 17, PathPlane.ZX: 18, PathPlane.YZ: 19}[self.plane]
        unit = (700 if self.feed_in_inches else 70) if self.inches else 71
        bits = sum(1 << axis for axis, mirrored in enumerate(self.mirror) if mirrored)
        return (
            self.motion,
            plane,
            self.cutter,
            self.shift,
            60 if self.exact_stop else 0,
            unit,
            91 if self.incremental else 90,
            ("CFC", "CFIN", "CFTCP").index(self.feed_mode),
            int(self.linear_feed),
            int(self.bottleneck),
            int(self.correct_centre),
            bits,
            self.tool_data,
            _word(self.tool),
            _word(self.spindle),
            skip_mask & 0xFFFF,
            int(self.smoothing),
            0,
        )


def _word(value: float) -> int:
    """Return a number as an unsigned word; what does not fit shows its low bits."""
    return int(value) & 0xFFFFFFFF
