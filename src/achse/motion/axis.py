"""Axis: access to one axis record from outside the kernel, equal for both forms of the record.

An `Axis` has every record field as an attribute holding a Python float, int or indexable array.
Changing one wakes a resting axis, so that the next cycle sees the change; changing a parameter lets
it compute what follows from its parameters. The parameters of its simulated machine are attributes
too, by their names in a configuration (`simulation_load_torque`).
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from achse.motion.control.signals import probe_counts, probe_inputs, probe_status
from achse.motion.couplings.masters import begin_leading_value, end_coupling, show_coupling
from achse.motion.features import Feature
from achse.motion.fields.coupling import MASTERS
from achse.motion.fields.declare import Field, Role
from achse.motion.machine.hardware import (
    AmplifierView,
    DriveIoView,
    EncoderIoView,
    MachineView,
    SensorView,
)
from achse.motion.machine.record import PARAMETERS
from achse.motion.monitoring import show_state
from achse.motion.order import CycleOrder
from achse.motion.parts import AxisController, AxisDrive, AxisEncoder
from achse.motion.port import STATUS_INVALID
from achse.motion.readout.shown import ShownField
from achse.motion.readout.shown_values import shown_cell
from achse.motion.record import LAYOUT, PART_OF, SHOWN_FIELDS, AxisFields
from achse.motion.rows import NcRows
from achse.motion.tables import Tables
from achse.motion.views import InnerView, View, property_within, views_of
from achse.native.memory import Cell

if TYPE_CHECKING:
    from achse.motion.channels.channel import NcChannel
    from achse.motion.groups.group import AxisGroup

    class _Fields(AxisFields):
        """Values of its parts by the same names, and values that are computed at each read."""

        actual_position: float
        actual_position_modulo: float
        actual_modulo_turns: int
        actual_velocity: float
        actual_velocity_unfiltered: float
        actual_acceleration: float
        homed: int
        application_request: int
        application_request_type: int
        application_command_number: int
        buffer_count: int
        delayed_error_code: int
        external_set_position: float
        external_set_velocity: float
        external_set_acceleration: float
        external_set_direction: int
        external_set_torque: float
        external_set_jerk: float
        external_set_torque_derivative: float
        fading_position_difference: float
        fading_relative_velocity: float
        fading_relative_acceleration: float
        homing_state: int
        phasing_active: int
        phasing_position: float
        set_position: float
        set_velocity: float
        set_acceleration: float
        set_jerk: float
        set_velocity_override: float
        set_direction: float
        set_position_modulo: float
        set_modulo_turns: int
        coupling_table_index: int
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


_OF_THE_CYCLE = {"resting", "features"}
"""Fields that say what the cycle has to do; a change of them wakes nothing by itself."""


class _WithinAxis(InnerView):
    """A job or a cam of an axis."""

    @classmethod
    def after_change(cls, field: Field) -> str:
        """Wake the axis, and set the bit of the feature that the value switches on."""
        wakes = "outer = view.outermost._record; outer.resting = 0"
        return f"{wakes}; outer.features |= {field.feature}" if field.feature else wakes


_WithinAxis.inner = _WithinAxis


class Axis(View, _Fields):
    """One axis of the NC: its names and, by attribute, every field of its record.

    `encoder`, `controller` and `drive` are those it works with, `encoders[n]`, `controllers[n]` and
    `drives[n]` all it has. Values of the parts it works with are attributes of the axis too, by
    their names in a configuration (`encoder_mask`), and those that an axis itself has by the same
    name (`actual_position`).
    """

    inner = _WithinAxis
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
    tables: Tables
    """All tables of the NC."""
    fellows: Mapping[int, "Axis"]
    """All axes of the NC by their ids, in the order of their records, itself included."""
    index: int
    """Number of its record among the axes of the NC."""
    order: CycleOrder
    """In which order the cycle goes through these."""
    group: "AxisGroup | None" = None
    """The group of several axes that it belongs to."""
    home_channel: "NcChannel"
    """The channel of its PTP group."""
    machine: MachineView
    """The simulated machine that the axis moves."""
    hardware_address: tuple[bytes, int, int] = (bytes(6), 0, 0)
    """AMS NetId, port and channel of its drive on a bus; zeros for a simulated machine."""

    @property
    def owner(self) -> "Axis":
        """Itself: what the parts of an axis lead to."""
        return self

    @property
    def sensor(self) -> SensorView:
        """The sensor of the simulated machine that its encoder reads."""
        return self.encoder.sensor

    @property
    def amplifier(self) -> AmplifierView:
        """The amplifier of the simulated machine that its drive controls."""
        return self.drive.amplifier

    @property
    def encoder_io(self) -> EncoderIoView:
        """The I/O structure of its encoder."""
        return self.encoder.io

    @property
    def drive_io(self) -> DriveIoView:
        """The I/O structure of its drive."""
        return self.drive.io

    @classmethod
    def after_change(cls, field: Field) -> str:
        """Wake, set the bit of the feature that the value switches on, adapt to a parameter."""
        if field.name in _OF_THE_CYCLE:
            return "pass"
        bits = field.feature
        if field.role is Role.PARAMETER:
            bits |= Feature.PARAMETERS
        return f"record.features |= {bits}; record.resting = 0" if bits else "record.resting = 0"

    def wake(self, *, adapts: bool = False) -> None:
        """Go on with the next cycle, and compute there what follows from the parameters."""
        record = self._record
        record.resting = 0
        if adapts:
            record.features |= Feature.PARAMETERS

    def show(self) -> None:
        """Update the status words after a command between two cycles, and wake."""
        show_state(self)
        self.wake()

    def show_cams(self) -> None:
        """Update the gear ratio and the places of its cams too, and what waits for them."""
        self.tables.show_slave(self)
        self.show()

    def describe(self, name: str, unit: str) -> None:
        """Give the axis its name and that of its position unit."""
        self.name = name
        self.unit = unit

    def go_on_bus(self) -> None:
        """Leave the simulated machine: from now on a bus fills the structures of the axis."""
        self.machine.several = self.machine.on_bus = 1
        self.encoder_io.state4 = self.drive_io.state4 = STATUS_INVALID
        self.drive_io.state1 = 0
        self.drive.on_bus = 1
        self.wake(adapts=True)

    def set_parts(
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
            encoder.in_use = int(number == 0)

    def parts(self) -> dict[str, list[Any]]:
        """Return all encoders, controllers and drives."""
        return {"encoder": self.encoders, "controller": self.controllers, "drive": self.drives}

    def follow(self, coupling: int, masters: Sequence["Axis"]) -> None:
        """Follow these axes from the next cycle on, by a law of `achse.motion.couplings.table`.

        Raises CouplingRing, ValueError unless there are a law and 1..`MASTERS` axes; then nothing
        has changed.
        """
        if not coupling or not 1 <= len(masters) <= MASTERS:
            raise ValueError(f"coupling {coupling} to {len(masters)} axes, expected 1..{MASTERS}")
        rows = [master.index for master in masters]
        others = {axis.index: axis.followed for axis in self.fellows.values() if axis.coupling.law}
        self.order.arrange(others | {self.index: rows})
        leading = {master.index for master in masters if master.followers}
        self.release()
        self.coupling.law, self.coupling.master_count = coupling, len(rows)
        for n in range(MASTERS):
            self.coupling.masters[n] = rows[n] if n < len(rows) else 0
        for master in masters:
            if not master.followers and master.index not in leading:
                begin_leading_value(master)
            master.followers += 1
            show_coupling(master)
        show_coupling(self)
        self.wake()

    def release(self) -> None:
        """End all couplings; set values stay what they are."""
        end_coupling(self, self.rows)

    @property
    def followed(self) -> list[int]:
        """Rows of the axes that it follows."""
        return list(self.coupling.masters[: self.coupling.master_count])

    @property
    def rows(self) -> NcRows:
        """Axes and cams as the kernel sees them; no encoders, order and characteristics."""
        return NcRows(list(self.fellows.values()), (), (), (), self.tables.cams.numbers)

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
        """StateDWord3: the inputs of touch probes 1 and 2 in bits 0 and 1; bit 2, the set torque
        has reached the target of a torque command."""
        return probe_inputs(self.record)

    @property
    def touch_probe_status(self) -> int:
        """The states of touch probes 1 … 4, a byte each."""
        return probe_status(self.encoder)

    @property
    def touch_probe_counters(self) -> int:
        """Edges that touch probes 1 … 4 latched since they were activated, a byte each."""
        encoder = self.encoder
        return probe_counts(encoder) if any(encoder.probe_counter) else 0

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

    @classmethod
    def path_of(cls, field: Field) -> str:
        return _PATHS.get(field.name, field.name)

    def place(self, field: Field, size: int) -> Cell | None:
        """Return the place of the first `size` bytes of a field, None without a place."""
        return None

    def place_of(self, name: str, size: int) -> Cell | None:
        """Return the same of any value by its name; None where another part may take over."""
        part, field = PART_OF[name]
        own: list[Any] = self.parts()[part] if part else [self]
        if len(own) != 1:
            return None
        if isinstance(field, ShownField):
            return shown_cell(self, name, size)
        place: Cell | None = own[0].place(field, size)
        return place

    def __repr__(self) -> str:
        return f"<Axis {self.axis_id} {self.name!r} at {self.actual_position:g} {self.unit}>"


_PATHS = {name: f"{part}.{field.name}" for name, part, field in SHOWN_FIELDS}
"""Fields of the records within an axis that are values of the axis, by their names there."""

ObjectAxis, WordsAxis = views_of(Axis, LAYOUT)
"""An axis whose record is a `SlotsRecord`, and one whose record is in memory."""


def _of_a_part(part: str, name: str) -> property:
    """Return a value of a part, by its name at the axis."""

    def read(axis: Axis) -> Any:
        return getattr(getattr(axis, part), name)

    def write(axis: Axis, value: float) -> None:
        setattr(getattr(axis, part), name, value)

    return property(read, write)


def _of_the_machine(part: str, name: str) -> property:
    """Return a parameter of the machine, by its name in a configuration."""

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


for _name, _part, _field in SHOWN_FIELDS:
    setattr(Axis, _name, property_within(Axis, _part, _field))
for _name, (_part, _field) in PART_OF.items():
    if _part:
        setattr(Axis, _name, _of_a_part(_part, _field.name))
    elif isinstance(_field, ShownField):
        setattr(Axis, _name, property(_field.read))
for _name, (_part, _field) in PARAMETERS.items():
    setattr(Axis, _name, _of_the_machine(_part, _field.name))
