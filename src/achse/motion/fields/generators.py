"""Fields of the special generators: external set points, oscillations, motion in open loop."""

from achse.motion.fields.declare import Inputs, InternalFields, flag, real, whole

__all__ = ["GeneratorMemory", "GeneratorSwitch"]


class GeneratorSwitch(Inputs):
    """Switches of the ring 0 that each axis obeys (002 §6.4.1.1)."""

    setpoint_consistency_check: int = flag(0, "inconsistent set points are corrected")


class GeneratorMemory(InternalFields):
    """Jobs of functions 0x23 … 0x28, 0x2D, 0x32 and 0x33 (002 §6.4.4.3)."""

    external_position: float = real(0.0, "mm", "external set position of the last cycle")
    external_velocity: float = real(0.0, "mm/s", "its velocity, as used")
    external_acceleration: float = real(0.0, "mm/s²", "its acceleration, as used")
    external_jerk: float = real(0.0, "mm/s³", "its jerk, as used")
    external_origin: float = real(0.0, "mm", "set position where the external one is 0")

    reversing_number: int = whole(0, "1", "number of the reversing command, 0 = none")
    reversing_target: float = real(0.0, "mm", "target that comes next")
    generator_pause: float = real(0.0, "s", "time at rest between two moves")
    generator_time: float = real(0.0, "s", "time in the present stage")
    generator_stage: int = whole(0, "1", "stage of the generator's sequence")
    generator_round: int = whole(0, "1", "sequences or steps done")
    generator_rounds: int = whole(0, "1", "sequences or steps to do, 0 = without end")
    generator_duration: float = real(0.0, "s", "time of one velocity or frequency")
    step_velocity_1: float = real(0.0, "mm/s", "first velocity of the steps")
    step_velocity_2: float = real(0.0, "mm/s", "second velocity of the steps")
    sine_base_velocity: float = real(0.0, "mm/s", "amplitude of the base oscillation")
    sine_base_frequency: float = real(0.0, "Hz", "its frequency")
    sine_base_angle: float = real(0.0, "1", "its phase angle")
    sine_velocity: float = real(0.0, "mm/s", "amplitude of the measuring oscillation")
    sine_frequency: float = real(0.0, "Hz", "its frequency")
    sine_frequency_ratio: float = real(1.0, "1", "from one frequency to the next")
    sine_angle: float = real(0.0, "1", "its phase angle")
    sine_share: float = real(0.0, "1", "of the amplitudes, follows the override")

    grouped: int = flag(0, "the axis belongs to a group of several axes")
    group_position: float = real(0.0, "mm", "set position that its group asks for")
    group_velocity: float = real(0.0, "mm/s", "its velocity there")
    group_acceleration: float = real(0.0, "mm/s²", "its acceleration there")
    group_jerk: float = real(0.0, "mm/s³", "its jerk there")

    direct_output: float = real(0.0, "mm/s", "output to the drive past the controller")
    torque_target: float = real(0.0, "1000 = 100 %", "commanded torque")
    torque_ramp: float = real(0.0, "1000 = 100 %/s", "change of the set torque, 0 = at once")
    torque_velocity_high: float = real(0.0, "mm/s", "largest velocity in torque mode")
    torque_velocity_low: float = real(0.0, "mm/s", "smallest velocity in torque mode")
    torque_acceleration: float = real(0.0, "mm/s²", "limit of speeding up, 0 = none")
    torque_deceleration: float = real(0.0, "mm/s²", "limit of slowing down, 0 = none")
    torque_continuous: int = flag(0, "ramp and limits may be changed while the command runs")
    torque_mode_before: int = whole(0, "DriveOperationMode", "where the drive goes back to")
