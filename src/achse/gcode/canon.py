"""Canonical commands: what an interpreted part program commands the channel that runs it.

The interpreter yields these in the order in which they have to happen. All lengths are in mm and
all velocities in mm/s. Positions are those of the axes: zero shifts, rotation, mirror, tool length
and cutter radius are in them already. Who carries them out plans the path, waits where a command
says so, and confirms handshakes; nothing in here knows how.
"""

from dataclasses import dataclass
from enum import Enum, IntEnum
from math import hypot
from typing import TypeAlias

from achse.gcode.vectors import PathPoint, turned

AUXILIARY_AXES = 5
"""Q1..Q5 beside X, Y, Z. Source: tcnci, auxiliary axes."""


@dataclass(frozen=True, slots=True)
class Origin:
    """Place in the program that a command comes from. All commands of one block share one
    origin."""

    program: str
    """Name of the file or of the subroutine's file; empty for a text without one."""
    line: int
    """Line in the file, from 1."""
    index: int
    """Text index: offset of the block's first byte in the file (channel state 0x10, 0x11)."""
    block: int
    """Number of the N word, 0 without one (cyclic structure, `block no`)."""
    counter: int
    """Number of blocks run up to this one, loops counted each time (block search by counter)."""


class PathPlane(Enum):
    """A main plane: its two axes in the order that makes the third one point to the viewer."""

    XY = (0, 1, 2)
    ZX = (2, 0, 1)
    YZ = (1, 2, 0)

    @property
    def axes(self) -> tuple[int, int, int]:
        """Indices of first axis, second axis and infeed axis; 0 is X."""
        return self.value


@dataclass(frozen=True, slots=True)
class LineMove:
    """A straight line of X, Y, Z; auxiliary axes go along in proportion to the path.

    With `start == end` only auxiliary axes move, or nothing does (a virtual movement).
    """

    origin: Origin
    start: PathPoint
    """Position of the program before the move; the first move of a program begins at the start
    positions."""
    end: PathPoint
    auxiliary: tuple[float, ...]
    """Positions of Q1..Q5 at the end, mm or the axis' own unit. Always five."""
    velocity: float
    """Path velocity in mm/s at the end; 0 when `rapid` (or when no F was programmed)."""
    start_velocity: float
    """Path velocity at the start: equal to `velocity` with FCONST, the last F with FLIN."""
    rapid: bool = False
    """True for G00: as fast as the rapid traverse of the axes allows."""
    exact_stop: bool = False
    """True for G09 or G60: the path velocity is 0 at the end, and nothing is smoothed there."""
    delete_distance: bool = False
    """True for DelDTG: function 0x40 ends this move at its present position."""

    @property
    def length(self) -> float:
        """Length of the path in mm, X, Y, Z only."""
        (x, y, z), (u, v, w) = self.start, self.end
        return hypot(u - x, v - y, w - z)

    def at(self, share: float) -> PathPoint:
        """Return the point after this share of the path, 0..1."""
        (x, y, z), (u, v, w) = self.start, self.end
        return (x + share * (u - x), y + share * (v - y), z + share * (w - z))


@dataclass(frozen=True, slots=True)
class ArcMove:
    """An arc, a full circle or a helix, in any plane.

    The point turns about `centre` by `angle`, counter-clockwise when seen from the tip of `normal`
    (right-hand rule); meanwhile it rises evenly by `rise` along `normal`. `centre` is at the height
    of the start. Turning the start gives the end to 1e-9 mm, unless numbers themselves are coarser.
    """

    origin: Origin
    start: PathPoint
    end: PathPoint
    centre: PathPoint
    normal: PathPoint
    """Unit vector. Clockwise arcs have the opposite normal of counter-clockwise ones."""
    angle: float
    """Angle turned, in rad, greater than 0; 2π is a full circle."""
    rise: float
    """Way along `normal` in mm: 0 for an arc, with sign for a helix."""
    auxiliary: tuple[float, ...]
    velocity: float
    start_velocity: float
    rapid: bool = False
    """Always False: G00 makes lines only."""
    exact_stop: bool = False
    delete_distance: bool = False

    @property
    def radius(self) -> float:
        """Distance of start and centre, mm."""
        (x, y, z), (u, v, w) = self.start, self.centre
        return hypot(x - u, y - v, z - w)

    @property
    def length(self) -> float:
        """Length of the path in mm, a helix measured along itself."""
        return hypot(self.radius * self.angle, self.rise)

    @property
    def plane(self) -> PathPlane | None:
        """The main plane that the arc is in, whatever its direction; None in space."""
        for plane in PathPlane:
            first, second, _ = plane.axes
            if self.normal[first] == 0.0 and self.normal[second] == 0.0:
                return plane
        return None

    @property
    def clockwise(self) -> bool:
        """True if the arc is clockwise (G02) in its main plane. False in space."""
        plane = self.plane
        return plane is not None and self.normal[plane.axes[2]] < 0.0

    def at(self, share: float) -> PathPoint:
        """Return the point after this share of the path, 0..1."""
        return turned(self.start, self.centre, self.normal, share * self.angle, share * self.rise)


@dataclass(frozen=True, slots=True)
class DwellTime:
    """G04: the path rests for this time after all before is done."""

    origin: Origin
    seconds: float


class Handshake(IntEnum):
    """Time at which an M function waits for the PLC, if at all."""

    NONE = 0
    BEFORE_MOVE = 1
    AFTER_MOVE = 2


@dataclass(frozen=True, slots=True)
class MFunction:
    """An M function, placed before or after the move of its block as its rule says.

    With `handshake` other than NONE: the path stops here, number and request go to the PLC, and
    nothing behind this command moves until the PLC grants it. With `fast`: set its bit in the mask
    when the path gets here. `clears` names fast M functions whose bits go out at the same moment.
    """

    origin: Origin
    number: int
    """0..159."""
    handshake: Handshake = Handshake.NONE
    fast: bool = False
    clears: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class FastMReset:
    """Clear these fast M functions when the path gets here: automatic reset at the block's end."""

    origin: Origin
    numbers: tuple[int, ...]


class Technology(Enum):
    """Words that only go to the cyclic structure of the channel."""

    SPINDLE = "S"
    TOOL = "T"
    AUXILIARY = "H"


@dataclass(frozen=True, slots=True)
class TechnologyWord:
    """S, T or H: goes to the cyclic structure when the path gets here."""

    origin: Origin
    word: Technology
    value: float
    """S in rpm as programmed, T the tool's number, H a signed number."""


class PathParameter(Enum):
    """Parameter of a `PathSetting`; each value names its numbers in order."""

    VERTEX_SMOOTHING = "type 0..5, subtype 0..3, radius mm; type or radius 0 is off"
    SPLINE_SMOOTHING = "radius mm"
    C1_REDUCTION_FACTOR = "factor 0..1 where the curvature jumps"
    C2_REDUCTION_FACTOR = "factor 0..1 where the curvature goes on evenly"
    VELO_JUMP = "factors of X, Y, Z"
    DEVIATION_ANGLE = "factor C0 0..1, low and high critical angle in degrees"
    PATH_DYNAMICS = "acceleration mm/s², deceleration mm/s², jerk mm/s³"
    GROUP_DYNAMICS = "group, acceleration mm/s², deceleration mm/s², jerk mm/s³"
    MINIMUM_VELOCITY = "mm/s at transitions"
    DYNAMIC_OVERRIDE = "0 < factor <= 1 on acceleration and jerk of the axes"
    SKIP_VIRTUAL_MOVEMENTS = "how many moves of length 0 in a row are skipped"


@dataclass(frozen=True, slots=True)
class PathSetting:
    """`#set …#`, `#skip …#` or DYNOVR: valid for the moves behind it, until a reset."""

    origin: Origin
    parameter: PathParameter
    values: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class HomeAxis:
    """G74: home one axis. A decoder stop that reads the positions again follows it."""

    origin: Origin
    axis: int
    """0 X, 1 Y, 2 Z, 3..7 Q1..Q5."""


class StopKind(Enum):
    """Condition that releases a decoder stop."""

    EMPTY = "@714: nothing is left to do: all before is carried out"
    RESCAN = "@716, G74: the same, then the positions of the axes are read again"
    EXTERNAL = "@717: the same, and function 0x30 (go ahead) came"
    READ_POSITIONS = "#get PathAxesPos#: the same, then the positions go to R parameters"


@dataclass(frozen=True, slots=True)
class DecoderStop:
    """The interpreter waits: carry out all before, then call `Interpreter.go_ahead`."""

    origin: Origin
    kind: StopKind


@dataclass(frozen=True, slots=True)
class ProgramStop:
    """Single block in the interpreter, or a found block: it waits for `Interpreter.go_ahead`."""

    origin: Origin


@dataclass(frozen=True, slots=True)
class ProgramMessage:
    """`#MSG(…)#`: a text for the operator, given out when the path gets here."""

    origin: Origin
    text: str


@dataclass(frozen=True, slots=True)
class BottleneckNotice:
    """The contour is damaged by the cutter (channel parameter 0x50 is 1 or 2); it goes on."""

    origin: Origin
    repaired: bool
    """True if the elements that do not fit were left out."""


@dataclass(frozen=True, slots=True)
class ProgramEnd:
    """M02, M30 or the end of the text. It is the last command."""

    origin: Origin
    clear_fast: bool
    """True for M30: clear all fast M functions, and S, T, H."""


Moving: TypeAlias = LineMove | ArcMove

Canonical: TypeAlias = (
    LineMove
    | ArcMove
    | DwellTime
    | MFunction
    | FastMReset
    | TechnologyWord
    | PathSetting
    | HomeAxis
    | DecoderStop
    | ProgramStop
    | ProgramMessage
    | BottleneckNotice
    | ProgramEnd
)
"""Everything that the interpreter yields."""
