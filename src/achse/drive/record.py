"""The drive record: every value of one drive, declared once, all of them 64 bits wide.

`DriveFields` is the table; from it come a class with `__slots__` (`DriveSlots`), a layout in
memory (`LAYOUT`) and the static type of both, so that the kernel means the same on either form. A
list in a declaration is an array, copied for every record.

Positions of objects are in inc (user increments), those of motor and machine in counts of the inner
encoder, torques in thousandths of rated torque ("‰"), times in seconds, flags 0 or 1. An object
whose value is here names its field in its row (achse.drive.objects), with range and default.
"""

from collections.abc import Callable, Sequence
from functools import partial
from operator import attrgetter, itemgetter
from typing import TYPE_CHECKING, Any

from achse.native.declare import Slot, lay_out, plain_record
from achse.native.memory import RowView

ENTRIES = 8
"""Objects a PDO holds at most (001 §2.8.1)."""


class ParameterFields:
    """Objects that configure; defaults and ranges are in their rows."""

    quick_stop_option: int = 0
    shutdown_option: int = 0
    disable_operation_option: int = 0
    halt_option: int = 0
    fault_reaction_option: int = 0
    following_error_window: int = 0
    following_error_time_out: int = 0
    position_window: int = 0
    position_window_time: int = 0
    velocity_window: int = 0
    velocity_window_time: int = 0
    max_torque: int = 0
    home_offset: int = 0
    max_profile_velocity: int = 0
    profile_velocity: int = 0
    profile_acceleration: int = 0
    profile_deceleration: int = 0
    quick_stop_deceleration: int = 0
    torque_slope: int = 0
    homing_method: int = 0
    homing_speed_switch: int = 0
    homing_speed_zero: int = 0
    homing_acceleration: int = 0
    interpolation_value: int = 0
    interpolation_index: int = 0
    max_acceleration: int = 0
    max_deceleration: int = 0
    positive_torque_limit: int = 0
    negative_torque_limit: int = 0
    probe_error_map: int = 0
    position_trigger: int = 0
    overtravel_stop_mode: int = 0
    sync_error_limit: int = 0
    diagnosis_flags: int = 0  # bit 0: emergencies are sent
    gear_numerator: int = 0
    gear_denominator: int = 0
    velocity_loop_gain: int = 0  # 0.1 Hz
    velocity_loop_integral: int = 0  # 0.01 ms
    position_loop_gain: int = 0  # 0.1/s
    inertia_ratio: int = 0  # %
    feed_forward: int = 0  # %
    deviation_warning: int = 0  # % of deviation_alarm
    deviation_alarm: int = 0  # inc
    rotation_level: int = 0  # 1/min or mm/s


class InputFields:
    """Objects and signals that command."""

    controlword: int = 0
    mode_request: int = 0
    target_position: int = 0
    target_velocity: int = 0
    target_torque: int = 0
    velocity_offset: int = 0
    torque_offset: int = 0
    probe_function: int = 0
    physical_outputs: int = 0
    output_mask: int = 0
    yaw_target: int = 0
    gantry_command: int = 0
    encoder_clear_command: int = 0
    reset_command: int = 0
    store_command: int = 0
    general_i1: int = 0
    general_i2: int = 0
    general_i3: int = 0
    general_i4: int = 0
    general_i5: int = 0
    general_i6: int = 0
    general_i7: int = 0
    general_i8: int = 0
    general_i9: int = 0
    general_f0: float = 0.0
    general_f1: float = 0.0
    general_f2: float = 0.0
    general_f3: float = 0.0
    general_f4: float = 0.0

    communication: int = 1  # AlState
    fresh_outputs: int = 0  # process data has come since the last step
    communication_cycle: float = 0.001  # s
    sync_type: int = 0  # 0 FreeRun, 2 DC with Sync0
    sync_cycle: int = 250000  # ns
    cycle_too_small: int = 0
    main_power: int = 1
    safety_1: int = 1  # SF1, SF2: both 0 is STO
    safety_2: int = 1
    inputs_on: int = 0  # bits of 60FDh forced on
    inputs_off: int = 0  # bits of 60FDh forced off
    probe_input: int = 0  # EXT-PROBE1, beside the machine's probe
    encoder_fault: int = 0  # error code while the encoder does not answer
    alarm_forced: int = 0  # error code of a cause that stays
    alarm_request: int = 0  # error code to raise once
    warnings_forced_1: int = 0
    warnings_forced_2: int = 0
    jammed: int = 0  # the machine is blocked
    external_load: float = 0.0  # ‰, against the positive direction
    yaw_alarm: int = 0


class StateFields:
    """Objects the drive reports."""

    error_code: int = 0
    error_register: int = 0
    present_alarm: int = 0
    statusword: int = 0
    mode_display: int = 0
    position_demand: int = 0
    position_internal: int = 0
    position_actual: int = 0
    velocity_demand: int = 0
    velocity_actual: int = 0
    torque_demand: int = 0
    torque_actual: int = 0
    probe_status: int = 0
    probe_positive: int = 0
    probe_negative: int = 0
    probe_2_positive: int = 0
    following_error: int = 0
    position_demand_internal: int = 0
    digital_inputs: int = 0
    digital_outputs: int = 0
    warnings_1: int = 0
    warnings_2: int = 0
    software_state: int = 0
    yaw_feedback: int = 0
    encoder_clear_state: int = 0
    reset_state: int = 0


class ControlFields:
    """Power state machine, supervision and status bits."""

    power_state: int = 0
    transition: int = 0  # number of the last one
    previous_controlword: int = 0
    standing: int = 1  # a stop has come to its end
    stop_time: float = 0.0  # s, since the set velocity of a stop is 0
    stop_deceleration: float = 0.0  # inc/s², of the quick stop, halt or fault reaction that runs
    alarm_count: int = 0
    reset_count: int = 0
    communication_lost: int = 0  # Op was left while enabled; until Op is back
    safety_mismatch_time: float = 0.0
    thermal_load: float = 0.0  # ‰·‰·s above rated torque
    deviation_exceeded: int = 0
    service_request: int = 0  # work for the drive outside the kernel
    commands: int = 0  # bit 0 3215h, bit 1 3200h as process data have them
    target_reached: int = 0
    bit_12: int = 0
    bit_13: int = 0
    following_error_time: float = 0.0
    window_time: float = 0.0
    in_window: int = 0
    velocity_window_seen: float = 0.0
    positive_overtravel: int = 0
    negative_overtravel: int = 0
    overtravel_stop: int = 0
    speed_exceeded: int = 0  # csp: the target exceeds the capability of the motor


class MotionFields:
    """Set points of the modes, touch probe and gantry."""

    demand: float = 0.0  # inc, not wrapped
    demand_velocity: float = 0.0  # inc/s
    demand_torque: float = 0.0  # ‰
    control: int = 0  # 0 off, 1 position, 2 velocity, 3 torque
    interpolation_rest: float = 0.0  # s until the target is reached
    interpolation_age: float = 0.0  # s since process data came

    plan_count: int = 0
    plan_index: int = 0
    plan_elapsed: float = 0.0
    plan_target: float = 0.0
    plan_end_velocity: float = 0.0
    plan_time: list[float] = [0.0] * 4
    plan_acceleration: list[float] = [0.0] * 4

    setpoint_active: int = 0
    setpoint_planned: int = 0
    setpoint_acknowledge: int = 0
    setpoint_target: float = 0.0
    setpoint_velocity: float = 0.0
    setpoint_passed: int = 0  # the running set point is passed at speed
    setpoint_latest: float = 0.0  # target of the set point accepted last
    buffer_count: int = 0
    buffer_target: list[float] = [0.0] * 2
    buffer_velocity: list[float] = [0.0] * 2
    buffer_pass: list[int] = [0] * 2

    homing_phase: int = 0
    homing_running: int = 0
    homing_attained: int = 0
    homing_error: int = 0
    homing_switch: int = 0
    homing_forward: int = 0
    homing_final: int = 0
    homing_level: int = 0
    homing_seen: int = 0

    probe_level: int = 0
    error_map_updates: int = 0

    gantry_link: int = 0
    gantry_active: int = 0
    yaw_position: float = 0.0
    yaw_homed: int = 0
    yaw_regulated: int = 0
    gantry_previous: int = 0
    gantry_state: int = 0  # bits 5 to 13 of 3056h
    idle_at: float = -1e300  # where the set point was put while off


class PlantFields:
    """Motor, load, encoder and machine; set from the configuration (achse.drive.machine)."""

    voltage_bit: int = 0  # statusword bit 4 while main power is normal
    dual_loop: int = 0
    absolute: int = 0  # 0 incremental, 1 single-turn, 2 multi-turn
    has_brake: int = 0
    brake_engaged: int = 0
    output_functions: int = 0  # 4 bits for each of O1..O5 (signals.OutputFunction)

    rated_current: int = 0  # mA
    rated_torque: int = 0  # mNm
    motor_type: int = 0
    encoder_resolution: int = 0
    peak_torque: float = 0.0  # ‰
    max_velocity: float = 0.0  # counts/s
    acceleration_gain: float = 0.0  # counts/s² per ‰, motor with load
    velocity_gain: float = 0.0  # ‰ per count/s
    torque_time: float = 0.0  # s, time constant of the torque loop
    coulomb: float = 0.0  # ‰
    viscous: float = 0.0  # ‰ per count/s
    gravity: float = 0.0  # ‰ in negative direction
    thermal_limit: float = 0.0  # ‰·‰·s
    counts_per_inc: float = 1.0
    inc_per_count: float = 1.0
    standstill: float = 0.0  # counts/s
    index_pitch: float = 0.0  # counts
    index_offset: float = 0.0
    index_width: float = 0.0
    negative_stop: float = -1e300  # counts of the machine
    positive_stop: float = 1e300
    negative_limit: float = -1e300
    positive_limit: float = 1e300
    negative_limit_assigned: int = 0
    positive_limit_assigned: int = 0
    home_assigned: int = 0
    home_from: float = 0.0
    home_to: float = 0.0
    probe_assigned: int = 0
    probe_from: float = 0.0
    probe_to: float = 0.0
    scale_ratio: float = 1.0  # counts of the external scale per count of the inner encoder

    motor_position: float = 0.0  # counts of the machine
    motor_velocity: float = 0.0  # counts/s
    motor_torque: float = 0.0  # ‰
    previous_position: float = 0.0
    encoder_zero: int = 0  # count of the machine that 6063h calls 0
    active_home_offset: int = 0  # inc
    reference: float = 0.0  # counts of the machine
    reference_velocity: float = 0.0  # counts/s
    velocity_integral: float = 0.0  # counts/s
    torque_command: float = 0.0  # ‰
    torque_limited: int = 0
    substeps: int = 1
    step_time: float = 0.0
    torque_response: float = 0.0  # share of a torque step reached within one substep


class ExchangeFields:
    """Process data and their mapping, for the compiled kernel (achse.drive.exchange)."""

    postponed: int = 0  # a step is to be done
    postponed_cycles: int = 0
    postponed_time: float = 0.0  # s, of each cycle
    outputs_came: int = 0
    received_count: int = 0
    received_word: list[int] = [0] * ENTRIES  # where the value goes
    received_at: list[int] = [0] * ENTRIES  # byte of the PDO
    received_size: list[int] = [0] * ENTRIES  # bytes, negative if signed
    sent_count: int = 0
    sent_word: list[int] = [0] * ENTRIES
    sent_at: list[int] = [0] * ENTRIES
    sent_size: list[int] = [0] * ENTRIES
    outputs: list[int] = [0] * 4  # 32 bytes
    inputs: list[int] = [0] * 4


class DriveFields(
    ParameterFields,
    InputFields,
    StateFields,
    ControlFields,
    MotionFields,
    PlantFields,
    ExchangeFields,
):
    """All fields of a drive, in the order of the record."""


LAYOUT = lay_out("drive record", DriveFields.__bases__, Slot)
"""One record in memory."""

FIELDS = LAYOUT.fields
"""Every field by name, in record order."""

if TYPE_CHECKING:

    class DriveSlots(DriveFields):
        pass

else:
    DriveSlots = plain_record(LAYOUT)


def collector(record: Any, fields: Sequence[str]) -> Callable[[], tuple[Any, ...]]:
    """Return a function that reads these fields, in this order, as fast as the form allows."""
    words = _words(record, fields)
    if len(fields) < 2:
        return lambda: tuple(getattr(record, name) for name in fields)
    if words is None:
        return partial(attrgetter(*fields), record)
    return partial(itemgetter(*(FIELDS[name].offset for name in fields)), words)


def distributor(record: Any, fields: Sequence[str]) -> Callable[[tuple[Any, ...]], None]:
    """Return a function that writes these fields, in this order."""
    words = _words(record, fields)
    offsets = tuple(FIELDS[name].offset for name in fields)

    def set_words(values: tuple[Any, ...]) -> None:
        for offset, value in zip(offsets, values, strict=True):
            words[offset] = value

    def set_fields(values: tuple[Any, ...]) -> None:
        for name, value in zip(fields, values, strict=True):
            setattr(record, name, value)

    return set_fields if words is None else set_words


def _words(record: Any, fields: Sequence[str]) -> Any:
    """Return the record as 64-bit words, if it is in memory and the fields are whole numbers."""
    whole = not any(FIELDS[name].is_real for name in fields)
    return record.ints if whole and isinstance(record, RowView) else None
