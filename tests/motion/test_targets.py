"""Targets of starts, and the velocity at borders that the commands behind them allow."""

from math import sqrt
from typing import Any

import pytest

from achse.motion import BufferMode, commands
from achse.motion.targets import look_ahead, modulo_part

V, A, J = 200.0, 1500.0, 2250.0


def test_modulo_part_stays_below_the_period() -> None:
    assert modulo_part(-1e-17, 360.0) == 0.0
    assert modulo_part(360.0, 360.0) == 0.0
    assert modulo_part(-90.0, 360.0) == 270.0


def stopping_way(velocity: float) -> float:
    """Half the velocity for the time of its ramp, here always one without constant deceleration."""
    assert velocity * J <= A * A
    return velocity * sqrt(velocity / J)


def queue(rig: Any, *moves: tuple[float, float], mode: BufferMode) -> None:
    for target, velocity in moves:
        code = commands.universal_start(rig.axis, 1, target, velocity, buffer_mode=mode)
        assert code == 0, hex(code)


@pytest.mark.parametrize(
    ("mode", "border"),
    [
        (BufferMode.BUFFERED, 0.0),
        (BufferMode.BLENDING_LOW, 80.0),
        (BufferMode.BLENDING_PREVIOUS, 80.0),
        (BufferMode.BLENDING_NEXT, 150.0),
        (BufferMode.BLENDING_HIGH, 150.0),
    ],
)
def test_the_mode_names_the_velocity_of_the_border(
    rig: Any, mode: BufferMode, border: float
) -> None:
    queue(rig, (300.0, 80.0), (600.0, 150.0), mode=mode)
    look_ahead(rig.axis)
    assert rig.axis.border_position == 300.0
    assert rig.axis.border_velocity == border


def test_a_border_is_passed_no_faster_than_the_way_behind_it_allows(rig: Any) -> None:
    slow = 50.0
    queue(rig, (300.0, V), (300.0 + stopping_way(slow), V), mode=BufferMode.BLENDING_HIGH)
    look_ahead(rig.axis)
    assert rig.axis.border_velocity == pytest.approx(slow)


def test_further_commands_lengthen_the_way_to_brake(rig: Any) -> None:
    way = stopping_way(150.0)
    ends = [300.0 + share * way for share in (0.0, 0.1, 0.2, 0.3, 0.4, 0.6, 0.7, 0.9, 1.0)]
    queue(rig, *((end, V) for end in ends), mode=BufferMode.BLENDING_PREVIOUS)
    look_ahead(rig.axis)
    several = rig.axis.border_velocity
    # Each border has to be passed without acceleration: slower than one ramp over the whole way,
    # faster than the first stretch alone would allow.
    assert stopping_way(several) < way
    assert stopping_way(several) > 3.0 * 0.1 * way


def test_an_endless_command_behind_allows_any_velocity(rig: Any) -> None:
    queue(rig, (300.0, V), mode=BufferMode.BUFFERED)
    commands.universal_start(rig.axis, 3, 0.0, 150.0, buffer_mode=BufferMode.BLENDING_NEXT)
    look_ahead(rig.axis)
    assert rig.axis.border_velocity == 150.0


def test_a_new_target_beyond_the_next_one_ends_the_blending(rig: Any) -> None:
    queue(rig, (300.0, V), (600.0, V), mode=BufferMode.BLENDING_HIGH)
    assert commands.new_end_position(rig.axis, 1, 700.0) == 0
    look_ahead(rig.axis)
    assert rig.axis.border_velocity == 0.0
    assert rig.axis.border_position == 700.0
    assert commands.new_end_position(rig.axis, 1, 200.0) == 0
    look_ahead(rig.axis)
    assert rig.axis.border_velocity == V


def test_segment_velocities_stand_above_the_mode(rig: Any) -> None:
    axis = rig.axis
    assert commands.universal_start(axis, 1, 300.0, V, segment_end_velocity=60.0) == 0
    look_ahead(axis)
    assert axis.border_velocity == 60.0
    queue(rig, (600.0, V), mode=BufferMode.BUFFERED)
    look_ahead(axis)
    assert axis.border_velocity == 60.0
    axis.buffer_count = 0
    code = commands.universal_start(
        axis, 1, 600.0, V, buffer_mode=BufferMode.BLENDING_HIGH, segment_start_velocity=90.0
    )
    assert code == 0
    look_ahead(axis)
    assert axis.border_velocity == 90.0


def test_the_blending_position_is_the_border(rig: Any) -> None:
    queue(rig, (300.0, V), mode=BufferMode.BUFFERED)
    code = commands.universal_start(
        rig.axis, 1, 600.0, V, buffer_mode=BufferMode.BLENDING_NEXT, blending_position=250.0
    )
    assert code == 0
    look_ahead(rig.axis)
    assert (rig.axis.border_position, rig.axis.target_position) == (250.0, 300.0)
