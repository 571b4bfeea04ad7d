"""Digital inputs, outputs and brake."""

from collections.abc import Callable

import pytest

from achse.drive import InputBit, Load, Mechanics, Mode, OutputFunction, VirtualDrive
from achse.drive.signals import rotation_threshold


@pytest.mark.parametrize(
    ("position", "bits"),
    [
        (0, InputBit.HOME),
        (-6_001, 0),
        (-1_000_000, InputBit.NEGATIVE_LIMIT),
        (1_000_000, InputBit.POSITIVE_LIMIT),
        (500_000, 0),
    ],
)
def test_switches_along_the_way(
    machine: Callable[..., Mechanics], position: int, bits: InputBit
) -> None:
    drive = VirtualDrive(machine(position))
    assert drive.get(0x60FD) == bits | InputBit.SF1 | InputBit.SF2


@pytest.mark.parametrize("bit", list(InputBit), ids=lambda bit: bit.name)
def test_each_input_can_be_held_on_and_off(drive: VirtualDrive, bit: InputBit) -> None:
    for state in (True, False):
        drive.faults.input(bit, state)
        drive.cycle()
        assert bool(int(drive.get(0x60FD)) & bit) is state
    drive.faults.input(bit, None)
    drive.cycle()
    assert bool(int(drive.get(0x60FD)) & bit) is (bit in InputBit.SF1 | InputBit.SF2)


def test_bits_are_those_of_the_manual() -> None:
    assert [bit.bit_length() - 1 for bit in InputBit] == [0, 1, 2, *range(16, 26)]


def test_safety_inputs_show(drive: VirtualDrive) -> None:
    drive.faults.sto()
    drive.cycle()
    assert not int(drive.get(0x60FD)) & (InputBit.SF1 | InputBit.SF2)


def test_requests_pass_the_mask(drive: VirtualDrive) -> None:
    drive.put(0x60FE, 0xFFFF_FFFF, 1)
    drive.put(0x60FE, 0x0005_0000, 2)
    drive.cycle()
    assert drive.record.digital_outputs == 0x0005_0000


def test_requests_and_status_outputs_are_ored() -> None:
    drive = VirtualDrive(Mechanics(outputs=(OutputFunction.SERVO_READY, OutputFunction.ALARM)))
    drive.put(0x60FE, 0x0004_0000, 1)
    drive.put(0x60FE, 0x001F_0000, 2)
    drive.cycle()
    assert drive.record.digital_outputs == 0x0005_0000
    drive.faults.encoder_loss()
    drive.cycle(3)
    assert drive.record.digital_outputs == 0x0006_0000


def test_status_outputs_show_what_they_are_assigned_to() -> None:
    functions = (OutputFunction.WARNING, OutputFunction.IN_POSITION, OutputFunction.ROTATION)
    drive = VirtualDrive(Mechanics(outputs=functions))
    drive.enable(Mode.PROFILE_POSITION)
    drive.run(0.1)
    assert drive.record.digital_outputs == 0x0002_0000
    drive.put(0x607A, 500_000)
    drive.control(0x1F, 100)
    assert drive.record.digital_outputs == 0x0004_0000
    drive.faults.overtravel(positive=False)
    drive.cycle(2)
    assert drive.record.digital_outputs & 0x0001_0000


def test_rotation_levels() -> None:
    record = VirtualDrive().record
    assert rotation_threshold(record) == pytest.approx(20 / 60 * 131_072)
    record.motor_type = 0
    assert rotation_threshold(record) == pytest.approx(0.02 * 131_072)


def test_the_brake_follows_the_drive_and_60feh_while_off() -> None:
    machine = Mechanics(load=Load(gravity=0.3), brake=True, outputs=(OutputFunction.BRAKE,))
    drive = VirtualDrive(machine)
    drive.cycle()
    assert drive.record.brake_engaged
    drive.put(0x60FE, 0x0001_0000, 2)
    drive.put(0x60FE, 0x0001_0000, 1)
    drive.run(0.05)
    assert not drive.record.brake_engaged
    assert drive.position < 0, "released by hand, the axis falls"
    drive.put(0x60FE, 0, 1)
    drive.enable(Mode.CYCLIC_POSITION)
    assert not drive.record.brake_engaged
    assert drive.record.digital_outputs == 0x0001_0000, "the drive holds it released"
    drive.control(0, 2)
    assert drive.record.brake_engaged


def test_the_rotation_output_follows_its_level() -> None:
    """Pt502, 1/min."""
    machine = Mechanics(outputs=(OutputFunction.ROTATION,))
    for level, shown in ((50, True), (150, False)):
        drive = VirtualDrive(machine, parameters={0x2502: level})
        drive.enable(Mode.CYCLIC_VELOCITY)
        drive.put(0x60FF, 100 * 131_072 // 60)
        drive.cycle(200)
        assert bool(drive.record.digital_outputs & 1 << 16) is shown
