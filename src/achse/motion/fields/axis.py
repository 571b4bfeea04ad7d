"""Fields of the axis itself: parameters, errors, status."""

from achse.motion.fields.declare import Parameters, States, flag, real, whole

__all__ = ["AxisParameters", "AxisState"]


class AxisParameters(Parameters):
    """Parameters of the axis (002 §6.4.4.1, 0x4000 + ID)."""

    axis_id: int = whole(0, "1", "axis id 1..255")
    max_velocity: float = real(2000.0, "mm/s", "largest velocity of a command", 1e-3, 1e10)
    max_acceleration: float = real(1e5, "mm/s²", "largest acceleration of a command", 0.01, 1e10)
    max_deceleration: float = real(1e6, "mm/s²", "largest deceleration of a command", 0.01, 1e10)
    default_acceleration: float = real(
        1500.0, "mm/s²", "acceleration unless a command gives one", 0.01, 1e10
    )
    default_deceleration: float = real(
        1500.0, "mm/s²", "deceleration unless a command gives one", 0.01, 1e10
    )
    default_jerk: float = real(2250.0, "mm/s³", "jerk unless a command gives one", 0.1, 1e12)
    fast_axis_stop_deceleration: float = real(
        0.0,
        "mm/s²",
        "deceleration of the stop after an error; 0 = that of the running command",
        0.0,
        1e10,
    )
    fast_axis_stop_jerk: float = real(
        0.0, "mm/s³", "jerk of the stop after an error; 0 = that of the running command", 0.0, 1e12
    )
    override_type: int = whole(1, "OverrideType", "what 100 % override relates to", 1, 4)
    unit_interpretation: int = whole(0, "bits", "bit 2: modulo axis", 0, 7)
    position_range_monitoring_enable: int = flag(1, "position window is watched")
    position_range_window: float = real(5.0, "mm", "half width of the position window", 0.0, 1e6)
    target_position_monitoring_enable: int = flag(1, "target window is watched")
    target_position_window: float = real(2.0, "mm", "half width of the target window", 0.0, 1e6)
    target_position_monitoring_time: float = real(
        0.02, "s", "time inside until arrival counts", 0.0, 600.0
    )
    peh_monitoring_enable: int = flag(0, "arrival in the target window is supervised")
    peh_monitoring_time: float = real(5.0, "s", "time from logical end to arrival", 0.0, 600.0)
    motion_monitoring_enable: int = flag(0, "physical movement is supervised")
    motion_monitoring_window: float = real(0.1, "mm", "movement that counts as movement", 0.0, 1e6)
    motion_monitoring_time: float = real(0.5, "s", "time in which it must be seen", 0.0, 600.0)
    error_reaction_mode: int = whole(0, "1", "0 at once, 1 delayed", 0, 1)
    error_reaction_delay: float = real(0.0, "s", "delay of the reaction in mode 1", 0.0, 1000.0)


class AxisState(States):
    """Errors and status of the axis (002 §6.4.4.2 and §6.4.4.4)."""

    error_code: int = whole(0, "NcError", "error of the axis, 0 = none")
    delayed_error_code: int = whole(0, "NcError", "error whose reaction is delayed")
    state_dword: int = whole(0, "StateBit", "status double word")
    operation_mode_state_dword: int = whole(0, "OperationModeBit", "active monitoring functions")
    motion_state: int = whole(0, "MotionState", "what the set-point generator does")
    coupling_state: int = whole(0, "1", "0 single, 1 master, 2 both, 3 slave")
    homed: int = flag(0, "axis is homed")
    reset_command_counter: int = whole(0, "1", "resets so far")
    loop_closed: int = flag(0, "position control loop is closed")
    in_position_range: int = flag(0, "actual position is inside the position window")
    in_target_position: int = flag(0, "arrived: long enough inside the target window")
