"""Axis: access to one axis record from outside the kernel, equal for both forms of the record.

An `Axis` has every record field as an attribute holding a Python float, int or indexable array.
Changing one wakes a resting axis, so that the next cycle sees the change; changing a parameter lets
it compute what follows from its parameters.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from achse.motion.record import (
    FIELDS,
    AxisFields,
    Field,
    Role,
    SlotsRecord,
    pack_record,
)
from achse.motion.signals import drive_inputs, probe_counts, probe_status
from achse.native.memory import Place, RowView, reader

__all__ = ["Axis", "ObjectAxis", "WordsAxis"]


if TYPE_CHECKING:
    from achse.motion.tables import Tables

    class _Fields(AxisFields):
        pass

else:

    class _Fields:
        pass


class Axis(_Fields):
    """One axis of the NC: its names and, by attribute, every field of its record.

    Further encoders, controllers and drives of an axis are records of their own, of which only the
    fields of these parts count. `encoders[n]`, `controllers[n]` and `drives[n]` hold number n; the
    one that controls is the axis itself. `owner` leads from any of them to the axis.
    """

    name: str
    unit: str
    cycle_ns: int
    owner: "Axis"
    records: list["Axis"]
    """The axis and the records of its further elements."""
    encoders: list["Axis"]
    controllers: list["Axis"]
    drives: list["Axis"]
    encoder_ids: tuple[int, ...]
    controller_ids: tuple[int, ...]
    drive_ids: tuple[int, ...]
    tables: "Tables"
    """All tables of the NC, which the owner of elements knows."""

    def describe(self, name: str, unit: str, owner: "Axis | None" = None) -> None:
        """Give the axis, or an element of `owner`, its name and that of its position unit."""
        self.name = name
        self.unit = unit
        self.owner = owner or self
        self.records = []
        self.owner.records.append(self)

    def take_elements(
        self,
        encoder_ids: tuple[int, ...],
        controller_ids: tuple[int, ...],
        drive_ids: tuple[int, ...],
    ) -> None:
        """Deal the records out to encoders, controllers and drives with these ids."""
        self.encoder_ids, self.controller_ids, self.drive_ids = (
            encoder_ids, controller_ids, drive_ids,
        )  # fmt: skip
        self.encoders = self.records[: len(encoder_ids)]
        self.controllers = self.records[: len(controller_ids)]
        self.drives = self.records[: len(drive_ids)]

    @property
    def actual_position_uncorrected(self) -> float:
        """Actual position without the position correction."""
        return self.actual_position - self.encoder_position_correction

    @property
    def dc_time_stamp(self) -> int:
        """Time of the last cycle in ns, the low 32 bits."""
        return self.set_cycle_counter * self.cycle_ns & 0xFFFF_FFFF

    @property
    def operation_mode_and_cycle(self) -> int:
        """OpModeDWord as TwinCAT 3 feeds it cyclically: the cycles counted in bits 24 … 31."""
        return self.operation_mode_state_dword | (self.set_cycle_counter & 0xFF) << 24

    @property
    def touch_probe_inputs(self) -> int:
        """StateDWord3: the inputs of touch probes 1 and 2 in bits 0 and 1."""
        return drive_inputs(self, self) & 0b11

    @property
    def touch_probe_status(self) -> int:
        """The states of touch probes 1 … 4, a byte each."""
        return probe_status(self)

    @property
    def touch_probe_counters(self) -> int:
        """Edges that touch probes 1 … 4 latched since they were activated, a byte each."""
        return probe_counts(self)

    @property
    def user_data(self) -> float:
        """The state that `user_data_state_offset` chooses for the cyclic interface."""
        match self.user_data_state_offset:
            case 0x1_0012:
                return self.encoder_actual_position_unfiltered - self.encoder_position_correction
            case 0x1_0014:
                velocity = self.plant_velocity
                return -velocity if self.drive_motor_polarity else velocity
            case 0x1_0017:
                return self.encoder_set_position_offset
        return 0.0

    def place(self, field: Field, size: int) -> Place | None:
        """Where the first `size` bytes of a field lie; None if the record is no memory."""
        return None

    def pack(self) -> bytes:
        """All fields as bytes, in record order, equal for both forms of the record."""
        raise NotImplementedError

    def __repr__(self) -> str:
        return f"<Axis {self.axis_id} {self.name!r} at {self.actual_position:g} {self.unit}>"


class ObjectAxis(Axis):
    """An axis whose record is a `SlotsRecord`."""

    def __init__(self, record: SlotsRecord) -> None:
        self._record = record

    def pack(self) -> bytes:
        return pack_record(self._record)


class WordsAxis(RowView, Axis):
    """An axis whose record lies in memory."""

    def pack(self) -> bytes:
        return self.row.tobytes()


def _object_property(row: Field) -> property:
    name = row.name
    read: Callable[[Any], Any] = eval(f"lambda axis: axis._record.{name}")
    if row.length:
        return property(read)

    def write(axis: Any, value: float) -> None:
        record = axis._record
        if getattr(record, name) != value:
            record.resting = 0
            if adapts:
                record.adapt = 1
            setattr(record, name, kind(value))

    adapts = row.role is Role.PARAMETER
    kind = float if row.is_real else int
    return property(read, write)


def _words_property(row: Field) -> property:
    first = row.offset
    words = "reals" if row.is_real else "wholes"
    resting, adapt = FIELDS["resting"].offset, FIELDS["adapt"].offset
    adapts = row.role is Role.PARAMETER
    if row.length:
        return property(reader(row))

    def write(axis: Any, value: float) -> None:
        memory = getattr(axis, words)
        if memory[first] != value:
            axis.wholes[resting] = 0
            if adapts:
                axis.wholes[adapt] = 1
            memory[first] = kind(value)

    kind = float if row.is_real else int
    return property(reader(row), write)


for _row in FIELDS.values():
    setattr(ObjectAxis, _row.name, _object_property(_row))
    setattr(WordsAxis, _row.name, _words_property(_row))
