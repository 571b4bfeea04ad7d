"""Jobs: the command at work (`ax.job`) and those behind it (`ax.waiting`, a ring).

Kernel source: compiled as it stands, see `compiled`.
"""

from math import inf

from achse.codes.axis import BufferMode
from achse.motion.record import JobFields

NOWHERE = inf
"""The blending position of a command that has none."""


def set_request(
    job: JobFields,
    number: int,
    start_type: int,
    position: float,
    velocity: float,
    acceleration: float,
    deceleration: float,
    jerk: float,
    end_velocity: float,
) -> None:
    """Set the request of a job, which begins where the axis is then."""
    job.number = number
    job.start_type = int(start_type)
    job.mode = int(BufferMode.ABORTING)
    job.position = position
    job.velocity = velocity
    job.acceleration = acceleration
    job.deceleration = deceleration
    job.jerk = jerk
    job.end_velocity = end_velocity
    job.start_velocity = 0.0
    job.blending_position = NOWHERE


def copy_request(job: JobFields, other: JobFields) -> None:
    """Copy the request of another job."""
    job.number = other.number
    job.start_type = other.start_type
    job.mode = other.mode
    job.position = other.position
    job.velocity = other.velocity
    job.acceleration = other.acceleration
    job.deceleration = other.deceleration
    job.jerk = other.jerk
    job.end_velocity = other.end_velocity
    job.start_velocity = other.start_velocity
    job.blending_position = other.blending_position
