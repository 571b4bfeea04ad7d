"""Machine descriptions: numbers of the plant, encoders after power-on, what cannot be."""

import math
from typing import Any

import pytest

from achse.drive import (
    Encoder,
    EncoderKind,
    Load,
    MachineError,
    Mechanics,
    Mode,
    Motor,
    MotorKind,
    Switches,
    VirtualDrive,
)


def test_the_plant_of_a_rotary_motor() -> None:
    motor = Motor(rated_torque=2.0, inertia=1e-4, max_speed=3000.0)
    load = Load(inertia=3e-4, coulomb=0.1, viscous=1e-3, gravity=0.4)
    drive = VirtualDrive(Mechanics(motor=motor, load=load, encoder=Encoder(resolution=10_000)))
    record = drive.record
    counts = 10_000 / math.tau
    assert record.max_velocity == pytest.approx(50 * 10_000)
    assert record.acceleration_gain * 1000 == pytest.approx(2.0 / 4e-4 * counts)
    assert (record.coulomb, record.gravity) == (pytest.approx(50.0), pytest.approx(200.0))
    assert record.viscous * counts == pytest.approx(0.5)
    assert drive.get(0x2103) == 300
    assert drive.get(0x607F) == 500_000


def test_the_plant_of_a_linear_motor() -> None:
    motor = Motor(MotorKind.LINEAR, 120.0, 2.1, 3.5, inertia=2.0, max_speed=5.0)
    machine = Mechanics(
        motor=motor,
        load=Load(inertia=4.0, coulomb=0.0, viscous=0.0),
        encoder=Encoder(resolution=1_000_000, index_pitch=20_000),
    )
    drive = VirtualDrive(machine, parameters={0x6087: 10**8, 0x6071: 100})
    assert drive.get(0x3000) == 0
    assert drive.get(0x6072) == 3500
    assert drive.record.max_velocity == 5_000_000
    drive.enable(Mode.PROFILE_TORQUE)
    drive.put(0x6071, 100)
    drive.run(0.05)
    first = drive.get(0x606C)
    drive.run(0.1)
    assert drive.get(0x606C) - first == pytest.approx(12.0 / 6.0 * 0.1 * 1e6, rel=1e-3)


@pytest.mark.parametrize(
    ("kind", "shown"),
    [
        (EncoderKind.INCREMENTAL, 0),
        (EncoderKind.SINGLE_TURN, 12_345),
        (EncoderKind.MULTI_TURN, 3 * 131_072 + 12_345),
    ],
)
def test_what_encoders_know_after_power_on(kind: EncoderKind, shown: int) -> None:
    machine = Mechanics(encoder=Encoder(kind=kind), position=3 * 131_072 + 12_345)
    drive = VirtualDrive(machine)
    assert drive.get(0x6063) == shown
    drive.enable(Mode.PROFILE_VELOCITY)
    drive.put(0x60FF, 300_000)
    drive.run(1.0)
    drive.control(0, 500)
    moved = drive.get(0x6063) - shown
    assert moved > 131_072, "the count runs on over the turn"
    drive.power_cycle()
    drive.bring_up()
    expected = {
        EncoderKind.INCREMENTAL: 0,
        EncoderKind.SINGLE_TURN: (shown + moved) % 131_072,
        EncoderKind.MULTI_TURN: shown + moved,
    }
    assert abs(drive.get(0x6063) - expected[kind]) <= 1


def test_a_multi_turn_counter_wraps() -> None:
    encoder = Encoder(kind=EncoderKind.MULTI_TURN, turns=16)
    assert (
        VirtualDrive(Mechanics(encoder=encoder, position=9 * 131_072)).get(0x6063) == -7 * 131_072
    )


def test_dual_loop_shows_the_scale_and_has_position_modes_only() -> None:
    drive = VirtualDrive(Mechanics(encoder=Encoder(dual_loop=True, scale_ratio=0.5)))
    drive.enable(Mode.CYCLIC_POSITION)
    for n in range(100):
        drive.put(0x607A, 100 * n)
        drive.cycle()
    drive.run(0.5)
    assert drive.get(0x6063) == pytest.approx(drive.position / 2, abs=1)
    for mode in (Mode.PROFILE_VELOCITY, Mode.CYCLIC_TORQUE):
        drive.put(0x6060, mode)
        drive.cycle()
        assert drive.get(0x6061) == Mode.CYCLIC_POSITION
    drive.put(0x6060, Mode.HOMING)
    drive.cycle()
    assert drive.get(0x6061) == Mode.HOMING


def test_stops_hold_the_machine() -> None:
    drive = VirtualDrive(Mechanics(switches=Switches(negative_stop=-5_000, positive_stop=5_000)))
    drive.enable(Mode.PROFILE_TORQUE)
    for sign in (1, -1):
        drive.put(0x6071, sign * 300)
        drive.run(1.0)
        assert (drive.position, drive.get(0x606C)) == (sign * 5_000, 0)


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"motor": Motor(inertia=0.0)}, "motor.inertia"),
        ({"motor": Motor(rated_torque=-1.0)}, "motor.rated_torque"),
        ({"load": Load(coulomb=-0.1)}, "load.coulomb"),
        ({"encoder": Encoder(resolution=0)}, "encoder.resolution"),
        ({"encoder": Encoder(index_pitch=0)}, "encoder.index_pitch"),
        ({"motor": Motor(max_speed=math.inf)}, "motor.max_speed"),
    ],
)
def test_what_cannot_be_is_refused(changes: dict[str, Any], named: str) -> None:
    with pytest.raises(MachineError, match=named):
        Mechanics(**changes)
