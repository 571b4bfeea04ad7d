"""Records of the path planner: elements of the path, junctions ahead, its state. Units: mm, s.

An element is what the path has between two transitions: a line, an arc (helix), a curve that rounds
a corner, a point to wait at. A junction is a transition ahead with what it allows. `AXES` values
belong to X, Y, Z and the auxiliary axes Q1..Q5; the length of a path is measured in X, Y, Z.
"""

from enum import IntEnum

from achse.native.declare import Slot, lay_out, plain_record, within

MAIN_AXES = 3
AXES = 8
"""X, Y, Z, Q1..Q5 (002 §6.4.3: 3 + 5 axes of a group)."""

COEFFICIENTS = 6 * AXES
"""A curve of degree 5 in all axes."""

KNOTS = 33
"""Places of a curve whose way from its beginning is known."""

SPANS = 32
"""Parts of a bent element, each with bounds of its own."""

_NO_AXES = [0.0] * AXES
_NO_SPANS = [0.0] * SPANS


class ElementKind(IntEnum):
    """Kind of an element."""

    LINE = 0
    ARC = 1
    CURVE = 2
    """Rounds a corner: polynomials of a parameter from 0 to 1."""
    WAIT = 3
    """A point with a dwell time; its length is 0."""


class PathPlace:
    """A point of the path with its derivatives by the way along the path."""

    position: list[float] = _NO_AXES
    tangent: list[float] = _NO_AXES
    """First derivative: a unit vector in X, Y, Z."""
    bend: list[float] = _NO_AXES
    """Second derivative, 1/mm."""
    twist: list[float] = _NO_AXES
    """Third derivative, 1/mm²."""


POINT = lay_out("PathPlace", [PathPlace], Slot)


class PathElement:
    """One element of the path."""

    kind: int = 0
    block: int = 0
    """Number of the block that it belongs to; a curve belongs to the block before the corner."""
    block_after: int = 0
    """Of a curve: the block it belongs to in its second half; else as `block`."""
    last: int = 0
    """1: the last element of its segment."""
    stops: int = 0
    """1: exact stop at its end."""
    first: float = 0.0
    """Way along the path where it begins."""
    length: float = 0.0
    whole: float = 0.0
    """Its length before corners were rounded: they take a share of it."""
    wait: float = 0.0
    """Dwell time, s."""
    feed: float = 0.0
    """Programmed velocity at its end, mm/s."""
    start_feed: float = 0.0
    """The same at its beginning; between them it changes evenly with the way."""
    spans: int = 0
    """Parts that have bounds of their own."""
    ends: list[float] = _NO_SPANS
    """Way from the beginning of the element to the end of each."""
    caps: list[float] = _NO_SPANS
    """Velocity that the feed and the limits of the axes allow."""
    starts: list[float] = _NO_SPANS
    """Acceleration along the path from rest; it falls with the square of the velocity."""
    accelerations: list[float] = _NO_SPANS
    """Acceleration along the path at the highest velocity; mm/s²."""
    rests: list[float] = _NO_SPANS
    """Deceleration towards rest; it falls with the square of the velocity too."""
    decelerations: list[float] = _NO_SPANS
    """Deceleration at the highest velocity."""
    powers: list[float] = _NO_SPANS
    """Deceleration times velocity, at most: along a bend it takes jerk of the axes; mm²/s³."""
    first_jerks: list[float] = _NO_SPANS
    """Jerk along the path from rest; it falls with the cube of the velocity."""
    jerks: list[float] = _NO_SPANS
    """Jerk at the highest velocity."""
    path_acceleration: float = 0.0
    """Acceleration along the path as commanded (paramPathDynamics), whatever the axes permit."""
    path_deceleration: float = 0.0
    path_jerk: float = 0.0
    deceleration: float = 0.0
    """The least of all parts."""
    jerk: float = 0.0
    junction: float = 0.0
    """Velocity that the transition at its end allows; of the last element 0."""
    bend_jump: float = 0.0
    """With `keep_jerk`, for the jump of curvature at its end: its share of what may jump in a cycle
    by squared velocity, s²/mm²; else 0."""
    bend_reserve: float = 0.0
    """Part of what may jump in a cycle that is left behind its end."""
    begin: list[float] = _NO_AXES
    end: list[float] = _NO_AXES
    slope: list[float] = _NO_AXES
    """Line: derivative by the way. Arc: that of its straight share (pitch, auxiliary axes)."""
    centre: list[float] = [0.0] * MAIN_AXES
    first_radius: list[float] = [0.0] * MAIN_AXES
    """Arc: from centre to start, the radius long."""
    second_radius: list[float] = [0.0] * MAIN_AXES
    """Arc: a quarter turn further."""
    turn: float = 0.0
    """Arc: angle by way, rad/mm."""
    coefficients: list[float] = [0.0] * COEFFICIENTS
    """Curve: of powers 0..5 of its parameter, 8 axes each."""
    ways: list[float] = [0.0] * KNOTS
    """Curve: way from its beginning at 0, 1/32, …, 1."""


ELEMENT = lay_out("PathElement", [PathElement], Slot)


class PathJunction:
    """A transition ahead, or a place where the bounds change, with the span that leads to it."""

    at: float = 0.0
    """Way in the direction of travel."""
    limit: float = 0.0
    """Velocity allowed there and behind it."""
    safe: float = 0.0
    """Velocity, at acceleration 0, from which all junctions behind it are kept span by span."""
    wanted_limit: float = 0.0
    """As `limit`, with the override."""
    wanted_safe: float = 0.0
    ends: int = 0
    """1: the element ends there."""
    waits: int = 0
    """1: the element is a dwell time."""
    velocity: float = 0.0
    """Wanted velocity of the span before the junction; its bounds follow, as in the element."""
    cap: float = 0.0
    start: float = 0.0
    acceleration: float = 0.0
    rest: float = 0.0
    deceleration: float = 0.0
    power: float = 0.0
    first_jerk: float = 0.0
    jerk: float = 0.0
    most_acceleration: float = 0.0
    """Acceleration along the path as commanded, or that of an emergency stop."""
    most_deceleration: float = 0.0
    most_jerk: float = 0.0


JUNCTION = lay_out("PathJunction", [PathJunction], Slot)


class PathAxis:
    """Limits of an axis."""

    velocity: float = 0.0
    acceleration: float = 0.0
    deceleration: float = 0.0
    jerk: float = 0.0
    jump: float = 0.0
    """Velocity that may jump at a corner (VeloJump): factor times acceleration times cycle time."""
    bend_jump: float = 0.0
    """Acceleration that may jump in a cycle where the curvature jumps, with `keep_jerk`, mm/s²."""


AXIS = lay_out("PathAxis", [PathAxis], Slot)


class PathState:
    """State of the path: its place, its commands, and the values of the cycle."""

    # elements count from 0 on, element n is in row n % rows
    oldest: int = 0
    """First element that is still there: as far as the path can go back."""
    current: int = 0
    following: int = 0
    """The element that comes next when one is appended."""
    history: int = 0
    """Elements that stay behind the current one."""
    table: int = 0
    """Segments that may wait or be under way."""
    appended: int = 0
    """Segments since the beginning."""
    passed_segments: int = 0
    """Segments that ended since the beginning; less again when the path goes back."""

    # motion
    way: float = 0.0
    velocity: float = 0.0
    """In the direction of travel; never negative."""
    acceleration: float = 0.0
    backwards: int = 0
    waiting: float = 0.0
    """Remaining dwell time."""
    arrived: int = 0
    """1: at rest at the end of the path."""

    # commands
    hold: int = 0
    """1: come to rest (feed hold, stop)."""
    stop_deceleration: float = 0.0
    """Emergency stop: its dynamics; 0 those of the path."""
    stop_jerk: float = 0.0
    barrier: int = -1
    """Single block: the path stops at the end of this element; -1 none."""
    override: float = 1.0
    override_type: int = 0
    most_override: float = 1.0

    # parameters of segments that are appended from now on
    path_acceleration: float = 0.0
    path_deceleration: float = 0.0
    path_jerk: float = 0.0
    method: int = 0
    c0: float = 0.0
    c1: float = 1.0
    c2: float = 1.0
    angle_low: float = 0.0
    angle_high: float = 0.0
    least_velocity: float = 0.0
    keep_jerk: int = 0
    smoothing: int = 0
    smoothing_subtype: int = 0
    smoothing_radius: float = 0.0
    cycle_time: float = 0.0
    axis_count: int = 0
    """Number of axes."""

    # junctions ahead
    junctions: int = 0
    junction: int = 0
    """The next junction."""
    fresh: int = 0
    """1: the junctions are those of the elements."""
    slower: int = 0
    """1: somewhere less is wanted than the junctions allow."""

    # the stopping trajectory: a ramp that leads to a junction in time, and the safe velocity there
    out: int = 0
    """0 none (at rest), 1 it keeps what the junctions allow, 2 also what is wanted there."""
    out_begin: float = 0.0
    """Begin of the ramp, in the direction of travel, with velocity and acceleration there."""
    out_velocity: float = 0.0
    out_acceleration: float = 0.0
    out_speed: float = 0.0
    """Velocity at its end."""
    out_deceleration: float = 0.0
    out_jerk: float = 0.0
    out_time: float = 0.0
    """Time for which it has been followed, s."""
    out_duration: float = 0.0
    out_at: float = 0.0
    """The junction that it leads to."""
    lost_cycles: int = 0
    """Number of times that there was none in motion: 0 if the bounds are right."""

    # results
    point: PathPlace = within(POINT)
    before: PathPlace = within(POINT)
    after: PathPlace = within(POINT)
    axis_velocity: list[float] = _NO_AXES
    axis_acceleration: list[float] = _NO_AXES


STATE = lay_out("PathState", [PathState], Slot)

axis_record = plain_record(AXIS)
junction_record = plain_record(JUNCTION)
element_record = plain_record(ELEMENT)
state_record = plain_record(STATE)
