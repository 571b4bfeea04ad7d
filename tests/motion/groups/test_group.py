"""What all groups share: who is at a place, when a motion ends."""

from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import commands
from achse.motion.groups.states import SafState


def test_assignment_is_all_or_nothing(make_groups: Any) -> None:
    rig = make_groups()
    commands.start(rig.axis(3), 1, 100.0, 10.0)
    assert rig.path.assign([1, 2, 3]) == NcError.GROUP_BUSY
    assert rig.path.ids == [0] * 8
    assert not rig.axis(1).grouped
    assert rig.path.assign([1, 2]) == 0
    assert rig.path.assign([2, 1]) == 0
    assert rig.path.ids[:2] == [2, 1]
    assert rig.path.assign([4]) == 0
    assert [rig.axis(n).grouped for n in (1, 2, 3, 4)] == [0, 0, 0, 1]
    assert rig.axis(4).group is rig.path
    assert rig.path.assign(range(9)) == NcError.GROUP_MASTER_INDEX


def test_a_member_takes_no_motion_of_its_own(make_groups: Any) -> None:
    rig = make_groups()
    rig.path.assign([1])
    axis, refused = rig.axis(1), NcError.FUNCTION_NOT_ALLOWED
    assert commands.start(axis, 1, 10.0, 10.0) == refused
    assert commands.home(axis) == refused
    assert commands.couple(axis, 1, 2, 0, 0, 1.0, 0.0, 0.0, 0.0) == refused
    assert commands.start_external_setpoint(axis, 1, 0.0) == refused
    assert commands.universal_start(axis, 3, 0.0, 10.0) == refused
    assert commands.set_actual_position(axis, 1, 5.0) == 0
    assert commands.set_homed_flag(axis, 1) == 0


def test_states_of_a_group_at_rest(make_groups: Any) -> None:
    rig = make_groups()
    assert rig.fifo.saf_state is SafState.IDLE
    rig.fifo.assign([1, 2])
    assert rig.fifo.saf_state is SafState.READY
    rig.axis(1).control_dword = 0
    rig.run()
    assert rig.fifo.saf_state is SafState.IDLE
    assert rig.fifo.motion_state == 0


@pytest.mark.parametrize("how", ["error", "stop", "enable"])
def test_an_axis_that_drops_out_ends_the_motion(make_groups: Any, how: str) -> None:
    rig = make_groups()
    rig.fifo.assign([1, 2])
    rig.fifo.write([0.1 * n for n in range(100) for _ in range(2)])
    rig.fifo.start()
    rig.run(20)
    if how == "error":
        commands.set_external_error(rig.axis(1), 0x4650)
    elif how == "stop":
        commands.stop(rig.axis(1))
    else:
        rig.axis(1).control_dword = 0
    rig.until(lambda: not rig.fifo.moving)
    rig.until(lambda: not any(axis.set_velocity for axis in rig.nc))
    assert bool(rig.fifo.error_code) == (how != "stop")
    assert rig.axis(2).set_motion_phase == 0
