"""The record of a servo: the objects of the drive, what the axis requests, what is under way."""

from achse.motion.fields.declare import Field, flag, ints, real, whole
from achse.motion.port import DRIVE_IO, ENCODER_IO, DriveIo, EncoderIo
from achse.native.declare import lay_out, plain_record, reference

ENTRIES = 16
"""Objects that one direction of the process data may hold for the axis."""

PROBES = 2
"""Touch probes of a drive with this profile."""

_LEAST, _MOST = -(2**31), 2**31 - 1


class _Links:
    encoder: EncoderIo = reference(ENCODER_IO, Field)
    drive: DriveIo = reference(DRIVE_IO, Field)


class _Parameters:
    """Use of the drive; set when it is linked."""

    interface: int = whole(8, "ServoMode", "8 csp, 9 csv, 10 cst", 8, 10)
    inverted: int = flag(0, "the motor turns the other way round: its limit switches change places")
    follow_bit: int = flag(1, "bit 12 of the statusword says whether the drive follows")
    reached_bit: int = flag(1, "bit 10 of the statusword says whether a homing has ended")
    home_offset: int = whole(0, "INC", "607Ch: what the drive counts at its reference")
    velocity_gain: float = real(0.0, "‰/(INC/s)", "cst: P-part of the velocity loop", 0.0)
    velocity_integral: float = real(0.0, "1/s", "cst: 1 / reset time of the velocity loop", 0.0)
    torque_per_acceleration: float = real(0.0, "‰/(INC/s²)", "cst: feed-forward of the torque", 0.0)
    torque_limit: float = real(3000.0, "‰", "cst: largest torque", 0.0)
    fixed_dead_time: float = real(-1.0, "s", "set value to actual value; below 0: measured")
    mode_cycles: int = whole(0, "1", "cycles after which a mode is active that 6061h does not show")
    switch_cycles: int = whole(100, "1", "cycles in which a change of the mode must be over")
    reset_limit: int = whole(500, "1", "cycles for which a reset of the drive is tried")


class _Outputs:
    """Objects that go to the drive."""

    controlword: int = whole(0, "bits", "6040h")
    mode: int = whole(8, "ServoMode", "6060h")
    target_torque: int = whole(0, "‰", "6071h")
    target_position: int = whole(0, "INC", "607Ah")
    velocity_offset: int = whole(0, "INC/s", "60B1h")
    torque_offset: int = whole(0, "‰", "60B2h")
    probe_function: int = whole(0, "bits", "60B8h")
    target_velocity: int = whole(0, "INC/s", "60FFh")


class _Inputs:
    """Objects that come from the drive."""

    drive_alarm: int = whole(0, "1", "603Fh")
    statusword: int = whole(0, "bits", "6041h")
    mode_display: int = whole(0, "ServoMode", "6061h")
    position: int = whole(0, "INC", "6064h")
    velocity: int = whole(0, "INC/s", "606Ch")
    torque: int = whole(0, "‰", "6077h")
    probe_status: int = whole(0, "bits", "60B9h")
    probe1_rising: int = whole(0, "INC", "60BAh")
    probe1_falling: int = whole(0, "INC", "60BBh")
    probe2_rising: int = whole(0, "INC", "60BCh")
    probe2_falling: int = whole(0, "INC", "60BDh")
    digital_inputs: int = whole(0, "bits", "60FDh")


class _Mapping:
    """Objects in the process data, and their places."""

    valid: int = flag(0, "the inputs are fresh and the drive takes outputs: working counter and Op")
    absent: int = flag(0, "the bus has looked for the drive and has not found it")
    has_mode: int = flag(0, "6060h and 6061h are there: the mode can change")
    has_velocity: int = flag(0, "606Ch is there")
    can_position: int = flag(0, "607Ah is there")
    can_velocity: int = flag(0, "60FFh is there")
    can_torque: int = flag(0, "6071h is there")
    input_count: int = whole(0, "1", "entries that are read")
    input_at: list[int] = ints(ENTRIES, "byte", "where they begin in the inputs")
    input_size: list[int] = ints(ENTRIES, "byte", "their sizes; below 0 with a sign")
    input_word: list[int] = ints(ENTRIES, "word", "the fields of this record they are")
    output_count: int = whole(0, "1", "entries that are sent")
    output_at: list[int] = ints(ENTRIES, "byte", "where they begin in the outputs")
    output_size: list[int] = ints(ENTRIES, "byte", "their sizes")
    output_word: list[int] = ints(ENTRIES, "word", "the fields of this record they are")


class _State:
    """Pending changes."""

    power: int = whole(0, "1", "state of the power drive system, as in `achse.motion.servo.power`")
    following: int = flag(0, "the drive is enabled and takes set values")
    was_ready: int = flag(0, "it was ready in the cycle before")
    mode_wait: int = whole(0, "1", "cycles until a mode that 6061h does not show is active")
    mode_is_active: int = flag(0, "the drive works in the mode that it was sent")
    switching: int = whole(0, "1", "cycles that are left for a change of the mode")
    resetting: int = whole(0, "1", "cycles that are left for a reset, 0 = none is tried")
    homing_cycles: int = whole(0, "1", "cycles since the drive was commanded to home")
    position_before: int = whole(0, "INC", "position of the cycle before")
    target_before: int = whole(0, "INC", "target position of the cycle before")
    way_before: int = whole(0, "INC", "its way in that cycle")
    speed: float = real(0.0, "INC/s", "velocity of the motor")
    integral: float = real(0.0, "‰", "I-part of the velocity loop")
    dead_cycles: float = real(0.0, "1", "cycles by which the actual position is late, measured")
    probe_armed: list[int] = ints(PROBES, "bits", "byte of 60B8h that a probe works with")
    probe_taken: list[int] = ints(PROBES, "bits", "edges of it that were passed on")
    probe_homing: int = flag(0, "probe 1 looks for the sync pulse of a homing")


class Servo(_Links, _Parameters, _Outputs, _Inputs, _Mapping, _State):
    """One drive of a bus and the structures of its axis."""


SERVO = lay_out("servo", Servo.__bases__, Field)

servo_record = plain_record(SERVO)
