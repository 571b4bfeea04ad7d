"""New positions and scalings (0x1A … 0x1F), and offsets of cams (0x43), of coupled axes: no step.

What is renamed between two cycles stays where it is: in the next cycles no axis goes farther than
its velocity allows, whatever law it follows, and whatever master is renamed.
"""

import random
from collections import Counter
from collections.abc import Callable
from typing import Any

import pytest

from achse.codes import NcError
from achse.codes.axis import ActualPositionType
from achse.codes.nc.choices import TableType
from achse.motion import Axis, AxisParameters, Nc, commands
from achse.motion.commands import CamDemand
from achse.motion.setpoints.dynamics import fastest
from achse.motion.states import SlaveType
from tests.motion.couplings.test_cams_drawn import drawn_points
from tests.motion.enabled_axes import QUICK

TABLE = 7
KINDS = (SlaveType.LINEAR, SlaveType.TABULAR, SlaveType.MULTI_TABULAR)


def rename(axis: Axis, dice: random.Random) -> int:
    """Give the present position another value, or change what a count means."""
    position = dice.choice((dice.uniform(-1.0, 1.0), dice.uniform(-500.0, 500.0)))
    kind = dice.choice((ActualPositionType.ABSOLUTE, ActualPositionType.RELATIVE))
    factor = axis.encoder.scaling_factor * dice.uniform(0.5, 2.0)
    match dice.randrange(4):
        case 0:
            return commands.set_actual_position(axis, kind, position)
        case 1:
            return commands.set_actual_position_on_the_fly(
                axis, dice.choice((1, 2)), dice.randrange(2), position
            )
        case 2:
            return commands.set_encoder_scaling_factor(axis, dice.choice((1, 2)), 0, factor)
    return commands.set_actual_position_only(axis, kind, position)


def shift(slave: Axis, dice: random.Random) -> int:
    """Offsets of a cam (0x43), with scalings or at a master position, or other changes."""
    numbers = [dice.choice((0.0, 0.0, 0.1, 80.0)) * dice.uniform(-1.0, 1.0) for _ in range(2)]
    scalings = [dice.uniform(-2.0, 2.0) for _ in range(2)]
    match dice.randrange(3):
        case 0:
            return commands.change_cam_offsets(slave, *numbers)
        case 1:
            return commands.change_cam_offsets(slave, *numbers, *scalings)
    return commands.change_cam_offsets(slave, *numbers, *scalings, dice.uniform(-300.0, 300.0))


def drawn_nc(dice: random.Random) -> Nc:
    """A master, a slave and a slave of that, on machines of any velocity."""
    values = QUICK | {
        "couple_slaves_by_actual_values": dice.choice((0, 0, 1)),
        "position_range_window": dice.choice((0.0, 0.0, 2.0)),
        "encoder_modulo_factor": dice.choice((100.0, 360.0)),
    }
    nc = Nc(
        dice.choice((500_000, 2_000_000)),
        [
            AxisParameters(n, values=values | {"max_velocity": 10.0 ** dice.uniform(2.0, 3.5)})
            for n in (1, 2, 3)
        ],
        compiled=dice.random() < 0.8,
    )
    points = drawn_points(dice, equidistant=False)
    table = nc.tables.create(TABLE, TableType.CAMMING, dice.choice((3, 4)), len(points), 2)
    nc.tables.write(table, 0, [number for point in points for number in point])
    nc.cycle(3)
    return nc


def couple(slave: Axis, master: int, dice: random.Random) -> int:
    kind = dice.choice(KINDS)
    if kind == SlaveType.LINEAR:
        return commands.couple(slave, kind, master, 0, 0, dice.choice((-0.5, 0.3, 1.0)))
    demand = CamDemand(
        TABLE,
        slave_absolute=dice.choice((0, 0, 1)),
        master_absolute=dice.randrange(2),
        slave_offset=dice.choice((0.0, slave.set_position)),
        slave_scaling=dice.uniform(-1.0, 1.0),
    )
    return commands.couple_by_cam(slave, kind, master, demand)


def test_what_is_renamed_or_shifted_makes_no_step(many: Callable[[int], int]) -> None:
    accepted: Counter[str] = Counter()
    for seed in range(many(24)):
        dice = random.Random(f"renamed {seed}")
        nc = drawn_nc(dice)
        master, slave, last = axes = list(nc)
        couple(slave, 1, dice)
        couple(last, 2, dice)
        for _ in range(8):
            if dice.random() < 0.4:
                commands.start(master, 1, dice.uniform(-300.0, 300.0), dice.uniform(5.0, 80.0))
            if dice.random() < 0.3:
                master.velocity_override = dice.choice((0, 1_000_000))
            nc.cycle(dice.randrange(80))
            one = dice.choice(axes)
            name, act = dice.choice((("rename", rename), ("shift", shift)))
            accepted[name] += act(one, dice) == 0 and (one is master or bool(one.coupling.law))
            for _ in range(dice.choice((1, 10))):
                before = [(each.set_position, each.loop_closed) for each in axes]
                nc.cycle()
                for each, (position, closed) in zip(axes, before, strict=True):
                    if closed and each.loop_closed and not _is_faster_gear(each, axes):
                        step = abs(each.set_position - position)
                        allowed = fastest(each) * nc.cycle_seconds
                        assert step <= allowed * (1 + 1e-6) + 1e-6, (seed, each, name)
    assert accepted["rename"] > 30
    assert accepted["shift"] > 4


def _is_faster_gear(axis: Axis, axes: list[Axis]) -> bool:
    """True for a gear behind an axis that may be faster: its slaves follow all the same (0186)."""
    master = axes[axis.index - 1]
    return axis.coupling.law == SlaveType.LINEAR and fastest(master) > fastest(axis)


@pytest.mark.parametrize("offset", [5.0, -40.0, 1e6])
def test_offset_that_would_step_is_refused(make_axes: Any, offset: float) -> None:
    nc = make_axes(2, max_velocity=1000.0, position_range_window=0.1)
    master, slave = nc.axis(1), nc.axis(2)
    table = nc.tables.create(TABLE, TableType.CAMMING, 3, 2, 2)
    nc.tables.write(table, 0, [0.0, 0.0, 100.0, 50.0])
    assert commands.couple_by_cam(slave, 10, 1, CamDemand(TABLE)) == 0
    commands.start(master, 1, 80.0, 100.0)
    nc.cycle(200)
    assert commands.change_cam_offsets(slave, offset, 0.0) == NcError.TABLE_SLAVE_RANGE
    assert commands.change_cam_offsets(slave, 0.01 * offset / abs(offset), 0.0) == 0
    before = slave.set_position
    nc.cycle()
    assert abs(slave.set_position - before) < 0.2
