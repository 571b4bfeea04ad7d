"""Fields of the special generators: external set points, oscillations, motion in open loop."""

from achse.motion.fields.declare import Inputs, InternalFields, flag, real, whole


class GeneratorSwitch(Inputs):
    """Switches of the ring 0 that each axis obeys (002 §6.4.1.1)."""

    setpoint_consistency_check: int = flag(0, "inconsistent set points are corrected")


class GeneratorMemory(InternalFields):
    """Output in open loop (function 0x28), membership of a group of several axes."""

    grouped: int = flag(0, "the axis belongs to a group of several axes")
    direct_output: float = real(0.0, "mm/s", "output to the drive past the controller")


class ReversingCommand(InternalFields):
    """Reversing operation between two targets (function 0x25)."""

    number: int = whole(0, "1", "number of the reversing command, 0 = none")
    target: float = real(0.0, "mm", "target that comes next")


class GeneratorSequence(InternalFields):
    """Sequence of moves, velocities or frequencies, and its progress (0x25, 0x32, 0x33)."""

    pause: float = real(0.0, "s", "time at rest between two moves")
    time: float = real(0.0, "s", "time in the present stage")
    stage: int = whole(0, "1", "stage of the sequence")
    round: int = whole(0, "1", "sequences or steps done")
    rounds: int = whole(0, "1", "sequences or steps to do, 0 = without end")
    duration: float = real(0.0, "s", "time of one velocity or frequency")
    velocity_1: float = real(0.0, "mm/s", "first velocity of the steps")
    velocity_2: float = real(0.0, "mm/s", "second velocity of the steps")


class ExternalMotion(InternalFields):
    """External set point of the last cycle (function 0x23)."""

    position: float = real(0.0, "mm", "external set position of the last cycle")
    velocity: float = real(0.0, "mm/s", "its velocity, as used")
    acceleration: float = real(0.0, "mm/s²", "its acceleration, as used")
    jerk: float = real(0.0, "mm/s³", "its jerk, as used")
    origin: float = real(0.0, "mm", "set position where the external one is 0")


class SineOscillation(InternalFields):
    """Base and measuring oscillation (function 0x33)."""

    base_velocity: float = real(0.0, "mm/s", "amplitude of the base oscillation")
    base_frequency: float = real(0.0, "Hz", "its frequency")
    base_angle: float = real(0.0, "1", "its phase angle")
    velocity: float = real(0.0, "mm/s", "amplitude of the measuring oscillation")
    frequency: float = real(0.0, "Hz", "its frequency")
    frequency_ratio: float = real(1.0, "1", "from one frequency to the next")
    angle: float = real(0.0, "1", "its phase angle")
    share: float = real(0.0, "1", "of the amplitudes, follows the override")


class TorqueCommand(InternalFields):
    """Torque command and its limits (function 0x2D)."""

    target: float = real(0.0, "1000 = 100 %", "commanded torque")
    ramp: float = real(0.0, "1000 = 100 %/s", "change of the set torque, 0 = at once")
    velocity_high: float = real(0.0, "mm/s", "largest velocity in torque mode")
    velocity_low: float = real(0.0, "mm/s", "smallest velocity in torque mode")
    acceleration: float = real(0.0, "mm/s²", "limit of speeding up, 0 = none")
    deceleration: float = real(0.0, "mm/s²", "limit of slowing down, 0 = none")
    continuous: int = flag(0, "ramp and limits may be changed while the command runs")
    mode_before: int = whole(0, "DriveOperationMode", "where the drive goes back to")
