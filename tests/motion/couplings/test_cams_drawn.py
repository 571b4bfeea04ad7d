"""Cams with everything drawn: closed forms in every cycle, both kernels, edits, letting go."""

import random
from bisect import bisect_right
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import floor
from typing import Any

import pytest

from achse.codes import NcError
from achse.codes.axis import StartType, StateBit
from achse.codes.nc.choices import TableSubType, TableType
from achse.motion import Axis, AxisParameters, Nc, commands
from achse.motion.commands import CamDemand
from achse.motion.setpoints.dynamics import fastest
from achse.motion.states import CamActivation, CamInterpolation, CamScaling, SlaveType
from achse.motion.tables import TableError
from achse.motion.tables.memory import COUNT, HEADER, SPAN

VALUES = {
    "control_dword": 7,
    "velocity_override": 1_000_000,
    "max_velocity": 5000.0,
    "controller_following_error_position_monitoring_enable": 0,
}


def drawn_points(dice: random.Random, equidistant: bool) -> list[tuple[float, float]]:
    count = dice.randint(4, 30)
    begin, step = dice.uniform(-50.0, 50.0), dice.uniform(2.0, 30.0)
    places = [begin]
    for n in range(1, count):
        places.append(begin + n * step if equidistant else places[-1] + dice.uniform(1.0, 40.0))
    value = dice.uniform(-20.0, 20.0)
    points = []
    for place in places:
        points.append((place, value))
        value += dice.uniform(-5.0, 5.0)
    return points


def lines(points: list[tuple[float, float]], position: float, cyclic: bool) -> float:
    """The closed form of straight lines."""
    places, values = zip(*points, strict=True)
    period, stroke, lift = places[-1] - places[0], values[-1] - values[0], 0.0
    if cyclic:
        cycle = floor((position - places[0]) / period)
        position, lift = position - cycle * period, cycle * stroke
    if position <= places[0]:
        return float(values[0] + lift)
    if position >= places[-1]:
        return float(values[-1] + lift)
    n = bisect_right(places, position) - 1
    share = (position - places[n]) / (places[n + 1] - places[n])
    return float(values[n] + share * (values[n + 1] - values[n]) + lift)


def build(ids: tuple[int, int], compiled: bool, seed: int) -> tuple[Nc, list[tuple[float, float]]]:
    dice = random.Random(seed)
    nc = Nc(
        dice.choice((500_000, 1_000_000, 2_000_000)),
        [AxisParameters(n, values=VALUES) for n in ids],
        compiled=compiled,
    )
    sub_type = dice.randint(1, 4)
    points = drawn_points(dice, sub_type < 3)
    table = nc.tables.create(7, TableType.CAMMING, sub_type, len(points), 2)
    nc.tables.write(table, 0, [number for point in points for number in point])
    nc.cycle(3)
    return nc, points


@pytest.mark.parametrize("seed", range(24))
def test_the_slave_keeps_its_law_in_every_cycle(seed: int) -> None:
    """Starts, stops, reversals and overrides of the master; the slave has a higher or lower id."""
    dice = random.Random(seed)
    ids = dice.choice(((1, 2), (2, 1)))
    nc, points = build(ids, seed % 2 == 0, seed)
    master, slave = nc.axis(ids[0]), nc.axis(ids[1])
    cyclic = nc.tables.find(7).cyclic
    demand = CamDemand(
        7,
        slave_offset=dice.uniform(-50.0, 50.0),
        master_offset=dice.uniform(-50.0, 50.0),
        slave_scaling=dice.uniform(-3.0, 3.0),
        master_scaling=dice.choice((-1.0, 1.0)) * dice.uniform(0.2, 4.0),
        master_absolute=dice.randint(0, 1),
    )
    began = master.set_position
    assert commands.couple_by_cam(slave, 10, ids[0], demand) == 0
    reference = 0.0 if demand.master_absolute else began

    def law(position: float) -> float:
        cam = (position - reference - demand.master_offset) / demand.master_scaling
        return demand.slave_scaling * lines(points, cam, cyclic)

    zero = slave.set_position - law(began)
    for _ in range(12):
        match dice.randint(0, 3):
            case 0:
                commands.stop(master)
            case 1:
                master.velocity_override = dice.randint(0, 1_000_000)
            case _:
                position, velocity = dice.uniform(-900.0, 900.0), dice.uniform(20.0, 900.0)
                commands.start(master, 1, position, velocity)
        for _ in range(dice.randint(1, 60)):
            nc.cycle()
            assert slave.set_position == pytest.approx(zero + law(master.set_position), abs=1e-9)
    position, velocity = slave.set_position, slave.set_velocity
    assert commands.decouple(slave) == 0
    nc.cycle()
    reach = abs(velocity) * nc.cycle_seconds * 1.5 + 1e-6
    reach += abs(slave.set_acceleration) * nc.cycle_seconds**2
    assert abs(slave.set_position - position) <= reach
    assert nc.tables.user_count(7) == 0


@pytest.mark.parametrize("seed", range(12))
def test_both_kernels_do_the_same_whatever_happens(seed: int) -> None:
    digests = []
    for compiled in (False, True):
        nc, points = build((1, 2), compiled, seed)
        dice = random.Random(seed + 1000)
        master, slave = nc.axis(1), nc.axis(2)
        kind = dice.choice((10, 11))
        codes = []
        for _ in range(60):
            demand = CamDemand(
                7,
                interpolation=dice.choice((0, 1, 2, 3)),
                slave_offset=dice.uniform(-60.0, 60.0),
                master_offset=dice.uniform(-60.0, 60.0),
                slave_scaling=dice.uniform(-3.0, 3.0),
                master_scaling=dice.uniform(-3.0, 3.0),
                slave_absolute=dice.randint(0, 1),
                master_absolute=dice.randint(0, 1),
                activation=dice.choice(list(CamActivation)),
                position=dice.uniform(-300.0, 300.0),
                master_type=dice.choice(list(CamScaling)),
                slave_type=dice.choice(list(CamScaling)),
            )
            where = dice.uniform(-600.0, 600.0)
            row, table = dice.randrange(len(points)), nc.tables.find(7)
            match dice.randint(0, 6):
                case 0 | 1:
                    operation = dice.randint(0, 3)
                    codes.append(commands.couple_by_cam(slave, kind, 1, demand, operation, 7))
                case 2:
                    codes.append(commands.change_cam_scaling(slave, demand))
                case 3:
                    nc.tables.write(table, 2 * row + 1, [dice.uniform(-20.0, 20.0)])
                case 4:
                    codes.append(commands.follow_correction(slave, 7, where))
                case 5 if dice.random() < 0.2:
                    codes.append(commands.decouple(slave))
                case _:
                    codes.append(commands.start(master, 1, where, 400.0))
            nc.cycle(dice.randint(1, 80))
        digests.append((nc.digest(), codes))
    assert digests[0] == digests[1]


class _Player:
    """Draws what to do with one axis, which leads or follows."""

    def __init__(self, axis: Axis, seed: int) -> None:
        self.axis = axis
        self.dice = random.Random(f"{seed} {axis.axis_id}")

    def act(self) -> None:
        axis, dice = self.axis, self.dice
        other = dice.randint(1, 4)
        match dice.randint(0, 16):
            case 0 | 1:
                commands.couple(axis, 1, other, 0, 0, dice.choice((0.5, -1.0, 2.0)), 0.0, 0.0, 0.0)
            case 2 | 3 | 4:
                demand = CamDemand(
                    7,
                    interpolation=dice.choice((0, 2)),
                    master_absolute=dice.randint(0, 1),
                    activation=dice.choice((0, 0, 2, 5)),
                    position=dice.uniform(-99.0, 99.0),
                )
                commands.couple_by_cam(axis, dice.choice((10, 11)), other, demand)
            case 5:
                commands.decouple(axis)
            case 6:
                commands.stop(axis)
            case 7:
                axis.control_dword = dice.choice((0, 7, 7, 3))
            case 8:
                commands.reset(axis)
                axis.control_dword = 7
            case 9:
                axis.couple_slaves_by_actual_values = dice.randint(0, 1)
            case 10:
                axis.controller.following_error_position_max = dice.choice((0.5, 5.0, 500.0))
            case 11:
                axis.velocity_override = dice.randint(0, 1_000_000)
            case 12:
                commands.start_phasing(axis, 0, 0, other, dice.uniform(-9.0, 9.0), 50.0)
            case _:
                place = dice.uniform(-400.0, 400.0)
                commands.start(axis, 1, place, dice.uniform(20.0, 900.0))


def test_the_short_way_does_what_the_long_one_does(
    compare_ways: Callable[[Callable[[], tuple[Nc, list[Any]]], int], None],
    many: Callable[[int], int],
) -> None:
    def make(seed: int) -> tuple[Nc, list[Any]]:
        dice = random.Random(seed)
        watched = {"controller_following_error_position_monitoring_enable": 1}
        nc = Nc(
            2_000_000,
            [AxisParameters(n, values=VALUES | watched) for n in range(1, 5)],
            compiled=True,
        )
        points = [(0.0, 0.0), (90.0, dice.uniform(5.0, 30.0)), (180.0, 4.0), (360.0, 0.0)]
        table = nc.tables.create(7, TableType.CAMMING, dice.choice((3, 4)), 4, 2)
        nc.tables.write(table, 0, [number for point in points for number in point])
        return nc, [_Player(axis, seed) for axis in nc]

    for seed in range(many(2)):
        compare_ways(partial(make, seed), seed)


def _bounds(nc: Nc, interpolation: int) -> tuple[float, float]:
    """The largest slope and bend of table 7, by its cubics."""
    numbers, first = nc.tables.cams.numbers, nc.tables.cam(7, interpolation)
    slope = bend = 0.0
    for n in range(int(numbers[first + COUNT]) - 1):
        at = first + HEADER + SPAN * n
        _, _, begin, square, cube = numbers[at : at + SPAN]
        way = numbers[at + SPAN] - numbers[at]
        bends = 2.0 * square, 2.0 * square + 6.0 * cube * way
        slope = max(slope, abs(begin) + way * max(map(abs, bends)))
        bend = max(bend, *map(abs, bends))
    return slope, bend


@pytest.mark.parametrize("seed", range(24))
def test_the_velocity_of_splines_is_continuous(seed: int) -> None:
    """Whatever is drawn: kind, scalings, offsets, a modulo master, reversals, overrides.

    Between two cycles the slope changes no more than the bends of the cubics on the way allow.
    """
    dice = random.Random(f"spline {seed}")
    modulo = {"unit_interpretation": 4, "encoder_modulo_factor": dice.uniform(50.0, 720.0)}
    nc = Nc(
        dice.choice((500_000, 1_000_000, 2_000_000)),
        [
            AxisParameters(1, values=VALUES | (modulo if dice.random() < 0.5 else {})),
            AxisParameters(2, values=VALUES),
        ],
        compiled=seed % 2 == 0,
    )
    sub_type = dice.choice(list(TableSubType))
    cyclic = sub_type in (TableSubType.EQUIDISTANT_CYCLIC, TableSubType.MONOTONIC_CYCLIC)
    points = drawn_points(dice, sub_type < TableSubType.MONOTONIC_LINEAR)
    table = nc.tables.create(7, TableType.CAMMING, sub_type, len(points), 2)
    nc.tables.write(table, 0, [number for point in points for number in point])
    nc.cycle(3)
    splines = [CamInterpolation.SPLINE, CamInterpolation.LOCAL]
    demand = CamDemand(
        7,
        # a local one does not lie flat at its ends, where a linear table stands
        interpolation=dice.choice(splines) if cyclic else CamInterpolation.SPLINE,
        slave_offset=dice.uniform(-50.0, 50.0),
        master_offset=dice.uniform(-50.0, 50.0),
        slave_scaling=dice.uniform(-3.0, 3.0),
        master_scaling=dice.choice((-1.0, 1.0)) * dice.uniform(0.2, 4.0),
        master_absolute=dice.randint(0, 1),
    )
    slope, bend = _bounds(nc, demand.interpolation)
    rate, factor = 1.0 / abs(demand.master_scaling), abs(demand.slave_scaling)
    master, slave = nc.axis(1), nc.axis(2)
    assert commands.couple_by_cam(slave, dice.choice((10, 11)), 1, demand) == 0
    moved = 0
    for _ in range(12):
        match dice.randint(0, 4):
            case 0:
                commands.stop(master)
            case 1:
                master.velocity_override = dice.randint(100_000, 1_000_000)
            case 2:
                kind = dice.choice((StartType.ENDLESS_POSITIVE, StartType.ENDLESS_NEGATIVE))
                commands.start(master, kind, 0.0, dice.uniform(20.0, 900.0))
            case _:
                position, velocity = dice.uniform(-900.0, 900.0), dice.uniform(20.0, 900.0)
                commands.start(master, StartType.ABSOLUTE, position, velocity)
        for _ in range(dice.randint(1, 150)):
            place, speed, velocity = master.set_position, master.set_velocity, slave.set_velocity
            nc.cycle()
            way = abs(master.set_position - place) * rate
            change = bend * way * abs(master.set_velocity)
            change += slope * abs(master.set_velocity - speed)
            assert abs(slave.set_velocity - velocity) <= factor * rate * change * (1 + 1e-9) + 1e-7
            moved += slave.set_velocity != velocity
    assert moved > 20 or not cyclic


def _plain_nc(dice: random.Random, compiled: bool) -> Nc:
    """Axes 1 and 2 lead, axis 3 is to follow; tables 7 to 9 are drawn."""
    window = dice.choice((0.0, 0.5, 5.0))
    values = VALUES | {"position_range_window": window}
    nc = Nc(
        dice.choice((500_000, 2_000_000)),
        [AxisParameters(n, values=values) for n in (1, 2, 3)],
        compiled=compiled,
    )
    for number in (7, 8, 9):
        sub_type = dice.choice((TableSubType.MONOTONIC_LINEAR, TableSubType.MONOTONIC_CYCLIC))
        points = drawn_points(dice, equidistant=False)
        table = nc.tables.create(number, TableType.CAMMING, sub_type, len(points), 2)
        nc.tables.write(table, 0, [number for point in points for number in point])
    nc.cycle(3)
    return nc


def _drawn_request(dice: random.Random, kind: int) -> Callable[[Axis], int]:
    """A request of a slave of cams, or one that couples or decouples."""
    first, other = dice.choice((7, 8, 9)), dice.choice((0, 7, 8, 9))
    demand = CamDemand(
        first,
        interpolation=dice.choice((0, 2)),
        slave_offset=dice.choice((0.0, dice.uniform(-1.0, 1.0))),
        master_offset=dice.choice((0.0, dice.uniform(-9.0, 9.0))),
        slave_scaling=dice.uniform(-2.0, 2.0),
        master_scaling=dice.choice((1.0, dice.uniform(0.5, 2.0))),
        slave_absolute=dice.choice((0, 0, 0, 1)),
        master_absolute=dice.randint(0, 1),
        activation=dice.choice((0, 0, 0, 0, *CamActivation)),
        position=dice.choice((200.0, dice.uniform(-300.0, 300.0))),
        master_type=dice.choice(list(CamScaling)),
        slave_type=dice.choice(list(CamScaling)),
    )
    master = dice.choice((1, 1, 2))
    gear, ending = dice.choice((0.5, -2.0)), dice.choice((0, 2, 6))
    match dice.randint(0, 11):
        case 0 | 1 | 2 | 3 | 4:
            operation = dice.randint(0, 3)
            return lambda axis: commands.couple_by_cam(axis, kind, master, demand, operation, other)
        case 5 | 6:
            return lambda axis: commands.change_cam_scaling(axis, replace(demand, table_id=other))
        case 7:
            return lambda axis: commands.scale_slave(axis, demand.slave_scaling)
        case 8:
            return lambda axis: commands.follow_correction(axis, first)
        case 9:
            return lambda axis: commands.end_profile(axis, first)
        case 10:
            return lambda axis: commands.decouple_with_follow_up(axis, ending)
    return lambda axis: commands.couple(axis, 1, master, 0, 0, gear)


@pytest.mark.parametrize("seed", range(30))
def test_requests_at_rest_need_no_cycle_between_them(seed: int) -> None:
    """The same requests, at once and with cycles between them, have the same codes and results.

    Alone a jump within the position window is carried out by a cycle: two of them at once may be
    beyond the window.
    """
    dice = random.Random(f"answers {seed}")
    kind, compiled = dice.choice((10, 11, 11, 11)), dice.random() < 0.2
    waits = dice.choice((1, 2, 7))
    both = [_plain_nc(random.Random(seed), compiled) for _ in range(2)]
    places = [dice.uniform(-100.0, 100.0) for _ in range(2)]
    for nc in both:
        for n, place in enumerate(places):
            commands.start(nc.axis(n + 1), 1, place, 900.0)
        nc.cycle(4000)
    accepted = 0
    for _ in range(25):
        requests = [_drawn_request(dice, kind) for _ in range(dice.randint(1, 5))]
        for request in requests:
            at_once, later = (request(nc.axis(3)) for nc in both)
            if at_once != later:
                assert at_once == NcError.TABLE_SLAVE_RANGE
                return
            accepted += not at_once
            ours, others = (nc.axis(3) for nc in both)
            shown = (ours.set_gear_ratio, ours.state_dword, ours.coupling_state)
            both[1].cycle(waits)
            assert shown[0] == pytest.approx(others.set_gear_ratio, abs=1e-9)
            assert shown[1] & _CAM_BITS == others.state_dword & _CAM_BITS
            assert shown[2] == others.coupling_state
            assert ours.coupling_table_index == others.coupling_table_index
        for nc in both:
            nc.cycle(3)
        ours, others = (nc.axis(3) for nc in both)
        assert ours.error_code == others.error_code == 0
        assert ours.set_position == pytest.approx(others.set_position, abs=1e-6)
    assert accepted


_CAM_BITS = (
    StateBit.CAM_TABLE_QUEUED
    | StateBit.CAM_SCALING_PENDING
    | StateBit.CAM_DATA_QUEUED
    | StateBit.PROTECTED
)


@pytest.mark.parametrize("seed", range(20))
def test_requests_in_motion_neither_jump_nor_wait_for_a_cycle(seed: int) -> None:
    """What is not at work, or waits, at once is so after a cycle too; no slave is too fast."""
    dice = random.Random(f"moving {seed}")
    kind, compiled = dice.choice((10, 11, 11)), dice.random() < 0.2
    both = [_plain_nc(random.Random(seed), compiled) for _ in range(2)]
    order = NcError.TABLE_NOT_FOUND, NcError.TOO_MANY_TABLES, NcError.ACTIVATION_PENDING
    demand = CamDemand(7, master_absolute=1)
    velocity = dice.uniform(20.0, 400.0)
    for nc in both:
        assert commands.couple_by_cam(nc.axis(3), kind, 1, demand) == 0
        for n in (1, 2):
            commands.start(nc.axis(n), StartType.ENDLESS_POSITIVE, 0.0, velocity)
        nc.cycle(100)
    for _ in range(6):
        requests = [_drawn_request(dice, kind) for _ in range(2)]
        codes = []
        for nc, between in zip(both, (0, 1), strict=True):
            slave = nc.axis(3)
            codes.append([requests[0](slave)])
            nc.cycle(between)
            codes[-1].append(requests[1](slave))
            nc.cycle(1 - between)
        if codes[0] != codes[1]:
            assert codes[0][0] == codes[1][0]
            assert codes[0][1] not in order
            return
        limit = 5000.0 * both[0].cycle_seconds + 1e-6
        for _ in range(30):
            before = both[0].axis(3).set_position
            for nc in both:
                nc.cycle()
            assert abs(both[0].axis(3).set_position - before) <= limit


def _any_request(dice: random.Random, kind: int, nc: Nc) -> Callable[[Axis], int]:
    """A request of `_drawn_request`, offsets (0x43), or an edit of a table at work."""
    numbers = [dice.uniform(-3.0, 3.0) for _ in range(4)]
    match dice.randint(0, 9):
        case 0:
            more = numbers[2:] if dice.random() < 0.5 else []
            return lambda axis: commands.change_cam_offsets(axis, *numbers[:2], *more)
        case 1:
            table = nc.tables.find(dice.choice((7, 8, 9)))
            place = 2 * dice.randrange(len(table.values) // 2) + 1
            value = table.values[place] + dice.choice((0.1, 1.0, 5.0)) * numbers[0]
            return lambda _: _written(nc, table, place, value)
    return _drawn_request(dice, kind)


def _written(nc: Nc, table: Any, place: int, value: float) -> int:
    try:
        nc.tables.write(table, place, [value])
    except TableError:
        return NcError.TABLE_SLAVE_RANGE
    return 0


def test_slave_never_steps_farther_than_its_velocity_allows(many: Callable[[int], int]) -> None:
    """Whatever is accepted: cams, layers, exchanges (0x4A, 0x45), scalings (0x49, 0x4D), edits."""
    accepted: Counter[bool] = Counter()
    for seed in range(many(16)):
        dice = random.Random(f"step {seed}")
        kind = dice.choice((10, 11, 11))
        nc = _plain_nc(dice, compiled=True)
        slave, masters = nc.axis(3), (nc.axis(1), nc.axis(2))
        slave.max_velocity = 10.0 ** dice.uniform(1.7, 3.5)
        low, high = -(10.0 ** dice.uniform(0.5, 3.0)), 10.0 ** dice.uniform(0.5, 3.0)
        limited = dice.random() < 0.6
        if limited:
            slave.encoder.soft_limit_min, slave.encoder.soft_limit_max = low, high
            slave.encoder.soft_limit_min_enable = slave.encoder.soft_limit_max_enable = 1
        nc.cycle(3)
        farthest = fastest(slave) * nc.cycle_seconds * (1 + 1e-6) + 1e-6
        for _ in range(20):
            if not slave.coupling.law:
                for axis in nc:
                    commands.reset(axis) if axis.error_code else commands.stop(axis)
                nc.cycle(2000)
            for _ in range(3):
                coupled = bool(slave.coupling.law)
                accepted[coupled] += _any_request(dice, kind, nc)(slave) == 0
                if slave.coupling.law == SlaveType.LINEAR:  # which may be faster than the axis
                    commands.decouple(slave)
            for master in masters:
                place, velocity = dice.uniform(-400.0, 400.0), 10.0 ** dice.uniform(0.5, 2.7)
                commands.start(master, StartType.ABSOLUTE, place, velocity)
            for _ in range(dice.randint(1, 40)):
                before = slave.set_position
                nc.cycle()
                assert abs(slave.set_position - before) <= farthest
                if limited:
                    assert low - 1e-3 <= slave.set_position <= high + 1e-3
    assert accepted[True] > 100
    assert accepted[False] > 50
