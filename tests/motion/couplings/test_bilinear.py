"""Slave type 16: two masters, the first of which has to move."""

from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import commands


@pytest.mark.parametrize("compiled", [False, True])
def test_worked_numbers(make_axes: Any, compiled: bool) -> None:
    """g1 = 2, g2 = -0.5, M1 by 10, M2 by 4: s by 18."""
    nc = make_axes(3, compiled=compiled)
    first, second, slave = nc
    assert commands.couple(slave, 16, 1, 0, 0, 2.0, -0.5, 2.0) == 0
    assert slave.followed == [0, 1]
    commands.start(first, 1, 10.0, 100.0)
    commands.start(second, 1, 4.0, 100.0)
    nc.cycle(2)
    assert slave.set_velocity == 2.0 * first.set_velocity - 0.5 * second.set_velocity
    nc.cycle(2000)
    assert slave.set_position == 18.0


def test_the_first_master_has_to_move(make_axes: Any) -> None:
    nc = make_axes(3)
    first, second, slave = nc
    commands.couple(slave, 16, 1, 0, 0, 1.0, 1.0, 2.0)
    commands.start(second, 1, 50.0, 100.0)
    nc.cycle(100)
    assert (slave.set_position, slave.set_velocity) == (0.0, 0.0)
    assert second.set_velocity > 0.0
    first.velocity_override = 0
    commands.start(first, 1, 5.0, 100.0)
    at = second.set_position
    nc.cycle(100)
    assert first.set_velocity == 0.0
    assert slave.set_velocity == second.set_velocity
    assert slave.set_position == pytest.approx(second.set_position - at)


def test_new_ratios_and_the_same_master(make_axes: Any) -> None:
    nc = make_axes(3)
    first, _second, slave = nc
    commands.couple(slave, 16, 1, 0, 0, 1.0, 1.0, 2.0)
    assert commands.change_coupling(slave, 3.0, 1.0, 1.0, 0.0) == NcError.SLAVE_COUPLING_PARAMETER
    assert commands.change_coupling(slave, 3.0, 1.0, 2.0, 0.0) == 0
    commands.start(first, 1, 10.0, 100.0)
    nc.cycle(2000)
    assert slave.set_position == 30.0


@pytest.mark.parametrize(
    ("parameters", "error"),
    [
        ((0.0, 1.0, 2.0), NcError.GEAR_FACTOR_ZERO),
        ((1.0, 0.0, 2.0), NcError.GEAR_FACTOR_ZERO),
        ((1.0, 1.0, 1.0), NcError.SLAVE_COUPLING_PARAMETER),
        ((1.0, 1.0, 0.0), NcError.ADDRESS_MASTER_AXIS),
        ((1.0, 1.0, 2.5), NcError.ADDRESS_MASTER_AXIS),
        ((1.0, 1.0, 3.0), NcError.MASTER_NOT_INSERTED),
        ((1.0, 1.0, float("nan")), NcError.ADDRESS_MASTER_AXIS),
    ],
)
def test_what_is_refused(make_axes: Any, parameters: Any, error: NcError) -> None:
    nc = make_axes(3)
    assert commands.couple(nc.axis(3), 16, 1, 0, 0, *parameters) == error
    assert nc.axis(3).coupling_state == 0
