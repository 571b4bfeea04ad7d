"""Enables withdrawn and given back at any moment of any motion: no position steps.

While the loop is closed, no set and no actual position goes farther in a cycle than the axis may.
When it opens or closes, the set position becomes the actual one, where the axis is. Both kernels
have the same bits.
"""

import random
from collections import Counter
from collections.abc import Callable

from achse.codes import NcError
from achse.codes.axis import ControlBit
from achse.codes.nc.choices import TableType
from achse.motion import Axis, AxisParameters, Nc, commands
from achse.motion.commands import CamDemand
from achse.motion.setpoints.dynamics import fastest
from tests.motion.enabled_axes import QUICK

ALL = 7
CAM = [0.0, 0.0, 50.0, 30.0, 200.0, 10.0]
MASKS = (0, 6, 5, 3, 1)
ROUNDING = 1e-6
OVERSHOOT = 1.05
"""Most that a loop adds to the velocity of its set point: it takes away following errors."""


def drawn_nc(dice: random.Random, compiled: bool) -> Nc:
    top = 10.0 ** dice.uniform(2.0, 3.5)
    acceleration = top * 10.0 ** dice.uniform(-0.5, 1.2)
    values = QUICK | {
        "max_velocity": top,
        "default_acceleration": acceleration,
        "default_deceleration": acceleration,
        "max_acceleration": 10.0 * acceleration,
        "max_deceleration": 10.0 * acceleration,
        "default_jerk": acceleration * 10.0 ** dice.uniform(0.5, 2.0),
        "controller_velocity_feedforward_weight": dice.choice((1.0, 1.0, 0.5)),
        "couple_slaves_by_actual_values": dice.randrange(2),
        "error_reaction_mode": dice.randrange(2),
        "error_reaction_delay": dice.choice((0.0, 0.1)),
    }
    nc = Nc(
        dice.choice((500_000, 1_000_000, 2_000_000)),
        [AxisParameters(n, values=values) for n in (1, 2)],
        compiled=compiled,
    )
    nc.tables.write(nc.tables.create(7, TableType.CAMMING, 3, 3, 2), 0, CAM)
    nc.cycle(3)
    return nc


def act(nc: Nc, dice: random.Random) -> int:
    """A command, an enable that changes, or one that is away for some cycles. Return its code."""
    master, slave = nc.axis(1), nc.axis(2)
    axis, top = dice.choice((master, master, slave)), master.max_velocity
    place, velocity = dice.uniform(-top, top), dice.uniform(0.05, 1.0) * top
    match dice.randrange(12):
        case 0 | 1 | 2:
            return commands.start(axis, 1, place, velocity)
        case 3:
            return commands.start(axis, dice.choice((3, 4)), 0.0, velocity)
        case 4:
            axis.control_dword = dice.choice(MASKS)
        case 5 | 6:
            axis.control_dword = dice.choice(MASKS)
            _cycles(nc, dice.choice((0, 1, 1, 2, 5, 50)))
            axis.control_dword = ALL
        case 7 | 8:
            for each in nc:
                if each.error_code and dice.random() < 0.9:
                    commands.reset(each)
                each.control_dword = ALL
        case 9:
            axis.velocity_override = dice.choice((0, 1_000_000, 1_000_000))
        case 10:
            return commands.couple(slave, 1, 1, 0, 0, dice.choice((1.0, -1.0, 0.5)))
        case 11:
            if slave.coupling.law:
                return commands.decouple(slave)
            demand = CamDemand(7, master_absolute=1, slave_offset=slave.set_position)
            return commands.couple_by_cam(slave, 10, 1, demand)
    return 0


def _cycles(nc: Nc, count: int) -> None:
    for _ in range(count):
        before = [_seen(axis) for axis in nc]
        nc.cycle()
        for axis, (position, actual, closed) in zip(nc, before, strict=True):
            most = fastest(axis) * nc.cycle_seconds * OVERSHOOT + ROUNDING
            assert abs(axis.actual_position - actual) <= most
            if closed and axis.loop_closed:
                assert abs(axis.set_position - position) <= most
            else:
                assert abs(axis.set_position - axis.actual_position) <= most


def _seen(axis: Axis) -> tuple[float, float, int]:
    return axis.set_position, axis.actual_position, axis.loop_closed


def test_no_position_steps_whatever_is_withdrawn(many: Callable[[int], int]) -> None:
    errors: Counter[int] = Counter()
    opened = 0
    for seed in range(many(14)):
        digests = []
        for compiled in (True, False):
            dice = random.Random(f"enables {seed}")
            nc = drawn_nc(dice, compiled)
            codes = []
            for _ in range(25 if seed % 7 == 0 or compiled else 0):
                codes.append(act(nc, dice))
                _cycles(nc, dice.choice((1, 2, 20, 60)))
                errors.update(axis.error_code for axis in nc)
                opened += any(not axis.loop_closed for axis in nc)
            digests.append((nc.digest(), codes))
        assert digests[0] == digests[1] or seed % 7
    assert errors[NcError.CONTROLLER_ENABLE_MISSING.number] > 20
    assert errors[NcError.FEED_ENABLE_PLUS_WITHDRAWN.number] > 5
    assert opened > 20


def test_enable_given_back_within_the_ramp_ends_at_rest() -> None:
    """The error stays: the axis rests where its ramp ends, with its loop closed."""
    for cycles in (1, 2, 7, 30):
        nc = drawn_nc(random.Random(cycles), compiled=False)
        axis = nc.axis(1)
        commands.start(axis, 3, 0.0, 0.5 * axis.max_velocity)
        nc.cycle(400)
        axis.control_dword = ALL & ~ControlBit.ENABLE
        _cycles(nc, cycles)
        axis.control_dword = ALL
        _cycles(nc, 2500)
        assert axis.error_code == NcError.CONTROLLER_ENABLE_MISSING.number
        assert axis.set_velocity == 0.0
        place = axis.set_position
        _cycles(nc, 20)
        assert axis.set_position == place
