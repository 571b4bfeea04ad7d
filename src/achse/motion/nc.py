"""Nc: the axes of one motion controller and their common cycle."""

import hashlib
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import islice
from typing import Any

from achse.motion.axis import Axis
from achse.motion.channels.parameters import ChannelParameters
from achse.motion.channels.table import Channels
from achse.motion.compiled import KERNEL
from achse.motion.control import curves
from achse.motion.control.drive import adapt_drive
from achse.motion.fields.declare import Field, Role
from achse.motion.groups.parameters import GroupParameters
from achse.motion.groups.table import Groups
from achse.motion.kernel import begin, begin_encoder
from achse.motion.machine.hardware import Hardware, begin_machine, fit
from achse.motion.machine.record import PARAMETERS as MACHINE_PARAMETERS
from achse.motion.order import CycleOrder
from achse.motion.parts import AxisController, AxisDrive, AxisEncoder, AxisPart
from achse.motion.record import (
    CONTROLLER,
    DRIVE,
    ENCODER,
    FIELDS,
    LAYOUT,
    PART_OF,
    SlotsRecord,
    controller_record,
    drive_record,
    encoder_record,
)
from achse.motion.retained import RetainedState
from achse.motion.rows import NcRows
from achse.motion.states import choices_of
from achse.motion.tables import TableParameters, Tables
from achse.motion.views import Store, View
from achse.native.compiled import bound_call
from achse.native.declare import pack
from achse.native.memory import Rows

HIGHEST_AXIS_ID = 255
"""Of encoders, controllers and drives too."""

MOST_ELEMENTS = 9
"""Encoders, controllers and drives of one axis, each."""

_EVERY_FIELD = ("",)
_ELEMENT_FIELDS = ("encoder_", "controller_", "drive_", "simulation_")

_SIMULATION = "simulation_"

_MOST_INCREMENTS = 2.0e9
"""Output at full velocity that a double word holds."""

_MOST_WEIGHT = FIELDS["drive_velocity_scaling"].most

_PLAIN_AXIS_NS = 5_000
"""Time of one axis per cycle without machine code, ns, roughly."""

_PLAIN_SHARE = 20
"""Machine code is worth its start-up time once plain axes take more than this part of the cycle."""

_CONFIGURABLE = (Role.PARAMETER, Role.INPUT)


STORED_VELOCITIES = (
    "jog_velocity_slow",
    "jog_velocity_fast",
    "rapid_traverse_velocity",
    "homing_velocity_towards_cam",
    "homing_velocity_off_cam",
)
"""Velocities of commands that have none of their own (0x4000+ID, 0x06 to 0x0A)."""


class AxisParametersError(ValueError):
    """The description of an axis names an unknown field or a value that cannot be."""


@dataclass(frozen=True, slots=True)
class AxisParameters:
    """Configuration of an axis at the start of the NC.

    `values` sets parameter and input fields of the record by name (`AxisFields`), in axis units and
    seconds; what is not named has its default. `control_dword` and `velocity_override` preset the
    cyclic interface. `drive_reference_velocity` is 1.1 times `max_velocity` unless given.
    Velocities of jogs and homings (`STORED_VELOCITIES`) are at most `max_velocity` unless given.

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
            row = configurable(name)
            if (
                row is None
                or not name.startswith(parts)
                or (parts is _ELEMENT_FIELDS and not _of_an_element(name))
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
                article = "an" if choices.__name__[0] in "AEIOU" else "a"
                raise AxisParametersError(
                    f"axis {self.axis_id}: {name} = {value!r} is not {article} {choices.__name__}"
                )

    def apply(self, axis: Axis) -> None:
        """Write all values of the NC into a fresh axis and its parts."""
        axis.axis_id = self.axis_id
        axis.describe(self.name or f"Axis {self.axis_id}", self.unit)
        axis.encoder_ids, axis.controller_ids, axis.drive_ids = self.ids().values()
        for name, value in self.values.items():
            if not PART_OF.get(name, ("machine",))[0]:
                setattr(axis, name, value)
        for name in STORED_VELOCITIES:
            if name not in self.values:
                setattr(axis, name, min(getattr(axis, name), axis.max_velocity))
        reference = 1.1 * axis.max_velocity
        for kind, number, part, values in self._described(axis):
            for name, value in values.items():
                if name in PART_OF and PART_OF[name][0] == kind:
                    setattr(part, PART_OF[name][1].name, value)
            if isinstance(part, AxisEncoder):
                _settle_scaling(part, values)
            elif isinstance(part, AxisDrive):
                if "drive_reference_velocity" not in values:
                    part.reference_velocity = reference
                if number == 0:
                    reference = part.reference_velocity
                if "drive_velocity_scaling" not in values:
                    part.velocity_scaling = _increments_per_second(axis, part, number)

    def _described(self, axis: Axis) -> Iterator[tuple[str, int, AxisPart, Mapping[str, float]]]:
        """Yield all parts of an axis, kind by kind, with their numbers and what is said of them."""
        described = (self.values, *self.elements)
        for kind, own in axis.parts().items():
            for number, part in enumerate(own):
                yield kind, number, part, described[number] if number < len(described) else {}

    def equip(self, axis: Axis, hardware: Hardware) -> None:
        """Build the machine of a fresh axis: as it is set up, but for what is said of the machine
        itself."""
        axis.machine = hardware.build(len(axis.encoders), len(axis.drives))
        for encoder, sensor in zip(axis.encoders, axis.machine.sensors, strict=True):
            encoder.equip(sensor)
        for drive, amplifier in zip(axis.drives, axis.machine.amplifiers, strict=True):
            drive.equip(amplifier)
        fit(axis.machine, axis)
        for number, values in enumerate((self.values, *self.elements)):
            for name, value in values.items():
                if name in MACHINE_PARAMETERS:
                    part, field = MACHINE_PARAMETERS[name]
                    own: dict[str, Sequence[Any]] = {
                        "machine": [axis.machine],
                        "sensor": axis.machine.sensors,
                        "amplifier": axis.machine.amplifiers,
                    }
                    parts = own[part]
                    if number < len(parts):
                        setattr(parts[number], field.name, value)


def configurable(name: str) -> Field | None:
    """Return the field of the NC or of its machine that a configuration sets by this name."""
    if name in MACHINE_PARAMETERS:
        return MACHINE_PARAMETERS[name][1]
    row = FIELDS.get(name)
    return row if row is not None and row.role in _CONFIGURABLE and name != "axis_id" else None


def _of_an_element(name: str) -> bool:
    """Return True if encoders, controllers and drives have this value each."""
    if name in MACHINE_PARAMETERS:
        return MACHINE_PARAMETERS[name][0] != "machine"
    return not name.startswith(_SIMULATION)


def _increments_per_second(axis: Axis, drive: AxisDrive, number: int) -> float:
    """Weight of a velocity output in increments a second, as far as a double word goes."""
    full = drive.reference_velocity / drive.reference_output
    encoder = axis.encoders[min(number, len(axis.encoders) - 1)]
    return min(1.0 / encoder.scaling_factor, _MOST_INCREMENTS / full, _MOST_WEIGHT)


def _settle_scaling(encoder: AxisEncoder, values: Mapping[str, float]) -> None:
    if {"encoder_scaling_numerator", "encoder_scaling_denominator"} & values.keys():
        encoder.scaling_factor = encoder.scaling_numerator / encoder.scaling_denominator
    else:
        encoder.scaling_numerator = encoder.scaling_factor


def _nothing() -> None:
    """Do nothing around a cycle without a bus."""


def _none(_: int) -> int:
    """No cycles are done together."""
    return 0


class Nc:
    """Axes by id and their SAF cycle of `cycle_ns` nanoseconds.

    `compiled` chooses the machine-code kernel (True, needs llvmlite), the plain one (False) or, by
    default, machine code if it is compiled already or pays with so many axes. Both give
    bit-identical states. `tables` are characteristics that drives may use. `groups` lead several
    axes, `channels` own them.

    Raises AxisParametersError, TableError, GroupParametersError.
    """

    def __init__(
        self,
        cycle_ns: int,
        axes: Iterable[AxisParameters],
        *,
        tables: Iterable[TableParameters] = (),
        groups: Iterable[GroupParameters] = (),
        channels: Iterable[ChannelParameters] = (),
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
        self._cycles: Callable[[int], None]
        self._many: Callable[[int], int] = _none
        self.kernel_arguments: tuple[Any, ...] = ()
        """Arguments of the kernel for rows and cycle time; another tuple with new curves."""
        self._around: tuple[Callable[[], None], Callable[[], None]] | None = None
        self.tables = Tables(lambda: self._axes.values())
        self.tables.laid_out = self.tables.characteristics.laid_out = self._load_curves
        ids = [parameters.ids() for parameters in configured]
        encoders, controllers, drives = (
            sum(len(each[kind]) for each in ids) for kind in ("encoder", "controller", "drive")
        )

        def store(base: type[View], layout: Any, fresh: type, count: int) -> Store:
            return Store(base, layout, fresh, count, compiled=compiled)

        self._records = store(Axis, LAYOUT, SlotsRecord, len(configured))
        self._encoders = store(AxisEncoder, ENCODER, encoder_record, encoders)
        self._controllers = store(AxisController, CONTROLLER, controller_record, controllers)
        self._drives = store(AxisDrive, DRIVE, drive_record, drives)
        self._hardware = Hardware(len(configured), encoders, drives, compiled=compiled)
        self._order = CycleOrder(len(configured))
        self._axes: dict[int, Axis] = {}
        self._owners: dict[str, dict[int, tuple[Axis, int]]] = {
            "encoder": {}, "controller": {}, "drive": {},
        }  # fmt: skip
        fresh = [
            iter(each.views)
            for each in (self._records, self._encoders, self._controllers, self._drives)
        ]
        for parameters in configured:
            self._add(parameters, *fresh)
        for table in tables:
            self.tables.add_configured(table)
        self.tables.characteristics.lay_out()
        self.tables.characteristics.build_valves()
        self.groups = Groups(groups, self._axes, self._dt)
        self._has_groups = len(self.groups) > 0
        self.channels = Channels(channels, self.groups, self._axes)

    def _load_curves(self) -> None:
        """Let the kernel read the curves as they are now."""
        spans = self.tables.characteristics.spans
        records, encoders = self._records.arguments, self._encoders.arguments
        hardware = self._hardware
        if not self.compiled:
            rows = NcRows(
                *(records[0], encoders[0], self._order.rows),
                *(spans, self.tables.cams.numbers),
            )
            self.kernel_arguments = (rows, hardware.rows, self._dt)
            self._cycles = partial(KERNEL.plain, *self.kernel_arguments)
            return
        self._curves = Rows(curves.LAYOUT, len(spans))
        for index, span in enumerate(spans):
            self._curves.row(index)[:] = pack(curves.LAYOUT, span)
        self.kernel_arguments = (
            *(*records, *encoders, *self._order.arguments),
            *(self._curves.address, self._curves.count),
            *self.tables.cams.arguments,
            *hardware.arguments,
            self._dt,
        )
        self._cycles = KERNEL.bind(*self.kernel_arguments)

    def _add(
        self,
        parameters: AxisParameters,
        axes: Iterator[Axis],
        encoders: Iterator[AxisEncoder],
        controllers: Iterator[AxisController],
        drives: Iterator[AxisDrive],
    ) -> None:
        """Set up one axis and its parts in the next records."""
        if parameters.axis_id in self._axes:
            raise AxisParametersError(f"axis id {parameters.axis_id} is given twice")
        axis = next(axes)
        ids = parameters.ids()
        axis.name = parameters.name or f"Axis {parameters.axis_id}"
        axis.set_parts(
            list(islice(encoders, len(ids["encoder"]))),
            list(islice(controllers, len(ids["controller"]))),
            list(islice(drives, len(ids["drive"]))),
        )
        axis.cycle_ns = self.cycle_ns
        axis.tables = self.tables
        axis.fellows = self._axes
        axis.index, axis.order = len(self._axes), self._order
        axis.first_encoder = len(self._owners["encoder"])
        axis.encoder_count = len(ids["encoder"])
        parameters.apply(axis)
        parameters.equip(axis, self._hardware)
        begin_machine(axis.machine)
        begin(axis, self._dt)
        for encoder in axis.encoders[1:]:
            begin_encoder(axis, encoder, self._dt)
        for drive in axis.drives[1:]:
            adapt_drive(axis, drive, self._dt)
        self._axes[parameters.axis_id] = axis
        for kind, own in ids.items():
            for number, id in enumerate(own):
                if id in self._owners[kind]:
                    raise AxisParametersError(f"{kind} id {id} is given twice")
                self._owners[kind][id] = axis, number

    @property
    def setpoint_consistency_check(self) -> int:
        """True if external set points are checked and corrected in each cycle, all axes alike."""
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
        """Return the axis with this id; KeyError if there is none."""
        return self._axes[axis_id]

    def ids(self, kind: str) -> list[int]:
        """Ids of all "encoder", "controller" or "drive" objects, in the order of the axes."""
        return list(self._owners[kind])

    def element(self, kind: str, id: int) -> Any:
        """Encoder, controller or drive `id`; KeyError if there is none."""
        axis, number = self._owners[kind][id]
        return axis.parts()[kind][number]

    def cycle(self, count: int = 1) -> None:
        """Run one SAF cycle of all axes, or several."""
        leading = self._has_groups and (self.groups.busy or self.channels.running)
        if self._around is None and not leading:
            self.cycle_count += count
            self._cycles(count)
            return
        before, after = self._around or (_nothing, _nothing)
        while count > 0:
            done = 0 if leading else self._many(count)
            self.cycle_count += done or 1
            if done == 0:
                before()
                self.channels.step()
                self.groups.step()
                self._cycles(1)
                after()
                done = 1
            count -= done

    def cycles_by_machine_code(self, count: int) -> Callable[[int], None] | None:
        """Return the machine code of `count` cycles, whose caller counts them; None if cycles have
        a part in Python.
        """
        leading = self._has_groups and (self.groups.busy or self.channels.running)
        call = None if self._around is not None or leading else bound_call(self._cycles)
        if call is None:
            return None
        call.words[-1] = count
        return self._cycles

    def connect(
        self,
        before: Callable[[], None],
        after: Callable[[], None],
        many: Callable[[int], int] | None = None,
    ) -> None:
        """Call these around each cycle: they bring the inputs of a bus, and send its outputs.

        `many(count)` may do up to so many cycles with all that belongs to them by itself; it says
        how many it did.
        """
        self._around = before, after
        self._many = many or _none

    def retained_state(self) -> dict[int, RetainedState]:
        """Return the part of each axis that outlives a restart, by its id."""
        return {axis_id: RetainedState.of(axis) for axis_id, axis in self._axes.items()}

    def inherit(self, states: Mapping[int, RetainedState]) -> None:
        """Begin after a restart, with what is left of axes with these ids."""
        for axis_id in self._axes.keys() & states.keys():
            states[axis_id].restore(self._axes[axis_id])

    def clear_cycle_time_errors(self) -> None:
        """Begin again with the counters of late cycles, which the pacing of the cycle counts."""
        self.late_cycles = 0
        self.late_io_cycles = 0

    def digest(self) -> bytes:
        """Hash of the whole state, 16 bytes, equal for both kernels."""
        state = hashlib.blake2b(self.cycle_count.to_bytes(8, "little"), digest_size=16)
        for axis in self._axes.values():
            state.update(axis.pack())
            for own in axis.parts().values():
                for part in own:
                    state.update(part.pack())
        for record in self._hardware.records():
            state.update(record.pack())
        for table in self.tables:
            state.update(table.values)
            state.update(table.motion)
        for each in (*self.groups, *self.channels):
            state.update(each.digest())
        return state.digest()
