"""Fields of a job: parameters of a started command, and its progress."""

from math import inf

from achse.motion.fields.declare import InternalFields, flag, real, whole


class JobRequest(InternalFields):
    """Request of the command (002 §6.4.4.3, 0x4200 + ID:0x16, 0x20)."""

    number: int = whole(0, "1", "command number, 16 bits")
    start_type: int = whole(0, "StartType", "kind")
    mode: int = whole(0, "BufferMode", "transition from its predecessor")
    position: float = real(0.0, "mm", "target or distance")
    velocity: float = real(0.0, "mm/s", "velocity")
    acceleration: float = real(0.0, "mm/s²", "acceleration")
    deceleration: float = real(0.0, "mm/s²", "deceleration")
    jerk: float = real(0.0, "mm/s³", "jerk")
    end_velocity: float = real(0.0, "mm/s", "velocity beyond the target")
    start_velocity: float = real(0.0, "mm/s", "segment start velocity; 0 = that of the mode")
    blending_position: float = real(
        inf, "mm", "where it takes over; infinite = at the target before it"
    )


class JobProgress(InternalFields):
    """Progress of the set-point generator with it."""

    way: float = real(0.0, "mm", "from border to border, while it waits")
    border_velocity: float = real(0.0, "mm/s", "wanted velocity at the border where it begins")
    direction: float = real(0.0, "1", "direction")
    peak_velocity: float = real(0.0, "mm/s", "velocity it reaches at 100 % override")
    timing: int = flag(0, "positioning time is being measured")
    time: float = real(0.0, "s", "positioning time so far")
