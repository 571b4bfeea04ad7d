"""Cutter compensation: figures of the facts, distances, what does not fit."""

from itertools import pairwise
from math import cos, hypot, pi, sin
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import NcError
from achse.gcode.canon import ArcMove, BottleneckNotice, LineMove, MFunction
from achse.gcode.errors import GcodeError
from achse.gcode.geometry.compensation import Bottleneck, BottleneckMode
from tests.gcode.programs import commands, ends, moves, refused, with_tool

WITNESSED = "G41 D1 X10 Y10 F600\nX30\nY30\nG2 X40 Y40 I10 J0\nG1 X60\nY20\nG40 X80 Y20"


def test_the_contour_of_the_facts() -> None:
    """LinuxCNC's interpreter with G41.1 gave the same."""
    data = with_tool()
    result = moves(WITNESSED, data)
    assert [(round(x, 4), round(y, 4)) for x, y, _ in (move.end for move in result)] == [
        (8.5858, 11.4142),
        (10.0, 12.0),
        (28.0, 12.0),
        (28.0, 30.0),
        (40.0, 42.0),
        (60.0, 42.0),
        (62.0, 40.0),
        (62.0, 20.0),
        (80.0, 20.0),
    ]
    assert isinstance(result[4], ArcMove)
    assert result[4].radius == pytest.approx(12.0)
    assert result[4].clockwise


def test_left_of_a_line() -> None:
    assert ends("G1 Y-5 F600\nG41 D1 Y0\nX10\nG40 Y5", with_tool())[1:] == [
        (-2.0, 0.0, 0.0),
        (0.0, 2.0, 0.0),
        (10.0, 2.0, 0.0),
        (10.0, 5.0, 0.0),
    ]


def test_before_an_inner_corner_the_selecting_line_ends_beside_the_next() -> None:
    assert ends("G42 D1 X10 F600\nY-10\nX20\nG40 X30", with_tool())[:2] == [
        (8.0, 0.0, 0.0),
        (8.0, -10.0, 0.0),
    ]


def test_a_tangential_joint_needs_no_corner() -> None:
    result = moves("G41 D1 Y0 X-5 F600\nX10\nG3 X20 Y10 I0 J10\nG40 G1 X20 Y20", with_tool())
    assert [type(move) for move in result][-3:] == [LineMove, ArcMove, LineMove]
    assert result[-2].end == pytest.approx((18.0, 10.0, 0.0))


def test_other_commands_keep_their_places() -> None:
    result = commands("G41 D1 X10 F600\nX20 M7\nM8\nZ-1\nY20 M9\nG40 X0", with_tool())
    shown = [
        f"M{each.number}" if isinstance(each, MFunction) else "move"
        for each in result
        if isinstance(each, MFunction | LineMove | ArcMove)
    ]
    assert shown == ["move", "M7", "move", "M8", "move", "M9", "move", "move"]
    assert result[4].end[2] == -1.0  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("mode", "inner", "outer"), [("CFC", 8.0, 12.0), ("CFIN", 8.0, 10.0), ("CFTCP", 10.0, 10.0)]
)
def test_the_feed_on_arcs(mode: str, inner: float, outer: float) -> None:
    """r = 10 mm, cutter 2 mm, F600: 8 mm/s inside, 12 mm/s outside keep 10 mm/s at the contour."""
    for side, expected in (("G41", inner), ("G42", outer)):
        text = f"{mode} {side} D1 X10 F600\nG3 X20 Y10 I0 J10\nG1 Y20\nG40 X30"
        arc = next(move for move in moves(text, with_tool()) if isinstance(move, ArcMove))
        assert arc.velocity == pytest.approx(expected)


def test_a_mirror_changes_the_side() -> None:
    plain = ends("G41 D1 X10 F600\nX20 Y10\nG40 X30", with_tool())
    mirrored = ends("MIRROR Y\nG41 D1 X10 F600\nX20 Y10\nG40 X30", with_tool())
    assert mirrored == [(x, -y + 0.0, z) for x, y, z in plain]


def test_arcs_of_corners_turn_the_short_way() -> None:
    result = moves("G41 D1 X10 F600\nX20\nX10 Y0.0\nG40 Y9", with_tool())
    corner = next(move for move in result if isinstance(move, ArcMove))
    assert corner.angle == pytest.approx(pi)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("G41 X10", NcError.TOOL_COMPENSATION_D_WORD),
        ("G41 D2 X10", NcError.TOOL_COMPENSATION_RADIUS),
        ("G41 D1 Z10", NcError.TOOL_COMPENSATION_GEOMETRY),
        ("G41 D1 G2 X10 I5 J0", NcError.TOOL_COMPENSATION_GEOMETRY),
        ("G41 D1 X10\nG42 X20", NcError.TOOL_COMPENSATION_GEOMETRY),
        ("G41 D1 X10\nG18 X20", NcError.TOOL_COMPENSATION_PLANE_CHANGE),
        ("G41 D1 X10\nD2 X20", NcError.TOOL_COMPENSATION_RADIUS_LOCKED),
        ("G41 D1 X10\n@714", NcError.TOOL_COMPENSATION_GEOMETRY),
        ("G41 D1 X10\nROT Z30\nX20", NcError.TOOL_COMPENSATION_GEOMETRY),
        ("G41 D1 X10\nG2 I5 J0", NcError.TOOL_COMPENSATION_GEOMETRY),
        ("G41 D1 X10\nG3 X12 Y0 I1 J0", NcError.TOOL_COMPENSATION_INNER_CIRCLE),
        ("G41 D1 X10\nCIP X20 I5 J5 K1", NcError.TOOL_COMPENSATION_GEOMETRY),
    ],
)
def test_refusals(text: str, code: NcError) -> None:
    assert refused(f"F600\n{text}", with_tool()).code is code


NARROW = "G42 D1 X0 Y-10 F600\nX20\nY-11\nX21\nY-10\nX40\nG40 Y10"
"""A groove 1 mm wide and deep: too narrow for a cutter of 4 mm on the side of the groove."""


def test_without_detection_there_is_no_search() -> None:
    assert len(moves(NARROW, with_tool())) > 5


def test_detection_refuses() -> None:
    data = with_tool()
    error = refused("CDON\n" + NARROW, data)
    assert error.code is NcError.TOOL_COMPENSATION_BOTTLENECK


def test_detection_reports_and_repairs() -> None:
    data = with_tool()
    data.bottleneck = Bottleneck(mode=BottleneckMode.REPAIR, look_ahead=5)
    result = commands("CDON\n" + NARROW, data)
    notices = [each for each in result if isinstance(each, BottleneckNotice)]
    assert notices
    assert all(each.repaired for each in notices)
    lows = [each.end[1] for each in result if isinstance(each, LineMove | ArcMove)]
    assert min(lows) >= -12.0 - 1e-9


def test_detection_only_reports() -> None:
    data = with_tool()
    data.bottleneck = Bottleneck(mode=BottleneckMode.NOTICE, look_ahead=5)
    result = commands("CDON\n" + NARROW, data)
    assert any(isinstance(each, BottleneckNotice) and not each.repaired for each in result)


def star(draw: Random) -> tuple[list[str], list[tuple[float, float]]]:
    """A closed contour of lines, cut on one side, begun in the middle of a line."""
    count = draw.randint(4, 14)
    corners = []
    for corner in range(count):
        angle = 2.0 * pi * (corner + draw.uniform(-0.3, 0.3)) / count
        far = draw.uniform(20.0, 60.0)
        corners.append((round(far * cos(angle), 3), round(far * sin(angle), 3)))
    if draw.random() < 0.5:
        corners.reverse()
    side = draw.choice(("G41", "G42"))
    (a, b), (c, d) = corners[0], corners[-1]
    x, y = round((a + c) / 2.0, 3), round((b + d) / 2.0, 3)
    way = hypot(a - x, b - y) * (1.0 if side == "G41" else -1.0)
    off = f"X{x - 15.0 * (b - y) / way:.3f} Y{y + 15.0 * (a - x) / way:.3f}"
    lines = [f"G0 {off}", f"G1 F600 {side} D1 X{x} Y{y}"]
    lines += [f"X{u} Y{v}" for u, v in corners]
    return [*lines, f"X{x} Y{y}", f"G40 {off}"], [(x, y), *corners, (x, y)]


def nearest(x: float, y: float, points: list[tuple[float, float]]) -> float:
    """Distance of a point to a polygon."""
    results = []
    for (a, b), (c, d) in pairwise(points):
        u, v = c - a, d - b
        share = min(max(((x - a) * u + (y - b) * v) / (u * u + v * v), 0.0), 1.0)
        results.append(hypot(x - a - share * u, y - b - share * v))
    return min(results)


@pytest.mark.parametrize("mode", [BottleneckMode.ABORT, BottleneckMode.REPAIR])
@given(st.randoms(use_true_random=False), st.floats(0.5, 6.0))
def test_the_cutter_never_gets_into_the_contour(
    mode: BottleneckMode, draw: Random, radius: float
) -> None:
    """With detection that sees the whole contour: either refused, or repaired, or it fits."""
    lines, points = star(draw)
    data = with_tool(round(radius, 2))
    data.bottleneck = Bottleneck(mode=mode, look_ahead=24)
    try:
        result = moves("CDON\n" + "\n".join(lines), data)
    except GcodeError as error:
        code = error.code
    else:
        for move, following in pairwise(result):
            assert move.end == following.start
        for move in result[2:-1]:
            for step in range(11):
                x, y, _ = move.at(step / 10)
                assert nearest(x, y, points) >= round(radius, 2) - 1e-6
        return
    assert mode is BottleneckMode.ABORT
    assert code is NcError.TOOL_COMPENSATION_BOTTLENECK


_TURNED = {
    "G18": str.maketrans("XYZIJK", "ZXYKIJ"),
    "G19": str.maketrans("XYZIJK", "YZXJKI"),
}
_PLACES = {"G18": (2, 0, 1), "G19": (1, 2, 0)}
"""Which axis has what X, Y, Z have in G17."""


@pytest.mark.parametrize("plane", ["G18", "G19"])
@given(
    st.integers(0, 10_000),
    st.booleans(),
    st.floats(0.05, 3.0),
    st.sampled_from(["", "CDON\n"]),
    st.sampled_from(["CFC", "CFIN", "CFTCP"]),
)
def test_all_planes_are_one(
    plane: str, seed: int, left: bool, radius: float, detection: str, feed: str
) -> None:
    """A contour turned into ZX or YZ has the same way of the cutter, turned too."""
    draw = Random(seed)
    lines = [f"{'G41' if left else 'G42'} D1 X10 Y10"]
    x, y = 10.0, 10.0
    for _ in range(draw.randint(2, 9)):
        kind = draw.choice(["G1", "G1", "G2", "G3"])
        x, y = x + draw.uniform(-20, 20), y + draw.uniform(-20, 20)
        if kind == "G1":
            height = f" Z{draw.uniform(-2, 2):.4f}" if draw.random() < 0.3 else ""
            lines.append(f"G1 X{x:.4f} Y{y:.4f}{height}")
        else:
            lines.append(f"{kind} X{x:.4f} Y{y:.4f} B{draw.uniform(15, 40):.4f}")
    text = "\n".join([*lines, "G1 G40 X90 Y95"])

    def of(prefix: str, body: str) -> list[tuple[float, ...]] | NcError:
        try:
            return [
                (*move.end, move.velocity, getattr(move, "angle", 0.0), getattr(move, "rise", 0.0))
                for move in moves(f"{prefix} F600 {feed}\n{detection}{body}", with_tool(radius))
            ]
        except GcodeError as error:
            return error.code

    flat, turned = of("G17", text), of(plane, text.translate(_TURNED[plane]))
    if isinstance(flat, NcError) or isinstance(turned, NcError):
        assert turned == flat
        return
    first, second, third = _PLACES[plane]
    back = [(row[first], row[second], row[third], *row[3:]) for row in turned]
    assert len(back) == len(flat)
    for here, there in zip(back, flat, strict=True):
        assert here == pytest.approx(there, abs=1e-9)


EIGHT = "G41 D1 X10 Y10 F600\nX30 Y30\nY10\nX10 Y30\nX0\nG40 X-20"
"""Its second and fourth line cross, as they are meant to."""


@pytest.mark.parametrize(("look_ahead", "message"), [(1, 0), (3, 0), (6, 1), (24, 1)])
def test_a_contour_that_crosses_itself_is_reported_as_far_as_the_detection_looks(
    look_ahead: int, message: int
) -> None:
    data = with_tool()
    data.bottleneck = Bottleneck(mode=BottleneckMode.NOTICE, look_ahead=look_ahead)
    result = commands("CDON\n" + EIGHT, data)
    assert sum(isinstance(each, BottleneckNotice) for each in result) == message
    ways = [each.end for each in result if isinstance(each, LineMove | ArcMove)]
    assert ways == [move.end for move in moves(EIGHT, with_tool())], "a notice changes nothing"


def test_a_closed_contour_meets_its_begin_without_notice() -> None:
    """A pocket and an island, begun in the middle of a side, whatever the detection sees."""
    for side, corners in (("G41", "X40\nY40\nX0\nY0"), ("G42", "X40\nY40\nX0\nY0")):
        data = with_tool()
        data.bottleneck = Bottleneck(look_ahead=24)
        text = f"CDON\nG1 X20 Y20 F600\n{side} D1 X20 Y0\n{corners}\nX20\nG40 Y{{}}"
        text = text.format(20 if side == "G41" else -20)
        assert moves(text, data)
