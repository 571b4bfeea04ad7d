"""The drive cycle: values as the objects show them, statuswords, many drives at once."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.drive import Mode, VirtualDrive
from achse.drive.kernel import cycle, cycles
from achse.drive.record import FIELDS, DriveFields


def _record() -> DriveFields:
    return VirtualDrive().record


@given(st.integers(-(2**40), 2**40), st.integers(-(2**31), 2**31 - 1))
def test_positions_wrap_at_32_bits(motor: int, zero: int) -> None:
    record = _record()
    record.motor_position = float(motor)
    record.encoder_zero = zero
    cycle(record, 1e-3)
    expected = (motor - zero + 2**31) % 2**32 - 2**31
    assert record.position_internal == record.position_actual == expected
    assert record.following_error == 0


def test_following_error_is_demand_less_actual(drive: VirtualDrive) -> None:
    drive.enable(Mode.CYCLIC_POSITION)
    for n in range(50):
        drive.put(0x607A, n * n)
        drive.cycle()
        assert drive.get(0x60F4) == drive.get(0x6062) - drive.get(0x6064)


def test_typical_statuswords(drive: VirtualDrive) -> None:
    """Bit 9 remote, and with the profile's sense of bit 4 the words masters are used to."""
    typical = VirtualDrive(voltage_bit=1)
    typical.put(0x6060, Mode.CYCLIC_POSITION)
    assert [typical.control(word) for word in (0, 6, 7)] == [0x0250, 0x0231, 0x0233]
    assert typical.control(15, 2) == 0x0237 | 0x1000 | 0x0400
    assert [drive.control(word) for word in (0, 6, 7)] == [0x0240, 0x0221, 0x0223]


def test_a_warning_changes_neither_state_nor_motion(drive: VirtualDrive) -> None:
    drive.enable(Mode.PROFILE_VELOCITY)
    drive.put(0x60FF, 100_000)
    drive.run(0.2)
    drive.record.warnings_forced_2 = 1
    drive.run(0.1)
    assert drive.statusword & 0x00EF == 0x00A7
    assert drive.get(0x606C) == pytest.approx(100_000, rel=1e-2)


def test_many_drives_many_cycles() -> None:
    one, other = _record(), _record()
    for record in (one, other):
        record.target_velocity = 100_000
        record.mode_request = Mode.PROFILE_VELOCITY
    for _ in range(20):
        cycle(one, 1e-3)
    cycles([other], 1e-3, 20)
    assert all(getattr(one, name) == getattr(other, name) for name in FIELDS)


def test_velocities_are_shown_within_32_bits() -> None:
    record = _record()
    record.inc_per_count = 1e9
    record.motor_velocity = 1e6
    cycle(record, 1e-3)
    assert record.velocity_actual == 2**31 - 1
