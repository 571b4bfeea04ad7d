"""Hardware: the simulated machines of an NC, built as its axes are set up at the start."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from achse.codes.nc.choices import AxisType, DriveType, StepperMode
from achse.motion.machine.amplifier import report
from achse.motion.machine.kernel import (
    ANALOG,
    DIGITAL,
    STEPPER,
    TWO_SPEEDS,
    HardwareRows,
    carry_out,
    write_inputs,
)
from achse.motion.machine.record import (
    AMPLIFIER,
    MACHINE,
    SENSOR,
    STEPPER_CYCLES,
    Amplifier,
    Machine,
    Sensor,
    amplifier_record,
    machine_record,
    sensor_record,
)
from achse.motion.machine.sensor import sense
from achse.motion.port import (
    DRIVE_IO,
    ENCODER_IO,
    DriveIo,
    EncoderIo,
    drive_io_record,
    encoder_io_record,
    wrapped,
)
from achse.motion.states import ANALOG_DRIVES
from achse.motion.views import Store, View

if TYPE_CHECKING:
    from achse.motion.axis import Axis
    from achse.motion.parts import AxisDrive

    class _Machine(View, Machine): ...

    class _Sensor(View, Sensor): ...

    class _Amplifier(View, Amplifier): ...

    class _EncoderIo(View, EncoderIo): ...

    class _DriveIo(View, DriveIo): ...

else:
    _Machine = _Sensor = _Amplifier = _EncoderIo = _DriveIo = View

_FULL_WORD = 0x7FFF_FFFF


class EncoderIoView(_EncoderIo):
    """The I/O structure of an encoder."""


class DriveIoView(_DriveIo):
    """The I/O structure of a drive."""


class MachineView(_Machine):
    """The machine of an axis: motor, load, what is along the way, the inputs it is wired to."""

    sensors: "list[SensorView]"
    amplifiers: "list[AmplifierView]"

    def changed(self, field: object) -> None:
        _wake(self)


class SensorView(_Sensor):
    """Counts of an encoder of the machine."""

    machine: MachineView
    io: EncoderIoView

    def changed(self, field: object) -> None:
        _wake(self.machine)

    @property
    def way(self) -> float:
        """Way of one increment, with the sign of the counting direction."""
        return -self.encoder_resolution if self.encoder_inverted else self.encoder_resolution


class AmplifierView(_Amplifier):
    """Reaction of a drive of the machine to its outputs."""

    machine: MachineView
    sensor: SensorView
    io: DriveIoView

    def changed(self, field: object) -> None:
        _wake(self.machine)


def _wake(machine: MachineView) -> None:
    if machine.resting:
        machine.resting = 0
    if machine.quiet_cycles or machine.fast_path or machine.adapt == 0:
        machine.quiet_cycles = 0
        machine.fast_path = 0
        machine.adapt = 1


class Hardware:
    """The simulated machines of some axes, one for each, with a sensor for each encoder and an
    amplifier for each drive; and the I/O structures they share with the NC."""

    def __init__(self, machines: int, sensors: int, amplifiers: int, *, compiled: bool) -> None:
        def store(base: type[View], layout: Any, fresh: type, count: int) -> Store:
            return Store(base, layout, fresh, count, compiled=compiled)

        self._machines = store(MachineView, MACHINE, machine_record, machines)
        self._sensors = store(SensorView, SENSOR, sensor_record, sensors)
        self._amplifiers = store(AmplifierView, AMPLIFIER, amplifier_record, amplifiers)
        encoder_ios = store(EncoderIoView, ENCODER_IO, encoder_io_record, sensors)
        drive_ios = store(DriveIoView, DRIVE_IO, drive_io_record, amplifiers)
        for sensor, encoder_io in zip(self._sensors.views, encoder_ios.views, strict=True):
            sensor.link("io", encoder_io)
        for amplifier, drive_io in zip(self._amplifiers.views, drive_ios.views, strict=True):
            amplifier.link("io", drive_io)
        self._stores = self._machines, encoder_ios, drive_ios  # whose memory must stay
        self._next_rows = 0, 0
        self._free = (
            iter(self._machines.views),
            iter(self._sensors.views),
            iter(self._amplifiers.views),
        )

    @property
    def arguments(self) -> tuple[Any, ...]:
        """Arguments of machine code for the rows."""
        stores = self._machines, self._sensors, self._amplifiers
        return tuple(argument for store in stores for argument in store.arguments)

    @property
    def rows(self) -> HardwareRows:
        """The rows for a kernel that runs as Python."""
        return HardwareRows(
            self._machines.arguments[0], self._sensors.arguments[0], self._amplifiers.arguments[0]
        )

    def records(self) -> Iterator[View]:
        """Yield all records, for a hash of the state."""
        for store in (*self._stores, self._sensors, self._amplifiers):
            yield from store.views

    def step(self, dt: float) -> None:
        """Apply the outputs in the structures for a cycle of `dt` seconds, then write the inputs.

        For a substitute of an NC; Python records only, without the curves of valves.
        """
        rows = self.rows
        for machine in rows.machines:
            carry_out(machine, rows, [], dt)
        for machine in rows.machines:
            write_inputs(machine, rows)

    def build(self, sensors: int, amplifiers: int) -> MachineView:
        """Return the next machine, with so many sensors and amplifiers."""
        machines, free_sensors, free_amplifiers = self._free
        machine: MachineView = next(machines)
        machine.sensors = [next(free_sensors) for _ in range(sensors)]
        machine.amplifiers = [next(free_amplifiers) for _ in range(amplifiers)]
        machine.first_sensor, machine.sensor_count = self._next_rows[0], sensors
        machine.first_amplifier, machine.amplifier_count = self._next_rows[1], amplifiers
        self._next_rows = self._next_rows[0] + sensors, self._next_rows[1] + amplifiers
        machine.several = int(sensors > 1 or amplifiers > 1)
        machine.link("sensor", machine.sensors[0])
        machine.link("amplifier", machine.amplifiers[0])
        for sensor in machine.sensors:
            sensor.link("machine", machine)
        for number, amplifier in enumerate(machine.amplifiers):
            amplifier.link("machine", machine)
            sensor = machine.sensors[min(number, sensors - 1)]
            amplifier.link("sensor", sensor)
            amplifier.number = number
        return machine


def fit(machine: MachineView, axis: "Axis") -> None:
    """Build the machine as the axis and its parts are set up now."""
    for sensor, encoder in zip(machine.sensors, axis.encoders, strict=True):
        sensor.encoder_resolution = encoder.scaling_factor
        sensor.encoder_inverted = encoder.count_direction
        sensor.encoder_mask = encoder.mask
        sensor.noise_state = axis.axis_id + 1
    for amplifier, drive in zip(machine.amplifiers, axis.drives, strict=True):
        _fit_output(amplifier, drive)
        _fit_weights(amplifier, drive)
        _fit_stepper(amplifier, axis, drive)
        if axis.axis_type == AxisType.DISCRETE_RAPID_CREEP:
            amplifier.kind = TWO_SPEEDS


def _fit_output(amplifier: AmplifierView, drive: "AxisDrive") -> None:
    amplifier.kind = ANALOG if drive.type in ANALOG_DRIVES else DIGITAL
    amplifier.full_velocity = drive.reference_velocity / drive.reference_output
    amplifier.full_output = drive.output_mask
    amplifier.motor_inverted = drive.motor_polarity
    amplifier.nonlinear = int(drive.type == DriveType.MDP_252_NONLINEAR)
    amplifier.quadrant_factor = drive.quadrant_compensation_factor or 1.0
    amplifier.knee_velocity = drive.velocity_reference_point
    amplifier.knee_output = drive.output_reference_point
    amplifier.position_loop = int(drive.type == DriveType.PROVIDRIVE_MC)


def _fit_weights(amplifier: AmplifierView, drive: "AxisDrive") -> None:
    increment = amplifier.sensor.encoder_resolution
    amplifier.position_weight = (drive.position_scaling or 1.0) / increment
    amplifier.velocity_weight = drive.velocity_scaling or 1.0
    amplifier.acceleration_weight = drive.acceleration_scaling
    amplifier.torque_offset_weight = drive.torque_offset_scaling
    amplifier.set_torque_weight = drive.set_torque_scaling
    amplifier.torque_weight = 1.0 / (drive.actual_torque_scaling or 1.0)
    amplifier.error_weight = drive.dsc_xerr_scaling / increment


def _fit_stepper(amplifier: AmplifierView, axis: "Axis", drive: "AxisDrive") -> None:
    if drive.type != DriveType.STEPPER:
        return
    amplifier.kind = STEPPER
    amplifier.step = axis.stepper_step_scaling
    counts = {StepperMode.TWO_PHASE: 4, StepperMode.ONE_TWO_PHASE: STEPPER_CYCLES}
    amplifier.mask_count = counts.get(StepperMode(axis.stepper_operation_mode), 0)
    for cycle in range(amplifier.mask_count):
        mask = getattr(drive, f"stepper_mask_cycle{cycle + 1}")
        amplifier.masks[cycle] = mask
        amplifier.mask_bits |= mask
    if amplifier.mask_count:
        amplifier.io.ctrl1 = amplifier.masks[0]


def begin_machine(machine: MachineView) -> None:
    """Let the hardware say what it is, before the first cycle."""
    for sensor in machine.sensors:
        sense(sensor)
    for amplifier in machine.amplifiers:
        report(amplifier)


def place_machine(machine: MachineView, position: float) -> None:
    """Put a machine there as if it had been when the power came on: its encoders count from 0."""
    machine.position = position
    for sensor in machine.sensors:
        sensor.zero = -position / sensor.way
    for amplifier in machine.amplifiers:
        amplifier.origin = -position


def count_from(sensor: SensorView, amplifier: AmplifierView, steps: int) -> None:
    """Have a drive count from another number: its encoder shows so many increments more."""
    sensor.zero += steps
    amplifier.origin += steps * sensor.way
    if sensor.io.state4 == 0:
        sensor.count += steps
        sensor.io.data_in1 = wrapped(sensor.io.data_in1 + steps)
