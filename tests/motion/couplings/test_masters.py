"""What followers see of a master."""

from typing import Any

import pytest

from achse.motion import commands
from achse.motion.couplings.masters import end_coupling
from achse.motion.record import AXIS_PARTS
from achse.motion.states import SlaveType
from achse.native.declare import pack


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


@pytest.mark.parametrize("compiled", [False, True], ids=["plain", "compiled"])
@pytest.mark.parametrize("by_error", [False, True], ids=["uncoupled", "error"])
def test_end_of_a_coupling_leaves_fresh_parts(
    make_rig: Any, compiled: bool, by_error: bool
) -> None:
    rig = make_rig(count=4, compiled=compiled)
    slave = rig.axis
    slave.gear_ratio_1 = 0.5
    kind = SlaveType.MULTI_MASTER
    assert commands.couple_to_several(slave, kind, (2, 3, 4), 100.0, 200.0, 1e3, 50.0) == 0
    rig.run(5)
    assert slave.coupling.master_count == 3
    if by_error:
        slave.external_error = 0x4550
        rig.run(2)
    else:
        slave.release()
    for name in ("coupling", "camming"):
        layout = AXIS_PARTS[name]
        assert pack(layout, getattr(slave, name)) == pack(layout, layout.plain())
    assert [axis.followers for axis in rig.nc] == [0, 0, 0, 0]


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
