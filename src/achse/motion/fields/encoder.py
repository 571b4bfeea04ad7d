"""Fields of an encoder: parameters, actual values, touch probes."""

from achse.motion.fields.declare import (
    InternalFields,
    Parameters,
    States,
    flag,
    floats,
    ints,
    real,
    whole,
)

POSITION_HISTORY = 16
"""Actual positions with time stamp that are stored; fewer cycles than lead to rest."""

TOUCH_PROBES = 4

PROBE_EDGES = 2 * TOUCH_PROBES
"""Rising edges of all touch probes, then their falling ones."""


class EncoderParameters(Parameters):
    """Parameters of the encoder (002 §6.4.5.1, 0x5000 + ID)."""

    scaling_factor: float = real(1e-4, "mm/INC", "distance of one increment", 1e-12, 1e30)
    scaling_numerator: float = real(1e-4, "mm/INC", "its numerator", 1e-12, 1e30)
    scaling_denominator: float = real(1.0, "1", "its denominator", 1e-12, 1e30)
    type: int = whole(1, "EncoderType", "kind of encoder", 1, 28)
    mode: int = whole(3, "EncoderMode", "what the encoder determines", 1, 3)
    input_address_offset: int = whole(0, "byte", "place in the I/O input image")
    output_address_offset: int = whole(0, "byte", "place in the I/O output image")
    evaluation_direction: int = whole(
        0, "EncoderEvaluationDirection", "counting directions that are evaluated", 0, 3
    )
    mask: int = whole(0xFFFF_FFFF, "INC", "largest count, then it starts at 0 again", 1)
    raw_value_filter_mask: int = whole(0, "bits", "bits of the count that are masked out")
    reference_system: int = whole(
        0, "EncoderReferenceSystem", "how the count becomes a position", 0, 2
    )
    sign_interpretation: int = whole(0, "EncoderSignInterpretation", "sign of the count", 0, 2)
    actual_position_correction_enable: int = flag(0, "the position correction is added")
    actual_position_correction_filter_time: float = real(
        0.0, "s", "PT1 filter of the position correction", 0.0, 60.0
    )
    dead_time_compensation_mode: int = whole(
        0, "DeadTimeCompensation", "what extrapolates the actual position", 0, 2
    )
    dead_time_compensation_control: int = whole(0, "bits", "bit 0: absolute I/O times")
    dead_time_compensation_shift: int = whole(
        0, "ns", "dead time of the encoder", -1_000_000_000, 1_000_000_000
    )
    control_dword: int = whole(0, "bits", "operation modes of the encoder")
    homing_cam_search_inverse: int = flag(1, "the cam is searched in negative direction")
    sync_pulse_search_inverse: int = flag(0, "the sync pulse is searched in negative direction")
    reference_position: float = real(0.0, "mm", "position of the reference mark", -1e9, 1e9)
    external_sync_pulse: int = flag(0, "the sync pulse is input 1 instead of the index")
    reference_mode: int = whole(1, "ReferenceMode", "what ends the homing sequence")
    sub_mask: int = whole(0xFFFF, "INC", "range within which the count is absolute, less 1", 0xF)
    homing_sensor_source: int = whole(
        0, "HomingSensorSource", "where the homing cam comes from", 0, 16
    )
    position_offset: float = real(0.0, "mm", "added to the scaled count", -1e9, 1e9)
    count_direction: int = flag(0, "counting direction is inverted")
    is_absolute: int = flag(0, "encoder is absolute: its position cannot be set")
    modulo_factor: float = real(360.0, "mm", "length of a modulo period", 1e-3, 1e9)
    modulo_tolerance_window: float = real(
        0.0, "mm", "a directed modulo start goes back within this window", 0.0, 5e8
    )
    soft_limit_min_enable: int = flag(0, "lower software limit is watched")
    soft_limit_max_enable: int = flag(0, "upper software limit is watched")
    soft_limit_min: float = real(0.0, "mm", "lower software limit")
    soft_limit_max: float = real(0.0, "mm", "upper software limit")
    position_filter_time: float = real(0.0, "s", "PT1 filter of the actual position", 0.0, 60.0)
    velocity_filter_time: float = real(0.01, "s", "PT1 filter of the actual velocity", 0.0, 60.0)
    acceleration_filter_time: float = real(
        0.1, "s", "PT1 filter of the actual acceleration", 0.0, 60.0
    )


class EncoderState(States):
    """Actual values (002 §6.4.5.2, 0x5100 + ID)."""

    actual_position: float = real(0.0, "mm", "actual position")
    actual_velocity: float = real(0.0, "mm/s", "actual velocity, filtered")
    actual_velocity_unfiltered: float = real(0.0, "mm/s", "actual velocity of this cycle")
    actual_acceleration: float = real(0.0, "mm/s²", "actual acceleration, filtered")
    actual_position_unfiltered: float = real(0.0, "mm", "position before the PT1 filter")
    homed: int = flag(0, "axis is homed")
    hardware_increments: int = whole(0, "INC", "count of the encoder, 32 bits signed")
    software_increments: int = whole(0, "INC", "count without overflow")
    set_position_offset: float = real(0.0, "mm", "shift made by 'set actual position'")
    reinitialization_state: int = whole(0, "1", "state of a re-initialisation, 0 = none")
    output_image: list[int] = ints(20, "bits", "output structure in words of 4 bytes")
    actual_position_filtered: float = real(
        0.0, "mm", "position after the PT1 filter, without dead-time compensation"
    )
    position_correction: float = real(0.0, "mm", "correction in the actual position")
    actual_velocity_uncorrected: float = real(
        0.0, "mm/s", "actual velocity without that of the correction"
    )
    dead_time_position_correction: float = real(0.0, "mm", "way of the dead-time compensation")


class TouchProbeState(States):
    """External latches of the encoder (002 §6.4.5.2, 0x5100 + ID:0x101, 0x200 … 0x213)."""

    latch_active: int = flag(0, "an external latch is active")
    latch_valid: int = flag(0, "an external latch value has become valid")
    latch_activation_difference: float = real(
        0.0, "mm", "way from activating the hardware latch to its value"
    )
    latch_hardware_increments: int = whole(0, "INC", "latched count of the hardware")
    latch_software_increments: int = whole(0, "INC", "latched count of the software")
    latch_position: float = real(0.0, "mm", "latched position")
    latch_hardware_increment_difference: int = whole(0, "INC", "to the latch before")
    latch_software_increment_difference: int = whole(0, "INC", "to the latch before")
    latch_position_difference: float = real(0.0, "mm", "to the latch before")
    probe_active: list[int] = ints(PROBE_EDGES, "0/1", "waits for its edge")
    probe_valid: list[int] = ints(PROBE_EDGES, "0/1", "its edge was latched")
    probe_position: list[float] = floats(PROBE_EDGES, "mm", "where its edge was")
    probe_counter: list[int] = ints(PROBE_EDGES, "1", "edges latched since activated")


class TouchProbeMemory(InternalFields):
    """Memory of the touch probes: awaited edges, and the last states of the hardware."""

    probe_continuous: list[int] = ints(PROBE_EDGES, "0/1", "goes on after an edge")
    probe_source: list[int] = ints(PROBE_EDGES, "SignalSource", "its signal")
    probe_refused: int = whole(0, "bits", "edges that the hardware on a bus cannot latch")
    armed: int = flag(0, "the hardware watches a signal")
    probe_seen: list[int] = ints(TOUCH_PROBES, "bits", "states of probes last seen")
    homing_seen: int = whole(0, "bits", "state of the homing latch as last seen")
    watched_count: int = whole(0, "INC", "count a cycle before, for the software sync")


class EncoderMemory(InternalFields):
    """Memory of the encoder: values from its parameters, and values from cycle to cycle."""

    adapt: int = flag(1, "parameters changed: derived values must be computed again")
    in_use: int = flag(1, "the axis works with it")
    special: int = flag(0, "functions beyond scaling and filters are in use")
    scale: float = real(1e-4, "mm/INC", "scaling with the sign of the direction")
    data: int = whole(0, "INC", "count as the hardware showed it last")
    raw: int = whole(0, "INC", "the same within the mask")
    velocity_weight: float = real(1.0, "1", "share of a new velocity in the filtered one")
    acceleration_weight: float = real(1.0, "1", "share of a new acceleration in the filtered one")
    backlash_side: float = real(0.0, "1", "direction of the last movement")
    history: list[float] = floats(POSITION_HISTORY, "mm", "actual positions, a ring")
