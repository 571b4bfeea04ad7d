"""Fields of the supervision: its clocks."""

from achse.motion.fields.declare import InternalFields, flag, real, whole

__all__ = ["MonitoringInternal"]


class MonitoringInternal(InternalFields):
    """What supervision remembers from cycle to cycle."""

    adapt: int = flag(1, "parameters changed: derived values must be computed again")
    resting: int = flag(0, "nothing changes until somebody writes to the record")
    quiet_cycles: int = whole(0, "1", "cycles without a change")
    drive_status: int = whole(0, "bits", "state 1 of the drive")
    io_invalid: int = flag(0, "encoder or drive has no valid data")
    limit_switch: int = whole(0, "1", "hardware limit switch the axis is on: -1, 0 none, 1")
    output_cut: int = flag(0, "an error opened the control loop; reset closes it")
    following_error_time: float = real(0.0, "s", "time above the position window")
    following_error_velocity_time: float = real(0.0, "s", "time above the velocity window")
    target_window_time: float = real(0.0, "s", "time inside the target window")
    peh_time: float = real(0.0, "s", "time since the logical end")
    motion_time: float = real(0.0, "s", "time without movement")
    motion_position: float = real(0.0, "mm", "where the last movement was seen")
    delayed_error_cut: int = flag(0, "the delayed error will open the loop")
    delayed_error_time: float = real(0.0, "s", "time since it was seen")
