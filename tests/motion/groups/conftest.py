"""An NC with four enabled axes and one group of each kind."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.motion import Axis, AxisParameters, Nc
from achse.motion.channels.parameters import ChannelParameters
from achse.motion.groups.fifo import FifoGroup
from achse.motion.groups.kinematic import KinematicGroup
from achse.motion.groups.parameters import GroupParameters, KinematicsParameters
from achse.motion.groups.path_group import PathGroup
from achse.motion.groups.states import ChannelType, GroupType

CYCLE_NS = 2_000_000
ENABLED = {"control_dword": 7, "velocity_override": 1_000_000}


class GroupRig:
    """3D group 11, FIFO 12 of two axes, kinematic group 13; `fifo` describes the FIFO."""

    def __init__(
        self, law: str = "scara", *, compiled: bool | None = None, values: Any = None, **fifo: Any
    ) -> None:
        described = {"dimension": 2, "length": 250, "time_delta": 0.002, **fifo}
        self.nc = Nc(
            CYCLE_NS,
            [AxisParameters(n, values=ENABLED | (values or {})) for n in (1, 2, 3, 4)],
            groups=[
                GroupParameters(11, GroupType.THREE_D, 1),
                GroupParameters(12, GroupType.FIFO, 2, **described),
                GroupParameters(13, GroupType.KINEMATIC, 3, kinematics=KinematicsParameters(law)),
            ],
            channels=[
                ChannelParameters(1),
                ChannelParameters(2, type=ChannelType.FIFO),
                ChannelParameters(3, type=ChannelType.KINEMATIC_TRANSFORMATION),
            ],
            compiled=compiled,
        )
        group = self.nc.groups.group
        path, fifo_group, kinematic = group(11), group(12), group(13)
        assert isinstance(path, PathGroup)
        assert isinstance(fifo_group, FifoGroup)
        assert isinstance(kinematic, KinematicGroup)
        self.path, self.fifo, self.kinematic = path, fifo_group, kinematic
        self.dt = CYCLE_NS / 1e9
        self.run(3)

    def run(self, cycles: int = 1) -> None:
        for _ in range(cycles):
            self.nc.cycle()

    def until(self, condition: Callable[[], Any], seconds: float = 20.0) -> None:
        for _ in range(round(seconds / self.dt)):
            if condition():
                return
            self.nc.cycle()
        raise AssertionError(f"not within {seconds} s")

    def axis(self, number: int) -> Axis:
        return self.nc.axis(number)


@pytest.fixture
def make_groups() -> Callable[..., GroupRig]:
    return GroupRig
