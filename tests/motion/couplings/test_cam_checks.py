"""Checks of cams: no request that is answered 0 makes a slave jump, now or later."""

import random
from collections.abc import Callable
from math import inf
from typing import Any

import pytest

from achse.codes.axis import StartType
from achse.codes.nc.choices import TableType
from achse.motion import Axis, AxisParameters, Nc, commands
from achse.motion.commands import CamDemand, Compensation
from achse.motion.states import CamActivation, CamScaling
from achse.motion.tables import TableError
from achse.motion.tables.table import MOTION_POINT, PointActivation

MASTERS = 3
SLAVES = 12
TABLES = (1, 2, 3, 4, 5, 6)
FUNCTION = 9
LAWS = (1, 3, 5, 10, 12, 15, 40, 99)


def decades(dice: random.Random, low: float, high: float) -> float:
    return float(10.0 ** dice.uniform(low, high))


def drawn_axis(dice: random.Random, number: int) -> AxisParameters:
    """Dynamics, windows and resolutions over decades; a slave often has soft limits."""
    slave = number > MASTERS
    modulo = {"unit_interpretation": 4, "encoder_modulo_factor": dice.uniform(50.0, 720.0)}
    values: dict[str, Any] = {
        "control_dword": 7,
        "velocity_override": 1_000_000,
        "max_velocity": decades(dice, 1.0, 4.0),
        "drive_reference_velocity": decades(dice, 1.5, 4.0),
        "default_acceleration": decades(dice, 2.0, 5.0),
        "default_deceleration": decades(dice, 2.0, 5.0),
        "default_jerk": decades(dice, 3.0, 7.0),
        "max_acceleration": 1e6,
        "max_deceleration": 1e6,
        "position_range_window": dice.choice((0.0, decades(dice, -3.0, 2.0))),
        "encoder_scaling_factor": decades(dice, -6.0, -2.0),
        "allow_slave_motion_commands": dice.randrange(2),
        "couple_slaves_by_actual_values": dice.randrange(2),
        "fading_acceleration": dice.choice((0.0, decades(dice, 2.0, 4.0))),
        "error_reaction_mode": dice.randrange(2),
        "error_reaction_delay": dice.choice((0.0, 0.05)),
        "controller_following_error_position_monitoring_enable": 0,
        "encoder_soft_limit_min_enable": int(slave and dice.random() < 0.6),
        "encoder_soft_limit_max_enable": int(slave and dice.random() < 0.6),
        "encoder_soft_limit_min": -decades(dice, -1.0, 2.5),
        "encoder_soft_limit_max": decades(dice, -1.0, 2.5),
    }
    return AxisParameters(number, values=values | (modulo if dice.random() < 0.3 else {}))


def drawn_points(dice: random.Random, equidistant: bool) -> list[tuple[float, float]]:
    height, step = decades(dice, -1.0, 2.0), decades(dice, 0.0, 1.7)
    place, value = dice.choice((0.0, dice.uniform(-50.0, 50.0))), 0.0
    points = []
    for _ in range(dice.randint(4, 12)):
        points.append((place, value))
        place += step if equidistant else step * dice.uniform(0.1, 2.0)
        value = dice.uniform(-height, height) if dice.random() < 0.8 else value
    return points


def drawn_function(dice: random.Random) -> bytes:
    place, points = 0.0, b""
    for number in range(1, 5):
        values = (dice.uniform(-30.0, 30.0), dice.uniform(-1.0, 1.0), 0.0, 0.0)
        points += MOTION_POINT.pack(number, dice.choice(LAWS), 0, 1, 0, place, *values)
        place += dice.uniform(5.0, 90.0)
    return points


class Plant:
    """Masters that move, slaves that change their cams; tables are shared and edited."""

    def __init__(self, seed: int, *, compiled: bool | None) -> None:
        dice = self.dice = random.Random(seed)
        self.nc = Nc(
            dice.choice((500_000, 1_000_000, 2_000_000, 10_000_000)),
            [drawn_axis(dice, n) for n in range(1, MASTERS + SLAVES + 1)],
            compiled=compiled,
        )
        tables = self.nc.tables
        for table_id in TABLES:
            sub_type = dice.randint(1, 4)
            points = drawn_points(dice, sub_type < 3)
            table = tables.create(table_id, TableType.CAMMING, sub_type, len(points), 2)
            tables.write(table, 0, [number for point in points for number in point])
        function = tables.create(FUNCTION, TableType.MOTION_FUNCTION, dice.choice((3, 4)), 4, 1)
        tables.write_points(function, 0, drawn_function(dice))
        self.nc.cycle(3)
        self.masters = [self.nc.axis(n + 1) for n in range(MASTERS)]
        self.slaves = [self.nc.axis(MASTERS + n + 1) for n in range(SLAVES)]
        self.kinds = {axis.axis_id: dice.choice((10, 11, 11, 13)) for axis in self.slaves}
        self.accepted = self.refused = 0
        self.history: list[str] = []

    def demand(self, table_id: int) -> CamDemand:
        dice = self.dice
        near = decades(dice, -2.0, 0.5)
        return CamDemand(
            table_id,
            interpolation=dice.choice((0, 0, 1, 2, 2, 3)),
            slave_offset=dice.choice((0.0, dice.uniform(-near, near))),
            master_offset=dice.choice((0.0, dice.uniform(-near, near), dice.uniform(-99.0, 99.0))),
            slave_scaling=dice.choice((1.0, dice.uniform(0.9, 1.1), dice.uniform(-3.0, 3.0))),
            master_scaling=dice.choice((1.0, -1.0, decades(dice, -1.0, 1.0))),
            slave_absolute=dice.randint(0, 1),
            master_absolute=dice.randint(0, 1),
            activation=dice.choice((0, 0, 0, 0, 2, 5, *CamActivation)),
            position=dice.uniform(-200.0, 200.0),
            master_type=dice.choice((0, 0, 0, *CamScaling)),
            slave_type=dice.choice((0, 0, *CamScaling)),
        )

    def lead(self) -> None:
        dice, axis = self.dice, self.dice.choice(self.masters)
        limit = min(axis.max_velocity, axis.drive.reference_velocity)
        match dice.randint(0, 9):
            case 0:
                commands.stop(axis)
            case 1:
                axis.velocity_override = dice.randint(0, 1_000_000)
            case 2:
                axis.control_dword = dice.choice((0, 7, 7, 7, 7, 7))
            case 3 | 5:
                kind = dice.choice((StartType.ENDLESS_POSITIVE, StartType.ENDLESS_NEGATIVE))
                commands.start(axis, kind, 0.0, limit * decades(dice, -2.0, 0.0))
            case 4 if axis.set_motion_phase == 0:
                commands.set_actual_position(axis, 1, dice.uniform(-300.0, 300.0))
            case _:
                place = dice.uniform(-400.0, 400.0)
                commands.start(axis, StartType.ABSOLUTE, place, limit * decades(dice, -2.0, 0.0))
        if axis.error_code:
            commands.reset(axis)
        if dice.random() < 0.5:
            axis.control_dword = 7

    def edit(self) -> int:
        dice, tables = self.dice, self.nc.tables
        try:
            if dice.random() < 0.3:
                function = tables.find(FUNCTION)
                when = dice.choice(list(CamActivation))
                tables.change_online(
                    function, PointActivation(when, dice.uniform(-99.0, 99.0), 0, 0)
                )
                tables.write_points(function, 0, drawn_function(dice))
            else:
                table = tables.find(dice.choice(TABLES))
                row = dice.randrange(table.row_count)
                value = table.values[2 * row + 1] + decades(dice, -3.0, 1.0)
                tables.write(table, 2 * row + 1, [value])
        except TableError as refusal:
            return refusal.error
        return 0

    def act(self, slave: Axis) -> int:
        dice = self.dice
        kind = self.kinds[slave.axis_id]
        table_id = FUNCTION if kind == 13 else dice.choice(TABLES)
        demand, master, running = self.demand(table_id), dice.randint(1, MASTERS), 0
        if slave.coupling.law:
            layer = dice.choice(slave.cams[: slave.camming.count])
            running = layer.now.table
            if dice.random() < 0.7:
                master = self.nc.axis(layer.master + 1).axis_id
        match dice.randint(0, 14) if slave.coupling.law else 14:
            case 0:
                return commands.change_cam_offsets(
                    slave, demand.slave_offset, demand.master_offset,
                    *(demand.slave_scaling, demand.master_scaling, demand.position)[
                        : dice.choice((0, 2, 3))
                    ],
                )  # fmt: skip
            case 1:
                return commands.scale_slave(slave, demand.slave_scaling)
            case 2 | 3:
                return commands.change_cam_scaling(slave, demand)
            case 4:
                position = dice.choice((None, demand.position))
                return commands.follow_correction(slave, table_id, position)
            case 5:
                return commands.end_profile(slave, running)
            case 6:
                return commands.start_phasing(
                    slave, 0, 0, master, dice.uniform(-9.0, 9.0), decades(dice, 0.0, 3.0)
                )
            case 7 if dice.random() < 0.2:
                slave.control_dword = dice.choice((0, 7))
                return 0
            case 8:
                way = Compensation(1, 1e3, 1e3, decades(dice, 0.0, 2.0), 100.0, 5.0, 50.0)
                return commands.start_superposition(slave, way)[0]
        if slave.error_code:
            commands.reset(slave)
        slave.control_dword = 7
        operation = dice.choice((1, 1, 1, 2, 2, 2, 3)) if slave.coupling.law else 0
        return commands.couple_by_cam(slave, kind, master, demand, operation, running)

    def turn(self) -> None:
        """Something happens to somebody."""
        dice = self.dice
        match dice.randint(0, 11):
            case 0 | 1:
                self.lead()
                return
            case 2:
                code = self.edit()
                what = "edit"
            case _:
                slave = dice.choice(self.slaves)
                code = self.act(slave)
                what = f"axis {slave.axis_id}"
        self.accepted += code == 0
        self.refused += code != 0
        self.history.append(f"{what} {code:#x}")


class Observer:
    """The set positions of the slaves, cycle by cycle."""

    def __init__(self, plant: Plant) -> None:
        self.plant = plant
        self.dt = plant.nc.cycle_seconds
        self.before = [(axis.set_position, axis.loop_closed) for axis in plant.slaves]
        encoders = [axis.encoder for axis in plant.slaves]
        self.lowest = [e.soft_limit_min if e.soft_limit_min_enable else -inf for e in encoders]
        self.highest = [e.soft_limit_max if e.soft_limit_max_enable else inf for e in encoders]
        self.fastest = [
            min(axis.max_velocity, axis.drive.reference_velocity) for axis in plant.slaves
        ]
        self.faults = self.moved = 0

    def cycle(self) -> None:
        self.plant.nc.cycle()
        for n, axis in enumerate(self.plant.slaves):
            position, closed = axis.set_position, axis.loop_closed
            before, was_closed = self.before[n]
            self.before[n] = position, closed
            if not closed or not was_closed or position == before:
                continue
            self.moved += 1
            self.faults += axis.error_code != 0
            rounding = 1e-8 + 1e-11 * abs(position)
            way = position - before
            assert abs(way) <= self.fastest[n] * self.dt * (1.0 + 1e-8) + rounding, self.log(axis)
            beyond = position - self.highest[n] if way > 0.0 else self.lowest[n] - position
            assert beyond <= 2e-6 + rounding, self.log(axis)

    def log(self, axis: Axis) -> str:
        return f"axis {axis.axis_id}, error {axis.error_code:#x}, " + "; ".join(
            self.plant.history[-20:]
        )


def play(seed: int, turns: int, *, compiled: bool | None) -> Observer:
    plant = Plant(seed, compiled=compiled)
    observer = Observer(plant)
    for _ in range(turns):
        for _ in range(plant.dice.choice((1, 1, 2, 5))):
            plant.turn()
        for _ in range(plant.dice.choice((1, 1, 2, 10))):
            observer.cycle()
    return observer


@pytest.mark.usefixtures("checked_kernels")
def test_no_accepted_cam_makes_a_slave_jump(many: Callable[[int], int]) -> None:
    """Neither farther in a cycle than the slave may go, nor beyond a soft limit."""
    moved = faults = accepted = 0
    for seed in range(many(3)):
        observer = play(seed, 500, compiled=True)
        moved += observer.moved
        faults += observer.faults
        accepted += observer.plant.accepted
    assert moved > 10_000
    assert accepted > 300
    assert faults > 50


def test_both_kernels_refuse_the_same() -> None:
    plants = [play(7, 40, compiled=compiled).plant for compiled in (False, True)]
    assert plants[0].history == plants[1].history
    assert plants[0].nc.digest() == plants[1].nc.digest()
