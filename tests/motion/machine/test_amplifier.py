"""What a drive makes of its outputs, against its equations."""

from typing import Any

import pytest

from achse.motion.port import (
    LIMIT_MAX,
    LIMIT_MIN,
    STATUS_ENABLED,
    STATUS_ERROR,
    STATUS_FAST_STOP,
    STATUS_INVALID,
    STATUS_READY,
)
from achse.motion.states import DriveOperationMode

ANALOG = 1
FULL = 0x7FFF_FFFF
VELOCITY = DriveOperationMode.VELOCITY_FEEDBACK1.value
POSITION = DriveOperationMode.POSITION_FEEDBACK1.value
TORQUE = DriveOperationMode.TORQUE.value
STIFF = {"time_constant": 0.0}


def analog(make_machine: Any, **values: float) -> Any:
    return make_machine(kind=ANALOG, full_velocity=1000.0, full_output=32_767, **STIFF | values)


@pytest.mark.parametrize("inverted", [0, 1])
def test_an_analog_output_is_a_share_of_the_full_velocity(
    make_machine: Any, inverted: int, dt: float
) -> None:
    bench = analog(make_machine, motor_inverted=inverted)
    bench.run(10, ctrl1=1, data_out1=3277)
    velocity = (-1000.0 if inverted else 1000.0) * 3277 / 32_767
    assert bench.machine.velocity == pytest.approx(velocity)
    assert bench.machine.position == pytest.approx(10 * dt * velocity)
    weight = bench.amplifier.velocity_weight
    assert bench.drive.data_in3 == round(abs(velocity) * weight)


def test_it_moves_when_it_is_enabled_alone(make_machine: Any) -> None:
    bench = analog(make_machine)
    bench.run(5, ctrl1=0, data_out1=10_000)
    assert bench.machine.position == 0.0
    assert bench.drive.state1 == STATUS_READY
    bench.run(5, ctrl1=1)
    assert bench.machine.position > 0.0
    assert bench.drive.state1 == STATUS_READY | STATUS_ENABLED


def test_a_digital_velocity_has_a_weight(make_machine: Any) -> None:
    bench = make_machine(velocity_weight=50.0, **STIFF)
    bench.run(3, ctrl1=1, ctrl3=VELOCITY, data_out2=-1000)
    assert bench.machine.velocity == -20.0


@pytest.mark.parametrize("dead_cycles", [0, 1, 7])
@pytest.mark.parametrize("mode", [VELOCITY, POSITION])
def test_outputs_come_after_the_dead_time(
    make_machine: Any, dead_cycles: int, mode: int, dt: float
) -> None:
    bench = make_machine(dead_time=dead_cycles * dt, velocity_weight=1.0, **STIFF)
    bench.run(3, ctrl1=1, ctrl3=mode)
    bench.run(dead_cycles, data_out1=10_000, data_out2=500)
    assert bench.machine.position == 0.0
    bench.run(1)
    assert bench.machine.position == pytest.approx(1.0)  # 10,000 increments, or a cycle at 500


def test_a_position_is_reached_in_a_cycle(make_machine: Any, dt: float) -> None:
    bench = make_machine(position_weight=100.0)
    for count in (10, 25, -3):
        before = bench.machine.position
        bench.run(1, ctrl1=1, ctrl3=POSITION, data_out1=count)
        assert bench.machine.position == pytest.approx(count / 100.0)
        assert bench.machine.velocity == pytest.approx((bench.machine.position - before) / dt)
    bench.run(5, ctrl1=0, data_out1=9)
    assert bench.machine.position == pytest.approx(-0.03)
    assert bench.machine.velocity == 0.0


def test_positions_go_on_beyond_a_double_word(make_machine: Any) -> None:
    bench = make_machine(position_weight=1.0)
    bench.machine.position = 2.0**31 - 3
    bench.run(1, ctrl1=1, ctrl3=POSITION, data_out1=-(2**31) + 5)
    assert bench.machine.position == 2.0**31 + 5


def test_a_blocked_motor_stays(make_machine: Any) -> None:
    bench = make_machine(blocked=1, velocity_weight=1.0, position_weight=1.0)
    for mode in (VELOCITY, POSITION, TORQUE):
        bench.run(5, ctrl1=1, ctrl3=mode, data_out1=7, data_out2=7, data_out5=500)
        assert (bench.machine.position, bench.machine.velocity) == (0.0, 0.0)


def test_a_torque_accelerates_against_load_and_friction(make_machine: Any, dt: float) -> None:
    bench = make_machine(
        full_torque_acceleration=5000.0, load_torque=100.0, friction_torque=50.0,
        set_torque_weight=10.0, torque_weight=2.0,
    )  # fmt: skip
    bench.run(100, ctrl1=1, ctrl3=TORQUE, data_out5=3500)
    assert bench.machine.velocity == pytest.approx(0.2 * 5000.0 * 100 * dt)
    assert bench.drive.data_in2 == 700


def test_limits_of_a_torque_hold_where_they_count(make_machine: Any) -> None:
    bench = make_machine(full_torque_acceleration=5000.0, velocity_weight=10.0)
    limits = {"data_out1": 300, "data_out2": -300, "data_out3": 0, "data_out6": 0}
    bench.run(500, ctrl1=1, ctrl2=1, ctrl3=TORQUE, data_out5=500, **limits)
    assert bench.machine.velocity == 30.0
    assert bench.drive.state1 & 1 << 6
    bench.run(100, ctrl2=0)
    assert bench.machine.velocity > 100.0
    assert bench.drive.state1 & 1 << 6 == 0


@pytest.mark.parametrize("side", [-1, 1])
def test_beyond_a_limit_switch_it_moves_back_alone(make_machine: Any, side: int) -> None:
    bench = make_machine(
        limit_min=-5.0, limit_max=5.0, velocity_weight=1.0, position=6.0 * side, **STIFF
    )
    bench.run(1)
    assert bench.drive.state2 == (LIMIT_MAX if side > 0 else LIMIT_MIN)
    assert bench.drive.state1 & STATUS_READY == 0
    bench.run(10, ctrl1=1, ctrl3=VELOCITY, data_out2=100 * side)
    assert bench.machine.position == 6.0 * side
    bench.run(10, data_out2=-100 * side)
    assert abs(bench.machine.position) < 5.0
    assert bench.drive.state2 == 0
    assert bench.drive.state1 & STATUS_READY


def test_the_status_shows_faults_and_signals(make_machine: Any) -> None:
    bench = make_machine(drive_inputs=0x81)
    bench.machine.not_ready = 1
    bench.run(1)
    assert bench.drive.state1 == STATUS_ERROR
    assert bench.drive.state8 == 0x81
    bench.machine.not_ready = 0
    bench.machine.fast_stop_signal = bench.machine.io_invalid = 1
    bench.run(1)
    assert bench.drive.state1 == STATUS_READY
    assert bench.drive.state4 == STATUS_FAST_STOP | STATUS_INVALID


def test_a_machine_at_rest_is_passed_over_until_something_changes(make_machine: Any) -> None:
    bench = make_machine(velocity_weight=1.0, **STIFF)
    bench.run(10)
    assert bench.machine.resting == 1
    bench.run(1, ctrl1=1, ctrl3=VELOCITY, data_out2=5)
    assert bench.machine.resting == 0
    bench.run(10, data_out2=0)
    assert bench.machine.resting == 1
    bench.amplifier.drift = 1.0
    assert bench.machine.resting == 0


def test_a_profidrive_closes_the_position_loop(make_machine: Any) -> None:
    bench = make_machine(position_loop=1, error_weight=10.0, velocity_weight=1.0, **STIFF)
    bench.run(2, ctrl1=1, ctrl3=VELOCITY, data_out1=20_000, data_out2=3, data_out6=40)
    assert bench.machine.velocity == pytest.approx(3.0 + 20.0 * 4.0)
