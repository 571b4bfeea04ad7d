"""Signals along the machine: edges are latched where they are, whatever the cycle."""

from typing import Any

import pytest

from achse.motion import AxisParameters, ControlBit, MotionPhase, Nc, StateBit, commands
from achse.motion.control.signals import WAITS, arm_in_force, homing_cam, probe_inputs
from achse.motion.features import Feature
from achse.motion.machine.signals import drive_inputs

RISING, FALLING = 0, 1
SINGLE, CONTINUOUS = 1, 2
INDEX, DRIVE_DEFINED = 128, 129
MARK = {"simulation_mark_begin": 10.0, "simulation_mark_end": 12.5, "simulation_mark_input": 2}


@pytest.fixture(params=[False, True], ids=["plain", "compiled"])
def make(request: pytest.FixtureRequest, make_rig: Any) -> Any:
    return lambda **values: make_rig(compiled=request.param, **values)


def move(rig: Any, target: float, velocity: float = 200.0) -> None:
    assert commands.start(rig.axis, 1, target, velocity) == 0
    rig.until_rest()
    rig.seconds(0.5)


def latched(rig: Any, probe: int, edge: int) -> tuple[int, int, float, int]:
    axis, i = rig.axis, probe - 1 + 4 * edge
    return (
        axis.encoder.probe_active[i], axis.encoder.probe_valid[i],
        axis.encoder.probe_position[i], axis.encoder.probe_counter[i],
    )  # fmt: skip


@pytest.mark.parametrize("velocity", [3.0, 200.0, 1900.0])
@pytest.mark.parametrize(
    ("edge", "target", "place"),
    [(RISING, 30.0, 10.0), (FALLING, 30.0, 12.5), (RISING, 11.0, 10.0)],
)
def test_a_mark_is_latched_where_it_is(
    make: Any, velocity: float, edge: int, target: float, place: float
) -> None:
    rig = make(**MARK)
    commands.activate_touch_probe(rig.axis, 2, edge, SINGLE, 2)
    move(rig, target, velocity)
    assert latched(rig, 2, edge) == (0, 1, pytest.approx(place, abs=1e-9), 1)


@pytest.mark.parametrize(("edge", "place"), [(RISING, 12.5), (FALLING, 10.0)])
def test_on_the_way_back_the_edges_are_the_other_ones(make: Any, edge: int, place: float) -> None:
    rig = make(**MARK)
    move(rig, 30.0)
    commands.activate_touch_probe(rig.axis, 2, edge, SINGLE, 2)
    move(rig, 0.0)
    assert latched(rig, 2, edge) == (0, 1, pytest.approx(place, abs=1e-9), 1)


def test_the_status_word_says_that_something_was_latched(make: Any) -> None:
    rig = make(**MARK)
    commands.activate_touch_probe(rig.axis, 2, RISING, SINGLE, 2)
    rig.run(1)
    assert not rig.has(StateBit.EXTERNAL_LATCH_VALID)
    commands.start(rig.axis, 1, 30.0, 100.0)
    rig.until(lambda axis: axis.actual_position >= 10.0)
    assert rig.has(StateBit.EXTERNAL_LATCH_VALID)
    rig.until_rest()
    commands.activate_touch_probe(rig.axis, 2, RISING, SINGLE, 2)
    rig.run(1)
    assert not rig.has(StateBit.EXTERNAL_LATCH_VALID)


def test_both_edges_of_a_mark_within_one_cycle(make: Any) -> None:
    """1900 mm/s are 3.8 mm per cycle; the mark is 2.5 mm long."""
    rig = make(simulation_mark_begin=900.0, simulation_mark_end=902.5, simulation_mark_input=1)
    commands.activate_touch_probe(rig.axis, 1, RISING, SINGLE, 1)
    commands.activate_touch_probe(rig.axis, 1, FALLING, SINGLE, 1)
    move(rig, 2500.0, 1900.0)
    assert latched(rig, 1, RISING)[2] == pytest.approx(900.0, abs=1e-9)
    assert latched(rig, 1, FALLING)[2] == pytest.approx(902.5, abs=1e-9)


def test_index_pulses_come_once_per_turn(make: Any) -> None:
    rig = make(simulation_turn=10_000.0, simulation_index_position=2_500.0)
    commands.activate_touch_probe(rig.axis, 3, RISING, CONTINUOUS, INDEX)
    move(rig, 20.0, 50.0)
    assert latched(rig, 3, RISING) == (1, 1, pytest.approx(19.25, abs=1e-9), 20)
    move(rig, 10.0, 50.0)
    assert latched(rig, 3, RISING) == (1, 1, pytest.approx(10.25, abs=1e-9), 30)
    commands.deactivate_touch_probe(rig.axis, 3, RISING)
    assert latched(rig, 3, RISING)[:2] == (0, 0)


def test_the_drive_chooses_the_signal(make: Any) -> None:
    rig = make(**MARK, simulation_latch_source=2)
    commands.activate_touch_probe(rig.axis, 1, FALLING, SINGLE, DRIVE_DEFINED)
    move(rig, 30.0)
    assert latched(rig, 1, FALLING)[2] == pytest.approx(12.5, abs=1e-9)


def test_an_input_switched_by_hand_is_seen_by_the_next_cycle(make: Any) -> None:
    rig = make()
    commands.activate_touch_probe(rig.axis, 1, RISING, CONTINUOUS, 1)
    commands.activate_touch_probe(rig.axis, 1, FALLING, SINGLE, 1)
    rig.seconds(1.0)
    assert rig.axis.resting == 1
    commands.start(rig.axis, 3, 0.0, 100.0)
    rig.seconds(1.0)
    rig.axis.simulation_drive_inputs = 1
    rig.run(1)
    here = rig.axis.actual_position
    assert latched(rig, 1, RISING) == (1, 1, pytest.approx(here, abs=1e-4), 1)
    rig.seconds(0.1)
    assert latched(rig, 1, RISING)[3] == 1
    rig.axis.simulation_drive_inputs = 0
    rig.run(1)
    there = rig.axis.actual_position
    assert latched(rig, 1, FALLING) == (0, 1, pytest.approx(there, abs=1e-4), 1)
    assert there == pytest.approx(here + 51 * 0.2, abs=1e-3)


def test_what_is_closed_already_is_no_edge(make: Any) -> None:
    rig = make(**MARK, simulation_drive_inputs=0b10)
    commands.activate_touch_probe(rig.axis, 2, RISING, SINGLE, 2)
    commands.activate_touch_probe(rig.axis, 2, FALLING, SINGLE, 2)
    move(rig, 30.0)
    assert latched(rig, 2, RISING)[:2] == latched(rig, 2, FALLING)[:2] == (1, 0)


def test_cam_and_mark_at_one_input_overlap(make: Any) -> None:
    """Closed from 5 to 12.5: the cam ends at 11, the mark begins at 10."""
    rig = make(**MARK, simulation_cam_begin=5.0, simulation_cam_end=11.0, simulation_cam_input=2)
    commands.activate_touch_probe(rig.axis, 2, RISING, CONTINUOUS, 2)
    commands.activate_touch_probe(rig.axis, 2, FALLING, CONTINUOUS, 2)
    move(rig, 30.0)
    assert latched(rig, 2, RISING)[2:] == (pytest.approx(5.0, abs=1e-9), 1)
    assert latched(rig, 2, FALLING)[2:] == (pytest.approx(12.5, abs=1e-9), 1)


def test_what_the_latch_before_was(make: Any) -> None:
    rig = make(simulation_turn=10_000.0)
    commands.activate_touch_probe(rig.axis, 1, RISING, CONTINUOUS, INDEX)
    commands.start(rig.axis, 1, 100.0, 20.0)
    rig.until(lambda axis: axis.encoder.probe_counter[0] == 7)
    axis = rig.axis
    assert axis.encoder.latch_hardware_increments == 70_000
    assert axis.encoder.latch_software_increments == 70_000
    assert axis.encoder.latch_position == pytest.approx(7.0)
    assert axis.encoder.latch_hardware_increment_difference == 10_000
    assert axis.encoder.latch_software_increment_difference == 10_000
    assert axis.encoder.latch_position_difference == pytest.approx(1.0)


def test_latches_read_positions_not_filters(make: Any) -> None:
    rig = make(
        **MARK, encoder_position_filter_time=0.05, encoder_position_offset=3.0,
        encoder_count_direction=1, drive_motor_polarity=1,
        encoder_dead_time_compensation_mode=1, encoder_dead_time_compensation_shift=5_000_000,
    )  # fmt: skip
    commands.set_actual_position(rig.axis, 1, 1000.0)
    commands.activate_touch_probe(rig.axis, 2, RISING, SINGLE, 2)
    move(rig, 1030.0, 50.0)
    assert latched(rig, 2, RISING)[2] == pytest.approx(1010.0, abs=1e-9)


@pytest.mark.parametrize("compiled", [False, True])
def test_a_further_encoder_has_probes_of_its_own(compiled: bool) -> None:
    values = {"control_dword": 7, "velocity_override": 1_000_000, **MARK}
    nc = Nc(
        2_000_000,
        [
            AxisParameters(
                1, values=values, encoder_ids=(1, 2),
                elements=[{"encoder_scaling_factor": 0.01, "encoder_position_offset": 500.0}],
            )
        ],
        compiled=compiled,
    )  # fmt: skip
    second = nc.element("encoder", 2)
    commands.activate_touch_probe(second, 2, RISING, SINGLE, 2)
    for _ in range(3):
        nc.cycle()
    commands.start(nc.axis(1), 1, 30.0, 100.0)
    for _ in range(1500):
        nc.cycle()
    assert second.probe_valid[1] == 1
    assert second.probe_position[1] == pytest.approx(510.0, abs=0.0101)
    assert nc.axis(1).encoder.probe_valid[1] == 0


def test_inputs_are_those_of_hand_cam_and_mark(rig: Any) -> None:
    axis = rig.axis
    axis.simulation_cam_begin, axis.simulation_cam_end = -1.0, 1.0
    for cam, mark, hand, inputs in ((0, 0, 0, 0), (3, 0, 1, 0b101), (8, 1, 0, 0x81)):
        axis.simulation_cam_input, axis.simulation_mark_input = cam, mark
        axis.simulation_drive_inputs = hand
        axis.simulation_mark_begin, axis.simulation_mark_end = -1.0, 1.0
        assert drive_inputs(axis.machine) == inputs
        rig.run(1)
        assert axis.drive.io.state8 == inputs
        assert homing_cam(axis) == (cam == 0)


@pytest.mark.parametrize("compiled", [False, True])
def test_a_rotary_table_meets_its_mark_each_turn(make_rig: Any, compiled: bool) -> None:
    rig = make_rig(
        compiled=compiled, simulation_period=360.0, simulation_mark_begin=350.0,
        simulation_mark_end=355.0, simulation_mark_input=1,
    )  # fmt: skip
    commands.activate_touch_probe(rig.axis, 1, RISING, CONTINUOUS, 1)
    commands.activate_touch_probe(rig.axis, 1, FALLING, CONTINUOUS, 1)
    move(rig, 1000.0, 1000.0)
    assert latched(rig, 1, RISING) == (1, 1, pytest.approx(710.0, abs=1e-9), 2)
    assert latched(rig, 1, FALLING) == (1, 1, pytest.approx(715.0, abs=1e-9), 2)
    move(rig, -6.0, 1000.0)
    assert latched(rig, 1, RISING) == (1, 1, pytest.approx(-5.0, abs=1e-9), 5)
    assert latched(rig, 1, FALLING) == (1, 1, pytest.approx(350.0, abs=1e-9), 4)
    assert drive_inputs(rig.axis.machine) == 1


def test_a_source_that_is_no_input_says_nothing(make: Any) -> None:
    rig = make(simulation_drive_inputs=255)
    rig.axis.simulation_latch_source = 100
    commands.activate_touch_probe(rig.axis, 1, RISING, SINGLE, DRIVE_DEFINED)
    move(rig, 10.0)
    assert latched(rig, 1, RISING)[:2] == (1, 0)


ACCEPT_BLOCKED = 7 | ControlBit.ACCEPT_BLOCKED_DRIVE

KINDS: dict[str, dict[str, float]] = {
    "servo": {},
    "turned round": {"encoder_count_direction": 1, "drive_motor_polarity": 1},
    "with position interface": {"simulation_ideal": 1},
    "two speeds": {
        "axis_type": 2, "drive_type": 7, "controller_type": 7, "drive_reference_velocity": 100.0,
    },
    "stepper": {
        "axis_type": 3, "drive_type": 8, "controller_type": 8, "stepper_step_scaling": 0.2,
    },
}  # fmt: skip


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("kind", KINDS)
def test_a_limit_switch_blocks_the_drive_and_lets_it_back_where_that_is_accepted(
    make: Any, kind: str, side: int
) -> None:
    limits = {"simulation_limit_max": 20.0} if side > 0 else {"simulation_limit_min": -20.0}
    rig = make(**KINDS[kind], **limits)
    axis = rig.axis
    outward, inward = (3, 4) if side > 0 else (4, 3)
    assert commands.start(axis, outward, 0.0, 60.0) == 0
    rig.until(lambda ax: ax.error_code)
    assert axis.error_code == 0x4650
    rig.seconds(1.0)
    assert 20.0 <= side * axis.actual_position <= 22.0
    assert axis.machine.velocity == 0.0
    assert commands.reset(axis) == 0
    rig.seconds(0.1)
    assert (axis.error_code, axis.loop_closed) == (0, 0)
    assert commands.start(axis, inward, 0.0, 60.0) == 0x4225
    axis.control_dword = ACCEPT_BLOCKED
    rig.seconds(0.1)
    assert axis.loop_closed == 1
    assert commands.start(axis, outward, 0.0, 60.0) == 0x4225
    assert commands.start(axis, 1, side * 5.0, 60.0) == 0
    rig.until(lambda ax: not ax.limit_switch)
    axis.control_dword = 7
    rig.until_rest()
    assert axis.set_position == pytest.approx(side * 5.0, abs=2.0)
    assert (axis.error_code, axis.loop_closed) == (0, 1)


def test_a_blocked_drive_that_is_accepted_does_not_follow(make: Any) -> None:
    rig = make(simulation_limit_max=20.0, control_dword=ACCEPT_BLOCKED)
    commands.start(rig.axis, 1, 60.0, 100.0)
    rig.until(lambda ax: ax.error_code)
    assert rig.axis.error_code == 0x4550
    assert 20.0 <= rig.axis.actual_position <= 21.0


@pytest.mark.parametrize("inputs", [0, 1, 2, 3, 0xFF])
def test_inputs_of_probes_and_the_torque_reached(inputs: int) -> None:
    axis = Nc(2_000_000, [AxisParameters(1)], compiled=False).axis(1)
    axis.drive.io.state8 = inputs
    assert axis.touch_probe_inputs == probe_inputs(axis.record) == inputs & 3
    axis.set_motion_phase = MotionPhase.TORQUE
    axis.set_torque = axis.torque.target = 2.0
    assert axis.touch_probe_inputs == inputs & 3 | 4
    axis.torque.target = 3.0
    assert axis.touch_probe_inputs == inputs & 3


@pytest.mark.parametrize(("state", "latch"), [(0, 0), (1, 0), (0, WAITS), (1, WAITS)])
def test_homing_is_watched_while_it_or_its_latch_waits(rig: Any, state: int, latch: int) -> None:
    axis = rig.axis
    axis.features = Feature.HOMING.value
    axis.homing.state, axis.homing.latch = state, latch
    arm_in_force(axis)
    assert bool(axis.features & Feature.HOMING) is bool(state or latch)
