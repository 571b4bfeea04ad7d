"""PathGroupParameters: parameters of a 3D group that clients write, and where they go.

Source: 002 §6.4.3.1, 0x3000 + group id.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from achse.motion.axis import Axis
from achse.motion.groups.group import AxisGroup
from achse.motion.groups.parameters import GroupParameters
from achse.motion.path import PathOverride, PathParameters, PathPlanner, ReductionMethod

MOST_OVERRIDE = 10.0
"""Highest override with type 2, a factor."""


class PathGroupParameters(AxisGroup):
    """A group with the parameters of a path; `planner` uses them for the segments to come."""

    def __init__(self, parameters: GroupParameters, axes: Mapping[int, Axis], places: int) -> None:
        super().__init__(parameters, axes, places)
        self.planner: PathPlanner | None = None
        self._path = PathParameters(keep_jerk=parameters.keep_jerk)
        self._single_block = 0
        self._channel_single_block = False

    @property
    def path_parameters(self) -> PathParameters:
        """Parameters of segments that are appended from now on."""
        return self._path

    @path_parameters.setter
    def path_parameters(self, parameters: PathParameters) -> None:
        """Set the parameters of the path. Raises PathError."""
        self._path = parameters
        if self.planner is not None:
            self.planner.parameters = self._path

    def _change(self, **values: Any) -> None:
        self.path_parameters = replace(self._path, **values)

    @property
    def reduction_method(self) -> ReductionMethod:
        """Reduction of the velocity at corners (0x500)."""
        return self._path.method

    @reduction_method.setter
    def reduction_method(self, method: int) -> None:
        self._change(method=ReductionMethod(method))

    @property
    def reduction_factor_c0(self) -> float:
        """Factor at corners (0x501)."""
        return self._path.c0

    @reduction_factor_c0.setter
    def reduction_factor_c0(self, factor: float) -> None:
        self._change(c0=factor)

    @property
    def reduction_factor_c1(self) -> float:
        """Factor where the curvature jumps (0x502)."""
        return self._path.c1

    @reduction_factor_c1.setter
    def reduction_factor_c1(self, factor: float) -> None:
        self._change(c1=factor)

    @property
    def reduction_factor_c2(self) -> float:
        """Factor where the curvature goes on (0x507)."""
        return self._path.c2

    @reduction_factor_c2.setter
    def reduction_factor_c2(self, factor: float) -> None:
        self._change(c2=factor)

    @property
    def critical_angle_low(self) -> float:
        """Corners up to here reduce nothing, degrees (0x503)."""
        return self._path.angle_low

    @critical_angle_low.setter
    def critical_angle_low(self, angle: float) -> None:
        self._change(angle_low=angle)

    @property
    def critical_angle_high(self) -> float:
        """Corners from here on reduce as far as it goes, degrees (0x504)."""
        return self._path.angle_high

    @critical_angle_high.setter
    def critical_angle_high(self, angle: float) -> None:
        self._change(angle_high=angle)

    @property
    def min_path_velocity(self) -> float:
        """Transitions reduce to no less, mm/s (0x505)."""
        return self._path.least_velocity

    @min_path_velocity.setter
    def min_path_velocity(self, velocity: float) -> None:
        self._change(least_velocity=velocity)

    @property
    def keep_jerk(self) -> bool:
        """True if the axes keep their jerk where the curvature jumps (achse's own parameter)."""
        return self._path.keep_jerk

    @keep_jerk.setter
    def keep_jerk(self, on: bool) -> None:
        self._change(keep_jerk=on)

    @property
    def override_type(self) -> PathOverride:
        """Reference of the override (0x50A)."""
        return self._path.override_type

    @override_type.setter
    def override_type(self, kind: int) -> None:
        above = kind == PathOverride.REDUCED_ABOVE
        self._change(
            override_type=PathOverride(kind), most_override=MOST_OVERRIDE if above else 1.0
        )

    @property
    def single_block_mode(self) -> int:
        """1: the path rests at the end of each segment until `next_block` (0x06).

        Starts and ends of programs leave it as it is.
        """
        return self._single_block

    @single_block_mode.setter
    def single_block_mode(self, on: int) -> None:
        self._single_block = on
        self._use_single_block()

    @property
    def channel_single_block(self) -> bool:
        """True if the channel wants single blocks, whatever 0x06 says."""
        return self._channel_single_block

    @channel_single_block.setter
    def channel_single_block(self, on: bool) -> None:
        self._channel_single_block = on
        self._use_single_block()

    @property
    def single_block(self) -> bool:
        """True if the group or its channel wants single blocks."""
        return bool(self._single_block) or self._channel_single_block

    def _use_single_block(self) -> None:
        if self.planner is not None:
            self.planner.single_block = self.single_block
