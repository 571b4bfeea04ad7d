"""The words of the dialect as rows: G codes, named words, @ commands, #set parameters.

Source: tcnci and tf5100 (classic dialect), general command overview and @-command overview. Rows
marked "from memory" are not in the material of this project.
"""

from dataclasses import dataclass
from enum import Enum

from achse.gcode.canon import PathParameter


class ModalGroup(Enum):
    """Words of one group exclude each other in a block."""

    MOTION = "motion"
    DWELL = "dwell"
    PLANE = "plane"
    CUTTER = "cutter compensation"
    SHIFT = "zero shift"
    PROGRAMMED_SHIFT = "programmed zero shift"
    EXACT_STOP = "exact stop"
    UNIT = "unit"
    DISTANCE = "absolute or incremental"
    HOMING = "homing"
    FEED_MODE = "feed at the contour"
    FEED_FORM = "feed over the segment"
    BOTTLENECK = "bottleneck detection"
    CENTRE = "centre point correction"
    ROTATION = "rotation"
    MIRROR = "mirror"
    DELETE_DISTANCE = "delete distance to go"
    DYNAMICS = "dynamics"
    ANGLE = "angle of a contour line"


@dataclass(frozen=True, slots=True)
class GWord:
    """One G code or named word."""

    name: str
    group: ModalGroup
    meaning: str
    alone: bool = False
    """True if only its own operands may be beside it in the block."""
    number: int = -1
    """Of a G code; -1 for a named word."""


def _g(number: int, group: ModalGroup, meaning: str, alone: bool = False) -> GWord:
    return GWord(f"G{number:02d}", group, meaning, alone, number)


_G_ROWS = (
    _g(0, ModalGroup.MOTION, "rapid traverse"),
    _g(1, ModalGroup.MOTION, "straight line"),
    _g(2, ModalGroup.MOTION, "clockwise arc or helix"),
    _g(3, ModalGroup.MOTION, "counter-clockwise arc or helix"),
    _g(4, ModalGroup.DWELL, "dwell, in seconds", alone=True),
    _g(8, ModalGroup.EXACT_STOP, "exact stop off, from memory"),
    _g(9, ModalGroup.EXACT_STOP, "exact stop in this block"),
    _g(17, ModalGroup.PLANE, "plane XY"),
    _g(18, ModalGroup.PLANE, "plane ZX"),
    _g(19, ModalGroup.PLANE, "plane YZ"),
    _g(40, ModalGroup.CUTTER, "cutter compensation off"),
    _g(41, ModalGroup.CUTTER, "cutter left of the contour"),
    _g(42, ModalGroup.CUTTER, "cutter right of the contour"),
    _g(53, ModalGroup.SHIFT, "all zero shifts off"),
    _g(54, ModalGroup.SHIFT, "first adjustable zero shift", alone=True),
    _g(55, ModalGroup.SHIFT, "second adjustable zero shift", alone=True),
    _g(56, ModalGroup.SHIFT, "third adjustable zero shift", alone=True),
    _g(57, ModalGroup.SHIFT, "fourth adjustable zero shift", alone=True),
    _g(58, ModalGroup.PROGRAMMED_SHIFT, "first programmed zero shift", alone=True),
    _g(59, ModalGroup.PROGRAMMED_SHIFT, "second programmed zero shift", alone=True),
    _g(60, ModalGroup.EXACT_STOP, "exact stop in each block"),
    _g(70, ModalGroup.UNIT, "positions in inches"),
    _g(71, ModalGroup.UNIT, "positions in mm"),
    _g(74, ModalGroup.HOMING, "homing of one axis", alone=True),
    _g(90, ModalGroup.DISTANCE, "absolute positions"),
    _g(91, ModalGroup.DISTANCE, "incremental positions"),
    _g(700, ModalGroup.UNIT, "positions and feed in inches"),
    _g(710, ModalGroup.UNIT, "positions and feed in mm"),
)

G_WORDS: dict[int, GWord] = {row.number: row for row in _G_ROWS}
"""By number."""

_NAMED_ROWS = (
    GWord("CIP", ModalGroup.MOTION, "arc through three points in space"),
    GWord("ROT", ModalGroup.ROTATION, "rotation, absolute", alone=True),
    GWord("AROT", ModalGroup.ROTATION, "rotation, additive", alone=True),
    GWord("MIRROR", ModalGroup.MIRROR, "mirror the named axes", alone=True),
    GWord("CDON", ModalGroup.BOTTLENECK, "bottleneck detection on"),
    GWord("CDOF", ModalGroup.BOTTLENECK, "bottleneck detection off"),
    GWord("CFC", ModalGroup.FEED_MODE, "feed constant at the contour"),
    GWord("CFIN", ModalGroup.FEED_MODE, "feed reduced inside arcs only"),
    GWord("CFTCP", ModalGroup.FEED_MODE, "feed constant at the tool's centre"),
    GWord("CPCON", ModalGroup.CENTRE, "centre point correction on"),
    GWord("CPCOF", ModalGroup.CENTRE, "centre point correction off"),
    GWord("DELDTG", ModalGroup.DELETE_DISTANCE, "function 0x40 may end this block"),
    GWord("FCONST", ModalGroup.FEED_FORM, "constant feed"),
    GWord("FLIN", ModalGroup.FEED_FORM, "feed changes linearly over the segment"),
    GWord("DYNOVR", ModalGroup.DYNAMICS, "factor on the dynamics of the axes"),
    GWord("ANG", ModalGroup.ANGLE, "angle of a contour line, degrees"),
)

NAMED_WORDS: dict[str, GWord] = {row.name: row for row in _NAMED_ROWS}
"""By name; DYNOVR and ANG take a value, the others none."""

ADDRESSES = {
    **dict.fromkeys("XYZ", "position"),
    **dict.fromkeys("IJK", "centre of an arc; third point of CIP"),
    **dict.fromkeys("BU", "radius of an arc"),
    "F": "feed",
    "S": "spindle",
    "T": "tool",
    "H": "auxiliary function",
    "D": "tool data",
    "P": "direction of the infeed axis; repetitions of a subroutine",
    "L": "subroutine",
}
"""Letters that take one value in a block; N, G, M, R and Q have rules of their own."""


class AtForm(Enum):
    """The operands of an @ command."""

    SAVE_LIST = "Kn, then n parameters to save"
    SAVE_RANGE = "Rn Rm"
    RESTORE_LIST = "Kn, then n parameters to load"
    RESTORE_RANGE = "Rm Rn, the last saved first"
    JUMP = "K±n or Rn"
    CASE = "Rn, then pairs of value and K block"
    JUMP_IF = "Rn, value, K block"
    LOOP_IF = "Rn, value, K block behind the loop"
    STOP = "nothing"
    ONE = "Rn: result"
    TWO = "Rn: result, value"
    THREE = "Rn: result, two values"


@dataclass(frozen=True, slots=True)
class AtCommand:
    """One @ command."""

    number: int
    form: AtForm
    meaning: str
    relation: str = ""
    """Relation of the two values required for a jump, or to stay in a loop; the operation in
    arithmetic."""


_JUMPS = (
    (121, "!="), (122, "=="), (123, "<="), (124, "<"), (125, ">="), (126, ">"),
)  # fmt: skip
_LOOPS = ((0, "=="), (1, "!="), (2, ">"), (3, ">="), (4, "<"), (5, "<="))

_AT_ROWS = (
    AtCommand(40, AtForm.SAVE_LIST, "save parameters"),
    AtCommand(41, AtForm.SAVE_RANGE, "save a range of parameters"),
    AtCommand(42, AtForm.RESTORE_LIST, "restore parameters"),
    AtCommand(43, AtForm.RESTORE_RANGE, "restore a range of parameters"),
    AtCommand(100, AtForm.JUMP, "jump"),
    AtCommand(111, AtForm.CASE, "jump by case"),
    *(
        AtCommand(number, AtForm.JUMP_IF, f"jump if {relation}", relation)
        for number, relation in _JUMPS
    ),
    *(
        AtCommand(131 + each, AtForm.LOOP_IF, f"loop while {relation}", relation)
        for each, relation in _LOOPS
    ),
    *(
        AtCommand(141 + each, AtForm.LOOP_IF, f"repeat until {relation}", relation)
        for each, relation in _LOOPS
    ),
    AtCommand(151, AtForm.LOOP_IF, "for, upwards", "<="),
    AtCommand(161, AtForm.LOOP_IF, "for, downwards", ">="),
    AtCommand(200, AtForm.ONE, "clear a parameter, from memory", "clear"),
    AtCommand(202, AtForm.TWO, "swap two parameters, from memory", "swap"),
    AtCommand(610, AtForm.TWO, "absolute value, from memory", "ABS"),
    AtCommand(613, AtForm.TWO, "square root, from memory", "SQRT"),
    AtCommand(614, AtForm.THREE, "root of the sum of squares, from memory", "hypot"),
    AtCommand(620, AtForm.ONE, "add 1", "+"),
    AtCommand(621, AtForm.ONE, "subtract 1, from memory", "-"),
    AtCommand(622, AtForm.ONE, "integer part, from memory", "INT"),
    AtCommand(630, AtForm.TWO, "sine, from memory", "SIN"),
    AtCommand(631, AtForm.TWO, "cosine, from memory", "COS"),
    AtCommand(632, AtForm.TWO, "tangent, from memory", "TAN"),
    AtCommand(634, AtForm.TWO, "arc sine, from memory", "ASIN"),
    AtCommand(635, AtForm.TWO, "arc cosine, from memory", "ACOS"),
    AtCommand(636, AtForm.TWO, "arc tangent, from memory", "ATAN"),
    AtCommand(714, AtForm.STOP, "decoder stop", "empty"),
    AtCommand(716, AtForm.STOP, "decoder stop, then positions are read again", "rescan"),
    AtCommand(717, AtForm.STOP, "decoder stop until function 0x30", "external"),
)

AT_COMMANDS: dict[int, AtCommand] = {row.number: row for row in _AT_ROWS}
"""By number."""


@dataclass(frozen=True, slots=True)
class PathParameterRow:
    """A parameter of `#set …#`: its name, what it sets and the ranges of its values."""

    name: str
    parameter: PathParameter
    ranges: tuple[tuple[float, float], ...]
    """Least and greatest of each value."""


_ANY = (0.0, float("inf"))
_SHARE = (0.0, 1.0)
_DEGREES = (0.0, 180.0)

_PATH_ROWS = (
    PathParameterRow(
        "paramVertexSmoothing", PathParameter.VERTEX_SMOOTHING, ((0, 5), (0, 3), _ANY)
    ),
    PathParameterRow("paramSplineSmoothing", PathParameter.SPLINE_SMOOTHING, (_ANY,)),
    PathParameterRow("paramC1ReductionFactor", PathParameter.C1_REDUCTION_FACTOR, (_SHARE,)),
    PathParameterRow("paramC2ReductionFactor", PathParameter.C2_REDUCTION_FACTOR, (_SHARE,)),
    PathParameterRow("paramVeloJump", PathParameter.VELO_JUMP, (_ANY, _ANY, _ANY)),
    PathParameterRow("paramDevAngle", PathParameter.DEVIATION_ANGLE, (_SHARE, _DEGREES, _DEGREES)),
    PathParameterRow("paramPathDynamics", PathParameter.PATH_DYNAMICS, (_ANY, _ANY, _ANY)),
    PathParameterRow(
        "paramGroupDynamics", PathParameter.GROUP_DYNAMICS, ((1, 255), _ANY, _ANY, _ANY)
    ),
    PathParameterRow("paramVeloMin", PathParameter.MINIMUM_VELOCITY, (_ANY,)),
)

PATH_PARAMETERS: dict[str, PathParameterRow] = {row.name.upper(): row for row in _PATH_ROWS}
"""By name in upper case."""
