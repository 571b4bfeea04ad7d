"""Nc: the axes of one motion controller and their common cycle."""

import hashlib
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

from achse.motion import curves
from achse.motion.axis import Axis, ObjectAxis, WordsAxis
from achse.motion.compiled import KERNEL
from achse.motion.kernel import begin
from achse.motion.record import FIELDS, LAYOUT, Role, SlotsRecord, pack_record
from achse.motion.remains import Remains
from achse.motion.states import choices_of
from achse.motion.tables import TableParameters, Tables
from achse.native.declare import pack
from achse.native.memory import Rows

__all__ = ["HIGHEST_AXIS_ID", "AxisParameters", "AxisParametersError", "Nc"]

HIGHEST_AXIS_ID = 255
"""Of encoders, controllers and drives too."""

MOST_ELEMENTS = 9
"""Encoders, controllers and drives of one axis, each."""

_EVERY_FIELD = ("",)
_ELEMENT_FIELDS = ("encoder_", "controller_", "drive_", "simulation_")

_PLAIN_AXIS_NS = 5_000
"""What one axis costs per cycle without machine code, about."""

_PLAIN_SHARE = 20
"""Machine code is worth its start-up time once plain axes take more than this part of the cycle."""

_CONFIGURABLE = (Role.PARAMETER, Role.INPUT)


class AxisParametersError(ValueError):
    """The description of an axis names an unknown field or a value that cannot be."""


@dataclass(frozen=True, slots=True)
class AxisParameters:
    """What an axis is when the NC starts.

    `values` sets parameter and input fields of the record by name (`AxisFields`), in axis units and
    seconds; what is not named has its default. `control_dword` and `velocity_override` preset the
    cyclic interface. `drive_reference_velocity` is 1.1 times `max_velocity` unless given.

    `encoder_ids`, `controller_ids` and `drive_ids` name what belongs to the axis, the first of each
    being the standard one; without them there is one each, with the id of the axis. `elements` are
    the values of encoder, controller and drive number 1, 2, … of the axis.
    """

    axis_id: int
    name: str = ""
    unit: str = "mm"
    values: Mapping[str, float] = field(default_factory=dict)
    encoder_ids: tuple[int, ...] = ()
    controller_ids: tuple[int, ...] = ()
    drive_ids: tuple[int, ...] = ()
    elements: Sequence[Mapping[str, float]] = ()

    def __post_init__(self) -> None:
        if not 1 <= self.axis_id <= HIGHEST_AXIS_ID:
            raise AxisParametersError(f"axis id {self.axis_id}: expected 1..{HIGHEST_AXIS_ID}")
        for kind, ids in self.ids().items():
            if len(ids) > MOST_ELEMENTS or not all(1 <= id <= HIGHEST_AXIS_ID for id in ids):
                raise AxisParametersError(
                    f"axis {self.axis_id}: {kind} ids {ids}, expected at most {MOST_ELEMENTS} "
                    f"of 1..{HIGHEST_AXIS_ID}"
                )
        if len(self.elements) > self.element_count:
            raise AxisParametersError(
                f"axis {self.axis_id}: {len(self.elements)} elements described, "
                f"there are {self.element_count} besides the first"
            )
        self._check(self.values, _EVERY_FIELD)
        for values in self.elements:
            self._check(values, _ELEMENT_FIELDS)

    def ids(self) -> dict[str, tuple[int, ...]]:
        """Ids of the encoders, controllers and drives; by default one each, with the axis id."""
        own = (self.axis_id,)
        return {
            "encoder": self.encoder_ids or own,
            "controller": self.controller_ids or own,
            "drive": self.drive_ids or own,
        }

    @property
    def element_count(self) -> int:
        """Elements besides the first: the most of encoders, controllers and drives, less one."""
        return max(map(len, self.ids().values())) - 1

    def _check(self, values: Mapping[str, float], parts: tuple[str, ...]) -> None:
        for name, value in values.items():
            row = FIELDS.get(name)
            if (
                row is None
                or row.role not in _CONFIGURABLE
                or name == "axis_id"
                or not name.startswith(parts)
            ):
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
            choices = choices_of(row.unit)
            if choices is not None and value not in list(choices):
                raise AxisParametersError(
                    f"axis {self.axis_id}: {name} = {value!r} is no {choices.__name__}"
                )

    def apply(self, axis: Axis) -> None:
        """Write all values into a fresh axis."""
        axis.axis_id = self.axis_id
        axis.describe(self.name or f"Axis {self.axis_id}", self.unit)
        _set(axis, self.values)
        if "drive_reference_velocity" not in self.values:
            axis.drive_reference_velocity = 1.1 * axis.max_velocity

    def apply_element(self, number: int, axis: Axis, owner: Axis) -> None:
        """Write the values of element `number` > 0 of `owner` into a fresh record."""
        axis.axis_id = self.axis_id
        axis.element_number = number
        axis.describe(f"{owner.name} {number + 1}", self.unit, owner)
        axis.drive_reference_velocity = owner.drive_reference_velocity
        if number <= len(self.elements):
            _set(axis, self.elements[number - 1])


def _set(axis: Axis, values: Mapping[str, float]) -> None:
    for name, value in values.items():
        setattr(axis, name, value)
    if {"encoder_scaling_numerator", "encoder_scaling_denominator"} & values.keys():
        axis.encoder_scaling_factor = (
            axis.encoder_scaling_numerator / axis.encoder_scaling_denominator
        )
    else:
        axis.encoder_scaling_numerator = axis.encoder_scaling_factor


class Nc:
    """Axes by id and their SAF cycle of `cycle_ns` nanoseconds.

    `compiled` chooses the machine-code kernel (True, needs llvmlite), the plain one (False) or, by
    default, machine code if it is compiled already or pays with so many axes. Both give
    bit-identical states. `tables` are characteristics that drives may use.

    Raises AxisParametersError, TableError.
    """

    def __init__(
        self,
        cycle_ns: int,
        axes: Iterable[AxisParameters],
        *,
        tables: Iterable[TableParameters] = (),
        compiled: bool | None = None,
    ) -> None:
        if cycle_ns <= 0:
            raise AxisParametersError(f"cycle time {cycle_ns} ns: expected more than 0")
        configured = sorted(axes, key=lambda parameters: parameters.axis_id)
        self.cycle_ns = cycle_ns
        self.cycle_count = 0
        self.late_cycles = 0
        self.late_io_cycles = 0
        self.computing_time_us = 0
        self._dt = cycle_ns / 1e9
        if compiled is None:
            load = len(configured) * _PLAIN_AXIS_NS * _PLAIN_SHARE
            compiled = KERNEL.available and (load > cycle_ns or KERNEL.cached)
        self.compiled = compiled
        count = sum(1 + parameters.element_count for parameters in configured)
        self._cycles: Callable[[int], None]
        views: list[Axis]
        self.tables = Tables(lambda: self._axes.values())
        self.tables.laid_out = self._take_curves
        if compiled:
            self._rows = Rows(LAYOUT, count)
            fresh_record = pack_record(SlotsRecord())
            views = []
            for index in range(count):
                axis = WordsAxis(self._rows, index)
                axis.row[:] = fresh_record
                views.append(axis)
        else:
            self._records = [SlotsRecord() for _ in range(count)]
            views = [ObjectAxis(record) for record in self._records]
        self._axes: dict[int, Axis] = {}
        self._owners: dict[str, dict[int, tuple[Axis, int]]] = {
            "encoder": {}, "controller": {}, "drive": {},
        }  # fmt: skip
        fresh = iter(views)
        for parameters in configured:
            self._add(parameters, fresh)
        for table in tables:
            self.tables.add_configured(table)
        self.tables.lay_out()

    def _take_curves(self) -> None:
        """Let the kernel read the curves as they are now."""
        pieces = self.tables.pieces
        if not self.compiled:
            self._cycles = partial(KERNEL.plain, self._records, pieces, self._dt)
            return
        self._curves = Rows(curves.LAYOUT, len(pieces))
        for index, piece in enumerate(pieces):
            self._curves.row(index)[:] = pack(curves.LAYOUT, piece)
        self._cycles = KERNEL.bind(
            *(self._rows.address, self._rows.count),
            *(self._curves.address, self._curves.count),
            self._dt,
        )

    def _add(self, parameters: AxisParameters, fresh: Iterator[Axis]) -> None:
        """Set up one axis and its elements in the next records."""
        axis = next(fresh)
        if parameters.axis_id in self._axes:
            raise AxisParametersError(f"axis id {parameters.axis_id} is given twice")
        parameters.apply(axis)
        axis.cycle_ns = self.cycle_ns
        axis.tables = self.tables
        begin(axis, self._dt)
        self._axes[parameters.axis_id] = axis
        for number in range(1, 1 + parameters.element_count):
            element = next(fresh)
            parameters.apply_element(number, element, axis)
            begin(element, self._dt)
        axis.take_elements(*parameters.ids().values())
        for kind, ids in parameters.ids().items():
            for number, id in enumerate(ids):
                if id in self._owners[kind]:
                    raise AxisParametersError(f"{kind} id {id} is given twice")
                self._owners[kind][id] = axis, number

    @property
    def setpoint_consistency_check(self) -> int:
        """Whether external set points are checked and corrected in each cycle, all axes alike."""
        return int(any(axis.setpoint_consistency_check for axis in self))

    @setpoint_consistency_check.setter
    def setpoint_consistency_check(self, enabled: int) -> None:
        for axis in self:
            axis.setpoint_consistency_check = enabled

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

    def ids(self, kind: str) -> list[int]:
        """Ids of all "encoder", "controller" or "drive" objects, in the order of the axes."""
        return list(self._owners[kind])

    def element(self, kind: str, id: int) -> Axis:
        """The record of encoder, controller or drive `id`; KeyError if there is none."""
        axis, number = self._owners[kind][id]
        elements: list[Axis] = getattr(axis, f"{kind}s")
        return elements[number]

    def cycle(self, count: int = 1) -> None:
        """One SAF cycle of all axes, or several."""
        self.cycle_count += count
        self._cycles(count)

    def remains(self) -> dict[int, Remains]:
        """What of each axis outlives a restart, by its id."""
        return {axis_id: Remains.of(axis) for axis_id, axis in self._axes.items()}

    def succeed(self, remains: Mapping[int, Remains]) -> None:
        """Begin after a restart, with what is left of axes with these ids."""
        for axis_id in self._axes.keys() & remains.keys():
            remains[axis_id].give(self._axes[axis_id])

    def clear_cycle_time_errors(self) -> None:
        """Begin anew with the counters of late cycles, which whoever paces the cycle counts."""
        self.late_cycles = 0
        self.late_io_cycles = 0

    def digest(self) -> bytes:
        """Hash of the whole state, 16 bytes, equal for both kernels."""
        state = hashlib.blake2b(self.cycle_count.to_bytes(8, "little"), digest_size=16)
        for axis in self._axes.values():
            for element in axis.records:
                state.update(element.pack())
        for table in self.tables:
            state.update(table.values)
        return state.digest()
