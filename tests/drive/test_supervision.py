"""Supervision: what the drive itself notices, and bit 11."""

from collections.abc import Callable

import pytest

from achse.drive import Alarm, Mechanics, Mode, Motor, PowerState, VirtualDrive, Warn
from achse.drive.supervision import SAFETY_MISMATCH_TIME

LIMIT = 0x0800
POSITION_MODES = (Mode.PROFILE_POSITION, Mode.CYCLIC_POSITION)
OTHER_MODES = (
    Mode.PROFILE_VELOCITY,
    Mode.PROFILE_TORQUE,
    Mode.CYCLIC_VELOCITY,
    Mode.CYCLIC_TORQUE,
)


def _fault(drive: VirtualDrive) -> Alarm | None:
    drive.wait(lambda: drive.power_state is PowerState.FAULT, 20, "fault")
    return Alarm.of(drive.record.error_code)


def test_position_error_too_big(drive: VirtualDrive) -> None:
    drive.set(0x2520, 50_000)
    drive.set(0x251E, 50)
    drive.faults.jam()
    drive.enable(Mode.CYCLIC_POSITION)
    warned: float = 0
    for n in range(1, 200):
        drive.put(0x607A, 500 * n)
        drive.cycle()
        if int(drive.get(0x3110)) & Warn.POSITION_DEVIATION_OVERFLOW.mask and not warned:
            warned = drive.get(0x60F4)
        if drive.power_state is not PowerState.OPERATION_ENABLED:
            break
    assert warned == pytest.approx(25_500, abs=500)
    assert _fault(drive) is Alarm.POSITION_ERROR_TOO_BIG


def test_overload_warns_and_trips() -> None:
    """Twice the rated torque is borne for overload_time."""
    drive = VirtualDrive(Mechanics(motor=Motor(overload_time=2.0)))
    drive.faults.jam()
    drive.enable(Mode.CYCLIC_TORQUE)
    drive.put(0x6071, 2_000)
    start = drive.time_ns
    drive.wait(lambda: int(drive.get(0x3110)) & Warn.OVERLOAD.mask, 5)
    assert (drive.time_ns - start) / 1e9 == pytest.approx(1.6, abs=0.01)
    assert _fault(drive) is Alarm.CONTINUOUS_OVERLOAD
    assert (drive.time_ns - start) / 1e9 == pytest.approx(2.0, abs=0.01)
    drive.put(0x6071, 0)
    drive.run(1.0)
    drive.reset_fault()


def test_rated_torque_is_borne_for_ever(drive: VirtualDrive) -> None:
    drive.faults.jam()
    drive.enable(Mode.CYCLIC_TORQUE)
    drive.put(0x6071, 1_000)
    drive.run(3.0)
    assert drive.power_state is PowerState.OPERATION_ENABLED


def test_over_speed() -> None:
    drive = VirtualDrive(Mechanics(motor=Motor(max_speed=60.0)))
    drive.enable(Mode.CYCLIC_TORQUE)
    drive.faults.load(-2_900)  # something pulls
    assert _fault(drive) is Alarm.OVER_SPEED


def test_under_voltage_while_enabled(drive: VirtualDrive) -> None:
    drive.faults.main_power(False)
    drive.cycle(3)
    assert drive.power_state is PowerState.SWITCH_ON_DISABLED
    drive.faults.main_power(True)
    drive.enable(Mode.CYCLIC_POSITION)
    drive.faults.main_power(False)
    assert _fault(drive) is Alarm.UNDER_VOLTAGE


def test_sto_while_enabled_and_before(drive: VirtualDrive) -> None:
    drive.faults.sto()
    drive.cycle(3)
    assert drive.power_state is PowerState.SWITCH_ON_DISABLED, "no alarm while off"
    drive.control(6, 2)
    assert drive.control(15, 3) & 0x6F == 0x21, "not obeyed"
    drive.faults.sto(False)
    drive.control(15, 3)
    assert drive.power_state is PowerState.OPERATION_ENABLED
    drive.put(0x6060, Mode.PROFILE_VELOCITY)
    drive.put(0x60FF, 500_000)
    drive.run(0.3)
    drive.faults.sto()
    drive.cycle(3)
    assert drive.power_state is PowerState.FAULT, "no deceleration without torque"
    assert drive.record.error_code == Alarm.SAFETY_FUNCTION_ALARM.code
    assert drive.get(0x606C) > 100_000


def test_safety_inputs_that_differ(drive: VirtualDrive) -> None:
    drive.faults.safety(True, False)
    drive.run(SAFETY_MISMATCH_TIME - 0.05)
    assert drive.power_state is PowerState.SWITCH_ON_DISABLED
    assert _fault(drive) is Alarm.SAFETY_FUNCTION_SIGNAL_INPUT_TIMING_ERROR


@pytest.mark.parametrize("mode", [*POSITION_MODES, *OTHER_MODES])
@pytest.mark.parametrize("positive", [True, False])
def test_limit_switches_show_in_bit_11_servo_on_or_off(
    drive: VirtualDrive, mode: Mode, positive: bool
) -> None:
    drive.put(0x6060, mode)
    drive.cycle()
    drive.faults.overtravel(positive=positive)
    drive.cycle()
    assert drive.statusword & LIMIT
    warning = Warn.POSITIVE_LIMIT if positive else Warn.NEGATIVE_LIMIT
    assert drive.get(0x3110) == warning.mask
    drive.enable(mode)
    drive.cycle()
    assert drive.statusword & LIMIT
    assert drive.get(0x3110) == warning.mask | Warn.OVERTRAVEL.mask


def test_hm_shows_the_torque_limit_only(drive: VirtualDrive) -> None:
    drive.enable(Mode.HOMING)
    drive.faults.overtravel(positive=True)
    drive.cycle()
    assert not drive.statusword & LIMIT


@pytest.mark.parametrize("mode", [*POSITION_MODES, *OTHER_MODES])
def test_the_torque_limit_shows_in_every_mode(mode: Mode) -> None:
    drive = VirtualDrive(parameters={0x6087: 10**6, 0x6083: 10**9})
    drive.faults.jam()
    drive.enable(mode)
    drive.put(0x6072, 50)
    drive.put(0x60FF, 100_000)
    drive.put(0x6071, 100)
    drive.put(0x60B2, 100)
    drive.put(0x607A, 5_000)
    drive.control(0x1F, 20)
    assert drive.statusword & LIMIT
    assert drive.get(0x3111) == Warn.TORQUE_LIMIT.mask
    drive.control(0, 5)
    assert not drive.statusword & LIMIT


def test_the_voltage_bit_follows_the_manual_or_the_profile() -> None:
    for bit in (0, 1):
        drive = VirtualDrive(voltage_bit=bit)
        assert bool(drive.statusword & 0x10) is bool(bit)
        drive.faults.main_power(False)
        drive.cycle()
        assert bool(drive.statusword & 0x10) is not bool(bit)


def test_a_switch_in_the_machine_warns(machine: Callable[..., Mechanics]) -> None:
    drive = VirtualDrive(machine(1_050_000))
    assert drive.get(0x3110) == Warn.POSITIVE_LIMIT.mask
