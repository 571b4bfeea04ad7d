"""Fields of an encoder: parameters and actual values."""

from achse.motion.fields.declare import Parameters, States, flag, real, whole

__all__ = ["EncoderParameters", "EncoderState"]


class EncoderParameters(Parameters):
    """Parameters of the encoder (002 §6.4.5.1, 0x5000 + ID)."""

    encoder_scaling_factor: float = real(1e-4, "mm/INC", "distance of one increment", 1e-12, 1e3)
    encoder_position_offset: float = real(0.0, "mm", "added to the scaled count", -1e9, 1e9)
    encoder_count_direction: int = flag(0, "counting direction is inverted")
    encoder_is_absolute: int = flag(0, "encoder is absolute: its position cannot be set")
    encoder_modulo_factor: float = real(360.0, "mm", "length of a modulo period", 1e-3, 1e9)
    encoder_modulo_tolerance_window: float = real(
        0.0, "mm", "a directed modulo start goes back within this window", 0.0, 5e8
    )
    encoder_soft_limit_min_enable: int = flag(0, "lower software limit is watched")
    encoder_soft_limit_max_enable: int = flag(0, "upper software limit is watched")
    encoder_soft_limit_min: float = real(0.0, "mm", "lower software limit", -1e10, 1e10)
    encoder_soft_limit_max: float = real(0.0, "mm", "upper software limit", -1e10, 1e10)
    encoder_position_filter_time: float = real(
        0.0, "s", "PT1 filter of the actual position", 0.0, 60.0
    )
    encoder_velocity_filter_time: float = real(
        0.01, "s", "PT1 filter of the actual velocity", 0.0, 60.0
    )
    encoder_acceleration_filter_time: float = real(
        0.1, "s", "PT1 filter of the actual acceleration", 0.0, 60.0
    )


class EncoderState(States):
    """Actual values (002 §6.4.5.2, 0x5100 + ID)."""

    actual_position: float = real(0.0, "mm", "actual position")
    actual_position_modulo: float = real(0.0, "mm", "actual position within its period")
    actual_modulo_turns: int = whole(0, "1", "period of the actual position")
    actual_velocity: float = real(0.0, "mm/s", "actual velocity, filtered")
    actual_velocity_unfiltered: float = real(0.0, "mm/s", "actual velocity of this cycle")
    actual_acceleration: float = real(0.0, "mm/s²", "actual acceleration, filtered")
    encoder_actual_position_unfiltered: float = real(0.0, "mm", "position before the PT1 filter")
    encoder_hardware_increments: int = whole(0, "INC", "count of the encoder, 32 bits signed")
    encoder_software_increments: int = whole(0, "INC", "count without overflow")
    encoder_set_position_offset: float = real(0.0, "mm", "shift made by 'set actual position'")
