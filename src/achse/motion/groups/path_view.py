"""States of a 3D group about its path (002 §6.4.3.2, 0x3100 + ID)."""

from math import hypot
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from achse.motion.groups.path_group import PathGroup

_MAIN = 3


class PathView:
    """Values of the path, all 0 without one. Lengths in mm, velocities in mm/s."""

    def __init__(self, group: "PathGroup") -> None:
        self._group = group

    @property
    def _axes(self) -> list[Any]:
        return [axis for axis in self._group.places[:_MAIN] if axis is not None]

    @property
    def remaining(self) -> float:
        """Way to the end of the present segment (0x500)."""
        planner = self._group.planner
        return 0.0 if planner is None else max(0.0, planner.remaining)

    @property
    def done(self) -> float:
        """Way since its beginning (0x501)."""
        planner = self._group.planner
        return 0.0 if planner is None else planner.done

    @property
    def velocity(self) -> float:
        """Set velocity on the path (0x502)."""
        planner = self._group.planner
        return 0.0 if planner is None or not self._group.moving else planner.velocity

    @property
    def acceleration(self) -> float:
        """Set acceleration on the path (0x503)."""
        planner = self._group.planner
        return 0.0 if planner is None or not self._group.moving else planner.acceleration

    @property
    def acceleration_abs(self) -> float:
        """Size of the set acceleration of X, Y, Z together (0x504)."""
        planner = self._group.planner
        if planner is None or not self._group.moving:
            return 0.0
        return hypot(*planner.axis_acceleration[:_MAIN])

    @property
    def end_velocity_max(self) -> float:
        """Velocity that the end of the segment allows (0x505)."""
        planner = self._group.planner
        return 0.0 if planner is None else planner.end_velocity

    @property
    def velocity_max(self) -> float:
        """Velocity that the segment allows (0x506)."""
        planner = self._group.planner
        return 0.0 if planner is None else planner.most_velocity

    @property
    def stop_distance(self) -> float:
        """Way on which the path would come to rest (0x507)."""
        planner = self._group.planner
        return 0.0 if planner is None or not self._group.moving else planner.stop_way

    @property
    def safety_distance(self) -> float:
        """Length of the segment, less what is done, less the stop distance (0x508)."""
        return self.remaining - self.stop_distance

    @property
    def override_percent(self) -> float:
        """Override that the path has (0x50A)."""
        planner = self._group.planner
        return 100.0 if planner is None else 100.0 * planner.override

    @property
    def actual_velocity(self) -> float:
        """Size of the actual velocity of X, Y, Z together (0x511)."""
        return hypot(*(axis.actual_velocity for axis in self._axes))

    @property
    def _tangent(self) -> list[float]:
        planner = self._group.planner
        if planner is None:
            return [0.0] * _MAIN
        return list(planner.tangent[:_MAIN])

    def _along(self, values: list[float]) -> float:
        return sum(a * b for a, b in zip(values, self._tangent, strict=False))

    @property
    def _actual_accelerations(self) -> list[float]:
        places = self._group.places[:_MAIN]
        return [0.0 if axis is None else axis.actual_acceleration for axis in places]

    @property
    def actual_acceleration(self) -> float:
        """Actual acceleration along the path (0x512)."""
        return self._along(self._actual_accelerations)

    @property
    def actual_acceleration_abs(self) -> float:
        """Size of the actual acceleration of X, Y, Z together (0x513)."""
        return hypot(*self._actual_accelerations)

    @property
    def _errors(self) -> list[float]:
        return self.differences[:_MAIN]

    @property
    def tangential_error(self) -> float:
        """Distance of the axes behind the set point along the path, negative if ahead (0x514)."""
        return self._along(self._errors)

    @property
    def orthogonal_error(self) -> float:
        """Distance of the axes beside the path (0x515)."""
        errors, along = self._errors, self.tangential_error
        beside = [e - along * t for e, t in zip(errors, self._tangent, strict=True)]
        return hypot(*beside)

    @property
    def done_normalized(self) -> float:
        """Share of the segment that is done, 0..1 (0x520)."""
        length = self.done + self.remaining
        return self.done / length if length > 0.0 else 0.0

    @property
    def total_remaining(self) -> float:
        """Way to the end of what is known (0x522); 0 unless parameter 0x508 is 1."""
        planner = self._group.planner
        if planner is None or not self._group.total_remaining_path_enable:
            return 0.0
        return max(0.0, planner.total_remaining)

    @property
    def programmed_velocity(self) -> float:
        """Feed of the segment (0x523)."""
        planner = self._group.planner
        return 0.0 if planner is None else planner.programmed_velocity

    @property
    def target(self) -> tuple[float, ...]:
        """End of the present or last segment: X, Y, Z, Q1..Q5 (0x530, 0x531)."""
        planner = self._group.planner
        element = None if planner is None else planner.element
        positions = self._group.positions
        if element is None or not self._group.moving:
            return positions
        ids = self._group.ids
        return tuple(e if id else 0.0 for e, id in zip(element.end, ids, strict=True))

    @property
    def set_positions(self) -> tuple[float, ...]:
        """X, Y, Z, Q1..Q5 (0x546)."""
        return self._group.positions

    @property
    def actual_positions(self) -> tuple[float, ...]:
        """X, Y, Z, Q1..Q5 (0x547)."""
        return tuple(0.0 if axis is None else axis.actual_position for axis in self._group.places)

    @property
    def differences(self) -> list[float]:
        """Set less actual positions (0x548)."""
        return [a - b for a, b in zip(self.set_positions, self.actual_positions, strict=True)]
