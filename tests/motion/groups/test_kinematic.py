"""Kinematic groups: what follows is where the law wants it, one cycle later."""

import random
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import commands
from achse.motion.groups.kinematics.table import KINEMATICS


def eight(*values: float) -> list[Any]:
    return [*values, *(0,) * (8 - len(values))]


@pytest.mark.parametrize("compiled", [False, True])
def test_axes_are_where_the_tool_was(make_groups: Any, compiled: bool) -> None:
    rig = make_groups(compiled=compiled)
    group = rig.kinematic
    assert group.assign_both(eight(1, 2), eight(3, 4)) == 0
    assert group.mcs_ids[:2] == [1, 2]
    assert group.acs_ids[:2] == [3, 4]
    commands.start(rig.axis(1), 1, 350.0, 120.0)
    commands.start(rig.axis(2), 1, 200.0, 150.0)
    before = [rig.axis(1).set_position, rig.axis(2).set_position]
    for _ in range(1500):
        rig.run()
        places = [0.0] * 8
        axes = eight(rig.axis(3).set_position, rig.axis(4).set_position)
        group.law.forward(group.numbers, axes, places)
        assert places[:2] == pytest.approx(before, abs=2e-3)
        before = [rig.axis(1).set_position, rig.axis(2).set_position]
    assert before == [350.0, 200.0]
    assert not group.moving
    assert group.dissolve() == 0
    assert not rig.axis(3).grouped


@pytest.mark.parametrize("law", KINEMATICS)
def test_every_law_can_be_assigned_and_followed(make_groups: Any, law: str) -> None:
    """Axes lead, places follow; then the other way round, which brings the axes back."""
    rig = make_groups(law)
    group = rig.kinematic
    source = random.Random(law)
    start = {"parallel": (120.0, 60.0), "delta": (20.0, 20.0)}.get(law, (10.0, 10.0))
    commands.set_actual_position(rig.axis(3), 1, start[0])
    commands.set_actual_position(rig.axis(4), 1, start[1])
    rig.run(2)
    assert group.assign_both(eight(1, 2), eight(3, 4), by_axes=True) == 0
    goal = [begin + source.uniform(3.0, 9.0) for begin in start]
    for axis, position in zip((3, 4), goal, strict=True):
        assert commands.start(rig.axis(axis), 1, position, 20.0) == 0
    rig.until(lambda: [rig.axis(n).set_position for n in (3, 4)] == goal)
    rig.run(3)
    places = group.forward(eight(*goal))
    assert [rig.axis(n).set_position for n in (1, 2)] == pytest.approx(places[:2])
    assert not group.error_code


def test_why_it_is_not_assigned(make_groups: Any) -> None:
    rig = make_groups()
    group = rig.kinematic
    assert group.assign([1, 2]) == group.assign_one(1, 0) == NcError.GROUP_PARAMETER
    assert group.assign_both(eight(1, 1), eight(3, 4)) == NcError.GROUP_PARAMETER
    rig.fifo.assign([3, 4])
    assert group.assign_both(eight(1, 2), eight(3, 4)) == NcError.MASTER_NOT_INSERTED
    rig.fifo.dissolve()
    commands.start(rig.axis(1), 1, 30.0, 20.0)
    assert group.assign_both(eight(1, 2), eight(3, 4)) == NcError.GROUP_BUSY
    assert group.ids == [0] * 8


def test_axes_without_enable_stop_the_tool(make_groups: Any) -> None:
    rig = make_groups()
    assert rig.kinematic.assign_both(eight(1, 2), eight(3, 4)) == 0
    rig.axis(4).control_dword = 0
    rig.run(3)
    commands.start(rig.axis(1), 1, 400.0, 100.0)
    rig.run(3)
    assert rig.kinematic.error_code == NcError.CONTROLLER_ENABLE_MISSING
    rig.until(lambda: rig.axis(1).set_velocity == 0.0)
    rig.axis(4).control_dword = 7
    rig.run(3)
    rig.kinematic.reset()
    places = rig.kinematic.forward(eight(rig.axis(3).set_position, rig.axis(4).set_position))
    assert [rig.axis(n).set_position for n in (1, 2)] == pytest.approx(places[:2], abs=1e-3)
    commands.start(rig.axis(1), 1, 400.0, 100.0)
    rig.until(lambda: rig.axis(1).set_position == 400.0)
    assert not rig.kinematic.error_code


def test_a_stop_of_the_group_stops_the_tool(make_groups: Any) -> None:
    rig = make_groups()
    rig.kinematic.assign_both(eight(1, 2), eight(3, 4))
    commands.start(rig.axis(1), 1, 400.0, 100.0)
    rig.run(50)
    assert rig.kinematic.dissolve() == NcError.GROUP_BUSY
    rig.kinematic.stop()
    rig.until(lambda: not rig.kinematic.moving)
    assert rig.axis(1).set_position > 400.0


@pytest.mark.parametrize("by_axes", [False, True])
def test_axes_that_lead_stand_when_they_are_assigned(make_groups: Any, by_axes: bool) -> None:
    """Else what follows would jump to their velocity."""
    rig = make_groups("identity")
    places, axes = [1, 2, *[0] * 6], [3, 4, *[0] * 6]
    leading = rig.axis(3 if by_axes else 1)
    assert commands.start(leading, 1, 100.0, 50.0) == 0
    rig.run(100)
    assert rig.kinematic.assign_both(places, axes, by_axes=by_axes) == NcError.GROUP_BUSY
    rig.until(lambda: not leading.set_motion_phase)
    assert rig.kinematic.assign_both(places, axes, by_axes=by_axes) == 0
