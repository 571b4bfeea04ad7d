"""All groups of an NC, by id."""

import pytest

from achse.motion import AxisParameters, Nc
from achse.motion.groups.parameters import (
    GroupParameters,
    GroupParametersError,
    KinematicsParameters,
)
from achse.motion.groups.states import GroupType
from achse.motion.groups.table import Groups


@pytest.mark.parametrize(
    ("group", "message"),
    [
        (GroupParameters(1, GroupType.FIFO, 2), "PTP group"),
        (GroupParameters(9, GroupType.TABLE, 2), "type"),
        (GroupParameters(9, GroupType.FIFO, 2, axes=[7]), "0x4012"),
        (
            GroupParameters(9, GroupType.KINEMATIC, 2, kinematics=KinematicsParameters("arm")),
            "expected identity",
        ),
    ],
)
def test_what_cannot_be(group: GroupParameters, message: str) -> None:
    axes = {axis.axis_id: axis for axis in Nc(1_000_000, [AxisParameters(1)], compiled=False)}
    with pytest.raises(GroupParametersError, match=message):
        Groups([group], axes, 0.001)


def test_an_id_twice() -> None:
    group = GroupParameters(9, GroupType.FIFO, 2)
    with pytest.raises(GroupParametersError, match="twice"):
        Groups([group, group], {}, 0.001)
