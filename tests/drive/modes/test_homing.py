"""Homing against the geometry of the machine: where home is, which way it goes, what fails."""

import math
from collections.abc import Callable

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from achse.drive import (
    Encoder,
    EncoderKind,
    InputBit,
    Mechanics,
    Mode,
    PowerState,
    Switches,
    VirtualDrive,
)
from achse.drive.modes.homing import METHODS
from tests.drive.machine_code import fast_drive

PITCH = 131_072
NEGATIVE, POSITIVE = -1_000_000, 1_000_000
NEAR, FAR = -6_000, 30_000
STATE = 0x3400


def _above(edge: int) -> int:
    """The first index pulse in positive direction from an edge."""
    return math.floor(edge / PITCH) * PITCH + PITCH


def _below(edge: int) -> int:
    return math.ceil(edge / PITCH) * PITCH - PITCH


# method -> edge and side of the index pulse, as CiA 402 draws them
HOMES = {
    1: _above(NEGATIVE),
    2: _below(POSITIVE),
    7: _below(NEAR),
    8: _above(NEAR),
    9: _below(FAR),
    10: _above(FAR),
    11: _above(FAR),
    12: _below(FAR),
    13: _above(NEAR),
    14: _below(NEAR),
}


@pytest.mark.parametrize("start", [-900_000, -50_000, 2_000, 100_000, 800_000])
@pytest.mark.parametrize("method", HOMES)
def test_home_is_the_index_pulse_beside_the_edge(
    machine: Callable[..., Mechanics], method: int, start: int
) -> None:
    drive = fast_drive(machine(start))
    drive.enable(Mode.HOMING)
    drive.home(method, offset=1_234)
    assert start + drive.record.encoder_zero - start == HOMES[method]
    assert drive.get(0x6062) == drive.get(0x6064) == drive.get(0x607C) == 1_234
    assert drive.get(0x6063) == drive.get(0x60FC) == 0


@pytest.mark.parametrize("start", [-900_000, 2_000, 800_000])
@pytest.mark.parametrize("method", range(7, 15))
def test_a_switch_shorter_than_the_braking_distance(method: int, start: int) -> None:
    """At 500,000 inc/s and 10,000,000 inc/s² the axis runs 12,500 inc past the switch."""
    switches = Switches(None, NEGATIVE, (50_000, 54_000), POSITIVE, None)
    drive = fast_drive(Mechanics(switches=switches, position=start))
    drive.enable(Mode.HOMING)
    drive.home(method)
    above = method in (8, 10, 11, 13)
    assert drive.record.encoder_zero == (PITCH if above else 0)


@pytest.mark.parametrize("start", [-900_000, -50_000, 2_000, 100_000, 800_000])
def test_33_and_34_take_the_next_index_pulse(machine: Callable[..., Mechanics], start: int) -> None:
    for method, home in ((33, _below(start)), (34, _above(start))):
        drive = fast_drive(machine(start))
        drive.enable(Mode.HOMING)
        drive.home(method)
        assert drive.record.encoder_zero == home
        assert drive.position == 0


@settings(max_examples=8, deadline=None)
@given(
    st.sampled_from([7, 8, 9, 10, 11, 12, 13, 14]),
    st.integers(-900_000, 900_000),
    st.integers(-400_000, 400_000),
    st.integers(5_000, 90_000),
    st.integers(0, PITCH - 1),
)
@example(method=7, start=601, near=601, width=17_396, offset=0)
def test_any_geometry(method: int, start: int, near: int, width: int, offset: int) -> None:
    """The home found is on the method's side of its edge, at an index pulse, and no other."""
    far = near + width
    edges = {7: near, 8: near, 9: far, 10: far, 11: far, 12: far, 13: near, 14: near}
    side = 1 if method in (8, 10, 11, 13) else -1
    edge = edges[method]
    first = math.floor((edge - offset) / PITCH) * PITCH + offset
    home = first + PITCH if side > 0 else first
    latency = 600  # the switch is seen once a cycle, at 500 inc/ms
    if min(abs(home - edge), abs(edge - first), abs(first + PITCH - edge)) <= latency:
        return
    switches = Switches(None, NEGATIVE, (near, far), POSITIVE, None)
    drive = fast_drive(
        Mechanics(switches=switches, position=start, encoder=Encoder(index_offset=offset))
    )
    drive.enable(Mode.HOMING)
    drive.home(method)
    assert drive.record.encoder_zero == home
    assert (drive.position, drive.get(0x6063)) == (0, 0)


@pytest.mark.parametrize(
    ("method", "start", "direction"),
    [
        *((method, -50_000, 1) for method in (7, 8, 9, 10)),
        *((method, 50_000, -1) for method in (11, 12, 13, 14)),
        *((method, 10_000, -1) for method in (7, 8, 13, 14)),
        *((method, 10_000, 1) for method in (9, 10, 11, 12)),
        (1, 0, -1),
        (2, 0, 1),
        (1, -1_050_000, 1),
        (2, 1_050_000, -1),
        (33, 60_000, -1),
        (34, 60_000, 1),
    ],
)
def test_initial_direction(
    machine: Callable[..., Mechanics], method: int, start: int, direction: int
) -> None:
    drive = fast_drive(machine(start))
    drive.enable(Mode.HOMING)
    drive.set(0x6098, method)
    drive.control(0x1F, 10)
    assert drive.record.demand_velocity * direction > 0


def test_speeds_and_acceleration(machine: Callable[..., Mechanics]) -> None:
    drive = fast_drive(machine(-500_000))
    drive.set(0x6099, 300_000, 1)
    drive.set(0x6099, 40_000, 2)
    drive.set(0x609A, 2_000_000)
    drive.set(0x6098, 10)
    drive.enable(Mode.HOMING)
    drive.control(0x1F)
    speeds, changes, before = [], [], drive.record.demand_velocity
    while drive.record.homing_running:
        drive.cycle()
        velocity = drive.record.demand_velocity
        speeds.append(abs(velocity))
        changes.append(abs(velocity - before) / 1e-3)
        before = velocity
    assert max(speeds) == pytest.approx(300_000)
    assert max(changes) == pytest.approx(2_000_000, rel=1e-6)
    at_index = [speed for speed in speeds[len(speeds) // 2 :] if speed > 1]
    assert max(at_index[-50:]) <= 40_000 * (1 + 1e-9)


def test_max_profile_velocity_limits_homing(machine: Callable[..., Mechanics]) -> None:
    drive = fast_drive(machine(-500_000))
    drive.set(0x607F, 100_000)
    drive.set(0x6098, 7)
    drive.enable(Mode.HOMING)
    drive.control(0x1F, 300)
    assert drive.record.demand_velocity == pytest.approx(100_000)


def test_status_runs_attained_done(machine: Callable[..., Mechanics]) -> None:
    drive = fast_drive(machine(-50_000))
    drive.set(0x6098, 34)
    drive.enable(Mode.HOMING)
    assert drive.statusword & STATE == 0x0400, "not started"
    assert drive.control(0x1F) & STATE == 0x0000, "running with the very next inputs"
    seen = [0x0000]
    while drive.statusword & STATE != 0x1400:
        drive.cycle()
        if drive.statusword & STATE != seen[-1]:
            seen.append(drive.statusword & STATE)
    assert seen == [0x0000, 0x1000, 0x1400]
    assert int(drive.get(0x3056)) & 8 == 0
    drive.control(0x0F, 10)
    assert drive.statusword & STATE == 0x1400


def test_software_state_shows_that_homing_runs(machine: Callable[..., Mechanics]) -> None:
    drive = fast_drive(machine(-50_000))
    drive.set(0x6098, 34)
    drive.enable(Mode.HOMING)
    drive.control(0x1F)
    assert int(drive.get(0x3056)) & 8


def test_taking_bit_4_back_interrupts(machine: Callable[..., Mechanics]) -> None:
    drive = fast_drive(machine(-500_000))
    drive.set(0x6098, 7)
    drive.enable(Mode.HOMING)
    drive.control(0x1F, 200)
    assert drive.control(0x0F) & STATE == 0x0000, "still moving"
    drive.run(0.5)
    assert drive.statusword & STATE == 0x0400
    assert drive.record.demand_velocity == 0
    drive.home(7)


def test_halt_stops_and_resumes(machine: Callable[..., Mechanics]) -> None:
    drive = fast_drive(machine(-500_000))
    drive.set(0x6098, 7)
    drive.enable(Mode.HOMING)
    drive.control(0x1F, 200)
    drive.control(0x11F, 300)
    assert drive.record.demand_velocity == 0
    assert drive.statusword & STATE == 0x0400
    drive.control(0x1F)
    drive.wait(lambda: drive.statusword & STATE == 0x1400, 20)
    assert drive.record.encoder_zero == HOMES[7]


def test_halt_on_the_way_back_to_the_index(machine: Callable[..., Mechanics]) -> None:
    drive = fast_drive(machine(-50_000))
    drive.set(0x6098, 34)
    drive.enable(Mode.HOMING)
    drive.control(0x1F)
    drive.wait(lambda: drive.record.homing_attained, 5)
    drive.control(0x11F, 100)
    drive.control(0x1F)
    drive.wait(lambda: drive.statusword & STATE == 0x1400, 5)
    assert drive.get(0x6063) == 0


def test_method_37_during_a_quick_stop_leaves_the_ramp(drive: VirtualDrive) -> None:
    """The scale moves; the motor goes on slowing down with 6085h."""
    drive.enable(Mode.PROFILE_VELOCITY)
    drive.put(0x60FF, 5_000_000)
    drive.run(1.0)
    drive.put(0x6085, 2_000_000)
    drive.put(0x6060, Mode.HOMING)
    drive.put(0x6098, 37)
    drive.control(0x0B)
    drive.control(0x1B, 500)
    assert drive.get(0x606C) == pytest.approx(5_000_000 - 2_000_000 * 0.5, rel=0.01)


def test_method_37_needs_neither_motion_nor_enabling(drive: VirtualDrive) -> None:
    drive.record.motor_position = 777.0
    drive.put(0x6060, Mode.HOMING)
    drive.set(0x607C, -50)
    drive.set(0x6098, 37)
    drive.cycle()
    assert drive.power_state is PowerState.SWITCH_ON_DISABLED
    drive.control(0x10)
    assert drive.get(0x6062) == drive.get(0x6064) == -50
    assert drive.get(0x6063) == drive.get(0x60FC) == 0
    assert drive.statusword & STATE == 0x1400


@pytest.mark.parametrize("method", [0, 3, 6, 15, 17, 32, 35, 36, 38, 127, -6, -128, -1, -5])
def test_other_methods_are_a_homing_error(drive: VirtualDrive, method: int) -> None:
    drive.set(0x6098, method)
    drive.enable(Mode.HOMING)
    assert drive.control(0x1F, 2) & STATE == 0x2400
    assert drive.power_state is PowerState.OPERATION_ENABLED


@pytest.mark.parametrize(
    ("method", "switches"),
    [
        (1, Switches(positive_limit=1e6, home=(0, 9))),
        (2, Switches(negative_limit=-1e6, home=(0, 9))),
        *((method, Switches(home=(0, 9), negative_limit=-1e6)) for method in (7, 8, 9, 10)),
        *((method, Switches(home=(0, 9), positive_limit=1e6)) for method in (11, 12, 13, 14)),
        *((method, Switches(None, -1e6, None, 1e6)) for method in range(7, 15)),
    ],
)
def test_missing_switches_fail_at_the_start(method: int, switches: Switches) -> None:
    drive = fast_drive(Mechanics(switches=switches))
    drive.set(0x6098, method)
    drive.enable(Mode.HOMING)
    assert drive.control(0x1F, 2) & STATE == 0x2400


def test_a_switch_that_never_comes_fails_at_the_other_limit(
    machine: Callable[..., Mechanics],
) -> None:
    drive = fast_drive(machine())
    drive.faults.input(InputBit.HOME, False)
    drive.set(0x6098, 7)
    drive.enable(Mode.HOMING)
    drive.control(0x1F)
    drive.wait(lambda: drive.statusword & 0x2000, 20)
    assert drive.statusword & STATE == 0x2000, "velocity is not 0"
    drive.run(0.5)
    assert drive.statusword & STATE == 0x2400


def test_an_index_pulse_that_never_comes_fails_at_the_limit(
    machine: Callable[..., Mechanics],
) -> None:
    drive = fast_drive(machine(encoder=Encoder(index_pitch=10**9, index_offset=5 * 10**8)))
    drive.set(0x6098, 34)
    drive.enable(Mode.HOMING)
    drive.control(0x1F)
    drive.wait(lambda: drive.statusword & 0x2000, 20)


def test_the_method_cannot_change_on_the_way(machine: Callable[..., Mechanics]) -> None:
    drive = fast_drive(machine(-500_000))
    drive.set(0x6098, 7)
    drive.enable(Mode.HOMING)
    drive.control(0x1F, 5)
    drive.put(0x6098, 33)
    drive.wait(lambda: drive.statusword & STATE == 0x1400, 20)
    assert drive.record.encoder_zero == HOMES[7]


def test_homing_attained_ends_with_the_mode_and_the_power(
    machine: Callable[..., Mechanics],
) -> None:
    drive = fast_drive(machine())
    drive.enable(Mode.HOMING)
    drive.home(37)
    drive.put(0x6060, Mode.PROFILE_POSITION)
    drive.cycle()
    drive.put(0x6060, Mode.HOMING)
    drive.cycle()
    assert drive.statusword & STATE == 0x0400
    drive.home(37)
    drive.power_cycle()
    drive.bring_up()
    drive.put(0x6060, Mode.HOMING)
    drive.cycle()
    assert not drive.statusword & 0x1000


def test_a_multi_turn_encoder_is_always_homed() -> None:
    drive = fast_drive(Mechanics(encoder=Encoder(kind=EncoderKind.MULTI_TURN)))
    drive.put(0x6060, Mode.HOMING)
    drive.cycle()
    assert drive.statusword & 0x1000


def test_disabling_interrupts(machine: Callable[..., Mechanics]) -> None:
    drive = fast_drive(machine(-500_000))
    drive.set(0x6098, 7)
    drive.enable(Mode.HOMING)
    drive.control(0x1F, 100)
    drive.control(0)
    drive.run(2.0)
    assert drive.statusword & STATE == 0x0400


def test_torque_limit_shows_while_homing(machine: Callable[..., Mechanics]) -> None:
    drive = fast_drive(machine(-500_000))
    drive.set(0x60E0, 10)
    drive.set(0x6098, 7)
    drive.enable(Mode.HOMING)
    drive.control(0x1F, 20)
    assert drive.statusword & 0x0800


def test_the_methods_are_those_described() -> None:
    assert [row.number for row in METHODS] == [1, 2, 7, 8, 9, 10, 11, 12, 13, 14, 33, 34, 37]
