"""Fields of a drive: parameters, requests of functions, output."""

from achse.motion.fields.declare import (
    Inputs,
    InternalFields,
    Parameters,
    States,
    flag,
    floats,
    ints,
    real,
    whole,
)

DRIVE_DELAY = 64
"""Longest delay of an output, in cycles; also that of the output filter."""

FILTER_ORDER = 10
"""Highest order of the output filter."""


class DriveParameters(Parameters):
    """Parameters of the drive (002 §6.4.7.1, 0x7000 + ID)."""

    motor_polarity: int = flag(0, "motor turns the other way round")
    reference_velocity: float = real(2200.0, "mm/s", "velocity at the reference output", 1e-3, 1e20)
    reference_output: float = real(1.0, "1", "output at the reference velocity", 1e-6, 5.0)
    output_limit_min: float = real(-1.0, "1", "lowest output", -1.0, 1.0)
    output_limit_max: float = real(1.0, "1", "highest output", -1.0, 1.0)
    type: int = whole(5, "DriveType", "kind of drive", 1, 24)
    mode: int = whole(1, "1", "mode of the drive, 1 = standard", 1, 1)
    input_address_offset: int = whole(0, "byte", "place in the I/O input image")
    output_address_offset: int = whole(0, "byte", "place in the I/O output image")
    output_mask: int = whole(0x7FFF_FFFF, "INC", "largest output in increments", 1)
    control_dword: int = whole(0, "bits", "operation modes of the drive")
    reset_counter: int = whole(5, "1", "cycles of a reset", 5)
    dead_time_compensation_mode: int = whole(
        0, "DeadTimeCompensation", "what extrapolates the position output", 0, 2
    )
    dead_time_compensation_control: int = whole(0, "bits", "bit 0: absolute I/O times")
    dead_time_compensation_shift: int = whole(
        0, "ns", "dead time of the drive", -1_000_000_000, 1_000_000_000
    )
    actual_torque_scaling: float = real(1.0, "%/INC", "actual torque of one increment", -1e30, 1e30)
    actual_torque_filter_time: float = real(0.0, "s", "PT1 filter of the actual torque", 0.0, 60.0)
    actual_torque_derivative_filter_time: float = real(
        0.0, "s", "PT1 filter of the torque derivative", 0.0, 60.0
    )
    velocity_offset: float = real(0.0, "mm/s", "added to the output against drift")
    velocity_scaling: float = real(1.0, "1", "weight of the velocity output", 0.0, 1e8)
    dsc_kpc: int = whole(
        0, "0.001/s", "gain of the position loop in a PROFIdrive, 0 = none; the NC then has none"
    )
    dsc_xerr_scaling: float = real(1.0, "1", "weight of the position error output", 0.0)
    position_scaling: float = real(1.0, "1", "weight of the position output", 0.0, 1e8)
    acceleration_scaling: float = real(1.0, "1", "weight of the acceleration output", 0.0, 1e8)
    torque_offset_scaling: float = real(1.0, "1", "weight of the torque offset", 0.0, 1e8)
    set_torque_scaling: float = real(1.0, "1", "weight of the set torque", 0.0, 1e8)
    velocity_output_delay: float = real(0.0, "s", "delay of the velocity output", 0.0, 1.0)
    acceleration_output_delay: float = real(0.0, "s", "delay of the acceleration output", 0.0, 1.0)
    torque_output_delay: float = real(0.0, "s", "delay of the torque output", 0.0, 1.0)
    output_filter_type: int = whole(0, "OutputFilter", "filter of the position output", 0, 2)
    output_filter_time: float = real(0.0, "s", "its time, 64 cycles at most", 0.0, 1.0)
    output_filter_order: int = whole(1, "1", "its order", 0, FILTER_ORDER)
    table_id: int = whole(0, "1", "characteristic table, 0 = none")
    table_interpolation_type: int = whole(
        0, "CharacteristicInterpolation", "how its points are joined", 0, 2
    )
    output_offset: float = real(0.0, "1", "added after the characteristic", -1.0, 1.0)
    quadrant_compensation_factor: float = real(
        1.0, "1", "output in quadrant III of that in quadrant I", 0.0, 100.0
    )
    velocity_reference_point: float = real(
        1.0, "1", "velocity at the knee of the characteristic", 0.01, 1.0
    )
    output_reference_point: float = real(
        1.0, "1", "output at the knee of the characteristic", 0.01, 1.0
    )
    stepper_mask_cycle1: int = whole(0b0001, "bits", "control byte in cycle 1", 0, 255)
    stepper_mask_cycle2: int = whole(0b0100, "bits", "control byte in cycle 2", 0, 255)
    stepper_mask_cycle3: int = whole(0b0010, "bits", "control byte in cycle 3", 0, 255)
    stepper_mask_cycle4: int = whole(0b1000, "bits", "control byte in cycle 4", 0, 255)
    stepper_mask_cycle5: int = whole(0, "bits", "control byte in cycle 5", 0, 255)
    stepper_mask_cycle6: int = whole(0, "bits", "control byte in cycle 6", 0, 255)
    stepper_mask_cycle7: int = whole(0, "bits", "control byte in cycle 7", 0, 255)
    stepper_mask_cycle8: int = whole(0, "bits", "control byte in cycle 8", 0, 255)
    stepper_mask_holding_current: int = whole(
        0, "bits", "further bits of the control byte at rest", 0, 255
    )


class DriveInterface(Parameters):
    """Configured knowledge of the drive beyond its type; no service."""

    simulation_ideal: int = flag(0, "the drive takes positions, whatever its type and controller")
    homed_by_drive: int = flag(0, "a drive on a bus homes the axis itself")


class DriveInput(Inputs):
    """Requests of functions to the drive."""

    drive_operation_mode: int = whole(0, "DriveOperationMode", "operation mode of the drive", 0)
    set_torque: float = real(0.0, "1000 = 100 %", "set torque in torque mode")
    set_torque_derivative: float = real(0.0, "1000 = 100 %/s", "its change")
    set_torque_offset: float = real(0.0, "1000 = 100 %", "torque added by feed-forward")


class DriveState(States):
    """Output to the drive (002 §6.4.7.2, 0x7100 + ID)."""

    output: float = real(0.0, "mm/s", "total output to the drive")
    limit_active: int = flag(0, "the output is at a limit")
    output_peak_negative: float = real(0.0, "mm/s", "smallest total output so far")
    output_peak_positive: float = real(0.0, "mm/s", "largest total output so far")
    output_percent_nonlinear: float = real(0.0, "%", "total output after the characteristic")
    output_image: list[int] = ints(
        10, "bits", "output structure in words of 4 bytes, beneath what the NC writes itself"
    )
    actual_torque: float = real(0.0, "1000 = 100 %", "actual torque, filtered")
    actual_torque_derivative: float = real(0.0, "1000 = 100 %/s", "its change")
    dead_time_position_correction: float = real(0.0, "mm", "way of the dead-time compensation")
    filtered_set_position: float = real(0.0, "mm", "set position after the output filter")
    filtered_set_velocity: float = real(0.0, "mm/s", "its velocity")
    filtered_set_acceleration: float = real(0.0, "mm/s²", "its acceleration")
    control_byte: int = whole(0, "bits", "control byte to a discrete drive", 0, 255)
    extended_control_byte: int = whole(0, "bits", "extended control byte", 0, 255)


class DriveInternal(InternalFields):
    """Memory of the drive: values from its parameters, and values from cycle to cycle."""

    on_bus: int = flag(0, "it is process data of a bus, not a simulated amplifier")
    reset_cycles: int = whole(0, "1", "remaining cycles of the reset request")
    special: int = flag(0, "more than a linear velocity drive is in use")
    ideal: int = flag(0, "the drive takes positions and follows them")
    digital: int = flag(0, "the outputs are weighted set values, not a share of full output")
    adapted_mode: int = whole(0, "DriveOperationMode", "operation mode this is derived for")
    delay: int = whole(0, "1", "cycles by which the velocity output is late")
    dsc_gain: float = real(0.0, "1/s", "gain of a position loop in the drive, 0 = none")
    torque_weight: float = real(1.0, "1", "share of a new torque in the filtered one")
    torque_rate_weight: float = real(1.0, "1", "share of a new change of it in the filtered one")
    full: float = real(2200.0, "mm/s", "velocity at 100 % output")
    signal_before: int = flag(0, "fast-stop signal of the cycle before")
    io_time: float = real(0.0, "s", "time without valid I/O data")
    curve_first: int = whole(0, "1", "first span of the characteristic's curve")
    curve_count: int = whole(0, "1", "its spans, 0 = no table")
    filter_count: int = whole(0, "1", "entries of the moving average")
    filter_stage: list[float] = floats(FILTER_ORDER, "mm", "stages of the output filter")
    filter_ring: list[float] = floats(DRIVE_DELAY, "mm", "set positions of the moving average")
    filter_index: int = whole(0, "1", "its oldest entry")
    stepper_step: int = whole(0, "STEP", "steps of the motor")
    stepper_wait: int = whole(0, "1", "cycles to the next step")
    stepper_level: int = whole(0, "1", "cycles per step")
    stepper_level_steps: int = whole(0, "STEP", "steps since the level changed")
    switch_phase: int = whole(0, "1", "phase of a rapid/creep movement")
    switch_direction: float = real(0.0, "1", "its direction")
    switch_start: float = real(0.0, "mm", "where its stop began")
    switch_time: float = real(0.0, "s", "time in that phase")
    sent_position: float = real(0.0, "mm", "set position of the last output, before its filter")
    delay_index: int = whole(0, "1", "next slot of the delay line")
    delay_output: list[float] = floats(DRIVE_DELAY, "mm/s", "velocity outputs that are late")
