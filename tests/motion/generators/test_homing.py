"""Homing: the documented sequence, in every mode, by the equations of motion."""

import random
from collections.abc import Callable
from itertools import pairwise
from math import sqrt
from typing import Any

import pytest

from achse.codes import NcError
from achse.codes.axis import HomingState
from achse.motion import Axis, MotionPhase, StateBit, commands

V = 30.0
"""Homing velocity of an axis, both ways, mm/s."""

JERK = 2250.0
RAMP = 2.0 * sqrt(V / JERK)
"""Time from rest to V and back: the acceleration rises and falls with the jerk alone."""

BRAKE = 0.5 * V * RAMP
"""Way of such a ramp, mm."""

CYCLE = 0.002
STEP = V * CYCLE
NO_CAM = {"simulation_cam_begin": 1.0, "simulation_cam_end": 0.0}
CAM_BIT = 1 << 5
MARK = {"simulation_mark_begin": -40.0, "simulation_mark_end": -30.0, "simulation_mark_input": 1}

TOWARDS, WAIT, LEAVE, OFF, LATCH, SET = (HomingState(n) for n in range(1, 7))


@pytest.fixture
def make(make_rig: Any) -> Any:
    """An axis that follows its set point exactly, homing to 100 mm."""
    values = {"simulation_ideal": 1.0, "encoder_reference_position": 100.0}
    return lambda **more: make_rig(**(values | more))


def walk(rig: Any, seconds: float = 20.0) -> list[tuple[int, float, float, float, int]]:
    """Homing state, set position, velocity, acceleration, status; after each cycle to the end."""
    axis = rig.axis
    rows = []
    for _ in range(round(seconds / CYCLE)):
        rig.run(1)
        rows.append(
            (
                axis.homing_state, axis.set_position, axis.set_velocity,
                axis.set_acceleration, axis.state_dword,
            )
        )  # fmt: skip
        if axis.homing_state == 0:
            return rows
    raise AssertionError(f"still in step {axis.homing_state}: {axis!r}")


def first(rows: list[Any], state: int) -> int:
    """Cycle, counted from 1, in which the step begins."""
    return next(n for n, row in enumerate(rows, 1) if row[0] == state)


def failed(axis: Axis, error: NcError) -> bool:
    return NcError.of(axis.error_code) is error and axis.homing_state == 0 and axis.homed == 0


def test_the_sequence_by_the_cam_alone(make: Any) -> None:
    rig = make()
    axis = rig.axis
    assert commands.home(axis) == 0
    assert rig.has(StateBit.HOMING_BUSY)
    assert rig.has(StateBit.HAS_JOB)
    rows = walk(rig)
    states = [row[0] for row in rows]
    assert [s for s, before in zip(states, [0, *states], strict=False) if s != before] == [
        TOWARDS, WAIT, LEAVE, OFF, SET, 0,
    ]  # fmt: skip
    on_cam = RAMP + (50.0 - BRAKE) / V
    assert first(rows, LEAVE) * CYCLE == pytest.approx(on_cam, abs=3 * CYCLE)
    turn = rows[first(rows, OFF) - 2][1]
    assert turn == pytest.approx(-50.0 - BRAKE, abs=3 * STEP)
    settle = axis.target_position_monitoring_time
    assert first(rows, OFF) * CYCLE == pytest.approx(on_cam + RAMP + settle, abs=5 * CYCLE)
    off_cam = RAMP + (-50.0 - turn - BRAKE) / V
    assert (first(rows, SET) - first(rows, OFF)) * CYCLE == pytest.approx(off_cam, abs=3 * CYCLE)
    assert axis.homing.latch_position == pytest.approx(-50.0, abs=2 * STEP)
    assert axis.actual_position == pytest.approx(100.0 + BRAKE, abs=2 * STEP)
    assert axis.set_position == axis.target_position == pytest.approx(axis.actual_position)
    assert axis.set_motion_phase == MotionPhase.NONE


def test_no_limit_is_broken_and_the_status_word_reports_the_truth(make: Any) -> None:
    rig = make(encoder_reference_mode=2)
    commands.home(rig.axis)
    rows = walk(rig)
    moving = rows[:-1]
    assert all(abs(v) <= V + 1e-9 for _, _, v, _, _ in moving)
    assert max(v for _, _, v, _, _ in moving) == pytest.approx(V)
    assert min(v for _, _, v, _, _ in moving) == pytest.approx(-V)
    for (_, p, v, a, _), (_, q, w, b, _) in pairwise(moving):
        assert abs(b - a) <= JERK * CYCLE + 1e-6
        assert q - p == pytest.approx(0.5 * (v + w) * CYCLE, abs=JERK * CYCLE**3)
    for _, _, v, _, status in moving:
        assert status & StateBit.HOMING_BUSY
        assert status & StateBit.HAS_JOB
        assert not status & (StateBit.HOMED | StateBit.NOT_MOVING | StateBit.ERROR)
        assert bool(status & StateBit.NEGATIVE_DIRECTION) == (v < 0.0)
        assert bool(status & StateBit.POSITIVE_DIRECTION) == (v > 0.0)
    status = rows[-1][4]
    assert status & StateBit.HOMED
    assert status & StateBit.NOT_MOVING
    assert not status & (StateBit.HOMING_BUSY | StateBit.HAS_JOB)


@pytest.mark.parametrize(
    ("mode", "values", "mark"),
    [
        (2, {}, -7 * 6.5536),
        (2, {"simulation_turn": 30_000.0, "simulation_index_position": 5_000.0}, -49.0 + 1.5),
        (2, {**MARK, "encoder_external_sync_pulse": 1}, -40.0),
        (3, MARK, -40.0),
        (4, MARK, -30.0),
        (5, {"encoder_sub_mask": 0x3FFFF}, -26.2144),
        (6, {}, -7 * 6.5536),
        (6, {**MARK, "simulation_latch_source": 1}, -40.0),
        (7, {**MARK, "simulation_latch_source": 1}, -30.0),
    ],
)
def test_a_latch_takes_the_mark_exactly(make: Any, mode: int, values: Any, mark: float) -> None:
    rig = make(encoder_reference_mode=mode, **values)
    axis = rig.axis
    commands.home(axis)
    rows = walk(rig)
    if values.get("simulation_turn"):
        turns = [(5_000.0 + 30_000.0 * n) * 1e-4 for n in range(-20, 1)]
        mark = min(turn for turn in turns if turn > -50.0 + STEP)
    assert LATCH in {row[0] for row in rows}
    assert axis.homing.latch_position == pytest.approx(mark, abs=1e-9)
    assert axis.encoder.set_position_offset == pytest.approx(100.0 - mark, abs=1e-9)
    stands = rows[-2][1]
    assert stands == pytest.approx(mark + BRAKE, abs=3 * STEP)
    assert axis.actual_position == pytest.approx(100.0 + stands - mark, abs=1e-4)
    assert axis.encoder.latch_activation_difference == pytest.approx(mark + 50.0, abs=2 * STEP)
    assert axis.homed == 1


def test_positions_renamed_on_the_way_do_not_matter(make: Any) -> None:
    ends = []
    for step in (None, LATCH, SET):
        rig = make(encoder_reference_mode=2)
        commands.home(rig.axis)
        if step is not None:
            rig.until(lambda axis, step=step: axis.homing_state == step)
            commands.set_actual_position_on_the_fly(rig.axis, 2, 0, 1000.0)
        rig.until_rest()
        assert rig.axis.homed == 1
        ends.append((rig.axis.actual_position, rig.axis.encoder.latch_activation_difference))
    assert ends[1] == pytest.approx(ends[0])
    assert ends[2] == pytest.approx(ends[0])


def test_a_real_homed_by_drive_as_exactly(make_rig: Any) -> None:
    rig = make_rig(encoder_reference_mode=2)
    commands.home(rig.axis)
    walk(rig)
    assert rig.axis.homing.latch_position == pytest.approx(-7 * 6.5536, abs=1e-9)
    assert rig.axis.error_code == 0


def test_homing_twice_gives_the_same_position(make: Any) -> None:
    rig = make(encoder_reference_mode=5)
    for _ in range(2):
        commands.home(rig.axis)
        assert not rig.has(StateBit.HOMED)
        walk(rig)
    assert rig.axis.encoder.set_position_offset == pytest.approx(100.0 + 7 * 6.5536, abs=1e-9)


def test_search_directions(make: Any) -> None:
    """The cam in positive direction, off it in negative direction."""
    rig = make(
        encoder_homing_cam_search_inverse=0, encoder_sync_pulse_search_inverse=1,
        simulation_cam_begin=20.0, simulation_cam_end=1e6, encoder_reference_mode=2,
    )  # fmt: skip
    commands.home(rig.axis)
    walk(rig)
    assert rig.axis.homing.latch_position == pytest.approx(3 * 6.5536, abs=1e-9)
    assert rig.axis.actual_position == pytest.approx(100.0 - BRAKE, abs=3 * STEP)


def test_a_cam_that_is_passed_can_be_left_on_the_other_side(make: Any) -> None:
    rig = make(encoder_sync_pulse_search_inverse=1, simulation_cam_begin=-70.0)
    commands.home(rig.axis)
    walk(rig)
    assert rig.axis.homing.latch_position == pytest.approx(-70.0, abs=2 * STEP)


def test_a_rotary_table_finds_the_nearest_turn_of_its_cam(make: Any) -> None:
    rig = make(simulation_period=360.0, simulation_cam_begin=-70.0)
    commands.start(rig.axis, 1, 330.0, 500.0)
    rig.until_rest()
    rig.seconds(0.1)
    commands.home(rig.axis)
    walk(rig)
    assert rig.axis.homing.latch_position == pytest.approx(310.0, abs=2 * STEP)


def test_from_the_cam_the_sequence_goes_on_with_step_3(make: Any) -> None:
    rig = make(simulation_cam_end=5.0)
    commands.home(rig.axis)
    rows = walk(rig)
    states = list(dict.fromkeys(row[0] for row in rows))
    assert states == [TOWARDS, LEAVE, OFF, SET, 0]
    assert rig.axis.homing.latch_position == pytest.approx(5.0, abs=2 * STEP)


def test_any_client_that_reads_every_cycle_sees_every_step(make_rig: Any) -> None:
    """Cams, marks, modes, velocities, overrides at random: the first cycle shows step 1 (004)."""
    source = random.Random(10)
    order = [TOWARDS, WAIT, LEAVE, OFF, LATCH, SET, 0]
    for number in range(60):
        begin = source.uniform(-60.0, 20.0)
        rig = make_rig(
            compiled=bool(number % 2),
            simulation_ideal=source.randrange(2),
            encoder_reference_mode=source.choice((1, 2, 3, 4, 5, 6, 7)),
            encoder_sub_mask=0xFFFF,
            homing_velocity_towards_cam=source.uniform(1.0, 100.0),
            homing_velocity_off_cam=source.uniform(1.0, 50.0),
            encoder_homing_cam_search_inverse=source.randrange(2),
            encoder_sync_pulse_search_inverse=source.randrange(2),
            simulation_cam_begin=begin,
            simulation_cam_end=begin + source.uniform(1.0, 40.0),
            velocity_override=source.choice((0, 100_000, 1_000_000)),
            **(MARK if source.randrange(2) else {}),
        )
        assert commands.home(rig.axis) == 0
        states = []
        for _ in range(1500):
            rig.run(1)
            states.append(rig.axis.homing_state)
        assert states[0] == TOWARDS
        assert states[1] in (WAIT, LEAVE)
        steps = [s for s, before in zip(states, [-1, *states], strict=False) if s != before]
        assert [order.index(s) for s in steps] == sorted({order.index(s) for s in steps})


def test_homing_velocities_are_those_of_the_axis(make: Any) -> None:
    rig = make(homing_velocity_towards_cam=100.0, homing_velocity_off_cam=5.0)
    commands.home(rig.axis)
    rows = walk(rig)
    assert min(row[2] for row in rows) == pytest.approx(-100.0)
    assert max(row[2] for row in rows) == pytest.approx(5.0)


def test_the_override_applies(make: Any) -> None:
    rig = make()
    commands.home(rig.axis)
    rig.seconds(0.5)
    rig.axis.velocity_override = 500_000
    rig.seconds(0.5)
    assert rig.axis.set_velocity == pytest.approx(-15.0)
    rig.axis.velocity_override = 0
    rig.seconds(1.0)
    assert rig.axis.set_velocity == 0.0
    assert rig.axis.homing_state == WAIT
    rig.axis.velocity_override = 1_000_000
    walk(rig)
    assert rig.axis.homed == 1


def drive_cam(rig: Any, press: Any, release: Any, at: float = -20.0) -> None:
    """Home while somebody closes the cam below `at` and opens it above."""
    commands.home(rig.axis)
    for _ in range(5000):
        (press if rig.axis.actual_position < at else release)(rig.axis)
        rig.run(1)
        if rig.axis.homing_state == 0:
            return
    raise AssertionError("homing did not end")


def test_the_cam_of_the_plc(make: Any) -> None:
    rig = make(**NO_CAM)
    drive_cam(
        rig,
        lambda axis: setattr(axis, "control_dword", 7 | CAM_BIT),
        lambda axis: setattr(axis, "control_dword", 7),
    )
    assert rig.axis.homed == 1
    assert rig.axis.encoder.set_position_offset == pytest.approx(120.0, abs=3 * STEP)


@pytest.mark.parametrize(("source", "closed", "opened"), [(3, 0b100, 0), (11, 0b011, 0b111)])
def test_the_cam_at_an_input_of_the_drive(make: Any, source: int, closed: int, opened: int) -> None:
    rig = make(encoder_homing_sensor_source=source, simulation_drive_inputs=opened, control_dword=7)
    drive_cam(
        rig,
        lambda axis: setattr(axis, "simulation_drive_inputs", closed),
        lambda axis: setattr(axis, "simulation_drive_inputs", opened),
    )
    assert rig.axis.encoder.set_position_offset == pytest.approx(120.0, abs=3 * STEP)


def test_the_simulated_cam_wired_to_an_input(make: Any) -> None:
    rig = make(simulation_cam_input=8, encoder_homing_sensor_source=8)
    commands.home(rig.axis)
    walk(rig)
    assert rig.axis.homing.latch_position == pytest.approx(-50.0, abs=2 * STEP)


@pytest.mark.parametrize(
    ("values", "step", "error"),
    [
        (
            {**NO_CAM, "encoder_soft_limit_min_enable": 1, "encoder_soft_limit_min": -20.0},
            WAIT,
            NcError.HOMING_CAM_NOT_FOUND,
        ),
        (
            {
                "simulation_cam_end": 1e6, "encoder_soft_limit_max_enable": 1,
                "encoder_soft_limit_max": 20.0,
            },
            OFF,
            NcError.HOMING_CAM_STAYS,
        ),
        (
            {
                "encoder_reference_mode": 3, "encoder_soft_limit_max_enable": 1,
                "encoder_soft_limit_max": 20.0,
            },
            LATCH,
            NcError.HOMING_SYNC_PULSE_NOT_FOUND,
        ),
    ],
)  # fmt: skip
def test_what_is_not_found_before_a_soft_limit(
    make: Any, values: Any, step: int, error: NcError
) -> None:
    rig = make(**values)
    commands.home(rig.axis)
    seen = 0
    while not rig.axis.error_code:
        seen = rig.axis.homing_state
        rig.run(1)
    assert seen == step
    assert failed(rig.axis, error)
    assert abs(rig.axis.set_position) == pytest.approx(20.0, abs=2 * STEP)
    rig.until_rest()
    assert not rig.has(StateBit.HOMING_BUSY)


def test_a_cam_that_opens_while_the_axis_brakes(make: Any) -> None:
    rig = make(**NO_CAM)
    axis = rig.axis
    commands.home(axis)
    rig.seconds(0.5)
    axis.control_dword = 7 | CAM_BIT
    rig.run(3)
    axis.control_dword = 7
    rig.until(lambda axis: axis.error_code)
    assert failed(axis, NcError.HOMING_CAM_LEFT_EARLY)
    assert axis.set_velocity == 0.0


@pytest.mark.parametrize(
    ("control", "error"),
    [(0, NcError.CONTROLLER_ENABLE_MISSING), (3, NcError.FEED_ENABLE_MINUS_WITHDRAWN)],
)
def test_enables_withdrawn(make: Any, control: int, error: NcError) -> None:
    rig = make()
    commands.home(rig.axis)
    rig.seconds(0.5)
    v = rig.axis.set_velocity
    rig.axis.control_dword = control
    rig.run(1)
    assert failed(rig.axis, error)
    assert rig.axis.set_velocity == pytest.approx(v, abs=JERK * CYCLE**2)
    rig.until_rest()
    rig.axis.control_dword = 7
    commands.reset(rig.axis)
    rig.run(2)
    commands.home(rig.axis)
    walk(rig)
    assert rig.axis.homed == 1


def test_a_stop_ends_homing(make: Any) -> None:
    rig = make()
    commands.home(rig.axis)
    rig.seconds(0.5)
    commands.stop(rig.axis)
    assert rig.axis.homing_state == 0
    assert rig.until_rest() * CYCLE == pytest.approx(RAMP, abs=2 * CYCLE)
    assert rig.axis.error_code == rig.axis.homed == 0


def test_a_start_takes_over_and_the_buffer_is_closed(make: Any) -> None:
    rig = make()
    commands.home(rig.axis)
    rig.seconds(0.5)
    code = commands.universal_start(rig.axis, 1, 5.0, 50.0, buffer_mode=1)
    assert NcError.of(code) is NcError.GROUP_BUSY
    assert rig.axis.homing_state == WAIT
    assert commands.universal_start(rig.axis, 1, 5.0, 50.0) == 0
    assert rig.axis.homing_state == 0
    rig.until_rest()
    assert rig.axis.set_position == 5.0
    assert rig.axis.homed == 0


@pytest.mark.parametrize(
    "values",
    [
        {"axis_type": 2, "drive_type": 7, "brake_delay_negative": 0.2, "brake_delay_positive": 0.2},
        {"drive_type": 8, "stepper_step_scaling": 0.1},
    ],
    ids=["two speeds", "stepper"],
)
@pytest.mark.parametrize("mode", [1, 2])
def test_discrete_drives_home_too(make: Any, values: Any, mode: int) -> None:
    """At creep speed, 220 mm/s, a cycle is 0.44 mm; the step of the motor is 0.1 mm."""
    rig = make(**values, encoder_reference_mode=mode)
    axis = rig.axis
    assert commands.home(axis) == 0
    states = [row[0] for row in walk(rig, 60.0)]
    assert [s for s in (WAIT, LEAVE, OFF, SET) if s in states] == [WAIT, LEAVE, OFF, SET]
    assert axis.homed == 1
    assert axis.error_code == 0
    place = (100.0 - axis.encoder.set_position_offset) - axis.encoder.position_offset
    if mode == 1:
        assert place == pytest.approx(-50.0, abs=1.0)
    else:
        assert place % 6.5536 == pytest.approx(0.0, abs=1e-6) or place % 6.5536 > 6.5535
    rig.seconds(1.0)
    stood = axis.actual_position
    assert commands.start(axis, 2, 50.0, 30.0) == 0
    rig.until_rest()
    assert axis.actual_position == pytest.approx(stood + 50.0, abs=5.0)


@pytest.mark.usefixtures("checked_kernels")
def test_whatever_happens_the_set_point_keeps_its_limits(
    make_rig: Any, many: Callable[[int], int]
) -> None:
    """Overrides, cams that come and go, enables, stops, resets: never a step."""
    for seed in range(many(4)):
        _disturb(make_rig, seed)


def _disturb(make_rig: Any, seed: int) -> None:
    dice = random.Random(seed)
    rig = make_rig(compiled=True, encoder_reference_mode=dice.randrange(1, 8), **MARK)
    axis = rig.axis
    for _ in range(300):
        match dice.randrange(8):
            case 0:
                axis.velocity_override = dice.choice([0, 1_000, 300_000, 1_000_000])
            case 1:
                axis.control_dword = dice.choice([7, 7, 7, 7 | CAM_BIT, 3, 0])
            case 2:
                commands.stop(axis)
            case 3:
                axis.simulation_cam_end = dice.uniform(-60.0, 20.0)
            case _:
                axis.control_dword |= 7
                if axis.error_code and axis.set_motion_phase == MotionPhase.NONE:
                    commands.reset(axis)
                commands.home(axis)
        for _ in range(dice.randrange(1, 200)):
            p, v, a = axis.set_position, axis.set_velocity, axis.set_acceleration
            origin, closed = axis.encoder.set_position_offset, axis.loop_closed
            rig.run(1)
            assert abs(axis.set_velocity) <= V + 1e-6
            if closed and axis.loop_closed:
                renamed = axis.encoder.set_position_offset - origin
                way = axis.set_position - p - renamed
                assert abs(way - 0.5 * (v + axis.set_velocity) * CYCLE) <= 1e-4
                assert abs(axis.set_acceleration - a) <= JERK * CYCLE + 1e-6
    axis.control_dword, axis.velocity_override = 7, 1_000_000
    axis.simulation_cam_end = -50.0
    commands.stop(axis)
    rig.until_rest()
    commands.reset(axis)
    rig.run(2)
    assert commands.home(axis) == 0
    rig.until(lambda axis: axis.homing_state == 0, 600.0)
    assert axis.homed == 1
