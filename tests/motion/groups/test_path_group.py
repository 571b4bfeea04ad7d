"""3D groups: their places, and the parts of a cycle."""

import random
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import AxisParameters, Nc
from achse.motion.channels.parameters import ChannelParameters
from achse.motion.groups.parameters import GroupParameters
from achse.motion.groups.path_group import PathGroup
from achse.motion.groups.states import GroupType
from achse.motion.path import PathLine


def test_auxiliary_axes_need_a_main_axis(make_groups: Any) -> None:
    rig = make_groups()
    assert rig.path.assign([0, 0, 0, 1]) == NcError.AUXILIARY_AXIS_COUNT
    assert rig.path.assign([0, 2, 0, 1]) == 0
    assert rig.path.remove(rig.axis(2)) == NcError.AUXILIARY_AXIS_COUNT
    assert rig.path.dissolve() == 0


CYCLE_NS = 2_000_000
READY = {"control_dword": 7, "velocity_override": 1_000_000}


def path_of(cycle_ns: int) -> tuple[Nc, PathGroup]:
    nc = Nc(
        cycle_ns,
        [AxisParameters(n, values=READY) for n in (1, 2, 3)],
        groups=[GroupParameters(11, GroupType.THREE_D, 1)],
        channels=[ChannelParameters(1)],
    )
    group = nc.groups.group(11)
    assert isinstance(group, PathGroup)
    nc.cycle(3)
    assert group.assign([1, 2, 3]) == 0
    return nc, group


@pytest.mark.parametrize("seed", range(6))
def test_a_divisor_gives_the_set_points_of_a_shorter_cycle(seed: int) -> None:
    """Every n-th set point of a path in an n-th of the cycle, to the bit; from a start on."""
    dice = random.Random(f"divisor {seed}")
    parts = dice.choice((2, 4, 5, 8, 16, 32))
    (whole, divided), (fine, plain) = path_of(CYCLE_NS), path_of(CYCLE_NS // parts)
    divided.saf_divisor = parts
    lines = [
        PathLine(tuple(dice.uniform(-20.0, 20.0) for _ in range(3)), dice.uniform(5.0, 300.0))
        for _ in range(dice.randint(1, 6))
    ]
    for group in (divided, plain):
        assert group.begin() == 0
        for line in lines:
            assert group.append(line) == 0
    divided.saf_divisor = 1  # counts from the next start on
    moved = set()
    for _ in range(400):
        whole.cycle()
        fine.cycle(parts)
        assert divided.planner is not None
        assert plain.planner is not None
        assert divided.planner.position == plain.planner.position
        assert divided.planner.axis_velocity == plain.planner.axis_velocity
        moved.add(divided.planner.position)
    assert len(moved) > 50
    assert divided.begin() in (0, NcError.GROUP_BUSY)


def test_a_divisor_ends_with_its_run(make_groups: Any) -> None:
    path = make_groups().path
    assert path.assign([1, 2, 3]) == 0
    path.saf_divisor = 4
    assert path.begin() == 0
    assert path.planner.state.cycle_time == 0.0005
    path.end()
    path.saf_divisor = 1
    assert path.begin() == 0
    assert path.planner.state.cycle_time == 0.002
