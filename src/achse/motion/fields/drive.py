"""Fields of a drive: parameters, output, and the motor that stands for the real one."""

from achse.motion.fields.declare import Memory, Parameters, States, flag, real, reals, whole

__all__ = ["DRIVE_DELAY", "DriveInternal", "DriveParameters", "DriveState", "SimulationParameters"]

DRIVE_DELAY = 16
"""Longest dead time of the simulated drive, in cycles."""


class DriveParameters(Parameters):
    """Parameters of the drive (002 §6.4.7.1, 0x7000 + ID)."""

    drive_motor_polarity: int = flag(0, "motor turns the other way round")
    drive_reference_velocity: float = real(2200.0, "mm/s", "velocity at 100 % output", 1e-3, 1e10)
    drive_output_limit_min: float = real(-1.0, "1", "lowest output", -1.0, 1.0)
    drive_output_limit_max: float = real(1.0, "1", "highest output", -1.0, 1.0)


class SimulationParameters(Parameters):
    """The simulated drive and its faults; configuration only, no service."""

    simulation_ideal: int = flag(0, "the drive follows the set position without error")
    simulation_time_constant: float = real(
        0.004, "s", "first-order lag of the drive's velocity", 0.0, 10.0
    )
    simulation_dead_time: float = real(
        0.0, "s", "delay from output to drive, 16 cycles at most", 0.0, 1.0
    )
    simulation_blocked: int = flag(0, "the motor is stuck (fault injection)")
    simulation_not_ready: int = flag(0, "the drive reports not ready (fault injection)")


class DriveState(States):
    """Output to the drive (002 §6.4.7.2, 0x7100 + ID)."""

    drive_output: float = real(0.0, "mm/s", "total output to the drive")
    drive_output_percent: float = real(0.0, "%", "the same of full output")
    drive_limit_active: int = flag(0, "the output is held at a limit")
    drive_output_peak_negative: float = real(0.0, "mm/s", "smallest total output so far")
    drive_output_peak_positive: float = real(0.0, "mm/s", "largest total output so far")


class DriveInternal(Memory):
    """The simulated motor."""

    plant_position: float = real(0.0, "INC", "position of the motor")
    plant_velocity: float = real(0.0, "mm/s", "velocity of the motor")
    delay_index: int = whole(0, "1", "next slot of the dead-time line")
    delay_output: list[float] = reals(DRIVE_DELAY, "mm/s", "outputs under way to the drive")
