"""Commands to an axis: checked here, carried out from the next cycle on.

Each function answers 0 or the number of the NC error that refuses it (`NcError`); a refused command
changes nothing. Functions carry the index offset of 0x4200 + axis id that they stand for (002
§6.4.4.3). Positions are in axis units, velocities per second; acceleration, deceleration and jerk
of 0 mean the axis default.

Read `starts` first, with `queue` (accepted and waiting commands) and `achse.motion.checks`; then
`stops`, `changes` and `superposition`, which change a motion. `homing`, `positions` and `probes`
are about encoders, `loops` and `switches` about the control loop and errors, `groups` about
membership. `slaves` and `special_generators` are sub-rooms.
"""

from achse.motion.commands.changes import (
    freeze_override,
    new_dynamics,
    new_end_position,
    new_end_position_and_velocity,
)
from achse.motion.commands.groups import (
    begin_group_motion,
    check_in_group,
    end_group_motion,
    join_group,
    leave_group,
    return_to_ptp_group,
)
from achse.motion.commands.homing import home, set_homing_state
from achse.motion.commands.loops import switch_control_loop
from achse.motion.commands.positions import (
    reinitialize_actual_position,
    reinitialize_encoder,
    set_actual_position,
    set_actual_position_in_drive,
    set_actual_position_on_the_fly,
    set_actual_position_only,
    set_encoder_scaling_factor,
    set_homed_flag,
)
from achse.motion.commands.probes import (
    activate_latch,
    activate_touch_probe,
    deactivate_latch,
    deactivate_touch_probe,
    set_latch_event,
)
from achse.motion.commands.slaves.cams import (
    CamDemand,
    change_cam_offsets,
    change_cam_scaling,
    couple_by_cam,
    end_profile,
    follow_correction,
    last_correction,
    scale_slave,
)
from achse.motion.commands.slaves.couplings import (
    change_coupling,
    couple,
    couple_to_several,
    decouple,
    decouple_and_start,
    decouple_with_follow_up,
    stop_slave,
)
from achse.motion.commands.slaves.phasing import start_phasing
from achse.motion.commands.slaves.synchronising import synchronise
from achse.motion.commands.special_generators.external import (
    start_external_setpoint,
    stop_external_setpoint,
    stop_external_setpoint_endless,
)
from achse.motion.commands.special_generators.open_loop import (
    change_drive_output,
    release_brake,
    set_drive_operation_mode,
    start_drive_output,
    start_torque_control,
    stop_drive_output,
)
from achse.motion.commands.special_generators.oscillation import (
    start_reversing,
    start_sine_oscillation,
    start_velocity_steps,
)
from achse.motion.commands.special_generators.special import start_special
from achse.motion.commands.starts import start, universal_start
from achse.motion.commands.stops import (
    clear,
    emergency_stop,
    oriented_stop,
    parameterized_stop,
    release_lock,
    stop,
    stop_information,
)
from achse.motion.commands.superposition import (
    Compensation,
    start_superposition,
    stop_superposition,
)
from achse.motion.commands.switches import (
    disable,
    enable,
    reset,
    set_drive_output,
    set_external_error,
)

__all__ = [
    "CamDemand",
    "Compensation",
    "activate_latch",
    "activate_touch_probe",
    "begin_group_motion",
    "change_cam_offsets",
    "change_cam_scaling",
    "change_coupling",
    "change_drive_output",
    "check_in_group",
    "clear",
    "couple",
    "couple_by_cam",
    "couple_to_several",
    "deactivate_latch",
    "deactivate_touch_probe",
    "decouple",
    "decouple_and_start",
    "decouple_with_follow_up",
    "disable",
    "emergency_stop",
    "enable",
    "end_group_motion",
    "end_profile",
    "follow_correction",
    "freeze_override",
    "home",
    "join_group",
    "last_correction",
    "leave_group",
    "new_dynamics",
    "new_end_position",
    "new_end_position_and_velocity",
    "oriented_stop",
    "parameterized_stop",
    "reinitialize_actual_position",
    "reinitialize_encoder",
    "release_brake",
    "release_lock",
    "reset",
    "return_to_ptp_group",
    "scale_slave",
    "set_actual_position",
    "set_actual_position_in_drive",
    "set_actual_position_on_the_fly",
    "set_actual_position_only",
    "set_drive_operation_mode",
    "set_drive_output",
    "set_encoder_scaling_factor",
    "set_external_error",
    "set_homed_flag",
    "set_homing_state",
    "set_latch_event",
    "start",
    "start_drive_output",
    "start_external_setpoint",
    "start_phasing",
    "start_reversing",
    "start_sine_oscillation",
    "start_special",
    "start_superposition",
    "start_torque_control",
    "start_velocity_steps",
    "stop",
    "stop_drive_output",
    "stop_external_setpoint",
    "stop_external_setpoint_endless",
    "stop_information",
    "stop_slave",
    "stop_superposition",
    "switch_control_loop",
    "synchronise",
    "universal_start",
]
