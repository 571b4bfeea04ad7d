"""Slave type 18: degrees of a drum whose radius is measured."""

from math import degrees
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import Nc, commands


def drum(make_axes: Any, *, compiled: bool = False) -> Nc:
    """A master, and a slave whose second encoder says that its drum has a radius of 50 mm."""
    nc: Nc = make_axes(2, second_encoders=(2,), compiled=compiled)
    gauge = nc.axis(2).encoders[1]
    gauge.scaling_factor, gauge.position_offset = 1e-12, 50.0
    nc.cycle(3)
    assert gauge.actual_position == pytest.approx(50.0)
    return nc


@pytest.mark.parametrize("compiled", [False, True])
def test_worked_numbers(make_axes: Any, compiled: bool) -> None:
    """r = 50, g = 1, vM = 100: 114.591559026 °/s."""
    nc = drum(make_axes, compiled=compiled)
    master, slave = nc
    slave.operation_mode_value = 1.0
    assert commands.couple(slave, 18, 1, 0, 0, 1e6) == 0
    commands.universal_start(master, 3, 0.0, 100.0)
    nc.cycle(500)
    assert master.set_velocity == 100.0
    assert slave.set_velocity == pytest.approx(114.591559026)
    slave.encoders[1].position_offset = 25.0
    nc.cycle(2)
    begin, at = slave.set_position, master.set_position
    nc.cycle(500)
    assert slave.set_velocity == pytest.approx(2 * 114.591559026)
    assert slave.set_position - begin == pytest.approx(2 * degrees((master.set_position - at) / 50))


def test_a_radius_of_0_stops_it(make_axes: Any) -> None:
    nc = drum(make_axes)
    master, slave = nc
    slave.operation_mode_value = 1.0
    commands.couple(slave, 18, 1, 0, 0, 10.0)
    commands.universal_start(master, 3, 0.0, 100.0)
    nc.cycle(500)
    gauge = slave.encoders[1]
    gauge.evaluation_direction = 3  # blocked
    gauge.software_increments = 0
    nc.cycle(5)
    gauge.position_offset = 0.0
    before = slave.set_position
    for _ in range(500):
        nc.cycle()
        assert 0.0 <= slave.set_position - before < 0.25
        before = slave.set_position
    assert slave.error_code == NcError.SLAVE_COUPLING_PARAMETER
    assert (slave.coupling_state, slave.set_velocity) == (0, 0.0)


def test_without_a_radius(make_axes: Any) -> None:
    nc = make_axes(2, second_encoders=(2,))
    master, slave = nc
    refused = NcError.SLAVE_COUPLING_PARAMETER
    assert slave.encoders[1].actual_position == 0.0
    assert commands.couple(slave, 18, 1, 0, 0, 1.0) == refused
    assert commands.couple(master, 18, 2, 0, 0, 1.0) == refused
