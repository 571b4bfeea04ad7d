"""What of an axis outlives a restart; the NC hands it on by id, see there."""

import pytest

from achse.motion import AxisParameters, Nc
from achse.motion.retained import RetainedState


def nc(persistent: int) -> Nc:
    values = {"persistent_data_enable": persistent}
    second = {"encoder_scaling_factor": 1e-3, "encoder_count_direction": 1}
    axis = AxisParameters(1, values=values, encoder_ids=(1, 2), elements=[second])
    return Nc(2_000_000, [axis], compiled=False)


@pytest.mark.parametrize("persistent", [0, 1])
def test_the_machine_stands_where_it_stood_and_the_axis_knows_it_or_not(persistent: int) -> None:
    axis = nc(persistent).axis(1)
    RetainedState([500.0, -50.0], 12.5, 1).restore(axis)
    assert axis.machine.position == pytest.approx(-0.05)
    assert [encoder.sensor.zero for encoder in axis.encoders] == pytest.approx([500.0, -50.0])
    assert (axis.actual_position, axis.set_position) == (12.5 * persistent,) * 2
    assert axis.homed == persistent


def test_remains_of_remains_are_the_same() -> None:
    axis = nc(1).axis(1)
    left = RetainedState([500.0, -50.0], 12.5, 1)
    left.restore(axis)
    again = RetainedState.of(axis)
    assert again.zeros == pytest.approx(left.zeros)
    assert (again.position, again.homed) == (left.position, left.homed)


@pytest.mark.parametrize("position", [12.5, -3.0])
def test_axis_that_knew_a_position_knows_the_kept_one(position: float) -> None:
    axis = nc(1).axis(1)
    for left in (RetainedState([500.0, -50.0], 4.0, 1), RetainedState([300.0, -30.0], position, 0)):
        left.restore(axis)
    assert (axis.actual_position, axis.set_position) == (position, position)
    assert (axis.machine.position, axis.homed) == (pytest.approx(-0.03), 0)


def test_axis_without_kept_encoders_leaves_its_machine_where_it_is() -> None:
    axis = nc(1).axis(1)
    RetainedState([500.0], 1.0, 0).restore(axis)
    RetainedState([], 2.0, 1).restore(axis)
    assert axis.machine.position == pytest.approx(-0.05)
    assert (axis.actual_position, axis.homed) == (2.0, 1)


def test_fewer_encoders_than_there_were() -> None:
    axis = nc(1).axis(1)
    RetainedState([500.0], 1.0, 0).restore(axis)
    assert axis.machine.position == pytest.approx(-0.05)
    assert [encoder.sensor.zero for encoder in axis.encoders] == pytest.approx([500.0, -50.0])
