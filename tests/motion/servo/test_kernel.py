"""Axes on drives: moves reach the targets they reach on simulated machines, faults end them."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import AlState, AlStatus, NcError
from achse.codes.axis import StartType
from achse.drive.alarms import Alarm
from achse.drive.machine import Switches
from achse.drive.power import PowerState
from achse.motion import commands
from achse.motion.port import STATUS_ENABLED, STATUS_ERROR, STATUS_READY
from achse.motion.servo import ServoMode
from achse.motion.states import DriveOperationMode, TorqueStartType

MODES = list(ServoMode)[1:]


def move(bench: Any, position: float, velocity: float = 100.0) -> None:
    assert commands.start(bench.axis, StartType.ABSOLUTE, position, velocity) == 0
    bench.until(lambda axis: axis.set_motion_phase == 0)


@pytest.mark.parametrize("inverted", [False, True])
@pytest.mark.parametrize("mode", MODES)
def test_a_move_reaches_its_target(make_bench: Any, mode: ServoMode, inverted: bool) -> None:
    bench = make_bench(mode=mode, inverted=inverted)
    bench.ready()
    for target in (20.0, -5.0):
        move(bench, target)
        bench.run(1.5)
        assert bench.axis.error_code == 0
        assert bench.axis.actual_position == pytest.approx(target, abs=0.02)
        sign = -1 if inverted else 1
        assert bench.drive.record.position_actual * 10.0 / 131_072 * sign == pytest.approx(
            bench.axis.actual_position, abs=1e-3
        )


def test_the_loop_is_closed_when_the_drive_is_enabled_and_not_before(make_bench: Any) -> None:
    bench = make_bench(control_dword=0)
    bench.run(0.1)
    assert not bench.axis.loop_closed
    assert bench.drive.power_state < PowerState.OPERATION_ENABLED
    bench.axis.control_dword = 7
    before = 0
    for _ in range(50):
        bench.nc.cycle(1)
        if bench.axis.loop_closed:
            break
        before += 1
        assert not bench.axis.drive_io.state1 & STATUS_READY
    assert before >= 2
    assert bench.axis.drive_io.state1 == STATUS_READY | STATUS_ENABLED
    assert bench.drive.power_state is PowerState.OPERATION_ENABLED
    bench.axis.control_dword = 0
    bench.run(0.05)
    assert not bench.axis.loop_closed
    assert bench.drive.power_state < PowerState.OPERATION_ENABLED


def test_nothing_jumps_when_a_drive_that_was_moved_is_enabled(make_bench: Any) -> None:
    bench = make_bench(control_dword=0)
    bench.run(0.02)
    bench.drive.record.motor_position += 131_072.0
    bench.run(0.02)
    assert bench.axis.actual_position == pytest.approx(10.0)
    bench.axis.control_dword = 7
    bench.ready()
    bench.run(0.1)
    assert bench.axis.actual_position == pytest.approx(10.0, abs=1e-3)
    assert bench.axis.following_error_peak_positive < 1e-3


@pytest.mark.parametrize("mode", MODES)
def test_a_fault_in_motion_is_4650_and_ends_by_a_reset(make_bench: Any, mode: ServoMode) -> None:
    bench = make_bench(mode=mode)
    bench.ready()
    assert commands.start(bench.axis, StartType.ABSOLUTE, 1000.0, 100.0) == 0
    bench.run(0.5)
    bench.drive.faults.alarm(Alarm.OVER_CURRENT_DETECTED, lasting=False)
    bench.until(lambda axis: axis.error_code, 0.1)
    assert NcError.of(bench.axis.error_code) is NcError.DRIVE_NOT_READY
    assert not bench.axis.loop_closed
    bench.run(1.0)
    assert bench.drive.power_state is PowerState.FAULT
    assert bench.axis.drive_io.state1 & STATUS_ERROR
    assert commands.reset(bench.axis) == 0
    bench.ready()
    assert bench.drive.power_state is PowerState.OPERATION_ENABLED
    assert bench.axis.error_code == 0
    here = bench.axis.actual_position
    move(bench, here + 10.0)
    bench.run(1.5)
    assert bench.axis.actual_position == pytest.approx(here + 10.0, abs=0.02)


def test_a_reset_alone_does_not_help_while_the_cause_is_there(make_bench: Any) -> None:
    bench = make_bench()
    bench.ready()
    bench.drive.faults.alarm(Alarm.OVER_VOLTAGE, lasting=True)
    bench.run(0.5)
    assert commands.reset(bench.axis) == 0
    bench.run(2.0)
    assert bench.drive.power_state is PowerState.FAULT
    assert not bench.axis.loop_closed


@pytest.mark.parametrize("compiled", [False, True])
def test_a_drive_that_was_not_found_is_4655_once_the_axis_is_enabled(
    make_bench: Any, compiled: bool
) -> None:
    bench = make_bench(compiled=compiled)
    bench.cut.add(0)
    bench.run(1.0)
    assert bench.axis.error_code == 0, "nobody has looked for it"
    bench.axis.control_dword = 0
    bench.absent = True
    bench.run(1.0)
    assert bench.axis.error_code == 0, "nobody needs it"
    bench.axis.control_dword = 7
    bench.until(lambda axis: axis.error_code, 0.01)
    assert NcError.of(bench.axis.error_code) is NcError.DRIVE_IO_INVALID
    assert commands.reset(bench.axis) == 0
    bench.run(0.1)
    assert NcError.of(bench.axis.error_code) is NcError.DRIVE_IO_INVALID
    bench.cut.clear()
    bench.run(0.1)
    assert commands.reset(bench.axis) == 0
    bench.ready()
    assert bench.axis.error_code == 0


@pytest.mark.parametrize("moving", [False, True])
def test_lost_data_are_4655_after_eight_cycles_and_come_back(make_bench: Any, moving: bool) -> None:
    bench = make_bench()
    bench.ready()
    if moving:
        assert commands.start(bench.axis, StartType.ABSOLUTE, 1000.0, 100.0) == 0
        bench.run(0.5)
    bench.cut.add(0)
    bench.drive.enter(AlState.SAFEOP, 0, AlStatus.WATCHDOG)
    cycles = bench.until(lambda axis: axis.error_code, 0.1) / 0.002
    assert NcError.of(bench.axis.error_code) is NcError.DRIVE_IO_INVALID
    assert 8 <= cycles <= 10
    bench.run(1.0)
    bench.cut.clear()
    bench.up([bench.drive])
    bench.run(0.1)
    assert commands.reset(bench.axis) == 0
    bench.ready()
    place = bench.drive.record.position_actual * 10.0 / 131_072
    assert bench.axis.actual_position == pytest.approx(place, abs=1e-3)
    move(bench, place - 10.0)
    assert bench.axis.error_code == 0


@given(st.integers(1, 7), st.integers(0, 400))
def test_a_few_lost_frames_stop_nothing(make_bench: Any, count: int, when: int) -> None:
    bench = make_bench()
    bench.ready()
    assert commands.start(bench.axis, StartType.ABSOLUTE, 50.0, 100.0) == 0
    bench.nc.cycle(when)
    bench.cut.add(0)
    bench.nc.cycle(count)
    bench.cut.clear()
    bench.until(lambda axis: axis.set_motion_phase == 0)
    bench.run(0.5)
    assert bench.axis.error_code == 0
    assert bench.axis.actual_position == pytest.approx(50.0, abs=1e-3)


def test_the_dead_time_is_measured_and_taken_out_of_the_following_error(make_bench: Any) -> None:
    bench = make_bench()
    bench.ready()
    assert commands.start(bench.axis, StartType.ABSOLUTE, 200.0, 100.0) == 0
    bench.until(lambda axis: axis.drive_io.dc_time > 0, 5.0)
    bench.run(0.6)
    assert bench.axis.set_velocity == pytest.approx(100.0)
    assert bench.axis.drive_io.dc_time * 1e-9 == pytest.approx(0.002, rel=0.1)
    assert abs(bench.axis.following_error) < 0.01
    behind = bench.axis.set_position - bench.axis.actual_position
    assert behind == pytest.approx(100.0 * 0.004, rel=0.1)


def test_limit_switches_and_inputs_of_the_drive_are_seen(make_bench: Any) -> None:
    bench = make_bench(switches=Switches(positive_limit=131_072.0, home=(-10.0, 10.0)))
    bench.ready()
    assert bench.axis.encoder_io.state2 == 1
    assert commands.start(bench.axis, StartType.ABSOLUTE, 100.0, 50.0) == 0
    bench.until(lambda axis: axis.error_code, 5.0)
    assert bench.axis.limit_switch == 1
    assert bench.axis.encoder_io.state2 == 0
    assert 10.0 < bench.axis.actual_position < 15.0


def test_torque_is_shown_in_thousandths(make_bench: Any) -> None:
    bench = make_bench()
    bench.ready()
    assert commands.start(bench.axis, StartType.ABSOLUTE, 100.0, 300.0) == 0
    bench.until(lambda axis: axis.set_acceleration == 2000.0, 2.0)
    bench.run(0.02)
    assert bench.axis.drive.actual_torque == pytest.approx(
        bench.drive.record.torque_actual, abs=10.0
    )
    assert bench.axis.drive.actual_torque > 20.0


@pytest.mark.parametrize("velocity", [5.0, 60.0])
def test_a_torque_command_keeps_to_its_velocity(make_bench: Any, velocity: float) -> None:
    bench = make_bench()
    bench.ready()
    torque, ramp, highest, lowest = 200.0, 1000.0, velocity, -velocity
    code = commands.start_torque_control(
        *(bench.axis, TorqueStartType.ABSOLUTE, 0, 0, 0, torque, ramp, highest, lowest),
        *(1000.0, 1000.0, 0.0),
    )
    assert code == 0
    bench.run(2.0)
    assert bench.axis.error_code == 0
    assert bench.drive.record.mode_display == ServoMode.CST
    assert 0.5 * velocity < bench.axis.actual_velocity < 1.2 * velocity


def test_another_mode_of_operation_is_taken_at_rest_without_losing_the_loop(
    make_bench: Any,
) -> None:
    bench = make_bench()
    bench.ready()
    for mode, number in (
        (DriveOperationMode.VELOCITY_FEEDBACK1, ServoMode.CSV),
        (DriveOperationMode.DEFAULT, ServoMode.CSP),
    ):
        assert commands.set_drive_operation_mode(bench.axis, mode) == 0
        for _ in range(50):
            bench.nc.cycle(1)
            assert bench.axis.loop_closed
        assert bench.drive.record.mode_display == number
        move(bench, bench.axis.actual_position + 5.0)
        assert bench.axis.error_code == 0


def test_a_mode_is_not_changed_while_another_change_is_under_way(make_bench: Any) -> None:
    bench = make_bench()
    bench.ready()
    set_mode = commands.set_drive_operation_mode
    assert set_mode(bench.axis, DriveOperationMode.VELOCITY_FEEDBACK1) == 0
    bench.nc.cycle(1)
    refused = 0
    while (code := set_mode(bench.axis, DriveOperationMode.DEFAULT)) and refused < 50:
        assert code == NcError.DRIVE_MODE_CHANGE_BUSY
        assert bench.drive.record.mode_display != ServoMode.CSV or refused < 5
        refused += 1
        bench.nc.cycle(1)
    assert 1 <= refused < 10
    bench.run(0.2)
    assert bench.drive.record.mode_display == ServoMode.CSP
    assert bench.axis.error_code == 0


@pytest.mark.parametrize("offset", [0, 50_000])
@pytest.mark.parametrize("reference", [0.0, 17.5])
def test_the_homed_by_drive_the_axis(make_bench: Any, offset: int, reference: float) -> None:
    bench = make_bench(homing_method=33, home_offset=offset, encoder_reference_position=reference)
    bench.ready()
    move(bench, 3.0)
    assert commands.home(bench.axis) == 0
    bench.until(lambda axis: axis.set_motion_phase == 0, 60.0)
    bench.run(0.3)
    assert bench.axis.homed
    assert bench.axis.error_code == 0
    assert bench.drive.record.position_actual == pytest.approx(offset, abs=50)
    assert bench.axis.actual_position == pytest.approx(reference, abs=0.01)
    move(bench, reference + 20.0)
    bench.run(0.2)
    assert bench.axis.actual_position == pytest.approx(reference + 20.0, abs=0.01)
    assert bench.drive.record.position_actual - offset == pytest.approx(262_144, abs=50)


def test_a_homing_that_the_drive_cannot_do_is_an_error(make_bench: Any) -> None:
    bench = make_bench(homing_method=7)  # needs a home switch
    bench.ready()
    assert commands.home(bench.axis) == 0
    bench.until(lambda axis: axis.error_code, 5.0)
    assert NcError.of(bench.axis.error_code) is NcError.HOMING_CAM_NOT_FOUND
    assert not bench.axis.homed
    assert commands.reset(bench.axis) == 0
    bench.run(0.5)
    move(bench, 5.0)
    assert bench.axis.error_code == 0


def test_a_homing_is_stopped(make_bench: Any) -> None:
    bench = make_bench(homing_method=33)
    bench.ready()
    move(bench, 8.0)
    assert commands.home(bench.axis) == 0
    bench.run(0.2)
    assert commands.stop(bench.axis) == 0
    bench.until(lambda axis: axis.set_motion_phase == 0, 5.0)
    bench.run(0.5)
    assert not bench.axis.homed
    assert bench.axis.error_code == 0
    here = bench.axis.actual_position
    move(bench, here + 5.0)
    assert bench.axis.actual_position == pytest.approx(here + 5.0, abs=0.01)
