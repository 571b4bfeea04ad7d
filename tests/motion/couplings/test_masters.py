"""What followers see of a master."""

from typing import Any

import pytest

from achse.motion import commands
from achse.motion.couplings.masters import end_coupling


@pytest.fixture
def rig(make_rig: Any) -> Any:
    return make_rig(count=3)


def states(rig: Any) -> list[int]:
    return [axis.coupling_state for axis in rig.nc]


def test_coupling_states(rig: Any) -> None:
    _first, second, third = rig.nc
    commands.couple(second, 1, 1, 0, 0, 1.0)
    assert states(rig) == [1, 3, 0]
    commands.couple(third, 1, 2, 0, 0, 1.0)
    assert states(rig) == [1, 2, 3]
    end_coupling(second, second.rows)
    assert states(rig) == [0, 1, 3]


def test_actual_values_lead_an_axis_that_is_not_ready(make_rig: Any) -> None:
    rig = make_rig(count=2, couple_slaves_by_actual_values=1)
    master, slave = rig.nc
    commands.couple(slave, 1, 1, 0, 0, 2.0)
    master.control_dword = 0
    rig.run(5)
    master.machine.position += 5.0
    master.wake()
    rig.run(5)
    assert slave.set_position == pytest.approx(2.0 * master.actual_position) == 10.0


def test_an_encoder_axis_leads_by_its_actual_values(make_rig: Any) -> None:
    rig = make_rig(count=2)
    master, slave = rig.nc
    master.axis_type = 5
    assert commands.couple(slave, 1, 1, 0, 0, 2.0) == 0
    master.machine.position += 0.5
    master.wake()
    rig.run(50)
    assert slave.set_position == pytest.approx(2.0 * master.actual_position, abs=1e-9)
    assert slave.set_position != 0.0
