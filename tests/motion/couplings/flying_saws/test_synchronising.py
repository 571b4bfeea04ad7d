"""Slave types 5 and 6 in the cycle: they keep their law, go back with their master, and stop."""

from itertools import pairwise
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import commands
from achse.motion.states import SynchronisingBit as Bit
from tests.motion.enabled_axes import gentle_axes

OFF, SYNCHRONISES, RUNS = 0, 12, 13


@pytest.mark.parametrize("compiled", [False, True])
def test_by_position_from_rest(compiled: bool) -> None:
    """M 100 → 300, S 20 → 120, g = 1: the worked numbers at 150, 200 and 250."""
    nc = gentle_axes(compiled=compiled)
    master, slave = nc
    commands.set_actual_position(master, 1, 100.0)
    commands.set_actual_position(slave, 1, 20.0)
    nc.cycle(5)
    assert commands.synchronise(slave, 6, 1, 0, 0, 1.0, 300.0, 120.0) == 0
    for target, place in ((150.0, 22.734375), (200.0, 38.75), (250.0, 72.734375), (400.0, 220.0)):
        commands.universal_start(master, 1, target, 100.0)
        nc.cycle(1500)
        assert (master.set_position, slave.set_velocity) == (target, 0.0)
        assert slave.set_position == pytest.approx(place, abs=1e-9)
        assert slave.motion_state == (RUNS if target == 400.0 else SYNCHRONISES)


@pytest.mark.parametrize("compiled", [False, True])
def test_by_position_in_motion(compiled: bool) -> None:
    """M 100 → 260, S 20 → 150, v0 = 0.25, g = 1.25: the formula in each cycle."""
    nc = gentle_axes(compiled=compiled)
    master, slave = nc
    commands.universal_start(master, 3, 0.0, 100.0)
    commands.universal_start(slave, 3, 0.0, 25.0)
    nc.cycle(1000)
    m0, s0 = master.set_position, slave.set_position
    code = commands.synchronise(slave, 6, 1, 0, 0, 1.25, m0 + 160.0, s0 + 130.0)
    assert code == 0
    worked = {40.0: 13.22265625, 80.0: 40.0, 120.0: 81.15234375}
    a, b = 130.0 - 40.0, 1.25 * 160.0 - 40.0
    speed = slave.set_velocity
    for _ in range(1000):
        nc.cycle()
        way = master.set_position - m0
        u = way / 160.0
        place = 40.0 * u + (10 * a - 4 * b) * u**3
        place += (7 * b - 15 * a) * u**4 + (6 * a - 3 * b) * u**5
        if u > 1.0:
            place = 130.0 + 1.25 * (way - 160.0)
        assert slave.set_position - s0 == pytest.approx(place, abs=1e-9)
        assert abs(slave.set_velocity - speed) < 0.5
        speed = slave.set_velocity
        if round(way, 9) in worked:
            assert slave.set_position - s0 == pytest.approx(worked.pop(round(way, 9)), abs=1e-8)
    assert not worked
    assert slave.motion_state == RUNS


def test_in_time_and_linear_from_then_on() -> None:
    """Δv = 100, a = 500, j = 5000: 0.3 s, 15 of way."""
    nc = gentle_axes()
    master, slave = nc
    commands.universal_start(master, 3, 0.0, 100.0)
    nc.cycle(1000)
    m0 = master.set_position
    assert commands.synchronise(slave, 5, 1, 0, 0, 1.0) == 0
    nc.cycle(160)
    assert slave.motion_state == RUNS
    assert slave.set_position == pytest.approx(master.set_position - m0 - 15.0, abs=1e-9)
    commands.stop(master)
    beside = slave.set_position - master.set_position
    for _ in range(500):
        nc.cycle()
        assert slave.set_position == pytest.approx(master.set_position + beside, abs=1e-9)
        assert slave.set_velocity == master.set_velocity


def saw_on_its_way(mask: int, *, moving: bool, ran: bool) -> Any:
    """A saw whose master comes back, behind where it was at coupling; samples of the slave."""
    nc = gentle_axes()
    master, slave = nc
    commands.universal_start(master, 3, 0.0, 100.0)
    if moving:
        commands.universal_start(slave, 3, 0.0, 50.0)
    nc.cycle(1000)
    m0, s0 = master.set_position, slave.set_position
    assert commands.synchronise(slave, 6, 1, 0, 0, 1.0, m0 + 300.0, s0 + 250.0, mask=mask) == 0
    nc.cycle(2000 if ran else 300)
    assert (slave.motion_state == RUNS) == ran
    commands.universal_start(master, 4, 0.0, 100.0)
    samples = []
    for _ in range(6000):
        nc.cycle()
        samples.append((master.set_position - m0, slave.set_position - s0, slave.set_velocity))
        if samples[-1][0] < -100.0:
            break
    return samples, slave, nc


@pytest.mark.parametrize("instant", [0, Bit.INSTANT_STOP_ON_ROLLBACK])
@pytest.mark.parametrize("ran", [False, True])
def test_a_master_that_goes_back_behind_where_it_was(ran: bool, instant: int) -> None:
    """A saw that had not run with it stops there, smoothly or within a cycle; else it follows."""
    samples, slave, _ = saw_on_its_way(instant, moving=True, ran=ran)
    behind = [sample for sample in samples if sample[0] < 0.0]
    if ran:
        assert slave.motion_state == RUNS
        assert behind[-1][1] == pytest.approx(behind[-1][0] - 50.0, abs=1e-9)
        return
    assert slave.motion_state == OFF
    assert behind[-1][2] == 0.0
    if instant:
        assert behind[0][2] == 0.0
        assert abs(behind[-1][1]) < 0.2
    else:
        assert -12.0 < behind[-1][1] < -4.0
        steps = [abs(b[2] - a[2]) for a, b in pairwise(behind)]
        assert max(steps) <= 500.0 * 0.002 * 1.001
    assert slave.coupling_state == 3


@pytest.mark.parametrize("instant", [0, Bit.INSTANT_STOP_ON_ROLLBACK])
def test_the_rollback_lock_stops_a_saw_that_ran(instant: int) -> None:
    samples, slave, _ = saw_on_its_way(Bit.ROLLBACK_LOCK | instant, moving=True, ran=True)
    at = [place for way, place, _ in samples if way >= 0.0][-1]
    assert (samples[-1][2], slave.motion_state) == (0.0, OFF)
    rolled = samples[-1][1] - at
    assert abs(rolled) < 0.2 if instant else -16.0 < rolled < -14.0


def test_a_saw_from_rest_waits_and_begins_again() -> None:
    samples, slave, nc = saw_on_its_way(0, moving=False, ran=False)
    master = nc.axis(1)
    assert samples[-1][1] == pytest.approx(0.0, abs=1e-12)
    assert slave.motion_state == 11
    commands.universal_start(master, 3, 0.0, 100.0)
    nc.cycle(4000)
    assert slave.motion_state == RUNS


def test_another_gear() -> None:
    nc = gentle_axes()
    master, slave = nc
    commands.universal_start(master, 3, 0.0, 100.0)
    nc.cycle(1000)
    commands.synchronise(slave, 6, 1, 0, 0, 1.0, master.set_position + 200.0, 100.0)
    nc.cycle(100)
    assert commands.change_coupling(slave, 2.0, 0, 0, 0) == NcError.SYNCHRONISING_CONDITIONS
    nc.cycle(1500)
    assert commands.change_coupling(slave, 0.0, 0, 0, 0) == NcError.GEAR_FACTOR_ZERO
    here, there = slave.set_position, master.set_position
    assert commands.change_coupling(slave, 2.0, 0, 0, 0) == 0
    nc.cycle(10)
    assert slave.set_position == pytest.approx(here + 2.0 * (master.set_position - there))


def test_another_gear_on_the_way_in_time_has_no_jump() -> None:
    nc = gentle_axes()
    master, slave = nc
    commands.universal_start(master, 3, 0.0, 100.0)
    nc.cycle(1000)
    commands.synchronise(slave, 5, 1, 0, 0, 1.0)
    for n in range(600):
        if n == 50:
            assert commands.change_coupling(slave, -0.5, 0, 0, 0) == 0
        v, a = slave.set_velocity, slave.set_acceleration
        nc.cycle()
        assert abs(slave.set_velocity - v) <= 500.0 * 0.002 * 1.0001
        assert abs(slave.set_acceleration - a) <= 5000.0 * 0.002 * 1.0001
    assert (slave.motion_state, slave.set_velocity) == (RUNS, -50.0)


def test_the_velocity_limit_of_a_change_in_time_holds_while_the_master_is_faster() -> None:
    nc = gentle_axes()
    master, slave = nc
    commands.universal_start(master, 3, 0.0, 100.0)
    nc.cycle(1000)
    code = commands.synchronise(slave, 5, 1, 0, 0, 1.0, 0, 0, 110.0, mask=int(Bit.MAX_VELOCITY))
    assert code == 0
    nc.cycle(20)
    commands.universal_start(master, 3, 0.0, 200.0)
    nc.cycle(1000)
    assert (slave.set_velocity, slave.motion_state) == (110.0, SYNCHRONISES)
    commands.universal_start(master, 3, 0.0, 105.0)
    nc.cycle(1000)
    assert (slave.set_velocity, slave.motion_state) == (105.0, RUNS)


@pytest.mark.parametrize("ran", [False, True])
@pytest.mark.parametrize("kind", [5, 6])
def test_a_loop_that_was_open(kind: int, ran: bool) -> None:
    nc = gentle_axes()
    master, slave = nc
    commands.universal_start(master, 3, 0.0, 20.0)
    nc.cycle(1000)
    m0 = master.set_position
    commands.synchronise(slave, kind, 1, 0, 0, 1.0, m0 + 100.0, 50.0)
    nc.cycle(3000 if ran else 10)
    commands.stop(master)
    nc.cycle(500)
    slave.control_dword = 0
    nc.cycle(20)
    slave.control_dword = 7
    nc.cycle(20)
    commands.universal_start(master, 3, 0.0, 20.0)
    before = slave.set_position
    for _ in range(6000):
        nc.cycle()
        assert abs(slave.set_position - before) <= 40.0 * 0.002
        before = slave.set_position
    assert slave.motion_state == RUNS
    if kind == 6 and not ran:
        wanted = master.set_position - m0 - 50.0
        assert slave.set_position == pytest.approx(wanted, abs=1e-9)


def test_an_encoder_that_trembles_is_met() -> None:
    nc = gentle_axes()
    master, slave = nc
    master.axis_type = 5
    master.control_dword = 0
    for n in range(3000):
        master.machine.position += 0.1 + 0.002 * (n % 3 - 1)
        master.wake()
        nc.cycle()
        if n == 500:
            assert commands.synchronise(slave, 5, 1, 0, 0, 1.0) == 0
    assert slave.motion_state == RUNS
    assert slave.set_velocity == pytest.approx(50.0, abs=5.0)


def test_kept_by_both_kernels() -> None:
    digests = []
    for compiled in (False, True):
        nc = gentle_axes(4, compiled=compiled)
        first, second, third, fourth = nc
        commands.universal_start(second, 3, 0.0, 100.0)
        commands.universal_start(third, 3, 0.0, 30.0)
        nc.cycle(500)
        m = second.set_position
        assert commands.synchronise(first, 6, 2, 0, 0, 0.7, m + 90.0, 50.0) == 0
        s = third.set_position
        assert commands.synchronise(third, 6, 2, 0, 0, 1.1, m + 70.0, s + 50.0, mask=0x30000) == 0
        assert commands.synchronise(fourth, 5, 3, 0, 0, -1.3, jerk=1e4) == 0
        nc.cycle(600)
        commands.universal_start(second, 4, 0.0, 100.0)
        nc.cycle(1500)
        digests.append(nc.digest())
    assert digests[0] == digests[1]
