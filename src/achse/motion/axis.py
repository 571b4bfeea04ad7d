"""Axis: access to one axis record from outside the kernel, equal for both forms of the record.

An `Axis` has every record field as an attribute holding a Python float, int or indexable array.
Changing one wakes a resting axis, so that the next cycle sees the change; changing a parameter lets
it compute what follows from its parameters. The parameters of its simulated machine are attributes
too, by their names in a configuration (`simulation_load_torque`).
"""

from typing import TYPE_CHECKING

from achse.motion.machine.hardware import (
    AmplifierView,
    DriveIoView,
    EncoderIoView,
    MachineView,
    SensorView,
)
from achse.motion.machine.record import PARAMETERS
from achse.motion.record import LAYOUT, AxisFields, Field, Role
from achse.motion.signals import probe_counts, probe_status
from achse.motion.views import View, views_of
from achse.native.memory import MemoryCell

__all__ = ["Axis", "ObjectAxis", "WordsAxis"]


if TYPE_CHECKING:
    from achse.motion.tables import Tables

    class _Fields(AxisFields):
        pass

else:

    class _Fields:
        pass


class Axis(View, _Fields):
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
    machine: MachineView
    """The simulated machine that the axis moves, of elements too."""
    sensor: SensorView
    """What its encoder is at the machine."""
    amplifier: AmplifierView
    """What its drive is at the machine."""
    encoder_io: EncoderIoView
    drive_io: DriveIoView

    def changed(self, field: Field) -> None:
        """Wake; a parameter lets the next cycle compute what follows from it."""
        if field.name != "resting" and self.resting:
            self.resting = 0
        if field.role is Role.PARAMETER:
            self.adapt = 1

    def equip(self, machine: MachineView, number: int) -> None:
        """Work with sensor and amplifier `number` of a machine."""
        self.machine = machine
        self.sensor = machine.sensors[number]
        self.amplifier = machine.amplifiers[number]
        self.link("encoder_io", self.sensor.io)
        self.link("drive_io", self.amplifier.io)

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
    def drive_actual_velocity(self) -> float:
        """Velocity as the drive itself knows it, in its own direction."""
        return self.drive_io.data_in3 / (self.drive_velocity_scaling or 1.0)

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
        return self.drive_io.state8 & 0b11

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
                return self.drive_actual_velocity
            case 0x1_0017:
                return self.encoder_set_position_offset
        return 0.0

    def place(self, field: Field, size: int) -> MemoryCell | None:
        """Where the first `size` bytes of a field lie; None if the record is no memory."""
        return None

    def __repr__(self) -> str:
        return f"<Axis {self.axis_id} {self.name!r} at {self.actual_position:g} {self.unit}>"


ObjectAxis, WordsAxis = views_of(Axis, LAYOUT)
"""An axis whose record is a `SlotsRecord`, and one whose record is in memory."""


def _of_the_machine(part: str, name: str) -> property:
    """A parameter of the machine, by its name in a configuration."""

    def read(axis: Axis) -> float:
        value: float = getattr(getattr(axis, part), name)
        return value

    def write(axis: Axis, value: float) -> None:
        setattr(getattr(axis, part), name, value)
        if axis.owner.resting:
            axis.owner.resting = 0

    return property(read, write)


for _name, (_part, _field) in PARAMETERS.items():
    setattr(Axis, _name, _of_the_machine(_part, _field.name))
