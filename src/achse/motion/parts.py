"""Parts of an axis from outside: its encoders, controllers and drives.

A part has the fields of its record as attributes, by their own names (`encoder.mask`) and by those
they have at the axis (`encoder.encoder_mask`), which the rows of services use.
"""

from typing import TYPE_CHECKING

from achse.motion.fields.declare import Field, Role
from achse.motion.machine.hardware import AmplifierView, DriveIoView, EncoderIoView, SensorView
from achse.motion.machine.record import PARAMETERS
from achse.motion.readout.shown import ShownField
from achse.motion.record import (
    CONTROLLER,
    DRIVE,
    ENCODER,
    PART_OF,
    AxisDriveFields,
    ControllerFields,
    EncoderFields,
)
from achse.motion.views import View, views_of
from achse.native.memory import Cell

if TYPE_CHECKING:
    from achse.motion.axis import Axis

    class _Encoder(EncoderFields):
        actual_position_modulo: float
        actual_modulo_turns: int

    class _Controller(ControllerFields):
        output_percent: float

    class _Drive(AxisDriveFields):
        output_percent: float

else:

    class _Encoder: ...

    class _Controller: ...

    class _Drive: ...


class AxisPart(View):
    """An encoder, controller or drive of an axis, its `owner`."""

    name: str
    owner: "Axis"

    @property
    def axis_id(self) -> int:
        return self.owner.axis_id

    def belong(self, owner: "Axis", name: str) -> None:
        """Be a part of this axis."""
        self.owner = owner
        self.name = name

    def changed(self, field: Field) -> None:
        """Wake the axis; a parameter lets the next cycle compute what follows from it."""
        if "owner" in vars(self):
            if field.feature:
                self.owner.features |= field.feature
            self.owner.wake(adapts=field.role is Role.PARAMETER)

    def place(self, field: Field, size: int) -> Cell | None:
        """Return the place of the first `size` bytes of a field, None without a place."""
        return None

    def place_of(self, name: str, size: int) -> Cell | None:
        """The same of a value by the name it has at the axis."""
        field = PART_OF[name][1]
        if isinstance(field, ShownField):
            return self.owner.place_of(name, size)
        return self.place(field, size)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name!r} of axis {self.axis_id}>"


class AxisEncoder(AxisPart, _Encoder):
    """An encoder; `sensor` is what it is at the simulated machine."""

    sensor: SensorView
    io: EncoderIoView
    axis: "Axis"

    def changed(self, field: Field) -> None:
        super().changed(field)
        if field.role is Role.PARAMETER:
            self.adapt = 1

    @property
    def encoder(self) -> "AxisEncoder":
        """Itself, as what a command is about: an encoder, or that of an axis."""
        return self

    def equip(self, sensor: SensorView) -> None:
        """Work with this sensor."""
        self.sensor = sensor
        self.link("io", sensor.io)


class AxisController(AxisPart, _Controller):
    """A controller."""


class AxisDrive(AxisPart, _Drive):
    """A drive; `amplifier` is what it is at the simulated machine."""

    amplifier: AmplifierView
    io: DriveIoView

    def equip(self, amplifier: AmplifierView) -> None:
        """Work with this amplifier."""
        self.amplifier = amplifier
        self.link("io", amplifier.io)

    @property
    def actual_velocity(self) -> float:
        """Velocity as the drive itself knows it, in its own direction."""
        return self.io.data_in3 / (self.velocity_scaling or 1.0)


def _by_its_name_at_the_axis(short: str) -> property:
    def read(part: AxisPart) -> object:
        return getattr(part, short)

    def write(part: AxisPart, value: float) -> None:
        setattr(part, short, value)

    return property(read, write)


for _name, (_kind, _row) in PART_OF.items():
    if not _kind:
        continue
    _class = {"encoder": AxisEncoder, "controller": AxisController, "drive": AxisDrive}[_kind]
    if isinstance(_row, ShownField):
        setattr(_class, _row.name, property(_row.read))
    if _name != _row.name:
        setattr(_class, _name, _by_its_name_at_the_axis(_row.name))


def _at_the_machine(part: str, name: str) -> property:
    def read(element: AxisPart) -> object:
        return getattr(getattr(element, part), name)

    def write(element: AxisPart, value: float) -> None:
        setattr(getattr(element, part), name, value)
        element.owner.wake()

    return property(read, write)


for _name, (_kind, _row) in PARAMETERS.items():
    if _kind != "machine":
        _class = AxisEncoder if _kind == "sensor" else AxisDrive
        setattr(_class, _name, _at_the_machine(_kind, _row.name))

VIEWS = {
    "encoder": views_of(AxisEncoder, ENCODER),
    "controller": views_of(AxisController, CONTROLLER),
    "drive": views_of(AxisDrive, DRIVE),
}
"""The classes of parts whose record is a plain object, and in memory."""
