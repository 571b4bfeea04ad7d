"""Kinematic groups at and through places where a kinematics has no solution, or two, or any.

The places of the tool are moved at random, within reach, along its edge and beyond. As long as the
group tells no error, the axes are where the law wants them and within their limits; after an error
all is at rest, and the documented way (enable, reset, dissolve, assign) leads on.
"""

import math
from random import Random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import NcError
from achse.codes.nc.choices import MotionPhase
from achse.motion import Axis, AxisParameters, Nc, commands
from achse.motion.channels.parameters import ChannelParameters
from achse.motion.groups.kinematic import KinematicGroup
from achse.motion.groups.kinematics.table import KINEMATICS, KinematicsLaw
from achse.motion.groups.parameters import GroupParameters, KinematicsParameters
from achse.motion.groups.states import ChannelType, GroupType

CYCLE_NS = 2_000_000
DT = CYCLE_NS / 1e9
VELOCITY = 400.0
VALUES = {
    "control_dword": 7,
    "velocity_override": 1_000_000,
    "max_velocity": VELOCITY,
    "max_acceleration": 4000.0,
    "max_deceleration": 4000.0,
    "default_jerk": 40_000.0,
}
ERRORS = {
    *(NcError.NUMBER_RANGE_LEFT, NcError.SET_VELOCITY_TOO_HIGH),
    *(NcError.CONTROLLER_ENABLE_MISSING, NcError.GROUP_CONSEQUENTIAL_ERROR),
    *(NcError.GROUP_BUSY, NcError.GROUP_PARAMETER),
}
AXES = {
    "identity": ((-50.0, 50.0),) * 3,
    "portal": ((-50.0, 50.0),) * 3,
    "scara": ((-170.0, 170.0), (-170.0, 170.0), (-50.0, 50.0)),
    "parallel": ((60.0, 150.0), (30.0, 120.0), (-50.0, 50.0)),
    "delta": ((-20.0, 70.0),) * 3,
}
"""Where the axes begin."""


class Tool:
    """Three places, three axes, one kinematics with drawn numbers."""

    def __init__(self, name: str, draw: Random) -> None:
        self.name, self.draw = name, draw
        numbers = {
            key: value if value in (0.0, 1.0) else value * draw.uniform(0.8, 1.2)
            for key, value in KINEMATICS[name].numbers.items()
        }
        self.nc = Nc(
            CYCLE_NS,
            [AxisParameters(n, values=VALUES) for n in range(1, 7)],
            groups=[
                GroupParameters(
                    13, GroupType.KINEMATIC, 1, kinematics=KinematicsParameters(name, numbers)
                )
            ],
            channels=[ChannelParameters(1, type=ChannelType.KINEMATIC_TRANSFORMATION)],
        )
        group = self.nc.groups.group(13)
        assert isinstance(group, KinematicGroup)
        self.group = group
        self.nc.cycle()

    @property
    def tool(self) -> list[Axis]:
        return [self.nc.axis(n) for n in (1, 2, 3)]

    @property
    def machine(self) -> list[Axis]:
        return [self.nc.axis(n) for n in (4, 5, 6)]

    def assign(self, by_axes: bool = False) -> int:
        return self.group.assign_both([1, 2, 3, *[0] * 5], [4, 5, 6, *[0] * 5], by_axes=by_axes)

    def begin(self) -> None:
        """The machine anywhere where the law has a solution."""
        for _ in range(100):
            for axis, (low, high) in zip(self.machine, AXES[self.name], strict=True):
                position = self.draw.uniform(low, high)
                assert commands.set_actual_position(axis, 1, position) == 0
            self.nc.cycle()
            if self.assign() == 0:
                return
        raise AssertionError("no pose")

    def at(self, axes: list[Axis]) -> list[float]:
        return [axis.set_position for axis in axes]

    def cycle(self) -> None:
        """One cycle; what is promised holds."""
        before, leads = self.at(self.machine), self.at(self.tool)
        self.nc.cycle()
        for axis, was in zip(self.machine, before, strict=True):
            assert math.isfinite(axis.set_position)
            assert abs(axis.set_position - was) <= VELOCITY * DT * 1.001 + 1e-3
        if self.group.moving and not self.group.error_code and not any(self.errors()):
            result = self.group.forward([*self.at(self.machine), *[0.0] * 5])
            assert isinstance(result, list), "the machine has left the law without an error"
            assert result[:3] == pytest.approx(leads, abs=5e-3)

    def errors(self) -> list[int]:
        return [axis.error_code for axis in self.machine]

    def goal(self) -> list[float]:
        """Within reach, at its edge, beyond it, or where the kinematics is singular."""
        draw = self.draw
        kind = draw.randrange(4)
        if kind == 0:
            result = self.group.forward(
                [*(draw.uniform(*limits) for limits in AXES[self.name]), *[0.0] * 5]
            )
            if isinstance(result, list):
                return result[:3]
        if kind == 1:
            return [draw.uniform(-1200.0, 1200.0) for _ in range(3)]
        if kind == 2:
            return [0.0, draw.choice((0.0, 0.0, 1e-9)), draw.uniform(-900.0, 0.0)]
        size = sum(value for value in self.group.numbers if value > 1.0)
        turn = draw.uniform(0.0, 2.0 * math.pi)
        return [size * math.cos(turn), size * math.sin(turn), draw.uniform(-50.0, 50.0)]

    def act(self) -> None:
        draw = self.draw
        kind = draw.randrange(12)
        if kind < 6:
            velocity = draw.uniform(1.0, VELOCITY)
            for axis, position in zip(self.tool, self.goal(), strict=True):
                commands.start(axis, 1, position, velocity)
        elif kind == 6:
            self.group.stop()
        elif kind == 7:
            self.group.reset()
        elif kind == 8:
            draw.choice(self.tool + self.machine).control_dword = draw.choice((0, 7, 7))
        elif kind == 9:
            commands.stop(draw.choice(self.tool + self.machine))
        elif kind == 10:
            axis = draw.choice(self.tool + self.machine)
            axis.velocity_override = draw.choice((0, 100_000, 1_000_000))
        elif draw.random() < 0.5:
            self.group.dissolve()
        else:
            self.assign(draw.random() < 0.2)

    def recover(self) -> None:
        for axis in self.nc:
            axis.control_dword, axis.velocity_override = 7, 1_000_000
        self.group.stop()
        for axis in self.tool + self.machine:
            commands.stop(axis)
        for _ in range(1000):
            self.nc.cycle()
        assert not any(axis.set_motion_phase for axis in self.nc), self.group.error_code
        self.group.reset()
        for axis in self.nc:
            commands.reset(axis)
        for _ in range(5):
            self.nc.cycle()
        assert not self.group.error_code
        assert self.group.dissolve() == 0
        for axis in self.nc:
            target = axis.set_position + 5.0
            assert commands.start(axis, 1, target, 50.0) == 0
            for _ in range(500):
                self.nc.cycle()
            assert axis.set_position == pytest.approx(target)
            assert axis.set_motion_phase == MotionPhase.NONE


@settings(max_examples=15)
@given(name=st.sampled_from(sorted(AXES)), seed=st.integers(0, 2**32 - 1))
def test_tools_at_random_places(name: str, seed: int) -> None:
    tool = Tool(name, Random(seed))
    tool.begin()
    for _ in range(tool.draw.randint(5, 30)):
        for _ in range(tool.draw.choice((1, 5, 50, 300))):
            tool.cycle()
            assert tool.group.error_code in {0, *ERRORS}, hex(tool.group.error_code)
        tool.act()
    tool.recover()


ANY = st.floats(allow_nan=True, allow_infinity=True)


@given(
    name=st.sampled_from(sorted(KINEMATICS)),
    arguments=st.lists(ANY, min_size=8, max_size=8),
    numbers=st.none() | st.lists(ANY, min_size=7, max_size=7),
)
def test_any_numbers_have_a_place_or_the_error(
    name: str, arguments: list[float], numbers: list[float] | None
) -> None:
    """Of the services 0x801 and 0x802; what they tell is finite."""
    group = Tool(name, Random(1)).group
    if numbers is not None:
        group.numbers = numbers[: len(group.numbers)]
    for call in (group.forward, group.inverse):
        result = call(arguments)
        if isinstance(result, list):
            assert all(map(math.isfinite, result))
        else:
            assert result == NcError.NUMBER_RANGE_LEFT


@given(
    name=st.sampled_from(sorted(AXES)),
    places=st.lists(st.floats(-1000.0, 1000.0), min_size=8, max_size=8),
    scale=st.floats(0.5, 2.0),
)
def test_axes_of_a_place_have_the_tool_there(name: str, places: list[float], scale: float) -> None:
    """Not on the other side of a crossing, where a second solution is."""
    law = KINEMATICS[name]
    numbers = [value if value in (0.0, 1.0) else value * scale for value in law.numbers.values()]
    axes, back = [0.0] * 8, [0.0] * 8
    if law.inverse(numbers, places, axes):
        assert law.forward(numbers, axes, back)
        assert back == pytest.approx(places, abs=2e-3)


@pytest.mark.parametrize("failure", [RuntimeError("bent"), KeyError(3), TypeError("no")])
def test_a_law_of_a_user_that_fails_is_an_error_of_the_group(
    make_groups: Any, failure: Exception, caplog: pytest.LogCaptureFixture
) -> None:
    """The cycle goes on, the tool stops, the log tells it once."""
    rig = make_groups("identity")
    group = rig.kinematic
    assert group.assign_both([1, 2, *[0] * 6], [3, 4, *[0] * 6]) == 0

    def inverse(numbers: Any, places: Any, axes: Any) -> int:
        if places[0] > 10.0:
            raise failure
        axes[:] = places
        return 1

    group.law = KinematicsLaw(group.law.forward, inverse, {})
    assert commands.start(rig.axis(1), 1, 50.0, 20.0) == 0
    rig.until(lambda: group.error_code)
    assert group.error_code == NcError.NUMBER_RANGE_LEFT
    rig.until(lambda: not rig.axis(1).set_velocity and not rig.axis(3).set_velocity)
    assert group.inverse([20.0] * 8) == NcError.NUMBER_RANGE_LEFT
    (line,) = [record.getMessage() for record in caplog.records if "kinematics" in record.message]
    assert type(failure).__name__ in line


def test_an_elbow_that_was_stretched_bends_to_its_side_again() -> None:
    law = KINEMATICS["scara"]
    arms, axes = [300.0, 200.0], [0.0, -10.0]
    for reach in (499.0, 500.0, 499.0):
        assert law.inverse(arms, [reach, 0.0], axes)
    assert axes[1] < 0.0
