"""A slave's life: masters that are not ready, superposition, delayed errors, what is forbidden."""

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from achse.codes import NcError
from achse.codes.nc.choices import TableType
from achse.motion import AxisParameters, Nc, StateBit, commands
from achse.motion.commands.superposition import Compensation
from achse.motion.states import DecouplingType

DT = 0.002
VALUES = {
    "control_dword": 7,
    "velocity_override": 1_000_000,
    "max_velocity": 1e4,
    "drive_reference_velocity": 1e5,
    "controller_following_error_position_monitoring_enable": 0,
}


def pair(*, compiled: bool | None = None, gear: float = 1.0, **values: float) -> Nc:
    axes = [AxisParameters(n, values=VALUES | values) for n in (1, 2)]
    nc = Nc(2_000_000, axes, compiled=compiled)
    nc.cycle(3)
    assert commands.couple(nc.axis(2), 1, 1, 0, 0, gear) == 0
    return nc


def run(nc: Nc, velocity: float, cycles: int = 1500) -> None:
    assert commands.universal_start(nc.axis(1), 3 if velocity > 0 else 4, 0.0, abs(velocity)) == 0
    nc.cycle(cycles)


@example(1, 9048.0472, -3.33557, -1.942343, 0.261718, 303, 260, True)
@example(1, 7769.6087, 3.926576, 1.314871, 0.870907, 432, 17, True)
@settings(max_examples=40, deadline=None)
@given(
    by_actual=st.integers(0, 1),
    fading=st.one_of(st.just(0.0), st.floats(100.0, 1e4)),
    gear=st.floats(-5.0, 5.0).filter(lambda g: abs(g) > 0.1),
    velocity=st.floats(-300.0, 300.0).filter(lambda v: abs(v) > 1.0),
    feedforward=st.floats(0.2, 1.0),
    before=st.integers(1, 800),
    opened=st.integers(1, 600),
    cut=st.booleans(),
)
def test_when_the_loop_of_a_master_opens_and_closes_slaves_do_not_jump(
    by_actual: int,
    fading: float,
    gear: float,
    velocity: float,
    feedforward: float,
    before: int,
    opened: int,
    cut: bool,
) -> None:
    """The following error, 0.04 s of way at most, would be twenty times as much."""
    nc = pair(
        gear=gear,
        couple_slaves_by_actual_values=by_actual,
        fading_acceleration=fading,
        controller_velocity_feedforward_weight=feedforward,
    )
    master, slave = nc
    run(nc, velocity, before)
    p, v = slave.set_position, slave.set_velocity
    if cut:
        master.output_cut = 1
    else:
        master.control_dword = 0
    fade = fading or master.default_acceleration
    turns = 0.25 * fade * DT * DT  # fading that turns round within a cycle
    most = abs(gear) * (0.6 * abs(velocity) * DT + 0.005 + turns)  # a motor that stops dead
    fades = 2.5 * abs(velocity) / fade
    for turn in range(opened + 500 + int(fades / DT)):
        if turn == opened:
            master.output_cut = 0
            master.control_dword = 7
            commands.reset(master)
        nc.cycle()
        step = slave.set_position - p
        assert abs(step - 0.5 * (v + slave.set_velocity) * DT) <= most
        p, v = slave.set_position, slave.set_velocity
    assert slave.coupling_state == 3
    assert (master.fading_position_difference, master.fading_relative_velocity) == (0.0, 0.0)


@pytest.mark.parametrize("compiled", [False, True])
def test_fading_takes_the_difference_away(compiled: bool) -> None:
    """A following error of 20 mm at 0.5 of the feed-forward, faded with 1000 mm/s²."""
    nc = pair(
        compiled=compiled,
        couple_slaves_by_actual_values=1,
        fading_acceleration=1000.0,
        controller_velocity_feedforward_weight=0.5,
        controller_position_kv=10.0,
    )
    master, slave = nc
    run(nc, 400.0)
    assert master.following_error == pytest.approx(20.0, abs=0.5)
    before = slave.set_position
    master.output_cut = 1
    nc.cycle()
    assert slave.set_position - before == pytest.approx(0.8, abs=0.05)
    assert master.fading_position_difference == pytest.approx(20.0, abs=0.5)
    assert abs(master.fading_relative_velocity) < 10.0
    nc.cycle(5)
    assert abs(master.fading_relative_acceleration) == 1000.0
    nc.cycle(500)
    assert master.fading_position_difference == 0.0
    assert slave.set_position == pytest.approx(master.actual_position, abs=1e-9)


@pytest.mark.parametrize("compiled", [False, True])
def test_superposition_on_a_slave(compiled: bool) -> None:
    nc = pair(compiled=compiled)
    master, slave = nc
    compensation = Compensation(1, 1000.0, 1000.0, 20.0, 100.0, 10.0, 200.0)
    run(nc, 100.0)
    assert commands.start_superposition(slave, compensation)[0] == NcError.JOB_FOR_SLAVE
    slave.allow_slave_motion_commands = 1
    code, done = commands.start_superposition(slave, compensation)
    assert (code, done.distance) == (0, 10.0)
    p = slave.set_position
    for _ in range(1500):
        nc.cycle()
        assert 0.0 < slave.set_position - p < 121.0 * DT
        p = slave.set_position
    assert slave.set_position - master.set_position == pytest.approx(10.0, abs=1e-9)
    assert (slave.compensating, slave.coupling_state) == (0, 3)
    assert commands.change_coupling(slave, 2.0, 0.0, 0.0, 0.0) == 0
    at, there = slave.set_position, master.set_position
    nc.cycle(100)
    assert slave.set_position == pytest.approx(at + 2.0 * (master.set_position - there), abs=1e-9)


def test_letting_go_while_something_is_superposed() -> None:
    nc = pair(allow_slave_motion_commands=1)
    _master, slave = nc
    run(nc, 100.0)
    commands.start_superposition(slave, Compensation(1, 1e3, 1e3, 20.0, 100.0, 10.0, 200.0))
    nc.cycle(200)
    p, v = slave.set_position, slave.set_velocity
    assert v > 104.0
    assert commands.decouple(slave) == 0
    nc.cycle()
    assert slave.set_position - p == pytest.approx(v * DT, rel=1e-3)


def test_a_delayed_error_leaves_time_to_stop_the_master() -> None:
    nc = pair(error_reaction_mode=1, error_reaction_delay=1.0)
    master, slave = nc
    run(nc, 100.0)
    slave.controller.following_error_position_max = 1e-9
    slave.controller.following_error_position_filter_time = 0.0
    slave.controller.following_error_position_monitoring_enable = 1
    slave.controller.velocity_feedforward_weight = 0.5
    nc.cycle(10)
    assert slave.delayed_error_code == NcError.FOLLOWING_ERROR_POSITION
    assert slave.state_dword & StateBit.ERROR_PROPAGATION_DELAYED
    assert (slave.error_code, slave.coupling_state) == (0, 3)
    commands.stop(master)
    nc.cycle(450)
    assert (master.set_velocity, slave.set_velocity) == (0.0, 0.0)
    assert slave.coupling_state == 3
    nc.cycle(200)
    assert slave.error_code == NcError.FOLLOWING_ERROR_POSITION
    assert slave.coupling_state == 0


FORBIDDEN = {
    "start": (1, 10.0, 100.0),
    "universal_start": (1, 10.0, 100.0),
    "home": (),
    "stop": (),
    "parameterized_stop": (100.0, 1000.0),
    "emergency_stop": (100.0, 1000.0),
    "oriented_stop": (10.0, 100.0, 1000.0),
}


@pytest.mark.parametrize("name", FORBIDDEN)
@pytest.mark.parametrize("velocity", [0.0, 100.0])
def test_a_slave_takes_no_motion_of_its_own(name: str, velocity: float) -> None:
    nc = pair()
    master, slave = nc
    if velocity:
        run(nc, velocity)
    code = getattr(commands, name)(slave, *FORBIDDEN[name])
    assert code in (NcError.JOB_FOR_SLAVE, NcError.FUNCTION_FOR_SLAVE), hex(code)
    nc.cycle()
    assert slave.set_position == master.set_position


def test_a_moving_encoder_axis_is_no_master_for_a_coupling_at_rest() -> None:
    axes = [AxisParameters(n, values=VALUES) for n in (1, 2)]
    nc = Nc(2_000_000, axes)
    nc.cycle(3)
    master, slave = nc
    commands.universal_start(master, 3, 0.0, 100.0)
    nc.cycle(500)
    master.axis_type = 5
    assert commands.couple(slave, 1, 1, 0, 0, 1.0) == NcError.COUPLING_DURING_JOB
    slave.operation_mode_value = 1.0
    assert commands.couple(slave, 15, 1, 0, 0, 1.0) == 0


@pytest.mark.parametrize("compiled", [False, True])
def test_followers_see_an_encoder_ahead_of_its_dead_time(compiled: bool) -> None:
    """Group 0x606: position plus velocity times the time; a new time fades in."""
    axes = [AxisParameters(n, values=VALUES | {"fading_acceleration": 500.0}) for n in (1, 2)]
    nc = Nc(2_000_000, axes, compiled=compiled)
    master, slave = nc
    master.axis_type, master.control_dword = 5, 0
    nc.cycle(3)
    assert commands.couple(slave, 1, 1, 0, 0, 1.0) == 0
    p, v = slave.set_position, slave.set_velocity
    for turn in range(3000):
        if turn == 500:
            master.coupling_dead_time = 0.05
        if turn == 2000:
            master.coupling_dead_time = 0.0
        master.machine.position += 0.2
        master.wake()
        nc.cycle()
        if turn > 100:
            assert abs(slave.set_velocity - v) <= 500.0 * DT + 0.1
            assert slave.set_position - p == pytest.approx(v * DT, abs=0.01)
        p, v = slave.set_position, slave.set_velocity
        if turn in (1999, 2999):
            ahead = 5.0 if turn == 1999 else 0.0  # 100 mm/s for 0.05 s
            assert slave.set_position - master.actual_position == pytest.approx(ahead, abs=1e-3)


@settings(max_examples=40, deadline=None)
@given(
    gear=st.floats(-5.0, 5.0).filter(lambda g: abs(g) > 0.1),
    velocity=st.floats(-300.0, 300.0).filter(lambda v: abs(v) > 20.0),
    limit=st.floats(5.0, 500.0),
    delayed=st.integers(0, 1),
    superposed=st.booleans(),
)
def test_a_slave_stops_at_its_soft_limit(
    gear: float, velocity: float, limit: float, delayed: int, superposed: bool
) -> None:
    """It comes to rest before the limit and lets go; its master goes on."""
    limit = min(limit, 30.0 * abs(gear * velocity))  # it is there within 40 s
    nc = pair(gear=gear, allow_slave_motion_commands=1, error_reaction_mode=delayed)
    master, slave = nc
    encoder = slave.encoder
    encoder.soft_limit_min, encoder.soft_limit_max = -limit, limit
    encoder.soft_limit_min_enable = encoder.soft_limit_max_enable = 1
    slave.wake(adapts=True)
    run(nc, velocity, 1)
    for turn in range(20_000):
        nc.cycle()
        assert abs(slave.set_position) <= limit + 1e-3
        if turn == 20 and superposed:
            compensation = Compensation(1, 1e3, 1e3, 20.0, 100.0, 10.0, 200.0)
            commands.start_superposition(slave, compensation)
        if slave.error_code and slave.set_velocity == 0.0:
            break
    upward = gear * velocity > 0.0
    passed = NcError.SOFT_LIMIT_MAX_PASSED if upward else NcError.SOFT_LIMIT_MIN_PASSED
    assert (slave.error_code, slave.coupling_state) == (passed, 0)
    assert abs(slave.set_position) > 0.5 * limit - 1.0
    assert (master.error_code, master.coupling_state) == (0, 0)
    assert master.set_velocity != 0.0


@pytest.mark.parametrize("compiled", [False, True])
def test_a_slave_turns_without_end(compiled: bool) -> None:
    """Modulo axes count turns: a slave of a turning master keeps its gear over them, both ways."""
    nc = pair(compiled=compiled, gear=-0.5, encoder_modulo_factor=360.0, unit_interpretation=4)
    master, slave = nc
    for velocity, seconds in ((3600.0, 20), (-3600.0, 30)):
        run(nc, velocity, 500 * seconds)
        assert slave.set_position == pytest.approx(-0.5 * master.set_position, abs=1e-9)
        turns, angle = divmod(slave.set_position, 360.0)
        assert (slave.set_modulo_turns, slave.set_position_modulo) == (turns, pytest.approx(angle))
    assert commands.decouple_with_follow_up(slave, DecouplingType.ORIENTED_STOP, 90.0) == 0
    nc.cycle(3000)
    assert slave.set_velocity == 0.0
    assert slave.set_position_modulo == pytest.approx(90.0, abs=1e-6)


def test_a_slave_may_be_faster_than_its_own_largest_velocity() -> None:
    """A law asks for what it asks for; the drive alone limits. Let go, limits hold again."""
    nc = pair(max_velocity=200.0, gear=2.0)
    _, slave = nc
    run(nc, 190.0)
    assert (slave.set_velocity, slave.error_code) == (380.0, 0)
    p = slave.set_position
    assert commands.decouple(slave) == 0
    nc.cycle()
    assert slave.set_position - p == pytest.approx(380.0 * DT, rel=0.01)


LAWS_THAT_SYNCHRONISE = {2, 3, 5, 6, 12}


@pytest.mark.parametrize("kind", [1, 10, 15, 16, 17, *sorted(LAWS_THAT_SYNCHRONISE)])
def test_what_a_slave_shows_as_its_motion_state(kind: int) -> None:
    """11 to 13 are of slaves that synchronise (002 §6.4.9); others show their set point."""
    axes = [AxisParameters(n, values=VALUES | {"max_velocity": 500.0}) for n in (1, 2, 3)]
    nc = Nc(2_000_000, axes)
    nc.tables.write(nc.tables.create(7, TableType.CAMMING, 3, 2, 2), 0, (0.0, 0.0, 1e5, 1e5))
    nc.cycle(3)
    master, slave = nc.axis(1), nc.axis(2)
    slave.operation_mode_value = slave.gear_ratio_1 = 1.0
    code = {
        10: lambda: commands.couple_by_cam(slave, 10, 1, commands.CamDemand(7)),
        2: lambda: commands.couple(slave, 2, 1, 0, 0, 100.0, 25.0, 90.0, 1.0),
        3: lambda: commands.couple(slave, 3, 1, 0, 0, 100.0, 25.0, 90.0, 1.0),
        5: lambda: commands.synchronise(slave, 5, 1, 0, 0, 1.0, 0, 0, 0, 0, 0, 0, 0),
        6: lambda: commands.synchronise(slave, 6, 1, 0, 0, 1.0, 100.0, 50.0, 0, 0, 0, 0, 0),
        12: lambda: commands.couple(slave, 12, 1, 0, 0, 1.0, 1.0),
        15: lambda: commands.couple(slave, 15, 1, 0, 0, 10.0),
        16: lambda: commands.couple(slave, 16, 1, 0, 0, 1.0, 1.0, 3.0),
        17: lambda: commands.couple_to_several(slave, 17, (1, 3, 0, 0), 1e3),
    }.get(kind, lambda: commands.couple(slave, 1, 1, 0, 0, 1.0))()
    assert code == 0
    states = []
    commands.universal_start(master, 1, 400.0, 100.0)
    for _ in range(3000):
        nc.cycle()
        if slave.motion_state not in states:
            states.append(slave.motion_state)
        phase = slave.state_dword & (StateBit.NOT_MOVING | StateBit.HAS_JOB)
        wanted = StateBit.NOT_MOVING if slave.set_velocity == 0.0 else StateBit.HAS_JOB
        assert phase == wanted
    if kind in LAWS_THAT_SYNCHRONISE:
        assert states[-1] == 13
        assert set(states) <= {0, 11, 12, 13}
    else:
        assert set(states) >= {0, 3, 4, 5}
        assert set(states) <= {0, 1, 3, 4, 5}
