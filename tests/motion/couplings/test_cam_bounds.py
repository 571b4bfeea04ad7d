"""When a change of a cam is due, what it then is, and how far a slave may jump: each bound."""

from array import array
from math import inf, nextafter
from types import SimpleNamespace
from typing import Any

import pytest

from achse.codes.axis import StateBit
from achse.motion import AxisParameters, Nc
from achse.motion.couplings import cams
from achse.motion.couplings.cams import (
    CHANGE_BEGIN,
    CHANGE_EXCHANGE,
    CHANGE_NOTHING,
    CHANGE_POINTS,
    CHANGE_REMOVE,
    CHANGE_SCALING,
    check_jump,
    due,
    jump_of,
    law_after,
    law_now,
    part_at,
    show_waiting,
)
from achse.motion.record import CAM, CAM_LAW, LAYOUT
from achse.motion.rows import NcRows
from achse.motion.setpoints.limits import TOLERANCE
from achse.motion.states import CamActivation, CamScaling
from achse.motion.tables.memory import BEGIN, COUNT, CYCLIC, HEADER, PERIOD, SPAN, STROKE
from achse.native.declare import pack

FIRST = 8
SECOND = FIRST + HEADER + 2 * SPAN
"""Where the cams are in memory."""

LEAD = 7.0
"""What the master's own positions are larger than those that slaves see."""

OFFSET, SCALING = 8.0, 2.0
"""Place of a cam position: OFFSET + SCALING · position."""


def rows(*, cyclic: bool) -> NcRows:
    """Cams from 10 to 110 and from 20 to 220; they rise by 1/2 in straight lines."""
    numbers = array("d", [0.0] * (SECOND + HEADER + 2 * SPAN))
    for field, value in ((COUNT, 2.0), (BEGIN, 10.0), (PERIOD, 100.0), (STROKE, 50.0)):
        numbers[FIRST + field] = value
    numbers[FIRST + CYCLIC] = float(cyclic)
    lines = array("d", [10.0, 0.0, 0.5, 0.0, 0.0, 110.0, 50.0, 0.0, 0.0, 0.0])
    numbers[FIRST + HEADER : SECOND] = lines
    for field, value in ((COUNT, 2.0), (BEGIN, 20.0), (PERIOD, 200.0), (STROKE, 100.0)):
        numbers[SECOND + field] = value
    numbers[SECOND + CYCLIC] = float(cyclic)
    lines = array("d", [20.0, 0.0, 0.5, 0.0, 0.0, 220.0, 100.0, 0.0, 0.0, 0.0])
    numbers[SECOND + HEADER :] = lines
    master: Any = LAYOUT.plain()
    master.leading_value.offset = LEAD
    return NcRows([master], (), (), (), numbers)


def layer(kind: int = CHANGE_EXCHANGE, when: int = 0, place: float = 0.0) -> Any:
    """A cam at work that waits for another, with these offsets and scalings now or then."""
    it: Any = CAM.plain()
    it.change.kind, it.change.when, it.change.position = kind, when, place
    if kind == CHANGE_BEGIN:
        it.next.cam, it.next.master_offset, it.next.master_scaling = FIRST, OFFSET + LEAD, SCALING
        it.now.master_reference, it.now.master_scaling = 1e3, 9.0
    else:
        it.now.table = 1
        it.now.cam, it.now.master_reference, it.now.master_offset = FIRST, 5.0, OFFSET - 5.0
        it.now.master_scaling, it.next.master_offset = SCALING, 1e3
    return it


@pytest.mark.parametrize("kind", [CHANGE_BEGIN, CHANGE_EXCHANGE])
@pytest.mark.parametrize(
    ("before", "now", "over", "forward", "backward"),
    [
        (-1.0, 1.0, 1, 1, 0),
        (1.0, -1.0, 1, 0, 1),
        (0.0, 0.0, 1, 0, 0),
        (0.0, 1.0, 1, 1, 0),
        (-1.0, 0.0, 1, 1, 0),
        (0.0, -1.0, 1, 0, 1),
        (1.0, 0.0, 1, 0, 1),
        (-2.0, -1.0, 0, 0, 0),
        (1.0, 2.0, 0, 0, 0),
        (-1.0, -2.0, 0, 0, 0),
        (2.0, 1.0, 0, 0, 0),
    ],
)
def test_change_at_a_master_position_is_due_on_the_way_over_it(
    kind: int, before: float, now: float, over: int, forward: int, backward: int
) -> None:
    """Ways are counted from the place, which is one of the master's own positions."""
    place = 100.0 - LEAD
    for when, expected in (
        (CamActivation.MASTER_AXIS_POSITION, over),
        (CamActivation.MASTER_AXIS_POSITION_POSITIVE, forward),
        (CamActivation.MASTER_AXIS_POSITION_NEGATIVE, backward),
    ):
        result = due(rows(cyclic=True), layer(kind, when, 100.0), place + before, place + now)
        assert result == (expected, place)


def test_change_at_once_or_never_is_due_where_the_master_was() -> None:
    for when, expected in (
        (CamActivation.INSTANTANEOUS, 1),
        (CamActivation.AS_SOON_AS_POSSIBLE, 1),
        (CamActivation.OFF, 0),
    ):
        assert due(rows(cyclic=True), layer(when=when), 3.0, 4.0) == (expected, 3.0)


AT_CAM, NEXT = CamActivation.MASTER_CAM_POSITION, CamActivation.NEXT_CYCLE


@pytest.mark.parametrize("kind", [CHANGE_BEGIN, CHANGE_EXCHANGE])
@pytest.mark.parametrize(
    ("cyclic", "when", "start", "end", "expected"),
    [
        (True, AT_CAM, 35.0, 45.0, (1, 40.0)),
        (True, AT_CAM, 35.0, 40.0, (1, 40.0)),
        (True, AT_CAM, 35.0, 39.0, (0, 40.0)),
        (True, AT_CAM, 41.0, 139.0, (0, 140.0)),
        (True, AT_CAM, 41.0, 140.0, (1, 140.0)),
        (True, AT_CAM, 45.0, 40.0, (1, 40.0)),
        (True, AT_CAM, 45.0, 41.0, (0, 40.0)),
        (True, AT_CAM, 39.0, -60.0, (1, -60.0)),
        (True, AT_CAM, 40.0, 45.0, None),
        (True, AT_CAM, 40.0, 39.0, None),
        (True, NEXT, 5.0, 10.0, (1, 10.0)),
        (True, NEXT, 5.0, 9.0, (0, 10.0)),
        (True, NEXT, 15.0, 112.0, (1, 110.0)),
        (True, NEXT, 15.0, 9.0, (1, 10.0)),
        (True, NEXT, 110.0, 112.0, None),
        (False, AT_CAM, 35.0, 45.0, (1, 40.0)),
        (False, AT_CAM, 40.0, 45.0, (1, 40.0)),
        (False, AT_CAM, 45.0, 40.0, (1, 40.0)),
        (False, AT_CAM, 41.0, 145.0, (0, 40.0)),
        (False, NEXT, 9.0, 20.0, (1, 9.0)),
        (False, NEXT, 111.0, 20.0, (1, 111.0)),
        (False, NEXT, 10.0, 9.0, (1, 10.0)),
        (False, NEXT, 10.0, 20.0, (0, 10.0)),
        (False, NEXT, 20.0, 10.0, (0, 10.0)),
        (False, NEXT, 20.0, 110.0, (0, 10.0)),
        (False, NEXT, 110.0, 111.0, (1, 110.0)),
    ],
)
def test_change_at_a_place_of_the_cam_is_due_on_the_way_over_it(
    kind: int,
    cyclic: bool,
    when: CamActivation,
    start: float,
    end: float,
    expected: tuple[int, float] | None,
) -> None:
    """Cam positions; None: a cam may begin where its master is, one at work waits a cycle."""
    result = due(
        rows(cyclic=cyclic),
        layer(kind, when, 40.0),
        OFFSET + SCALING * start,
        OFFSET + SCALING * end,
    )
    if expected is not None:
        assert result == (expected[0], OFFSET + SCALING * expected[1])
    elif kind == CHANGE_BEGIN:
        assert result == (1, OFFSET + SCALING * start)
    else:
        assert result[0] == 0


@pytest.mark.parametrize("place", [-35.0, 10.0, 60.0, 95.0])
@pytest.mark.parametrize("cycle", [-2, 0, 3])
def test_cyclic_cam_begins_where_its_master_stands(place: float, cycle: int) -> None:
    at = OFFSET + SCALING * (place + 100.0 * cycle)
    for way in (0.0, 1.0, -1.0):
        assert due(rows(cyclic=True), layer(CHANGE_BEGIN, AT_CAM, place), at, at + way) == (1, at)


def test_cam_that_begins_unscaled_lies_at_the_positions_of_its_master() -> None:
    it = layer(CHANGE_BEGIN, AT_CAM, 40.0)
    it.change.master_type = CamScaling.OFF
    assert due(rows(cyclic=False), it, 40.0 - LEAD, 41.0 - LEAD) == (1, 40.0 - LEAD)
    assert due(rows(cyclic=False), it, 41.0 - LEAD, 42.0 - LEAD) == (0, 40.0 - LEAD)


@pytest.mark.parametrize(
    ("cyclic", "once", "position", "cycle", "value"),
    [
        (True, 0, 10.0, 0, 0.0),
        (True, 0, nextafter(110.0, 0.0), 0, 50.0),
        (True, 0, 110.0, 1, 50.0),
        (True, 0, nextafter(10.0, 0.0), -1, 0.0),
        (True, 0, 235.0, 2, 112.5),
        (True, 0, -50.0, -1, -30.0),
        (False, 0, 235.0, 0, 50.0),
        (False, 0, -5.0, 0, 0.0),
        (True, 1, 235.0, None, 50.0),
        (True, 1, -5.0, None, 0.0),
    ],
)
@pytest.mark.parametrize("base", [0, 1])
@pytest.mark.parametrize("before", [0, 1, -7])
def test_part_of_a_cam_counts_its_cycles(
    cyclic: bool,
    once: int,
    position: float,
    cycle: int | None,
    value: float,
    base: int,
    before: int,
) -> None:
    """A correction stays in the cycle in which it began."""
    if not cyclic:
        base = before = 0
    it = layer()
    it.once, it.now.base_cycle, it.cycle = once, base, before
    it.now.slave_reference, it.now.slave_offset, it.now.slave_scaling = 3.0, 4.0, 2.0
    if once:
        position += 100.0 * base
    part, slope, _, _, strokes = part_at(rows(cyclic=cyclic), it, position)
    lift = 0.0 if once else -50.0 * base
    assert part == pytest.approx(7.0 + 2.0 * (value + lift), abs=1e-9)
    assert part == 7.0 + 2.0 * (it.value + strokes)
    assert it.cycle == (before if cycle is None else cycle)
    assert (slope == 0.5) == (10.0 <= it.cam_position < 110.0)


@pytest.fixture(scope="module")
def slave() -> Any:
    return Nc(2_000_000, [AxisParameters(1)]).axis(1)


def test_slave_may_jump_within_its_position_window(slave: Any) -> None:
    for window, position in ((0.0, 0.0), (5.0, 0.0), (5.0, -4e9)):
        slave.position_range_window, slave.set_position = window, position
        most = window + TOLERANCE + 1e-12 * abs(position)
        for sign in (1.0, -1.0):
            assert check_jump(slave, sign * most) == 0
            assert check_jump(slave, sign * nextafter(most, inf)) != 0


@pytest.mark.parametrize(
    ("kinds", "bits"),
    [
        ((CHANGE_NOTHING, CHANGE_NOTHING), 0),
        ((CHANGE_SCALING, CHANGE_NOTHING), StateBit.CAM_SCALING_PENDING),
        ((CHANGE_NOTHING, CHANGE_POINTS), StateBit.CAM_DATA_QUEUED),
        ((CHANGE_BEGIN, CHANGE_NOTHING), StateBit.CAM_TABLE_QUEUED),
        ((CHANGE_NOTHING, CHANGE_EXCHANGE), StateBit.CAM_TABLE_QUEUED),
        ((CHANGE_REMOVE, CHANGE_NOTHING), StateBit.CAM_TABLE_QUEUED),
        (
            (CHANGE_SCALING, CHANGE_REMOVE),
            StateBit.CAM_SCALING_PENDING | StateBit.CAM_TABLE_QUEUED,
        ),
        ((CHANGE_SCALING, CHANGE_POINTS), StateBit.CAM_SCALING_PENDING | StateBit.CAM_DATA_QUEUED),
    ],
)
def test_status_shows_what_waits(slave: Any, kinds: tuple[int, int], bits: int) -> None:
    slave.camming.count = 2
    slave.camming.status = slave.camming.changes = 1
    for each, kind in zip(slave.cams, (*kinds, CHANGE_BEGIN), strict=False):
        each.change.kind = kind
    show_waiting(slave)
    assert (slave.camming.status, slave.camming.changes) == (bits, int(bits != 0))


def test_law_of_all_cams_but_one() -> None:
    """Two of them are at work; the slave has a phase shift beside its first master."""
    both, first, second = rows(cyclic=True), layer(), layer()
    master: Any = both.axes[0]
    (
        master.leading_value.position,
        master.leading_value.velocity,
        master.leading_value.acceleration,
    ) = 88.0, 6.0, 4.0
    second.now.slave_reference, second.now.slave_offset, second.now.slave_scaling = 3.0, 4.0, 2.0
    unused = layer()
    unused.now.table = 0
    ax: Any = SimpleNamespace(
        coupling=SimpleNamespace(law=1, masters=[0], slave_base=1.0),
        camming=SimpleNamespace(count=3), cams=[first, second, unused, layer()],
        phasing=SimpleNamespace(position=0.0, velocity=0.0, acceleration=0.0),
    )  # fmt: skip
    # cam position 40: 15, with a slope of 1/2 by the cam, 1/4 by the master
    laws = {"first": (15.0, 1.5, 1.0), "second": (7.0 + 30.0, 3.0, 2.0)}
    one, other = laws["first"], laws["second"]
    assert law_now(ax, both, 1) == (1.0 + one[0], one[1], one[2])
    assert law_now(ax, both, 0) == (1.0 + other[0], other[1], other[2])
    together = (1.0 + one[0] + other[0], one[1] + other[1], one[2] + other[2])
    assert law_now(ax, both, -1) == together


USER, AUTO, OFF = CamScaling.USER_DEFINED, CamScaling.AUTO_OFFSET, CamScaling.OFF


@pytest.mark.parametrize(
    ("kind", "master", "slave_type", "absolute", "cam", "scaling", "expected"),
    [
        (CHANGE_SCALING, AUTO, USER, (0, 0), 0, 4.0, (5.0, -77.0, 4.0, 0, 3.0, 1.0, 3.0, 49.0)),
        (CHANGE_SCALING, USER, OFF, (0, 0), 0, 1.0, (5.0, 15.0, 1.0, 0, 3.0, 4.0, 2.0, 65.0)),
        (CHANGE_SCALING, OFF, AUTO, (0, 0), 0, 9.0, (5.0, 3.0, 2.0, 0, 3.0, -11.0, 3.0, 37.0)),
        (
            *(CHANGE_EXCHANGE, USER, USER, (1, 0), SECOND, 2.0),
            (-LEAD, 15.0, 2.0, 0, 6.0, 1.0, 3.0, 37.0),
        ),
        (
            *(CHANGE_EXCHANGE, AUTO, USER, (1, 0), SECOND, 2.0),
            (5.0, -77.0, 2.0, 0, -54.0, 1.0, 3.0, 37.0),
        ),
        (
            *(CHANGE_EXCHANGE, USER, USER, (0, 1), SECOND, -0.0625),
            (88.0, 15.0, -0.0625, 1, 0.0, 1.0, 3.0, 31.0),
        ),
        (
            *(CHANGE_EXCHANGE, USER, AUTO, (1, 1), SECOND, 2.0),
            (-LEAD, 15.0, 2.0, 0, 0.0, 7.0, 3.0, 37.0),
        ),
        (
            *(CHANGE_EXCHANGE, USER, AUTO, (1, 0), SECOND, 2.0),
            (-LEAD, 15.0, 2.0, 0, 6.0, 1.0, 3.0, 37.0),
        ),
        (CHANGE_POINTS, OFF, OFF, (0, 0), SECOND, 9.0, (5.0, 3.0, 2.0, 0, 3.0, 4.0, 2.0, 27.0)),
        (CHANGE_BEGIN, OFF, OFF, (1, 0), FIRST, 9.0, (-LEAD, 0.0, 1.0, 0, -42.5, 0.0, 1.0, 0.0)),
        (CHANGE_BEGIN, OFF, USER, (0, 1), FIRST, 9.0, (88.0, 0.0, 1.0, -1, 0.0, 1.0, 3.0, 136.0)),
        (CHANGE_BEGIN, OFF, AUTO, (1, 1), FIRST, 9.0, (-LEAD, 0.0, 1.0, 0, 0.0, -107.5, 3.0, 20.0)),
    ],
)
def test_change_makes_references_offsets_and_scalings(
    kind: int,
    master: CamScaling,
    slave_type: CamScaling,
    absolute: tuple[int, int],
    cam: int,
    scaling: float,
    expected: tuple[float, ...],
) -> None:
    """At 88 the cam at work is at 40 and adds 37; the slave is at 20."""
    it = layer(CHANGE_NOTHING)
    it.change.kind, it.next.cam, it.next.table = kind, cam, 2
    it.now.table = int(kind != CHANGE_BEGIN)
    it.now.slave_reference, it.now.slave_offset, it.now.slave_scaling = 3.0, 4.0, 2.0
    it.change.master_type, it.change.slave_type = master, slave_type
    it.next.master_offset, it.next.master_scaling = 15.0, scaling
    it.next.slave_offset, it.next.slave_scaling = 1.0, 3.0
    it.next.master_absolute, it.next.slave_absolute = absolute
    ax: Any = SimpleNamespace(
        set=SimpleNamespace(position=20.0), camming=SimpleNamespace(count=1), cams=[it],
        coupling=SimpleNamespace(law=1, masters=[0], slave_base=20.0),
        phasing=SimpleNamespace(position=0.0, velocity=0.0, acceleration=0.0),
    )  # fmt: skip
    both = rows(cyclic=True)
    lead: Any = both.axes[0].leading_value
    lead.position, lead.velocity, lead.acceleration = 89.0, 6.0, 4.0
    before, after = pack(CAM, it), CAM_LAW.plain()
    assert cams.planned(ax, both, it, 88.0, after) == expected[-1]
    values = [after.master_reference, after.master_offset, after.master_scaling, after.base_cycle]
    values += [after.slave_reference, after.slave_offset, after.slave_scaling]
    assert tuple(values) == expected[:-1]
    assert pack(CAM, it) == before
    jump = expected[-1] - (37.0 if it.now.table else 20.0 if absolute[1] else 0.0)
    assert jump_of(ax, both, it, 88.0) == jump
    foreseen = law_after(ax, both, 0, it, 88.0)
    cams.change(ax, both, it, 88.0)
    assert law_now(ax, both, -1) == pytest.approx(foreseen, abs=1e-9)


def test_cam_that_begins_beside_others_stays_where_nothing_is_added() -> None:
    it, other = layer(CHANGE_BEGIN), layer()
    it.change.slave_type, it.next.slave_absolute, it.next.slave_scaling = AUTO, 1, 3.0
    ax: Any = SimpleNamespace(
        set=SimpleNamespace(position=20.0), camming=SimpleNamespace(count=2), cams=[it, other]
    )
    assert cams.planned(ax, rows(cyclic=True), it, 88.0, CAM_LAW.plain()) == 0.0
    assert jump_of(ax, rows(cyclic=True), it, 88.0) == 0.0


def test_cam_that_goes_makes_no_jump() -> None:
    it = layer(CHANGE_REMOVE)
    assert jump_of(SimpleNamespace(), rows(cyclic=True), it, 50.0) == 0.0  # type: ignore[arg-type]


@pytest.mark.parametrize(("superposed", "at_work"), [(10.0, 4.0), (40.0, 2.0), (-100.0, 2.0)])
def test_change_waits_while_it_would_lead_beyond_a_soft_limit(
    superposed: float, at_work: float
) -> None:
    """The limits, -50 and 60, are those of the set position with what is superposed."""
    nc = Nc(2_000_000, [AxisParameters(1)])
    ax = nc.axis(1)
    both, it = rows(cyclic=True), layer(CHANGE_SCALING)
    it.now.slave_offset, it.next.slave_scaling = 2.0, 1.0
    it.now.slave_scaling, it.next.master_scaling, it.change.master_type = 1.0, SCALING, OFF
    lead: Any = both.axes[0].leading_value
    lead.position = it.last_master_position = OFFSET + SCALING * 70.0
    ax.cams[0], ax.camming.count, ax.set.position = it, 1, 32.0
    ax.coupling.offset, ax.max_velocity, ax.drive.reference_velocity = superposed, 1e4, 1e4
    ax.limits.active, ax.limits.low, ax.limits.high = 1, -50.0, 60.0
    it.next.slave_offset = 4.0 if superposed > 0.0 else 0.0
    cams.carry_out(ax, both, 0.002)
    assert it.now.slave_offset == at_work


def test_cycles_of_a_cam_are_counted_up_to_1e15() -> None:
    assert cams._cycle_of(rows(cyclic=True), FIRST, 1e300) == 10**15
    assert cams._cycle_of(rows(cyclic=True), FIRST, -1e300) == -(10**15)
    assert cams._cycle_of(rows(cyclic=False), FIRST, 1e300) == 0
