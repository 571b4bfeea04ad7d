"""Groups of one axis: an emergency stop, and how it goes on."""

from typing import Any

from achse.motion import commands
from achse.motion.groups.ptp import PtpGroup
from achse.motion.groups.states import GroupType, SafState


def test_it_says_what_its_axis_is(make_groups: Any) -> None:
    rig = make_groups()
    group = PtpGroup(rig.axis(2))
    assert (group.group_id, group.name, group.type) == (2, "Axis 2", GroupType.PTP)
    assert group.channel.channel_id == 4
    assert group.index_in_channel == 2
    assert group.saf_state is SafState.READY
    rig.axis(2).axis_type = 5
    assert group.type is GroupType.ENCODER


def test_endless_moves_go_on(make_groups: Any) -> None:
    rig = make_groups()
    group = PtpGroup(rig.axis(1))
    commands.universal_start(rig.axis(1), 4, 0.0, 50.0)
    rig.run(200)
    assert group.emergency_stop(5000.0, 50000.0) == 0
    rig.until(lambda: rig.axis(1).set_velocity == 0.0)
    assert group.saf_state is SafState.READY
    assert group.step_on() == 0
    rig.run(300)
    assert rig.axis(1).set_velocity == -50.0


def test_a_stop_forgets_what_was_interrupted(make_groups: Any) -> None:
    rig = make_groups()
    group = PtpGroup(rig.axis(1))
    for forget in (group.stop, group.clear, group.reset):
        commands.start(rig.axis(1), 1, rig.axis(1).set_position + 100.0, 50.0)
        rig.run(100)
        assert group.emergency_stop(5000.0, 50000.0) == 0
        rig.until(lambda: rig.axis(1).set_velocity == 0.0)
        assert forget() == 0
        assert group.emergency_stop_active == 0
        rest = rig.axis(1).set_position
        assert group.step_on() == 0
        rig.run(20)
        assert rig.axis(1).set_position == rest
