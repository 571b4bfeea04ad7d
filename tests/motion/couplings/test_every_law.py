"""Every law with everything drawn: chains, orders, changes, and letting go at any moment.

Set points of both kernels are the same to the bit. A slave keeps its law to 1e-9 in each cycle, and
whatever lets it go, it goes on from the position and velocity that it has.
"""

import random
from collections.abc import Callable, Iterator
from math import pi, radians, sin

import pytest

from achse.codes.axis import MotionState, StateBit
from achse.codes.nc.choices import MotionPhase, TableType
from achse.motion import Axis, AxisParameters, Nc, commands
from achse.motion.commands import CamDemand
from achse.motion.commands.superposition import Compensation
from achse.motion.states import DecouplingType, SlaveType
from achse.motion.tables import MOTION_POINT

TABLE, FUNCTION = 7, 8
FULL = 1_000_000
RUNS = MotionState.SLAVE_SYNCHRONOUS
LAWS = (1, 2, 3, 5, 6, 10, 11, 12, 13, 15, 16, 17, 18)


def station(dice: random.Random, compiled: bool) -> Nc:
    """Three to six axes in any order of ids, on machines of any quality."""
    ids = dice.sample(range(1, 100), dice.randint(3, 6))
    period = dice.choice((360.0, 100.0))
    parts = []
    for id in ids:
        top = 10.0 ** dice.uniform(2.0, 3.5)
        acceleration = top * 10.0 ** dice.uniform(0.0, 1.0)
        values = {
            "control_dword": 7,
            "velocity_override": FULL,
            "max_velocity": top,
            "default_acceleration": acceleration,
            "default_deceleration": acceleration * 10.0 ** dice.uniform(-0.5, 0.0),
            "max_acceleration": 100.0 * acceleration,
            "max_deceleration": 100.0 * acceleration,
            "default_jerk": acceleration * 10.0 ** dice.uniform(0.5, 2.0),
            "fading_acceleration": dice.choice((0.0, acceleration)),
            "couple_slaves_by_actual_values": dice.randint(0, 1),
            "allow_slave_motion_commands": dice.randint(0, 1),
            "error_reaction_mode": dice.randint(0, 1),
            "error_reaction_delay": dice.choice((0.0, 0.1)),
            "encoder_modulo_factor": period,
            "controller_velocity_feedforward_weight": dice.choice((1.0, 0.5)),
            "controller_slave_coupling_kcp": dice.choice((0.0, 2.0)),
            "controller_following_error_position_monitoring_enable": dice.randint(0, 1),
            "controller_following_error_position_max": dice.choice((1e6, 50.0)),
            "motion_monitoring_enable": dice.randint(0, 1),
        }
        second = (id + 100,) if dice.random() < 0.5 else ()
        parts.append(AxisParameters(id, values=values, encoder_ids=(id, *second) if second else ()))
    nc = Nc(dice.choice((500_000, 1_000_000, 2_000_000)), parts, compiled=compiled)
    points = [number for n in range(9) for number in (45.0 * n, dice.uniform(-30.0, 30.0))]
    nc.tables.write(nc.tables.create(TABLE, TableType.CAMMING, dice.randint(1, 4), 9, 2), 0, points)
    function = nc.tables.create(FUNCTION, TableType.MOTION_FUNCTION, dice.choice((3, 4)), 3, 1)
    motion = (
        (0.0, 0.0, 0.0),
        (dice.uniform(50.0, 150.0), dice.uniform(20.0, 80.0), dice.uniform(-1.0, 1.0)),
        (360.0, 0.0, 0.0),
    )
    nc.tables.write_points(
        function,
        0,
        b"".join(
            MOTION_POINT.pack(n + 1, 15, 8, 1, 0, *at, 0.0, 0.0) for n, at in enumerate(motion)
        ),
    )
    nc.cycle(3)
    for axis in nc:
        if len(axis.encoders) > 1:  # the radius of a drum
            axis.encoders[1].scaling_factor = 1e-12
            axis.encoders[1].position_offset = dice.uniform(20.0, 200.0)
    nc.cycle(3)
    return nc


def couple(nc: Nc, dice: random.Random, slave: Axis) -> int:
    """A law and all its parameters."""
    axes = list(nc)
    master, other = dice.choice(axes), dice.choice(axes)
    gear = dice.choice((-1.0, 1.0)) * 10.0 ** dice.uniform(-1.0, 0.5)
    kind = dice.choice(LAWS)
    way = dice.choice((-1.0, 1.0)) * dice.uniform(1.0, 300.0)
    behind = (1.0 if gear > 0.0 else -1.0) * way
    dynamics = [dice.choice((0.0, 10.0 ** dice.uniform(2.0, 4.0))) for _ in range(4)]
    id = master.axis_id
    match kind:
        case 2 | 3:
            places = (master.set_position + 4.0 * way, slave.set_position + behind)
            if dice.random() < 0.3:
                places = (0.0, 0.0)
            return commands.couple(
                slave, kind, id, 0, 0, *places, dice.uniform(20.0, 90.0), dice.choice((0.0, gear))
            )
        case 5 | 6:
            top, acceleration, deceleration, jerk = dynamics
            return commands.synchronise(
                slave, kind, id, 0, 0, gear, master.set_position + 3.0 * way,
                slave.set_position + 3.0 * gear * way * dice.uniform(0.5, 1.5),
                top, acceleration, deceleration, jerk,
                dice.choice((0, 0, dice.randrange(1 << 16))),
            )  # fmt: skip
        case 10 | 11 | 13:
            demand = CamDemand(
                FUNCTION if kind == 13 else TABLE, dice.randrange(4), dice.uniform(-50.0, 50.0),
                dice.uniform(-50.0, 50.0), dice.uniform(-2.0, 2.0), gear, 0,
                dice.randint(0, 1), dice.choice((0, 2, 5)),
                master.set_position + dice.uniform(-20.0, 20.0), 0, 0,
            )  # fmt: skip
            return commands.couple_by_cam(slave, kind, id, demand, dice.choice((0, 1)))
        case 12:
            second = float(other.axis_id) if dice.random() < 0.5 else 0.0
            return commands.couple(slave, kind, id, 0, 0, 1.0, dice.uniform(0.1, 1.0), second)
        case 15 | 18:
            slave.operation_mode_value = dice.choice((0.0, gear))
            slave.gear_ratio_1 = 0.5 * gear
            return commands.couple(slave, kind, id, 0, 0, 10.0 ** dice.uniform(0.0, 3.0))
        case 16:
            return commands.couple(slave, kind, id, 0, 0, gear, 0.5, float(other.axis_id))
        case 17:
            slave.gear_ratio_1, slave.gear_ratio_2 = gear, dice.uniform(-1.0, 1.0)
            ids = dice.choice(((id, other.axis_id, 0, 0), (id, 0, 0, other.axis_id), (id, 0, 0, 0)))
            return commands.couple_to_several(slave, dice.choice((15, 17, 100)), ids, *dynamics)
    return commands.couple(slave, kind, id, 0, 0, gear)


def change(dice: random.Random, slave: Axis) -> int:
    """New parameters, ratios or a shift of the phase."""
    gear = dice.choice((-1.0, 1.0)) * 10.0 ** dice.uniform(-1.0, 0.5)
    values = list(slave.coupling.parameters)
    match dice.randint(0, 6):
        case 5:
            return commands.start_phasing(
                slave, 1, 0, 0, 50.0 * gear, 10.0 ** dice.uniform(1.0, 3.0)
            )
        case 6:
            compensation = Compensation(1, 1e3, 1e3, 20.0, 100.0, 5.0 * gear, 300.0)
            return commands.start_superposition(slave, compensation)[0]
        case 0:
            slave.gear_ratio_1 = slave.operation_mode_value = gear
            return 0
        case 1:
            return commands.scale_slave(slave, gear)
        case 2:
            return commands.change_cam_offsets(slave, gear, 5.0 * gear)
        case 3 if slave.coupling.law in (2, 3):
            values[3] = gear
        case _:
            values[0] = gear
    return commands.change_coupling(slave, *values)


def free(dice: random.Random, slave: Axis) -> tuple[int, bool]:
    """One of the ways to let a slave go; whether the set point may stand at once."""
    position = slave.set_position + dice.uniform(-500.0, 500.0)
    velocity = 10.0 ** dice.uniform(1.0, 3.0)
    dynamics = [dice.choice((0.0, 10.0 ** dice.uniform(3.0, 4.0))) for _ in range(3)]
    match dice.randint(0, 4):
        case 0:
            return commands.decouple(slave), False
        case 1:
            return commands.stop_slave(slave), False
        case 2:
            return commands.decouple_and_start(slave, 1, position, velocity, *dynamics), False
        case 3:
            return commands.universal_start(slave, 1, position, velocity), False
    form = dice.choice(list(DecouplingType))
    code = commands.decouple_with_follow_up(slave, form, position, velocity, *dynamics)
    return code, form == DecouplingType.INSTANTANEOUS_STOP


def act(nc: Nc, dice: random.Random, healthy: bool) -> list[object]:
    """Something happens to one of the axes."""
    axis = dice.choice(list(nc))
    top = axis.max_velocity
    kind = dice.randint(0, 13)
    if kind < 4 and not axis.coupling.law:
        return [
            commands.universal_start(
                axis,
                dice.choice((1, 2, 3, 4)),
                dice.uniform(-2000.0, 2000.0),
                dice.uniform(0.1, 1.0) * top,
            )
        ]
    if kind < 7 and not axis.coupling.law:
        return [couple(nc, dice, axis)]
    if kind == 7:
        axis.velocity_override = dice.choice((FULL, dice.randint(0, FULL)))
        return []
    if kind == 8:
        return [commands.stop(axis)] if not axis.coupling.law else [change(dice, axis)]
    if kind == 9 and axis.coupling.law:
        return [change(dice, axis)]
    if kind == 10 and not healthy:
        axis.control_dword = dice.choice((0, 7, 7))
        return [commands.reset(axis)] if axis.error_code else []
    if kind == 11 and not healthy:
        axis.output_cut = 1
    return []


def law_of(axis: Axis) -> tuple[float, ...]:
    """While this stays, the law has one closed form."""
    law = axis.coupling
    return law.law, axis.sync.state, law.in_gear, law.gear, law.gear_weight, law.master_moved


def begin(nc: Nc, dice: random.Random) -> list[object]:
    """Couple most axes at rest; others are at a stop, or on their way."""
    axes = list(nc)
    reports: list[object] = [couple(nc, dice, axis) for axis in dice.sample(axes, len(axes) - 1)]
    for axis in nc:
        if not axis.coupling.law and dice.random() < 0.7:
            velocity = dice.uniform(0.1, 1.0) * axis.max_velocity
            reports.append(commands.universal_start(axis, dice.choice((3, 4)), 0.0, velocity))
    return reports


def expected(nc: Nc, slave: Axis, before: dict[int, float], shifted: float) -> float | None:
    """The way of this cycle by the closed form, where the law has one that knows no history.

    `before` is where the slave saw its masters, `shifted` its phase then.
    """
    axes = list(nc)
    ways = [axes[row].leading_value.position - before[row] for row in slave.followed]
    ways[0] += slave.phasing_position - shifted
    values = slave.coupling.parameters
    runs = slave.motion_state == RUNS
    match slave.coupling.law:
        case SlaveType.LINEAR:
            return values[0] * ways[0]
        case SlaveType.FLYING_SAW_VELOCITY | SlaveType.FLYING_SAW_POSITION if runs:
            return (values[3] or 1.0) / sin(radians(values[2])) * ways[0]
        case SlaveType.SYNCHRONISING_VELOCITY | SlaveType.SYNCHRONISING_POSITION if runs:
            return values[0] * ways[0]
        case SlaveType.MODULO_FLYING_SAW if runs:
            return ways[int(values[0]) - 1]
        case SlaveType.CYCLIC_GEAR:
            return slave.coupling.gear * ways[0]
        case SlaveType.SURFACE_SPEED:
            return 180.0 / pi / slave.encoders[1].actual_position * slave.coupling.gear * ways[0]
        case SlaveType.BILINEAR if slave.coupling.master_moved:
            return values[0] * ways[0] + values[1] * ways[1]
        case SlaveType.MULTI_MASTER if slave.coupling.in_gear:
            return sum(slave.coupling.ratios[n] * way for n, way in enumerate(ways))
    return None


def watch(nc: Nc, seed: int, healthy: bool) -> Iterator[tuple[object, ...]]:
    """Play one history; each cycle is looked at and told."""
    dice = random.Random(seed)
    dt = nc.cycle_seconds
    for turn in range(41):
        message = act(nc, dice, healthy) if turn else begin(nc, dice)
        slaves = [axis for axis in nc if axis.coupling.law]
        released, stands = None, False
        if slaves and dice.random() < 0.25:
            released = dice.choice(slaves)
            at, v, a = released.set_position, released.set_velocity, released.set_acceleration
            code, stands = free(dice, released)
            message.append(code)
            if released.coupling.law:
                released = None
        for n in range(dice.choice((1, dice.randint(1, 80)))):
            axes = list(nc)
            laws = [law_of(axis) for axis in axes]
            before = {row: axis.leading_value.position for row, axis in enumerate(axes)}
            here = [
                (axis.set_position - axis.coupling.offset, axis.phasing_position,
                 axis.set_motion_phase)
                for axis in axes
            ]  # fmt: skip
            nc.cycle()
            if released is not None and n == 0 and released.loop_closed:
                step = released.set_position - at
                own = max(released.default_acceleration, released.default_deceleration, 1e4)
                bend = abs(a) + own
                if stands:
                    assert step == 0.0
                else:
                    assert abs(step - v * dt) <= bend * dt * dt + 1e-9
                    if not released.error_code:
                        assert abs(released.set_velocity - v) <= 2.0 * bend * dt + 1e-9
            for axis, law, (position, shifted, phase) in zip(axes, laws, here, strict=True):
                assert abs(axis.set_position) < 1e9
                if not axis.coupling.law or law != law_of(axis) or not axis.loop_closed:
                    continue
                way = expected(nc, axis, before, shifted)
                if way is None or n == 0 or phase != MotionPhase.COUPLED:
                    continue
                scale = 1.0 + abs(axis.set_position) + abs(before[axis.followed[0]])
                moved = axis.set_position - axis.coupling.offset - position
                assert moved == pytest.approx(way, abs=1e-12 * scale + 1e-9)
            yield (
                *message,
                *(
                    (axis.set_position, axis.set_velocity, axis.set_acceleration, axis.set_jerk,
                     axis.actual_position, axis.coupling_state, axis.motion_state,
                     axis.state_dword, axis.error_code)
                    for axis in axes
                ),
            )  # fmt: skip


@pytest.mark.parametrize("healthy", [True, False])
def test_laws_are_kept_and_letting_go_never_jumps(
    healthy: bool, many: Callable[[int], int]
) -> None:
    for seed in range(many(6)):
        _compare(seed, healthy)


def _compare(seed: int, healthy: bool) -> None:
    plain, compiled = (
        watch(station(random.Random(seed), kernel), seed + 5000, healthy)
        for kernel in (False, True)
    )
    for one, other in zip(plain, compiled, strict=True):
        assert one == other


RAMPS = (SlaveType.CYCLIC_GEAR, SlaveType.SURFACE_SPEED, SlaveType.MULTI_MASTER)
"""Laws whose ratio changes by a ramp, cycle by cycle."""


def shown(slave: Axis) -> tuple[object, ...]:
    """What clients read of a coupling besides its ratio: law, state, masters, table, its bits."""
    law, bits = slave.coupling.law, slave.state_dword & _BITS
    return law, slave.coupling_state, tuple(slave.followed), slave.coupling_table_index, bits


_BITS = (
    StateBit.CAM_TABLE_QUEUED
    | StateBit.CAM_SCALING_PENDING
    | StateBit.CAM_DATA_QUEUED
    | StateBit.PROTECTED
)


def test_what_was_answered_is_visible_before_the_next_cycle() -> None:
    """Requests of all kinds of couplings, masters at rest: a cycle changes nothing of them."""
    accepted: set[int] = set()
    for seed in range(12):
        dice = random.Random(f"visible {seed}")
        nc = station(dice, compiled=True)
        for _ in range(60):
            slave = dice.choice(list(nc))
            if not slave.coupling.law:
                code = couple(nc, dice, slave)
            elif dice.random() < 0.5:
                code = change(dice, slave)
            else:
                code = commands.decouple(slave)
            before, ratio = shown(slave), slave.set_gear_ratio
            at_rest = all(axis.set_velocity == 0.0 for axis in nc)
            nc.cycle()
            if code == 0 and at_rest:
                accepted.add(slave.coupling.law)
                assert shown(slave) == before
                if slave.set_velocity == 0.0 and slave.coupling.law not in RAMPS:
                    assert slave.set_gear_ratio == pytest.approx(ratio, abs=1e-5)
            nc.cycle(200)
    assert accepted >= {0, SlaveType.MULTI_MASTER, *LAWS} - {SlaveType.SEVERAL_CYCLIC_GEARS}
