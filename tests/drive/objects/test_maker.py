"""Maker's objects: reset, turns of the encoder, general objects, parameters that act."""

from typing import Any

import pytest

from achse.codes import AbortCode, AlState
from achse.drive import (
    Encoder,
    EncoderKind,
    Mechanics,
    Mode,
    Motor,
    MotorKind,
    PowerState,
    VirtualDrive,
    Warn,
)

TURN = 131_072


def _multi_turn(position: float = 0.0) -> VirtualDrive:
    encoder = Encoder(kind=EncoderKind.MULTI_TURN)
    return VirtualDrive(Mechanics(encoder=encoder, position=position))


def test_motor_and_encoder_are_shown() -> None:
    machine = Mechanics(
        motor=Motor(kind=MotorKind.DIRECT_DRIVE, rated_torque=5.0, rated_current=3.5),
        encoder=Encoder(resolution=1_000_000),
    )
    drive = VirtualDrive(machine)
    assert [drive.get(index) for index in (0x3000, 0x3001, 0x6075, 0x6076)] == [
        1,
        1_000_000,
        3500,
        5000,
    ]


def test_general_objects_hold_what_they_are_given() -> None:
    drive = VirtualDrive()
    for index in range(0x3201, 0x320A):
        drive.set(index, -index)
    for index in range(0x3210, 0x3215):
        drive.set(index, index + 0.5)
    drive.cycle()
    assert [drive.get(index) for index in range(0x3201, 0x320A)] == [
        -index for index in range(0x3201, 0x320A)
    ]
    assert drive.read_object(0x3210, 0) == bytes.fromhex("00424846")  # 12816.5


def test_reset_begins_again_and_returns_to_0(drive: VirtualDrive) -> None:
    drive.enable(Mode.CYCLIC_POSITION)
    drive.set(0x6085, 77)
    drive.set(0x3215, 1)
    drive.cycle()
    assert drive.get(0x3215) == 0
    assert drive.power_state < PowerState.READY_TO_SWITCH_ON
    drive.cycle()
    assert drive.power_state is PowerState.SWITCH_ON_DISABLED
    assert drive.get(0x6085) != 77, "what was not stored is gone"
    assert drive.get(0x6061) == 0


def test_a_reset_by_process_data_is_an_edge(drive: VirtualDrive) -> None:
    drive.set(0x6085, 77)
    for _ in range(5):
        drive.put(0x3215, 1)
        drive.control(0x06)
    assert drive.get(0x6085) != 77
    assert drive.power_state is PowerState.READY_TO_SWITCH_ON, "reset once, not every cycle"
    drive.set(0x6085, 77)
    drive.put(0x3215, 0)
    drive.cycle()
    drive.put(0x3215, 1)
    drive.cycle(2)
    assert drive.get(0x6085) != 77


def test_clearing_the_turns() -> None:
    drive = _multi_turn(position=5 * TURN + 1000)
    assert drive.get(0x6063) == 5 * TURN + 1000
    drive.set(0x3200, 1)
    assert drive.get(0x3200) == 1
    drive.cycle()
    assert drive.get(0x3200) == 2
    drive.run(0.2)
    assert drive.get(0x3200) == 4
    assert drive.get(0x6063) == 5 * TURN + 1000, "until the reset"
    drive.set(0x3215, 1)
    drive.cycle(2)
    assert drive.get(0x6063) == 1000


def test_clearing_is_refused_while_enabled() -> None:
    drive = _multi_turn()
    drive.enable(Mode.CYCLIC_POSITION)
    drive.set(0x3200, 1)
    drive.cycle()
    assert drive.get(0x3200) == 16


def test_clearing_fails_without_turns_to_clear(drive: VirtualDrive) -> None:
    drive.set(0x3200, 1)
    drive.cycle()
    assert drive.get(0x3200) == 32


def test_clearing_fails_when_the_motor_is_enabled_meanwhile() -> None:
    drive = _multi_turn()
    drive.set(0x3200, 1)
    drive.cycle(2)
    drive.enable(Mode.CYCLIC_POSITION)
    drive.cycle(2)
    assert drive.get(0x3200) == 32


def test_gear_acts_after_a_reset_and_warns_until_then(drive: VirtualDrive) -> None:
    drive.set(0x2210, 10_000)
    drive.set(0x220E, TURN)
    drive.cycle()
    assert int(drive.get(0x3110)) & Warn.RESTART_REQUIRED.mask
    assert drive.get(0x4096) == 0x941
    assert drive.statusword & 0x80
    drive.set(0x3216, 1)
    drive.run(1.0)
    drive.power_cycle()
    drive.bring_up(AlState.OP)
    assert not drive.statusword & 0x80
    assert drive.record.inc_per_count == pytest.approx(10_000 / TURN)


def test_position_is_count_times_gear_plus_offset() -> None:
    presets = {0x220E: 4, 0x2210: 1, 0x607C: 500}
    encoder = Encoder(kind=EncoderKind.MULTI_TURN)
    drive = VirtualDrive(Mechanics(encoder=encoder, position=25_000), parameters=presets)
    assert drive.get(0x6063) == 100_000
    assert drive.position == 25_000 + 500


def test_warning_words_and_code(drive: VirtualDrive) -> None:
    for warning in Warn:
        drive.faults.warning(warning)
        drive.cycle()
        assert drive.get(warning.index) == warning.mask
        assert drive.get(0x4096) == warning.number
        assert drive.statusword & 0x80
        drive.faults.warning(warning, False)
        drive.cycle()
        assert drive.get(warning.index) == 0


def test_the_error_code_of_the_panel_ends_with_the_alarm(drive: VirtualDrive) -> None:
    drive.faults.encoder_loss()
    drive.cycle(3)
    assert drive.get(0x4095) == drive.get(0x603F) == 0xFF23
    drive.faults.encoder_loss(False)
    drive.reset_fault()
    assert drive.get(0x4095) == 0
    assert drive.get(0x603F) == 0xFF23, "the last error that occurred"


def test_position_trigger_is_shown_in_the_software_state(drive: VirtualDrive) -> None:
    drive.set(0x3061, 1)
    drive.cycle()
    assert drive.get(0x3056) == 1 << 4


def test_not_supported_is_not_readable(aborts: Any) -> None:
    for index in (0x3002, 0x3055, 0x3100, 0x3104, 0x607D):
        with aborts(AbortCode.UNSUPPORTED_ACCESS):
            VirtualDrive().read_object(index, 0)
