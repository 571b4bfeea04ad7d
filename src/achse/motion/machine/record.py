"""The records of a simulated machine: the machine of an axis, its sensors, its amplifiers.

The names in a configuration begin with `simulation_`; they belong to no service. What a sensor or
an amplifier is (resolution, direction, weights) is what the axis is set to at the start, unless the
configuration says otherwise; from then on nothing that is written to the NC changes the machine.
Places are in axis units, in the direction of the axis, from where its encoder counted 0 at first.
"""

from achse.motion.fields.declare import Field, Role, flag, floats, ints, real, whole
from achse.motion.fields.often import OFTEN
from achse.motion.port import DRIVE_IO, ENCODER_IO, DriveIo, EncoderIo
from achse.native.declare import lay_out, plain_record, reference

DEAD_TIME = 64
"""Longest dead time of an amplifier, in cycles."""

STEPPER_CYCLES = 6
"""Excitations of a stepper motor, at most."""


class MachineParameters:
    """Motor, load, what is along the way, and the inputs it is wired to; one for each axis."""

    blocked: int = flag(0, "the motor is stuck (fault injection)")
    not_ready: int = flag(0, "the drive reports not ready (fault injection)")
    io_invalid: int = flag(0, "I/O data are invalid (fault injection)")
    drive_inputs: int = whole(0, "bits", "digital inputs 1..8 of the drive", 0, 255)
    fast_stop_signal: int = flag(0, "bit 7 of drive status 4")
    full_torque_acceleration: float = real(20_000.0, "mm/s²", "acceleration at 100 % torque", 1e-3)
    load_torque: float = real(0.0, "1000 = 100 %", "load against positive movement")
    friction_torque: float = real(0.0, "1000 = 100 %", "friction while moving", 0.0)
    limit_min: float = real(
        -1e15, "mm", "from where on a hardware limit switch blocks the drive, negative direction"
    )
    limit_max: float = real(
        1e15, "mm", "from where on a hardware limit switch blocks the drive, positive direction"
    )
    period: float = real(
        0.0,
        "mm",
        "way after which the machine repeats itself, as a rotary table does; 0 = never",
        0.0,
    )
    cam_begin: float = real(
        -1e6, "mm", "where the reference cam begins; none if that is after its end"
    )
    cam_end: float = real(-50.0, "mm", "where the reference cam ends")
    cam_input: int = whole(
        0, "1", "digital input of the drive the cam is wired to, 0 = that of the encoder", 0, 8
    )
    mark_begin: float = real(100.0, "mm", "where the probe mark begins")
    mark_end: float = real(110.0, "mm", "where the probe mark ends")
    mark_input: int = whole(0, "1", "digital input of the drive that sees the mark, 0 = none", 0, 8)
    latch_source: int = whole(
        128, "SignalSource", "what the drive itself latches on: input 1..8, 128 index pulse", 1, 128
    )


class _MachineState:
    """Place and motion of the motor."""

    position: float = real(0.0, "mm", "where the machine is")
    velocity: float = real(0.0, "mm/s", "how fast it moves")
    torque: float = real(0.0, "1000 = 100 %", "torque of the motor")
    driver: int = whole(0, "1", "number of the drive that moves it")
    limit_switch: int = whole(0, "1", "hardware limit switch it is on: -1, 0 none, 1", -1, 1)
    resting: int = flag(0, "nothing moves until an output or a parameter changes")
    quiet_cycles: int = whole(0, "1", "cycles without a movement")
    adapt: int = flag(1, "something about it has changed: derived values must be computed again")
    fast_path: int = flag(0, "it is a motor without load, one drive and one encoder without noise")
    several: int = flag(0, "it has more than one sensor or amplifier, or is on a bus")
    on_bus: int = flag(0, "a bus fills the structures of its axis instead")
    first_sensor: int = whole(0, "1", "row of its first sensor, the others are behind it")
    sensor_count: int = whole(0, "1", "its sensors")
    first_amplifier: int = whole(0, "1", "row of its first amplifier, the others are behind it")
    amplifier_count: int = whole(0, "1", "its amplifiers")


class SensorParameters:
    """Parameters of a sensor, one for each encoder."""

    encoder_resolution: float = real(1e-4, "mm/INC", "way of one increment", 1e-12, 1e30)
    encoder_inverted: int = flag(0, "it counts down in positive direction")
    encoder_mask: int = whole(0xFFFF_FFFF, "INC", "largest count, then it begins at 0 again", 1)
    turn: float = real(
        65_536.0, "INC", "increments per motor turn, with one index pulse", 1.0, 1e12
    )
    index_position: float = real(0.0, "INC", "count at an index pulse")
    noise: float = real(0.0, "INC", "amplitude of the noise on the count", 0.0, 1e6)


class _SensorState:
    """Its count, and the latches."""

    zero: float = real(0.0, "INC", "count at the zero of the machine")
    count: int = whole(0, "INC", "count, without overflow")
    noise_state: int = whole(0, "1", "state of the noise, 0 = not begun")
    watching: int = flag(0, "a latch waits")
    before: float = real(0.0, "mm", "where the machine was a cycle before, for the latches")
    inputs_before: int = whole(0, "bits", "digital inputs a cycle before, for the latches")


class AmplifierParameters:
    """Parameters of an amplifier, one for each drive."""

    time_constant: float = real(0.004, "s", "first-order lag of the velocity", 0.0, 10.0)
    dead_time: float = real(0.0, "s", "delay from output to drive, 64 cycles at most", 0.0, 1.0)
    drift: float = real(0.0, "mm/s", "velocity of the drive at output 0")
    creep_velocity: float = real(
        0.1, "1", "creep velocity of a two-speed drive, of its rapid one", 1e-3, 1.0
    )
    table_id: int = whole(
        0, "1", "characteristic of the valve, output to velocity; 0 = the inverse of the NC's", 0
    )
    full_velocity: float = real(2200.0, "mm/s", "velocity at full output", 1e-12, 1e30)
    full_output: int = whole(0x7FFF_FFFF, "INC", "full output", 1)
    motor_inverted: int = flag(0, "a positive output moves in negative direction")
    position_weight: float = real(1e4, "INC/mm", "position output of one unit", 1e-30, 1e30)
    velocity_weight: float = real(1e4, "INC/(mm/s)", "velocity output of one unit", 1e-30, 1e30)
    acceleration_weight: float = real(1.0, "INC/(mm/s²)", "acceleration output of one unit", 0.0)
    torque_offset_weight: float = real(1.0, "INC", "torque offset of 1/1000", 0.0)
    set_torque_weight: float = real(1.0, "INC", "set torque of 1/1000", 0.0)
    torque_weight: float = real(1.0, "INC", "actual torque of 1/1000")
    error_weight: float = real(1e4, "INC/mm", "following error of one unit", 0.0)
    step: float = real(0.01, "mm", "way of one step of a stepper motor", 1e-9, 1e6)
    quadrant_factor: float = real(
        1.0, "1", "non-linear drive: output in quadrant III of that in quadrant I", 0.0, 100.0
    )
    knee_velocity: float = real(1.0, "1", "non-linear drive: velocity at the knee", 0.01, 1.0)
    knee_output: float = real(1.0, "1", "non-linear drive: output at the knee", 0.01, 1.0)


class _AmplifierState:
    """Structure of the drive, and its pending changes."""

    kind: int = whole(0, "1", "0 digital, 1 analog, 2 two speeds, 3 stepper")
    position_loop: int = flag(0, "it closes the position loop with a gain from the NC (PROFIdrive)")
    nonlinear: int = flag(0, "it undoes the characteristic of a non-linear drive")
    valve_first: int = whole(0, "1", "first span of the curve of the valve")
    valve_count: int = whole(0, "1", "its spans, 0 = none")
    valve_inverse: int = flag(0, "the curve goes from velocity to output")
    masks: list[int] = ints(STEPPER_CYCLES, "bits", "excitations of a stepper motor in turn")
    mask_count: int = whole(0, "1", "excitations in turn, 0 = it takes a frequency")
    mask_bits: int = whole(0, "bits", "all bits of the excitations")
    reported_control: int = whole(0, "bits", "control 1 when the state was reported last")
    origin: float = real(0.0, "mm", "position output at the zero of the machine")
    number: int = whole(0, "1", "number among the drives of the axis")
    mode: int = whole(0, "DriveOperationMode", "operation mode in force")
    delay: int = whole(0, "1", "cycles from output to drive")
    delay_index: int = whole(0, "1", "next slot of the dead-time line")
    delayed: list[float] = floats(DEAD_TIME, "1", "outputs under way to the drive")
    step_index: int = whole(0, "1", "excitation of the present step, or level of the frequency")
    step_cycles: int = whole(0, "1", "cycles since the last step")
    step_interval: int = whole(0, "1", "cycles between the last two steps")
    limited: int = flag(0, "the velocity is at a limit of the torque command")
    delays: int = flag(0, "outputs take their time to the drive")
    loads: int = flag(0, "load, friction, drift or a position loop in the drive")
    lag_weight: float = real(1.0, "1", "share of the way to its command that it goes in a cycle")
    torque_scale: float = real(20.0, "mm/s²", "acceleration of 1/1000 of the full torque")


class _MachineLinks:
    sensor: "Sensor" = Field(0)  # type: ignore[assignment]  # refers to what comes below
    amplifier: "Amplifier" = Field(0)  # type: ignore[assignment]


class Machine(_MachineLinks, MachineParameters, _MachineState):
    """The simulated machine of one axis; it refers to the first of its sensors and amplifiers."""


MACHINE = lay_out("machine", Machine.__bases__, Field, OFTEN["machine"], whole_lines=True)


class _SensorLinks:
    io: EncoderIo = reference(ENCODER_IO, Field)
    machine: Machine = reference(MACHINE, Field)


class Sensor(_SensorLinks, SensorParameters, _SensorState):
    """An encoder of the simulated machine."""


SENSOR = lay_out("sensor", Sensor.__bases__, Field, OFTEN["sensor"], whole_lines=True)


class _AmplifierLinks:
    io: DriveIo = reference(DRIVE_IO, Field)
    machine: Machine = reference(MACHINE, Field)
    sensor: Sensor = reference(SENSOR, Field)


class Amplifier(_AmplifierLinks, AmplifierParameters, _AmplifierState):
    """A drive of the simulated machine."""


AMPLIFIER = lay_out("amplifier", Amplifier.__bases__, Field, OFTEN["amplifier"], whole_lines=True)

MACHINE.fields["sensor"].refers = SENSOR
MACHINE.fields["amplifier"].refers = AMPLIFIER

machine_record = plain_record(MACHINE)
sensor_record = plain_record(SENSOR)
amplifier_record = plain_record(AMPLIFIER)

PARTS = {"machine": MachineParameters, "sensor": SensorParameters, "amplifier": AmplifierParameters}
"""Parts of a machine, and the parameters of each."""

PARAMETERS: dict[str, tuple[str, Field]] = {}
"""Parameters by their name in a configuration: the part they are of, and their field."""

for _layout, (_part, _section) in zip((MACHINE, SENSOR, AMPLIFIER), PARTS.items(), strict=True):
    for _name in _section.__annotations__:
        _layout.fields[_name].role = Role.PARAMETER
        PARAMETERS[f"simulation_{_name}"] = _part, _layout.fields[_name]

PARAMETERS["encoder_simulation_noise_scaling"] = PARAMETERS["simulation_noise"]
"""The one that a service of the NC sets (0x5000:0x110)."""
