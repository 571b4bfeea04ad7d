"""Features of an axis beyond a plain move or a coupling, a bit each (`AxisFields.features`).

A feature sets its bit where it switches on. The stage of the cycle that works for it clears the
bit when it finds the feature off. With no bit set the cycle takes its fast path (see
`achse.motion.kernel`).

A value that is written from outside the cycle sets the bit of its feature by the table `SWITCHES`;
what a parameter switches on is found when the cycle derives from the parameters.
"""

from collections.abc import Mapping
from enum import IntEnum


class Feature(IntEnum):
    """Bits of `features`."""

    PARAMETERS = 1 << 0
    """Parameters have changed: what follows from them must be computed again."""
    KIND = 1 << 1
    """Discrete axis, encoder axis or stepper motor."""
    OPERATION_MODE = 1 << 2
    """Operation mode of the drive that a command has chosen."""
    GENERATOR = 1 << 3
    """Set point made by another generator than moves and couplings."""
    EXTERNAL_SETPOINT = 1 << 4
    """External set-point generator."""
    SUPERPOSITION = 1 << 5
    """Section compensation."""
    REVERSING = 1 << 6
    """Reversing command."""
    PHASING = 1 << 7
    """Phasing."""
    HOMING = 1 << 8
    """Homing sequence, or its latch."""
    LATCH = 1 << 9
    """Touch probe that waits or has latched."""
    SOFT_LIMITS = 1 << 10
    """Soft limits."""
    FAST_STOP = 1 << 11
    """Fast-stop signal of the drive."""
    IO_INVALID = 1 << 12
    """I/O data that are invalid, or were so a moment ago."""
    LIMIT_SWITCH = 1 << 13
    """Hardware limit switch that is reached."""
    OUTPUT_LIMIT = 1 << 14
    """Output at its limit."""
    STATUS = 1 << 15
    """Rare bit of the status double word: stopped, new target, locked."""
    DELAYED_ERROR = 1 << 16
    """Error whose reaction is delayed."""
    ERROR = 1 << 17
    """Error, or an output cut by one."""
    EXTERNAL_ERROR = 1 << 18
    """Error set from outside that has not taken effect yet."""
    DISABLED = 1 << 19
    """Axis or drive output disabled."""
    GROUPED = 1 << 20
    """Member of a group of several axes."""
    POSITION_DELAY = 1 << 21
    """Set position behind the set velocity."""
    TORQUE_OFFSET = 1 << 22
    """Additive torque."""
    DRIVE = 1 << 23
    """Output by a characteristic, a filter or a delay."""
    CONTROLLER = 1 << 24
    """Controller beyond P."""


ALL_FEATURES = sum(Feature)
"""Every bit: the state of a fresh axis, whose first cycle clears those that are off."""

BY_PARAMETERS = (
    Feature.KIND.value
    | Feature.SOFT_LIMITS.value
    | Feature.FAST_STOP.value
    | Feature.POSITION_DELAY.value
    | Feature.DRIVE.value
    | Feature.CONTROLLER.value
)
"""Features that parameters switch on and off."""

TRANSIENT = ALL_FEATURES & ~BY_PARAMETERS & ~Feature.PARAMETERS
"""Features that commands, inputs and errors switch on and off."""

SWITCHES: Mapping[Feature, tuple[str, ...]] = {
    Feature.OPERATION_MODE: ("drive_operation_mode",),
    Feature.GENERATOR: ("set_motion_phase",),
    Feature.EXTERNAL_SETPOINT: ("external_setpoint_active",),
    Feature.SUPERPOSITION: ("compensating",),
    Feature.REVERSING: ("reversing.number",),
    Feature.PHASING: ("phasing.active",),
    Feature.HOMING: ("homing.state", "homing.latch"),
    Feature.LATCH: ("encoder.latch_active", "encoder.latch_valid", "encoder.armed"),
    Feature.IO_INVALID: ("io_invalid", "drive.io_time"),
    Feature.LIMIT_SWITCH: ("limit_switch",),
    Feature.OUTPUT_LIMIT: ("drive.limit_active",),
    Feature.STATUS: ("has_been_stopped", "got_new_target", "motion_locked"),
    Feature.DELAYED_ERROR: ("delayed_error.code",),
    Feature.ERROR: ("error_code", "output_cut"),
    Feature.EXTERNAL_ERROR: ("external_error",),
    Feature.DISABLED: ("axis_disabled", "drive_output_disabled"),
    Feature.GROUPED: ("grouped",),
    Feature.TORQUE_OFFSET: ("set_torque_offset",),
}
"""Fields, some of a part of the axis, whose value switches a feature on; 0 is off."""
