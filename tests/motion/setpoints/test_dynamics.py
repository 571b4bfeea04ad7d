"""Dynamics in force: what takes the present acceleration away, and what a fault brakes with."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.codes.axis import StateBit
from achse.codes.nc.choices import MotionPhase
from achse.motion import commands
from achse.motion.setpoints.dynamics import fastest, fault_deceleration, fault_jerk, run_out

STEEP = 1e5
"""Jerk of the running command; the axis has 2250 mm/s³ by default."""

WEAK = 10.0

TAKE_OVER: dict[str, Callable[[Any], int]] = {
    "halt": lambda axis: commands.universal_start(axis, 8192, 0.0, 0.0),
    "weak halt": lambda axis: commands.universal_start(axis, 8192, 0.0, 0.0, 0.0, WEAK, WEAK),
    "MC_Stop": lambda axis: commands.universal_start(axis, 4096, 0.0, 0.0, 0.0, WEAK, WEAK),
    "stop with a ramp": lambda axis: commands.parameterized_stop(axis, WEAK, WEAK),
    "slower": lambda axis: commands.universal_start(axis, 3, 0.0, 10.0, WEAK, WEAK, WEAK),
    "near target": lambda axis: commands.universal_start(axis, 2, 1.0, 10.0, WEAK, WEAK, WEAK),
    "the other way": lambda axis: commands.universal_start(axis, 4, 0.0, 40.0, WEAK, WEAK, WEAK),
}


def accelerating(make_rig: Any, **values: float) -> Any:
    """40 ms after the start of the example: 48.8 mm/s, and still gaining 1500 mm/s²."""
    rig = make_rig(**values)
    assert commands.universal_start(rig.axis, 3, 0.0, 100.0, 1500.0, 1500.0, STEEP) == 0
    rig.seconds(0.04)
    assert rig.axis.set_velocity == pytest.approx(48.75)
    assert rig.axis.set_acceleration == pytest.approx(1500.0)
    return rig


def fastest_until_rest(rig: Any) -> float:
    top: float = 0.0
    for _ in range(60_000):
        rig.run(1)
        top = max(top, abs(rig.axis.set_velocity))
        if rig.axis.set_motion_phase == MotionPhase.NONE:
            return top
    return top


@pytest.mark.parametrize("maximum", [2000.0, 900.0, 100.0])
@pytest.mark.parametrize("command", TAKE_OVER.values(), ids=TAKE_OVER)
def test_a_weaker_jerk_does_not_make_an_axis_faster(
    make_rig: Any, command: Callable[[Any], int], maximum: float
) -> None:
    """The running jerk takes the acceleration away: 48.75 + 1500² / 2e5 = 60 mm/s at most."""
    rig = accelerating(make_rig, max_velocity=maximum)
    assert command(rig.axis) == 0
    expected = 48.75 + 1500.0**2 / (2.0 * STEEP)
    top = 0.0
    for _ in range(2000):
        rig.run(1)
        top = max(top, abs(rig.axis.set_velocity))
    assert top <= expected * (1.0 + 1e-9)


def test_the_halt_of_the_example_rests_soon(make_rig: Any) -> None:
    """60 mm/s are braked by 2250 mm/s³ within 60^1.5 / 2250^0.5 mm."""
    rig = accelerating(make_rig, encoder_soft_limit_max=30.0, encoder_soft_limit_max_enable=1)
    assert TAKE_OVER["halt"](rig.axis) == 0
    begin = rig.axis.set_position
    rig.until_rest()
    assert rig.axis.error_code == 0
    assert rig.axis.set_position < begin + 0.015 * 60.0 + 60.0**1.5 / 2250.0**0.5
    assert rig.axis.set_position <= 30.0


def test_new_dynamics_with_a_weaker_jerk_keep_the_velocity_of_the_move(make_rig: Any) -> None:
    rig = accelerating(make_rig)
    assert commands.new_dynamics(rig.axis, WEAK, WEAK, WEAK) == 0
    assert fastest_until_rest(rig) <= 100.0 * (1.0 + 1e-9)


def test_a_release_is_itself_released_with_the_running_jerk(make_rig: Any) -> None:
    """Three ever weaker halts, each in the release of the one before."""
    rig = accelerating(make_rig)
    for weak in (1000.0, 100.0, 10.0):
        assert commands.universal_start(rig.axis, 8192, 0.0, 0.0, 0.0, weak, weak) == 0
        rig.run(2)
        assert rig.axis.set_acceleration > 0.0
    assert fastest_until_rest(rig) <= 60.0 * (1.0 + 1e-9)


def test_a_braking_axis_keeps_what_the_weaker_jerk_can_release(rig: Any) -> None:
    assert commands.universal_start(rig.axis, 3, 0.0, 500.0, 5000.0, 5000.0, STEEP) == 0
    rig.seconds(1.0)
    assert commands.universal_start(rig.axis, 8192, 0.0, 0.0, 0.0, 5000.0, STEEP) == 0
    rig.until(lambda axis: axis.set_velocity < 250.0)
    assert commands.universal_start(rig.axis, 3, 0.0, 1.0, 5000.0, 5000.0, 10_000.0) == 0
    rig.run(1)
    while rig.axis.set_acceleration < 0.0:
        v, a = rig.axis.set_velocity, rig.axis.set_acceleration
        rig.run(1)
        gain = (rig.axis.set_acceleration - a) / rig.dt
        assert gain <= (1e5 if a * a > 1.01 * 2.0 * 10_000.0 * v else 1e4) * (1.0 + 1e-9)
        assert rig.axis.set_velocity >= 0.0


WITHDRAWN: dict[str, Callable[[Any], object]] = {
    "enable": lambda axis: setattr(axis, "control_dword", 6),
    "feed enable": lambda axis: setattr(axis, "control_dword", 5),
    "reset": lambda axis: commands.reset(axis),
    "override 0": lambda axis: setattr(axis, "velocity_override", 0),
    "external error": lambda axis: commands.set_external_error(axis, 0x4A00),
    "emergency stop": lambda axis: commands.emergency_stop(axis, 1000.0, 1000.0),
    "fast stop": lambda axis: setattr(axis, "simulation_fast_stop_signal", 1),
}


@pytest.mark.parametrize("fault", WITHDRAWN.values(), ids=WITHDRAWN)
@pytest.mark.parametrize("own", [(0.0, 0.0), (4000.0, 50_000.0)])
def test_a_fault_is_stronger_than_a_weak_halt(
    make_rig: Any, fault: Callable[[Any], None], own: tuple[float, float]
) -> None:
    """From 100 mm/s: 2 √(v / j) where the deceleration is not reached, else v / d + d / j."""
    rig = make_rig(
        fast_axis_stop_deceleration=own[0], fast_axis_stop_jerk=own[1], fast_axis_stop_signal_type=1
    )
    axis = rig.axis
    assert commands.start(axis, 3, 0.0, 100.0) == 0
    rig.seconds(1.0)
    assert commands.universal_start(axis, 8192, 0.0, 0.0, 0.0, WEAK, WEAK) == 0
    rig.seconds(0.1)
    v = axis.set_velocity
    assert v > 99.0
    fault(axis)
    jerk, deceleration = max(own[1], 2250.0), max(own[0], 1500.0)
    time = 2.0 * (v / jerk) ** 0.5
    if v * jerk > deceleration**2:
        time = v / deceleration + deceleration / jerk
    assert rig.until_rest() * rig.dt == pytest.approx(time, abs=0.005)


def test_a_feed_enable_is_watched_while_a_halt_runs(rig: Any) -> None:
    assert commands.start(rig.axis, 4, 0.0, 100.0) == 0
    rig.seconds(1.0)
    commands.stop(rig.axis)
    rig.axis.control_dword = 3
    rig.run(1)
    assert rig.axis.error_code == 0x4357
    assert rig.has(StateBit.ERROR)


def test_a_fault_does_not_weaken_a_strong_command(rig: Any) -> None:
    assert commands.universal_start(rig.axis, 3, 0.0, 100.0, 1e5, 1e5, 1e8) == 0
    rig.seconds(1.0)
    commands.set_external_error(rig.axis, 0x4A00)
    assert rig.until_rest() <= 3


def test_the_strongest_ramp_is_that_of_command_default_and_fast_stop(make_rig: Any) -> None:
    axis = make_rig(default_deceleration=5e6, max_deceleration=2e6).axis
    assert (fault_deceleration(axis), fault_jerk(axis)) == (2e6, 2250.0)
    axis.fast_axis_stop_deceleration, axis.fast_axis_stop_jerk = 1e20, 1e30
    assert (fault_deceleration(axis), fault_jerk(axis)) == (1e12, 1e12)


def test_what_an_acceleration_still_adds(make_rig: Any) -> None:
    rig = accelerating(make_rig)
    assert run_out(rig.axis) == pytest.approx(60.0)
    assert fastest(make_rig(max_velocity=700.0).axis) == 700.0
    assert fastest(make_rig(drive_reference_velocity=500.0).axis) == 500.0


def test_a_stopped_compensation_keeps_the_axis_maximum(make_rig: Any) -> None:
    """Main motion and compensation, both still accelerating, are stopped at any time."""
    for cycles in range(2, 60, 3):
        rig = make_rig(max_velocity=120.0, default_acceleration=1500.0)
        assert commands.universal_start(rig.axis, 3, 0.0, 110.0, 0.0, 0.0, STEEP) == 0
        rig.run(10)
        compensation = commands.Compensation(1, 20_000.0, 20_000.0, 100.0, 110.0, 20.0, 100.0)
        assert commands.start_superposition(rig.axis, compensation)[0] in (0, 0x4243)
        rig.run(cycles)
        v = rig.axis.set_velocity
        assert commands.universal_start(rig.axis, 8192, 0.0, 0.0, 0.0, WEAK, WEAK) == 0
        top = max(state[1] for state in rig.trace(200))
        assert top <= min(120.0, v + 1500.0**2 / (2.0 * STEEP)) * (1.0 + 1e-9)


def test_a_stop_takes_no_external_acceleration_over(make_rig: Any) -> None:
    """The feed gains 50,000 mm/s²; the axis by itself would need half a minute to release that."""
    rig = make_rig(controller_following_error_position_monitoring_enable=0)
    axis = rig.axis
    assert commands.start_external_setpoint(axis, 1, 0.0) == 0
    for n in range(1, 6):
        axis.external_set_acceleration = 50_000.0
        axis.external_set_velocity = 50_000.0 * n * rig.dt
        axis.external_set_position = 25_000.0 * (n * rig.dt) ** 2
        rig.run(1)
    assert axis.set_velocity == pytest.approx(500.0)
    commands.stop_external_setpoint(axis)
    assert fastest_until_rest(rig) <= 500.0


def test_own_and_external_motion_keep_the_maximum_together(make_rig: Any) -> None:
    rig = make_rig(
        allow_motion_commands_with_external_setpoint=1,
        controller_following_error_position_monitoring_enable=0,
    )
    axis = rig.axis
    assert commands.start_external_setpoint(axis, 1, 0.0) == 0
    assert commands.universal_start(axis, 3, 0.0, 1500.0) == 0
    top = 0.0
    for n in range(1, 2000):
        axis.external_set_velocity = min(float(n), 1000.0)
        axis.external_set_position += axis.external_set_velocity * rig.dt
        rig.run(1)
        top = max(top, axis.set_velocity)
    assert axis.error_code == 0x4359
    assert 1500.0 < top <= 2000.0 * (1.0 + 1e-6)


def test_a_smaller_maximum_holds_for_what_runs(make_rig: Any) -> None:
    rig = make_rig()
    assert commands.universal_start(rig.axis, 3, 0.0, 500.0) == 0
    assert commands.universal_start(rig.axis, 4, 0.0, 400.0, buffer_mode=1) == 0
    rig.axis.max_velocity = 200.0
    assert max(abs(state[1]) for state in rig.trace(3000)) <= 200.0 * (1.0 + 1e-9)
