"""Nc: the axes of one motion controller and their common cycle."""

import hashlib
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from achse.motion.axis import Axis, ObjectAxis, WordsAxis
from achse.motion.compiled import compiled_cycle, numba_installed
from achse.motion.kernel import begin, cycle_all
from achse.motion.record import FIELDS, Role, SlotsRecord, record_dtype

__all__ = ["HIGHEST_AXIS_ID", "AxisParameters", "AxisParametersError", "Nc"]

HIGHEST_AXIS_ID = 255

_PLAIN_AXIS_NS = 5_000
"""What one axis costs per cycle without Numba, about."""

_PLAIN_SHARE = 20
"""Numba is worth its start-up time once plain axes take more than this part of the cycle."""

_CONFIGURABLE = (Role.PARAMETER, Role.INPUT)


class AxisParametersError(ValueError):
    """The description of an axis names an unknown field or a value that cannot be."""


@dataclass(frozen=True, slots=True)
class AxisParameters:
    """What an axis is when the NC starts.

    `values` sets parameter and input fields of the record by name (`AxisFields`), in axis units and
    seconds; what is not named has its default. `control_dword` and `velocity_override` preset the
    cyclic interface. `drive_reference_velocity` is 1.1 times `max_velocity` unless given.
    """

    axis_id: int
    name: str = ""
    unit: str = "mm"
    values: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not 1 <= self.axis_id <= HIGHEST_AXIS_ID:
            raise AxisParametersError(f"axis id {self.axis_id}: expected 1..{HIGHEST_AXIS_ID}")
        for name, value in self.values.items():
            row = FIELDS.get(name)
            if row is None or row.role not in _CONFIGURABLE or name == "axis_id":
                raise AxisParametersError(f"axis {self.axis_id}: no parameter {name!r}")
            if not row.least <= value <= row.most or not math.isfinite(value):
                raise AxisParametersError(
                    f"axis {self.axis_id}: {name} = {value!r}, "
                    f"expected {row.least:g}..{row.most:g} ({row.unit})"
                )
            if not row.is_real and value != int(value):
                raise AxisParametersError(
                    f"axis {self.axis_id}: {name} = {value!r}, expected a whole number ({row.unit})"
                )

    def apply(self, axis: Axis) -> None:
        """Write all values into a fresh axis."""
        axis.axis_id = self.axis_id
        axis.describe(self.name or f"Axis {self.axis_id}", self.unit)
        for name, value in self.values.items():
            setattr(axis, name, value)
        if "drive_reference_velocity" not in self.values:
            axis.drive_reference_velocity = 1.1 * axis.max_velocity
        if {"encoder_scaling_numerator", "encoder_scaling_denominator"} & self.values.keys():
            axis.encoder_scaling_factor = (
                axis.encoder_scaling_numerator / axis.encoder_scaling_denominator
            )
        else:
            axis.encoder_scaling_numerator = axis.encoder_scaling_factor


class Nc:
    """Axes by id and their SAF cycle of `cycle_ns` nanoseconds.

    `compiled` chooses the machine-code kernel (True, needs Numba), the plain one (False) or, by
    default, whichever suits the number of axes. Both give bit-identical states.
    """

    def __init__(
        self, cycle_ns: int, axes: Iterable[AxisParameters], *, compiled: bool | None = None
    ) -> None:
        if cycle_ns <= 0:
            raise AxisParametersError(f"cycle time {cycle_ns} ns: expected more than 0")
        configured = sorted(axes, key=lambda parameters: parameters.axis_id)
        self.cycle_ns = cycle_ns
        self.cycle_count = 0
        self._dt = cycle_ns / 1e9
        if compiled is None:
            load = len(configured) * _PLAIN_AXIS_NS * _PLAIN_SHARE
            compiled = load > cycle_ns and numba_installed()
        self.compiled = compiled
        self._records: Any
        self._cycle_all: Callable[[Any, float], None]
        views: list[Axis]
        if compiled:
            import numpy

            self._cycle_all = compiled_cycle()
            self._records = numpy.zeros(len(configured), record_dtype())
            self._cycle_all(self._records[:0], self._dt)  # compiles or loads now, not in a cycle
            for name, row in FIELDS.items():
                self._records[name] = row.default
            rows = self._records.view("u1").reshape(len(configured), -1)
            views = [WordsAxis(memoryview(row)) for row in rows]
        else:
            self._cycle_all = cycle_all
            self._records = [SlotsRecord() for _ in configured]
            views = [ObjectAxis(record) for record in self._records]
        self._axes: dict[int, Axis] = {}
        for parameters, axis in zip(configured, views, strict=True):
            if parameters.axis_id in self._axes:
                raise AxisParametersError(f"axis id {parameters.axis_id} is given twice")
            parameters.apply(axis)
            begin(axis, self._dt)
            self._axes[parameters.axis_id] = axis

    @property
    def cycle_seconds(self) -> float:
        return self._dt

    def __iter__(self) -> Iterator[Axis]:
        return iter(self._axes.values())

    def __len__(self) -> int:
        return len(self._axes)

    def axis(self, axis_id: int) -> Axis:
        """The axis with this id; KeyError if there is none."""
        return self._axes[axis_id]

    def cycle(self) -> None:
        """One SAF cycle of all axes."""
        self.cycle_count += 1
        self._cycle_all(self._records, self._dt)

    def digest(self) -> bytes:
        """Hash of the whole state, 16 bytes, equal for both kernels."""
        state = hashlib.blake2b(self.cycle_count.to_bytes(8, "little"), digest_size=16)
        for axis in self._axes.values():
            state.update(axis.pack())
        return state.digest()
