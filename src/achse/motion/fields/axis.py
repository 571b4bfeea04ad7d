"""Fields of the axis itself: parameters, errors, status."""

from achse.motion.fields.declare import Parameters, States, flag, real, whole


class AxisParameterFields(Parameters):
    """Parameters of the axis (002 §6.4.4.1, 0x4000 + ID)."""

    axis_id: int = whole(0, "1", "axis id 1..255")
    axis_type: int = whole(1, "AxisType", "kind of axis", 1, 7)
    homing_velocity_towards_cam: float = real(
        30.0, "mm/s", "homing velocity towards the cam", 1e-3, 1e20
    )
    homing_velocity_off_cam: float = real(
        30.0, "mm/s", "homing velocity while the sync pulse is searched", 1e-3, 1e20
    )
    jog_velocity_slow: float = real(100.0, "mm/s", "manual velocity, slow", 1e-3, 1e20)
    jog_velocity_fast: float = real(600.0, "mm/s", "manual velocity, fast", 1e-3, 1e20)
    rapid_traverse_velocity: float = real(2000.0, "mm/s", "rapid traverse velocity", 0.0, 1e20)
    loop_enable: int = flag(0, "targets are approached from one side")
    loop_distance: float = real(0.0, "mm", "signed overrun of such an approach")
    pulse_distance_positive: float = real(5.0, "mm", "distance of a pulse, positive", 0.0)
    pulse_distance_negative: float = real(5.0, "mm", "distance of a pulse, negative", 0.0)
    couple_slaves_by_actual_values: int = flag(0, "slaves follow actual values while not ready")
    fading_acceleration: float = real(
        0.0, "mm/s²", "dynamics of fading from set to actual values; 0 = smaller default", 0.0, 1e10
    )
    fast_axis_stop_signal_type: int = whole(
        0, "SignalType", "what of bit 7 of drive status 4 stops the axis", 0, 5
    )
    allow_slave_motion_commands: int = flag(0, "a slave takes motion commands")
    allow_motion_commands_with_external_setpoint: int = flag(
        0, "motion commands are taken while the external generator is active"
    )
    backlash_compensation_enable: int = flag(0, "backlash is compensated")
    backlash: float = real(
        0.0, "mm", "what the load stays behind the motor after a reversal", -1e3, 1e3
    )
    persistent_data_enable: int = flag(0, "position and homed flag survive a restart")
    setpoint_velocity_position_delay: float = real(
        0.0, "s", "set position behind set velocity", 0.0, 1.0
    )
    max_velocity_jump: float = real(0.0, "1", "factor of the largest velocity jump", 0.0, 1e6)
    auxiliary_axis_limiting_enable: int = flag(1, "an auxiliary axis keeps its limits")
    auxiliary_axis_tolerance_ball: float = real(
        0.0, "mm", "tolerance of an auxiliary axis", 0.0, 1e3
    )
    auxiliary_axis_max_position_deviation: float = real(
        0.0, "mm", "largest deviation of an auxiliary axis", 0.0, 1e4
    )
    fast_axis_stop_acceleration: float = real(
        0.0, "mm/s²", "acceleration of the stop after an error", 0.0, 1e20
    )
    user_data_state_offset: int = whole(
        0, "1", "state shown as UserData: 0, 0x10012, 0x10014, 0x10017", 0, 0x10017
    )
    stepper_operation_mode: int = whole(1, "StepperMode", "excitation of the motor", 1, 3)
    stepper_step_scaling: float = real(0.01, "mm/STEP", "distance of one step", 1e-6, 1e3)
    stepper_min_velocity: float = real(1.0, "mm/s", "slowest step frequency", 0.0, 1e3)
    stepper_steps_per_velocity_level: int = whole(
        0, "STEP", "steps before the frequency changes again", 0, 100
    )
    creep_distance_positive: float = real(
        10.0, "mm", "distance to the target where creep begins, positive", 0.0, 1e5
    )
    creep_distance_negative: float = real(
        10.0, "mm", "distance to the target where creep begins, negative", 0.0, 1e5
    )
    brake_distance_positive: float = real(
        1.0, "mm", "distance to the target where braking begins, positive", 0.0, 1e5
    )
    brake_distance_negative: float = real(
        1.0, "mm", "distance to the target where braking begins, negative", 0.0, 1e5
    )
    brake_delay_positive: float = real(0.0, "s", "from output off to brake on, positive", 0.0, 60.0)
    brake_delay_negative: float = real(0.0, "s", "from output off to brake on, negative", 0.0, 60.0)
    rapid_to_creep_switch_time: float = real(0.0, "s", "pause from rapid to creep", 0.0, 60.0)
    creep_distance_stop: float = real(0.0, "mm", "creep distance of a stop", 0.0, 1e5)
    brake_release_delay: float = real(0.0, "s", "from brake off to output on", 0.0, 60.0)
    pulse_time_positive: float = real(0.0, "s", "time of a pulse, positive", 0.0, 60.0)
    pulse_time_negative: float = real(0.0, "s", "time of a pulse, negative", 0.0, 60.0)
    max_velocity: float = real(2000.0, "mm/s", "largest velocity of a command", 1e-3, 1e20)
    max_acceleration: float = real(1e5, "mm/s²", "largest acceleration of a command", 0.01, 1e20)
    max_deceleration: float = real(1e6, "mm/s²", "largest deceleration of a command", 0.01, 1e20)
    default_acceleration: float = real(
        1500.0, "mm/s²", "acceleration unless a command gives one", 0.01, 1e20
    )
    default_deceleration: float = real(
        1500.0, "mm/s²", "deceleration unless a command gives one", 0.01, 1e20
    )
    default_jerk: float = real(2250.0, "mm/s³", "jerk unless a command gives one", 0.1, 1e30)
    fast_axis_stop_deceleration: float = real(
        0.0,
        "mm/s²",
        "deceleration of the stop after an error; 0 = that of the running command",
        0.0,
        1e20,
    )
    fast_axis_stop_jerk: float = real(
        0.0, "mm/s³", "jerk of the stop after an error; 0 = that of the running command", 0.0, 1e30
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
    no_motion_window: float = real(
        0.1, "mm/s", "velocity below which an encoder axis does not move", 0.0, 1e3
    )
    no_motion_time: float = real(0.01, "s", "time below it until that counts", 0.0, 60.0)
    error_reaction_mode: int = whole(0, "1", "0 at once, 1 delayed", 0, 1)
    error_reaction_delay: float = real(0.0, "s", "delay of the reaction in mode 1", 0.0, 1000.0)


class AxisState(States):
    """Errors and status of the axis (002 §6.4.4.2 and §6.4.4.4)."""

    error_code: int = whole(0, "NcError", "error of the axis, 0 = none")
    state_dword: int = whole(0, "StateBit", "status double word")
    operation_mode_state_dword: int = whole(0, "OperationModeBit", "active monitoring functions")
    motion_state: int = whole(0, "MotionState", "what the set-point generator does")
    compensating: int = flag(0, "section compensation is active")
    external_setpoint_active: int = flag(0, "the external set-point generator is active")
    active_control_loop: int = whole(0, "1", "element that controls: encoder, controller, drive")
    operation_mode_feedback: int = whole(0, "1", "operation mode as confirmed to the PLC")
    initialize_command_counter: int = whole(0, "1", "initialisations so far")
    setpoint_correction_counter: int = whole(0, "1", "set points corrected for consistency")
    set_gear_ratio: float = real(0.0, "1", "gear ratio in force, 0 = not coupled")
    coupling_state: int = whole(0, "1", "0 single, 1 master, 2 both, 3 slave")
    reset_command_counter: int = whole(0, "1", "resets so far")
    loop_closed: int = flag(0, "position control loop is closed")
    in_position_range: int = flag(0, "actual position is inside the position window")
    in_target_position: int = flag(0, "arrived: long enough inside the target window")


class ApplicationRequest(States):
    """Request of an axis to the application."""

    request: int = flag(0, "the application has a request")
    request_type: int = whole(0, "1", "what for: 0 nothing, 1 homing")
    command_number: int = whole(0, "1", "number of that request")
