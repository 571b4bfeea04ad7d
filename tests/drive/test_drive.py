"""The drive as a slave hosts it: process data, states, sync supervision, emergencies."""

import struct
from typing import Any

import pytest

from achse.codes import AbortCode, AlState, AlStatus
from achse.drive import Alarm, Drive, Mode, PowerState, VirtualDrive
from achse.drive.drive import LONGEST_CYCLE_NS

OK = AlStatus.NO_ERROR
RX = struct.Struct("<HbHiHI")  # 1600h
TX = struct.Struct("<HHbiHiiI")  # 1A00h


def _op(sync0_ns: int = 0, **options: Any) -> Drive:
    drive = Drive(**options)
    for state in (AlState.PREOP, AlState.SAFEOP, AlState.OP):
        assert drive.enter(state, sync0_ns, OK) is OK
    return drive


def _cycle(drive: Drive, word: int, target: int = 0, elapsed: int = 1_000_000) -> tuple[int, ...]:
    drive.write_outputs(RX.pack(word, Mode.CYCLIC_POSITION, 3_000, target, 0, 0))
    assert drive.step(elapsed) is OK
    return TX.unpack(drive.read_inputs())


def test_a_csp_ramp_over_process_data() -> None:
    drive = _op()
    for word in (0, 6, 7, 15, 15):
        error, status, mode, position, *_ = _cycle(drive, word)
    assert (error, status & 0x6F, mode, position) == (0, 0x27, 8, 0)
    for n in range(1_000):
        _, status, _, position, _, _, deviation, _ = _cycle(drive, 15, 100 * n)
        assert status & 0x1000
        assert position + deviation == 100 * n
    assert abs(deviation) < 50


def test_sizes_are_those_of_the_mapping() -> None:
    drive = Drive()
    assert (drive.output_size, drive.input_size) == (RX.size, TX.size)
    assert len(drive.read_inputs()) == TX.size


def test_inputs_stay_valid_between_states() -> None:
    drive = Drive()
    for state in (AlState.PREOP, AlState.SAFEOP):
        drive.enter(state, 0, OK)
        assert TX.unpack(drive.read_inputs())[1] == drive.record.statusword


@pytest.mark.parametrize("sync0", [250_000, 500_000, 750_000, 1_000_000, 2_000_000, 4_000_000])
def test_sync0_cycles_the_drive_keeps(sync0: int) -> None:
    drive = _op(sync0)
    assert (drive.get(0x1C32, 1), drive.get(0x1C33, 2)) == (2, sync0)


@pytest.mark.parametrize(
    ("sync0", "shown"),
    [
        (250_000, (25, -5)),
        (500_000, (5, -4)),
        (750_000, (75, -5)),
        (1_000_000, (1, -3)),
        (2_000_000, (2, -3)),
        (3_500_000, (35, -4)),
        (4_000_000, (4, -3)),
        (2_750_000, (1, -3)),
    ],
)
def test_60c2h_shows_the_communication_cycle(sync0: int, shown: tuple[int, int]) -> None:
    drive = _op(sync0)
    assert (drive.get(0x60C2, 1), drive.get(0x60C2, 2)) == shown
    assert drive.record.communication_cycle == pytest.approx(sync0 * 1e-9)


def test_a_fall_is_never_refused() -> None:
    drive = _op(1_000_000)
    drive.enter(AlState.SAFEOP, 333, AlStatus.WATCHDOG)
    assert drive.state == AlState.SAFEOP
    drive = _op(1_000_000)
    drive.faults.local_control()
    assert drive.enter(AlState.SAFEOP, 333, OK) is OK
    assert drive.state == AlState.SAFEOP


@pytest.mark.parametrize("sync0", [1, 125_000, 249_999, 300_000, 4_250_000, 5_000_000])
@pytest.mark.parametrize("state", [AlState.SAFEOP, AlState.OP])
def test_sync0_cycles_it_refuses(sync0: int, state: AlState) -> None:
    drive = Drive()
    drive.enter(AlState.PREOP, 0, OK)
    assert drive.enter(state, sync0, OK) is AlStatus.SYNC_CYCLE
    assert drive.state == AlState.PREOP


def test_the_counter_of_the_manual_s_example() -> None:
    """10F1h: limit 9, lost and received frames in turn: 0 3 2 5 4 7 6 9."""
    drive = _op(1_000_000)
    drive.set(0x10F1, 9, 2)
    seen, answers = [drive.sync_error_counter], []
    for n in range(10):
        if n % 2:
            drive.write_outputs(RX.pack(0, 8, 0, 0, 0, 0))
        answers.append(drive.step(1_000_000))
        seen.append(drive.sync_error_counter)
    assert seen == [0, 3, 2, 5, 4, 7, 6, 9, 9, 9, 9]
    assert answers == [OK] * 6 + [AlStatus.SYNCHRONIZATION] * 4


def test_limit_0_and_free_run_do_not_count() -> None:
    for sync0, limit in ((1_000_000, 0), (0, 9)):
        drive = _op(sync0)
        drive.set(0x10F1, limit, 2)
        assert {drive.step(1_000_000) for _ in range(50)} == {OK}


def test_missed_events_are_counted_whatever_the_limit() -> None:
    drive = _op(1_000_000)
    for n in range(7):
        if n % 3:
            drive.write_outputs(RX.pack(0, 8, 0, 0, 0, 0))
        drive.step(1_000_000)
    assert (drive.get(0x1C32, 11), drive.get(0x1C33, 11), drive.get(0x1C32, 32)) == (3, 3, 0)
    drive.enter(AlState.SAFEOP, 1_000_000, AlStatus.SYNCHRONIZATION)
    assert (drive.get(0x1C32, 11), drive.get(0x1C32, 32), drive.get(0x1C33, 32)) == (3, 1, 1)
    drive.enter(AlState.OP, 1_000_000, OK)
    assert (drive.get(0x1C32, 11), drive.get(0x1C32, 32)) == (0, 0)


def test_the_counter_never_falls_below_0() -> None:
    drive = _op(1_000_000)
    for _ in range(5):
        _cycle(drive, 0)
    assert drive.sync_error_counter == 0


def test_emergencies_wait_in_order_and_can_be_switched_off() -> None:
    drive = _op()
    for alarm in (Alarm.OVER_VOLTAGE, Alarm.OVER_SPEED):
        drive.faults.alarm(alarm, lasting=False)
        _cycle(drive, 0)
        _cycle(drive, 0)
    assert drive.take_emergency() == bytes.fromhex("11ff010000000000")
    assert drive.take_emergency() == bytes.fromhex("13ff010000000000")
    assert drive.take_emergency() is None
    drive.set(0x10F3, 0, 5)
    drive.faults.alarm(Alarm.OVER_VOLTAGE, lasting=False)
    _cycle(drive, 0)
    assert drive.take_emergency() is None


def test_a_watchdog_while_enabled() -> None:
    """SafeOp with 0x1B: fault, emergency; acknowledge, Op and reset recover."""
    drive = _op()
    for word in (0, 6, 7, 15, 15):
        _cycle(drive, word)
    drive.enter(AlState.SAFEOP, 0, AlStatus.WATCHDOG)
    for _ in range(3):
        drive.step(1_000_000)
    assert drive.power_state is PowerState.FAULT
    assert drive.take_emergency() == bytes.fromhex("49ff010000000000")
    drive.enter(AlState.OP, 0, OK)
    for word in (0, 0x80, 0, 6, 7, 15, 15):
        inputs = _cycle(drive, word, drive.record.position_actual)
    assert inputs[1] & 0x6F == 0x27


def test_leaving_op_drops_outputs_not_yet_taken() -> None:
    drive = _op()
    drive.write_outputs(RX.pack(6, 8, 0, 0, 0, 0))
    drive.enter(AlState.SAFEOP, 0, OK)
    drive.step(1_000_000)
    assert drive.record.controlword == 0


@pytest.mark.parametrize("elapsed", [250_000, 1_000_000, 2_500_000, 100_000_000])
def test_long_steps_are_done_in_cycles(elapsed: int) -> None:
    drive = _op()
    _cycle(drive, 0)
    drive.step(elapsed)
    count = -(-elapsed // LONGEST_CYCLE_NS)
    assert drive.record.step_time == pytest.approx(elapsed / count * 1e-9)
    assert drive.step(0) is OK


def test_bytes_in_and_out(aborts: Any) -> None:
    drive = Drive()
    drive.write_object(0x6081, 0, bytes.fromhex("40420f00"))
    assert drive.read_object(0x6081, 0) == bytes.fromhex("40420f00")
    for data in (b"", b"\0\0\0", b"\0" * 5):
        with aborts(AbortCode.UNSUPPORTED_ACCESS):
            drive.write_object(0x6081, 0, data)
    with aborts(AbortCode.READ_ONLY):
        drive.write_object(0x6041, 0, b"\0\0")
    with aborts(AbortCode.NO_OBJECT):
        drive.read_object(0x7000, 0)


def test_presets_are_checked(aborts: Any) -> None:
    with aborts(AbortCode.VALUE_RANGE):
        Drive(parameters={0x605A: 5})
    with aborts(AbortCode.NO_OBJECT):
        Drive(parameters={0x9999: 5})
    assert Drive(parameters={(0x6099, 2): 5}).get(0x6099, 2) == 5


def test_presets_hold_what_is_not_stored() -> None:
    drive = VirtualDrive(parameters={0x6081: 7})
    drive.set(0x6081, 8)
    drive.power_cycle()
    assert drive.get(0x6081) == 7


def test_a_master_that_reads_no_emergency_gets_the_newest() -> None:
    drive = VirtualDrive()
    for alarm in (*[Alarm.OVER_SPEED] * 100, Alarm.CONTINUOUS_OVERLOAD):
        drive.faults.alarm(alarm, lasting=False)
        drive.cycle(2)
        drive.reset_fault()
    reports = []
    while (message := drive.take_emergency()) is not None:
        reports.append(int.from_bytes(message[:2], "little"))
    assert reports[-2:] == [Alarm.CONTINUOUS_OVERLOAD.code, 0]
    assert len(reports) < 100


def test_a_reset_in_op_leaves_the_cycle_of_sync0() -> None:
    drive = VirtualDrive()
    drive.bring_up(AlState.PREOP)
    drive.bring_up(AlState.OP, sync0_ns=2_000_000)
    drive.request_reset()
    drive.cycle()
    assert drive.get(0x1C32, 2) == 2_000_000
    assert (drive.get(0x60C2, 1), drive.get(0x60C2, 2)) == (2, -3)
    assert drive.record.communication_cycle == pytest.approx(0.002)


def test_power_cycle_begins_in_init() -> None:
    drive = VirtualDrive()
    drive.enable(Mode.CYCLIC_POSITION)
    drive.power_cycle()
    assert drive.state == AlState.INIT
    assert drive.power_state is PowerState.NOT_READY_TO_SWITCH_ON
    assert "INIT, not ready to switch on" in repr(drive)
