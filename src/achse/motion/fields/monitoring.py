"""Fields of the supervision: its clocks."""

from achse.motion.features import ALL_FEATURES
from achse.motion.fields.declare import InternalFields, States, flag, real, whole


class MonitoringInternal(InternalFields):
    """Memory of the supervision from cycle to cycle."""

    features: int = whole(ALL_FEATURES, "bits", "features beyond a plain move that are on")
    first_encoder: int = whole(0, "1", "row of its first encoder, the others are behind it")
    encoder_count: int = whole(1, "1", "its encoders")
    resting: int = flag(0, "nothing changes until the record is written")
    quiet_cycles: int = whole(0, "1", "cycles without a change")
    drive_status: int = whole(0, "bits", "state 1 of the drive")
    io_invalid: int = flag(0, "encoder or drive has no valid data")
    limit_switch: int = whole(0, "1", "hardware limit switch the axis is on: -1, 0 none, 1")
    output_cut: int = flag(0, "an error opened the control loop; reset closes it")


class MonitoringTimes(InternalFields):
    """Times of the monitoring functions."""

    following_error_time: float = real(0.0, "s", "time above the position window")
    following_error_velocity_time: float = real(0.0, "s", "time above the velocity window")
    target_window_time: float = real(0.0, "s", "time inside the target window")
    peh_time: float = real(0.0, "s", "time since the logical end")
    motion_time: float = real(0.0, "s", "time without movement")
    motion_position: float = real(0.0, "mm", "position of the last movement")
    standstill_time: float = real(0.0, "s", "time for which an encoder axis has been too slow")
    encoder_moves: int = flag(0, "an encoder axis moves, or did so a moment ago")


class DelayedErrorState(States):
    """Error whose reaction is delayed."""

    code: int = whole(0, "NcError", "error whose reaction is delayed")


class DelayedReaction(InternalFields):
    """Reaction to this error."""

    cut: int = flag(0, "the reaction will open the loop")
    time: float = real(0.0, "s", "time since the error")


class DelayedError(DelayedErrorState, DelayedReaction):
    """Error of an axis whose reaction is delayed, and that reaction."""
