"""Axis: access to one axis record from outside the kernel, equal for both forms of the record.

An `Axis` has every record field as an attribute holding a Python float, int or indexable array.
Changing one wakes a resting axis, so that the next cycle sees the change; changing a parameter lets
it compute what follows from its parameters. The parameters of its simulated machine are attributes
too, by their names in a configuration (`simulation_load_torque`).
"""

from typing import TYPE_CHECKING, Any

from achse.motion.machine.hardware import (
    AmplifierView,
    DriveIoView,
    EncoderIoView,
    MachineView,
    SensorView,
)
from achse.motion.machine.record import PARAMETERS
from achse.motion.parts import AxisController, AxisDrive, AxisEncoder
from achse.motion.record import LAYOUT, PART_OF, AxisFields, Field, Role
from achse.motion.signals import probe_counts, probe_status
from achse.motion.views import View, views_of
from achse.native.memory import MemoryCell

__all__ = ["Axis", "ObjectAxis", "WordsAxis"]


if TYPE_CHECKING:
    from achse.motion.tables import Tables

    class _Fields(AxisFields):
        """What it shows of its parts by the same names."""

        actual_position: float
        actual_position_modulo: float
        actual_modulo_turns: int
        actual_velocity: float
        actual_velocity_unfiltered: float
        actual_acceleration: float
        homed: int
        following_error: float
        following_error_velocity: float
        following_error_difference: float
        following_error_peak_negative: float
        following_error_peak_positive: float
        following_error_difference_peak_negative: float
        following_error_difference_peak_positive: float

else:

    class _Fields:
        pass


class Axis(View, _Fields):
    """One axis of the NC: its names and, by attribute, every field of its record.

    `encoder`, `controller` and `drive` are those it works with, `encoders[n]`, `controllers[n]` and
    `drives[n]` all it has. Values of the parts it works with are attributes of the axis too, by
    their names in a configuration (`encoder_mask`), and those that an axis itself has by the same
    name (`actual_position`).
    """

    name: str
    unit: str
    cycle_ns: int
    encoder: AxisEncoder
    controller: AxisController
    drive: AxisDrive
    encoders: list[AxisEncoder]
    controllers: list[AxisController]
    drives: list[AxisDrive]
    encoder_ids: tuple[int, ...]
    controller_ids: tuple[int, ...]
    drive_ids: tuple[int, ...]
    tables: "Tables"
    """All tables of the NC."""
    machine: MachineView
    """The simulated machine that the axis moves."""

    @property
    def owner(self) -> "Axis":
        """Itself: what the parts of an axis lead to."""
        return self

    @property
    def sensor(self) -> SensorView:
        """What its encoder is at the simulated machine."""
        return self.encoder.sensor

    @property
    def amplifier(self) -> AmplifierView:
        """What its drive is at the simulated machine."""
        return self.drive.amplifier

    @property
    def encoder_io(self) -> EncoderIoView:
        """The I/O structure of its encoder."""
        return self.encoder.io

    @property
    def drive_io(self) -> DriveIoView:
        """The I/O structure of its drive."""
        return self.drive.io

    def changed(self, field: Field) -> None:
        """Wake; a parameter lets the next cycle compute what follows from it."""
        if field.name != "resting":
            self.wake(adapts=field.role is Role.PARAMETER)

    def wake(self, *, adapts: bool = False) -> None:
        """Go on with the next cycle, and compute there what follows from the parameters."""
        if self.resting:
            self.resting = 0
        if adapts:
            self.adapt = 1

    def describe(self, name: str, unit: str) -> None:
        """Give the axis its name and that of its position unit."""
        self.name = name
        self.unit = unit

    def take_parts(
        self,
        encoders: list[AxisEncoder],
        controllers: list[AxisController],
        drives: list[AxisDrive],
    ) -> None:
        """Have these encoders, controllers and drives, and work with the first of each."""
        self.encoders, self.controllers, self.drives = encoders, controllers, drives
        for part, own in self.parts().items():
            for number, each in enumerate(own):
                each.belong(self, self.name if number == 0 else f"{self.name} {number + 1}")
            self.link(part, own[0])
        for number, encoder in enumerate(encoders):
            encoder.link("axis", self)
            encoder.leads = int(number == 0)

    def parts(self) -> dict[str, list[Any]]:
        """All encoders, controllers and drives."""
        return {"encoder": self.encoders, "controller": self.controllers, "drive": self.drives}

    @property
    def actual_position_uncorrected(self) -> float:
        """Actual position without the position correction."""
        return self.actual_position - self.encoder.position_correction

    @property
    def drive_actual_velocity(self) -> float:
        """Velocity as the drive itself knows it, in its own direction."""
        return self.drive.actual_velocity

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
        return self.drive.io.state8 & 0b11

    @property
    def touch_probe_status(self) -> int:
        """The states of touch probes 1 … 4, a byte each."""
        return probe_status(self.encoder)

    @property
    def touch_probe_counters(self) -> int:
        """Edges that touch probes 1 … 4 latched since they were activated, a byte each."""
        return probe_counts(self.encoder)

    @property
    def user_data(self) -> float:
        """The state that `user_data_state_offset` chooses for the cyclic interface."""
        match self.user_data_state_offset:
            case 0x1_0012:
                return self.encoder.actual_position_unfiltered - self.encoder.position_correction
            case 0x1_0014:
                return self.drive_actual_velocity
            case 0x1_0017:
                return self.encoder.set_position_offset
        return 0.0

    def place(self, field: Field, size: int) -> MemoryCell | None:
        """Where the first `size` bytes of a field are; None if the record is not in memory."""
        return None

    def place_of(self, name: str, size: int) -> MemoryCell | None:
        """The same of any value by its name; None where another part may take over."""
        part, field = PART_OF[name]
        if not part:
            return self.place(field, size)
        own: list[Any] = self.parts()[part]
        place: MemoryCell | None = own[0].place(field, size) if len(own) == 1 else None
        return place

    def __repr__(self) -> str:
        return f"<Axis {self.axis_id} {self.name!r} at {self.actual_position:g} {self.unit}>"


ObjectAxis, WordsAxis = views_of(Axis, LAYOUT)
"""An axis whose record is a `SlotsRecord`, and one whose record is in memory."""


def _of_a_part(part: str, name: str) -> property:
    """A value of a part, by its name at the axis."""

    def read(axis: Axis) -> Any:
        return getattr(getattr(axis, part), name)

    def write(axis: Axis, value: float) -> None:
        setattr(getattr(axis, part), name, value)

    return property(read, write)


def _of_the_machine(part: str, name: str) -> property:
    """A parameter of the machine, by its name in a configuration."""

    def of(axis: Axis) -> Any:
        if part == "machine":
            return axis.machine
        return axis.encoder.sensor if part == "sensor" else axis.drive.amplifier

    def read(axis: Axis) -> Any:
        return getattr(of(axis), name)

    def write(axis: Axis, value: float) -> None:
        setattr(of(axis), name, value)
        axis.wake()

    return property(read, write)


for _name, (_part, _field) in PART_OF.items():
    if _part:
        setattr(Axis, _name, _of_a_part(_part, _field.name))
for _name, (_part, _field) in PARAMETERS.items():
    setattr(Axis, _name, _of_the_machine(_part, _field.name))
