"""A rig for one NC: run cycles, record the set point, on either kernel."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import Axis, AxisParameters, Nc, StateBit

CYCLE = 0.002


class Rig:
    """One NC with axis 1 enabled, override 100 %, soft limits off, 2 ms cycle."""

    def __init__(self, *, compiled: bool = False, count: int = 1, **values: float) -> None:
        presets = {"control_dword": 7, "velocity_override": 1_000_000, **values}
        self.nc = Nc(
            2_000_000,
            [AxisParameters(i + 1, values=presets) for i in range(count)],
            compiled=compiled,
        )
        self.axis: Axis = self.nc.axis(1)
        self.dt = CYCLE
        self.run(2)

    def run(self, cycles: int) -> None:
        for _ in range(cycles):
            self.nc.cycle()

    def seconds(self, seconds: float) -> None:
        self.run(round(seconds / self.dt))

    def until(self, condition: Callable[[Axis], Any], seconds: float = 60.0) -> int:
        """Cycles until the condition holds, checked after each; fails when it never does."""
        for cycle in range(1, round(seconds / self.dt) + 1):
            self.nc.cycle()
            if condition(self.axis):
                return cycle
        raise AssertionError(f"not within {seconds} s: {self.axis!r}")

    def until_rest(self, seconds: float = 60.0) -> int:
        return self.until(lambda axis: axis.set_motion_phase == 0, seconds)

    def trace(self, cycles: int) -> list[tuple[float, float, float]]:
        """Set position, velocity and acceleration, now and after each cycle."""
        axis = self.axis
        samples = [(axis.set_position, axis.set_velocity, axis.set_acceleration)]
        for _ in range(cycles):
            self.nc.cycle()
            samples.append((axis.set_position, axis.set_velocity, axis.set_acceleration))
        return samples

    def refuses(self, error: NcError, command: Callable[..., int], *arguments: Any) -> None:
        """The command answers this error and changes nothing."""
        before = self.nc.digest()
        code = command(self.axis, *arguments)
        assert NcError.of(code) is error, hex(code)
        assert self.nc.digest() == before

    def has(self, bit: StateBit) -> bool:
        return bool(self.axis.state_dword & bit)


@pytest.fixture
def rig() -> Rig:
    return Rig()


@pytest.fixture
def make_rig() -> type[Rig]:
    return Rig
