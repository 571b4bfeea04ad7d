"""Fields of a controller: parameters and parts of its output."""

from achse.motion.fields.declare import Parameters, States, flag, real

__all__ = ["ControllerParameters", "ControllerState"]


class ControllerParameters(Parameters):
    """Parameters of the controller (002 §6.4.6.1, 0x6000 + ID)."""

    controller_position_kv: float = real(
        20.0, "1/s", "proportional gain of the position loop", 0.0, 1000.0
    )
    controller_velocity_feedforward_weight: float = real(
        1.0, "1", "share of set velocity added", 0.0, 1.0
    )
    controller_output_limit: float = real(
        0.5, "1", "largest controller part of full output", 0.0, 1.0
    )
    controller_position_dead_band: float = real(0.0, "mm", "error that is not acted upon", 0.0, 1e4)
    controller_following_error_position_monitoring_enable: int = flag(
        1, "position following error is supervised"
    )
    controller_following_error_position_max: float = real(
        5.0, "mm", "largest following error", 0.0, 1e6
    )
    controller_following_error_position_filter_time: float = real(
        0.02, "s", "time above it until error 0x4550", 0.0, 600.0
    )
    controller_following_error_velocity_monitoring_enable: int = flag(
        0, "velocity following error is supervised"
    )
    controller_following_error_velocity_max: float = real(
        500.0, "mm/s", "largest velocity following error", 0.0, 1e6
    )
    controller_following_error_velocity_filter_time: float = real(
        0.02, "s", "time above it until error 0x4551", 0.0, 600.0
    )


class ControllerState(States):
    """Following error and output (002 §6.4.6.2, 0x6100 + ID)."""

    following_error: float = real(0.0, "mm", "set minus actual position")
    following_error_peak_negative: float = real(0.0, "mm", "smallest following error so far")
    following_error_peak_positive: float = real(0.0, "mm", "largest following error so far")
    following_error_velocity: float = real(0.0, "mm/s", "set minus actual velocity")
    controller_output: float = real(0.0, "mm/s", "output of the position controller")
    controller_output_percent: float = real(0.0, "%", "the same of full output")
