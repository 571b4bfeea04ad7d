"""A coupling that is refused, or a change of one, leaves every record byte for byte as it was."""

from collections.abc import Callable
from math import inf, nan
from typing import TypeVar

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import NcError
from achse.codes.nc.choices import TableType as Kind
from achse.motion import Axis, AxisParameters, Nc, commands
from achse.motion.commands import CamDemand
from achse.motion.states import CamActivation, CamOperation, DecouplingType, SlaveType

T = TypeVar("T")

TABLE, FUNCTION, AXES = 7, 8, 4
VALUES = {
    "control_dword": 7,
    "velocity_override": 1_000_000,
    "max_velocity": 1e4,
    "controller_following_error_position_monitoring_enable": 0,
}


def _mostly(usual: st.SearchStrategy[T], *odd: T) -> st.SearchStrategy[T]:
    """Seldom one of the values that are refused: else nothing would come to the later checks."""
    return st.integers(0, 15).flatmap(lambda n: st.sampled_from(odd) if n == 15 else usual)


Number = _mostly(
    st.one_of(st.sampled_from((0.0, 1.0, -1.0, 2.0, 30.0, 60.0)), st.floats(-500.0, 500.0)),
    *(1e6, -1e7, 1e13, nan, inf, -inf),
)
Positive = _mostly(st.one_of(st.just(0.0), st.floats(1e2, 1e5)), -1.0, 1e30, nan)
Place = _mostly(st.integers(1, AXES), 0, AXES + 1)
"""Ids of axes, seldom one that no axis has."""
Subindex = _mostly(st.just(0), 1)
Type = _mostly(st.sampled_from((1, 2, 3, 12, 15, 16, 18)), *SlaveType, 0, 4, 9, 101)
TableId = _mostly(st.just(TABLE), 0, FUNCTION, 99)


@st.composite
def demands(draw: st.DrawFn) -> CamDemand:
    return CamDemand(
        table_id=draw(TableId),
        interpolation=draw(_mostly(st.integers(0, 3), -1, 5)),
        slave_offset=draw(Number),
        master_offset=draw(Number),
        slave_scaling=draw(Number),
        master_scaling=draw(Number),
        slave_absolute=draw(st.integers(0, 1)),
        master_absolute=draw(st.integers(0, 1)),
        activation=draw(_mostly(st.sampled_from(CamActivation), 77)),
        position=draw(Number),
        master_type=draw(st.integers(0, 3)),
        slave_type=draw(st.integers(0, 3)),
    )


Act = Callable[[Nc, Axis], int | tuple[int, float]]


@st.composite
def acts(draw: st.DrawFn) -> Act:
    """One request that couples or changes a coupling, with everything drawn."""
    kind, master = draw(Type), draw(Place)
    numbers = [draw(Number) for _ in range(4)]
    dynamics = [draw(Positive) for _ in range(4)]
    places = [draw(Subindex) for _ in range(2)]
    match draw(st.integers(0, 12)):
        case 0 | 1 | 2:
            numbers[2] = draw(st.one_of(Number, Place.map(float)))
            return lambda nc, slave: commands.couple(slave, kind, master, *places, *numbers)
        case 3 | 4:
            kind = draw(_mostly(st.sampled_from((15, 17, 100)), 1))
            ids = [draw(Place), *(draw(st.one_of(st.just(0), Place)) for _ in range(3))]
            return lambda nc, slave: commands.couple_to_several(slave, kind, ids, *dynamics)
        case 5 | 6:
            kind, mask = draw(_mostly(st.sampled_from((5, 6)), 1)), draw(st.integers(0, 0xFFFF))
            return lambda nc, slave: commands.synchronise(
                *(slave, kind, master, *places),
                *(numbers[0], numbers[1], numbers[2], *dynamics, mask),
            )
        case 7 | 8:
            kind, demand = draw(_mostly(st.sampled_from((10, 11, 13)), 1)), draw(demands())
            operation = draw(_mostly(st.sampled_from(CamOperation), 9))
            further = draw(st.lists(TableId, max_size=2))
            reference = draw(TableId)
            return lambda nc, slave: commands.couple_by_cam(
                slave, kind, master, demand, operation, reference, further_tables=further
            )
        case 9:
            return lambda nc, slave: commands.change_coupling(slave, *numbers)
        case 10:
            demand = draw(demands())
            return lambda nc, slave: commands.change_cam_scaling(slave, demand)
        case 11:
            more = numbers[: draw(st.sampled_from((0, 2, 3)))]
            return lambda nc, slave: commands.change_cam_offsets(slave, *numbers[:2], *more)
    position = draw(st.one_of(st.none(), Number))
    table = draw(TableId)
    return lambda nc, slave: commands.follow_correction(slave, table, position)


@st.composite
def events(draw: st.DrawFn) -> Act:
    """Something that decides what is refused next."""
    velocity = draw(st.floats(1.0, 500.0))
    match draw(st.integers(0, 5)):
        case 0 | 1:
            kind = draw(st.sampled_from((1, 3, 4)))
            return lambda nc, axis: commands.universal_start(axis, kind, 100.0, velocity)
        case 2:
            return lambda nc, axis: commands.set_external_error(axis, 0x4FFF)
        case 3:
            word = draw(st.sampled_from((0, 7, 7)))

            def enable(nc: Nc, axis: Axis) -> int:
                axis.control_dword = word
                return 0

            return enable
        case 4:
            form = draw(st.sampled_from(DecouplingType))
            return lambda nc, axis: commands.decouple_with_follow_up(axis, form, 1.0, velocity)
    return lambda nc, axis: commands.reset(axis)


def station(types: list[int], *, compiled: bool) -> Nc:
    """Axes with a second encoder each, a table and a motion function."""
    parts = [
        AxisParameters(n, values=VALUES | {"axis_type": kind}, encoder_ids=(n, n + 100))
        for n, kind in enumerate(types, start=1)
    ]
    nc = Nc(2_000_000, parts, compiled=compiled)
    points = [number for n in range(9) for number in (45.0 * n, 10.0 * (n % 2))]
    nc.tables.write(nc.tables.create(TABLE, Kind.CAMMING, 2, 9, 2), 0, points)
    nc.tables.create(FUNCTION, Kind.MOTION_FUNCTION, 3, 3, 1)
    for axis in nc:
        axis.encoders[1].position_offset = 50.0
    nc.cycle(3)
    return nc


Types = st.lists(_mostly(st.just(1), 2, 5), min_size=AXES, max_size=AXES)
"""Continuous axes, seldom a discrete one or one that is an encoder alone."""


@settings(max_examples=50, deadline=None)
@given(
    types=Types,
    story=st.lists(
        st.tuples(st.integers(1, AXES), st.one_of(acts(), acts(), events()),
                  st.sampled_from((0, 0, 1, 30, 200))),
        min_size=6, max_size=20,
    ),
    compiled=st.booleans(),
)  # fmt: skip
def test_a_refusal_leaves_all_records_as_they_were(
    types: list[int], story: list[tuple[int, Act, int]], compiled: bool
) -> None:
    nc = station(types, compiled=compiled)
    for id, act, cycles in story:
        before, order = nc.digest(), list(nc.axis(1).order.rows)
        if act(nc, nc.axis(id)) not in (0, (0, 0.0)):
            assert (nc.digest(), list(nc.axis(1).order.rows)) == (before, order)
        nc.cycle(cycles)


RING: dict[str, Act] = {
    "by parameters": lambda nc, slave: commands.couple(slave, SlaveType.LINEAR, 2, 0, 0, 1.0),
    "flying saw": lambda nc, slave: commands.couple(
        slave, SlaveType.FLYING_SAW_POSITION, 2, 0, 0, 300.0, 40.0, 45.0, 1.0
    ),
    "several masters": lambda nc, slave: commands.couple_to_several(
        slave, SlaveType.MULTI_MASTER, (3, 2, 0, 0), 500.0, 400.0, 5e4, 60.0
    ),
    "synchronising": lambda nc, slave: commands.synchronise(
        slave, SlaveType.SYNCHRONISING_VELOCITY, 2, 0, 0, 2.0, 0.0, 0.0, 9.0, 8.0, 7.0, 6.0, 3
    ),
    "cam": lambda nc, slave: commands.couple_by_cam(slave, SlaveType.TABULAR, 2, CamDemand(TABLE)),
}


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("name", RING)
def test_a_ring_is_refused_and_sleepers_sleep_on(name: str, compiled: bool) -> None:
    nc = station([1] * AXES, compiled=compiled)
    assert commands.couple(nc.axis(2), SlaveType.LINEAR, 1, 0, 0, 1.0) == 0
    nc.cycle(500)
    assert all(axis.resting for axis in nc)
    before = nc.digest()
    assert RING[name](nc, nc.axis(1)) == NcError.MASTER_NOT_INSERTED
    assert nc.digest() == before
