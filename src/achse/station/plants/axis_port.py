"""Plants behind the hardware port of axes: each is a drive with profile CiA 402 for its axis.

The servos of the NC do what they do on a bus: power, modes, velocity loop, dead time. Instead of
frames, their process data are numbers of the unit.
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass

from achse.motion import Nc
from achse.motion.port import wrapped
from achse.motion.servo import ProcessEntry, ServoLink, ServoMode, ServoOptions, Servos, ServoView
from achse.station.configuration.fmu import FmuAxisConfig
from achse.station.plants.errors import PlantError
from achse.station.plants.plant import Plant

_INPUTS = struct.Struct("<Hibi")
_INPUT_OBJECTS = ((0x6041, 0, 2), (0x6064, 2, 4), (0x6061, 6, 1), (0x606C, 7, 4))
_OUTPUTS = struct.Struct("<Hbhii")
_OUTPUT_OBJECTS = (
    (0x6040, 0, 2), (0x6060, 2, 1), (0x6071, 3, 2), (0x607A, 5, 4), (0x60FF, 9, 4),
)  # fmt: skip
"""Process data of an axis: object, offset, bytes."""

_MOST_VELOCITY = 2**31 - 1
_MOST_COUNTS = 2.0**53
"""Beyond this a double has no increments."""

_DISABLED, _READY, _ON, _ENABLED = 0x40, 0x21, 0x23, 0x27
"""States of the power drive system in 6041h (CiA 402)."""

_VOLTAGE, _REMOTE, _FOLLOWING = 1 << 4, 1 << 9, 1 << 12


def statusword(controlword: int) -> int:
    """Return 6041h of a drive that follows 6040h at once and has no faults."""
    base = _VOLTAGE | _REMOTE
    if controlword & 0x6 != 0x6:  # disable voltage, quick stop
        return base | _DISABLED
    if controlword & 0x1 == 0:
        return base | _READY
    if controlword & 0x8 == 0:
        return base | _ON
    return base | _ENABLED | _FOLLOWING


@dataclass(frozen=True, slots=True)
class PlantAxis:
    """An axis and the numbers of its variables among inputs and outputs of the unit."""

    axis_id: int
    config: FmuAxisConfig
    options: ServoOptions
    plant: Plant
    command: int
    position: int
    velocity: int | None
    enable: int | None

    def check(self, outputs: Sequence[float]) -> None:
        """Raise PlantError for a position that no encoder has."""
        counts = self._counts(outputs)
        if not abs(counts) < _MOST_COUNTS:
            name = self.plant.output_variables[self.position].name
            raise PlantError(
                f"{name}: expected a position of at most 2^53 increments of"
                f" {self.config.increment:g}, got {outputs[self.position]:g}"
            )

    def _counts(self, outputs: Sequence[float]) -> float:
        config = self.config
        position = config.scale * outputs[self.position] + config.offset
        return position / config.increment

    def counts(self) -> int:
        """Actual position in increments, beyond 32 bits too."""
        return round(self._counts(self.plant.outputs))

    def counts_per_second(self) -> int:
        """Actual velocity in increments."""
        if self.velocity is None:
            return 0
        config = self.config
        speed = config.scale * self.plant.outputs[self.velocity] / config.increment
        return round(max(-_MOST_VELOCITY, min(speed, _MOST_VELOCITY)))

    def put_command(self, torque: int, position: int, velocity: int) -> None:
        """Set the input of the unit from 6071h, 607Ah or 60FFh."""
        config = self.config
        if config.interface is ServoMode.CST:
            value = torque * 1e-3 * config.rated_torque
            value = -value if config.scale < 0.0 else value
        elif config.interface is ServoMode.CSV:
            value = velocity * config.increment / config.scale
        else:
            near = self.counts()
            target = near + wrapped(position - near)
            value = (target * config.increment - config.offset) / config.scale
        self.plant.inputs[self.command] = value


class AxisPort:
    """The axes of an NC that plants move: they exchange before and after each of its cycles.

    Raises ServoError.
    """

    def __init__(self, nc: Nc, plants: Sequence[Plant], axes: Sequence[PlantAxis]) -> None:
        """`plants` in the order of their steps."""
        self._plants = tuple(plants)
        self._axes = tuple(axes)
        links = [
            ServoLink(
                axis.axis_id,
                _entries(_INPUT_OBJECTS, number * _INPUTS.size, axis.velocity is None),
                _entries(_OUTPUT_OBJECTS, number * _OUTPUTS.size),
                axis.options,
            )
            for number, axis in enumerate(self._axes)
        ]
        count = len(self._axes)
        self._servos = Servos(nc, links, count * _INPUTS.size, count * _OUTPUTS.size)
        self._servo_of: dict[int, tuple[ServoView, Plant]] = {
            axis.axis_id: (servo, axis.plant)
            for axis, servo in zip(self._axes, self._servos.servos, strict=True)
        }

    def before(self) -> None:
        """Step the plants, and take what they say."""
        for plant in self._plants:
            plant.exchange()
        servos = self._servos
        image, outputs = servos.inputs, servos.outputs
        for number, (axis, servo) in enumerate(zip(self._axes, servos.servos, strict=True)):
            valid = not axis.plant.failure
            if valid:
                controlword, mode, *_ = _OUTPUTS.unpack_from(outputs, number * _OUTPUTS.size)
                _INPUTS.pack_into(
                    *(image, number * _INPUTS.size, statusword(controlword)),
                    *(wrapped(axis.counts()), mode, axis.counts_per_second()),
                )
            if servo.valid != valid:
                servos.connect(servo, valid)
        servos.take()

    def after(self) -> None:
        """Pass the set values of the NC to the plants."""
        servos = self._servos
        servos.send()
        for number, axis in enumerate(self._axes):
            controlword, _, *values = _OUTPUTS.unpack_from(servos.outputs, number * _OUTPUTS.size)
            enabled = statusword(controlword) & _FOLLOWING != 0
            if enabled:
                axis.put_command(*values)
            elif axis.config.interface is ServoMode.CSP:
                axis.plant.inputs[axis.command] = axis.plant.outputs[axis.position]
            else:
                axis.plant.inputs[axis.command] = 0.0
            if axis.enable is not None:
                axis.plant.inputs[axis.enable] = float(enabled)

    def many(self, count: int) -> int:
        """Cycles done together: none, the plants step in each."""
        return 0

    def missing_condition(self, axis_id: int) -> str:
        """Return the reason why an axis is not ready; empty if it is ready, or has no plant."""
        if axis_id not in self._servo_of:
            return ""
        servo, plant = self._servo_of[axis_id]
        if plant.failure:
            return f"its fmu {plant.name} has failed: {plant.failure}"
        return servo.missing_condition if servo.valid else "its fmu has not begun"

    def digest(self) -> bytes:
        """State of the servos."""
        return self._servos.digest()


def _entries(
    objects: Sequence[tuple[int, int, int]], begin: int, without_velocity: bool = False
) -> list[ProcessEntry]:
    return [
        ProcessEntry(index, begin + offset, size)
        for index, offset, size in objects
        if not (without_velocity and index == 0x606C)
    ]
