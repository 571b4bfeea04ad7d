"""Fields of the motions beside the main one: section compensation and phasing."""

from achse.motion.fields.declare import InternalFields, States, flag, floats, real, whole
from achse.motion.fields.setpoint import SEGMENTS


class PhasingState(States):
    """Phase shift (002 §6.4.4.3, 0x4200 + ID:0x34)."""

    active: int = flag(0, "phasing is active")
    position: float = real(0.0, "mm", "shift by which this axis sees its master")


class PhasingProfile(InternalFields):
    """Profile towards the commanded shift."""

    velocity: float = real(0.0, "mm/s", "change of the shift")
    acceleration: float = real(0.0, "mm/s²", "change of that")
    begin: float = real(0.0, "mm", "shift when the running command began")
    target: float = real(0.0, "mm", "shift where it will end")
    count: int = whole(0, "1", "rows of the table")
    index: int = whole(0, "1", "active row")
    elapsed: float = real(0.0, "s", "time since its start")
    time: list[float] = floats(SEGMENTS, "s", "duration of each row")
    jerk: list[float] = floats(SEGMENTS, "mm/s³", "jerk of each row")


class Phasing(PhasingState, PhasingProfile):
    """Phasing of a slave."""


class SuperposedMotion(InternalFields):
    """Trapezoid on top of the main motion; its clock is the main motion's way."""

    sign: float = real(0.0, "1", "direction of the additional motion")
    direction: float = real(0.0, "1", "direction of the main motion")
    process_velocity: float = real(0.0, "mm/s", "main velocity it was planned for")
    fastest: float = real(0.0, "mm/s", "main velocity up to which its clock follows")
    limit: float = real(0.0, "mm/s", "velocity that both together do not exceed")
    acceleration: float = real(0.0, "mm/s²", "additional acceleration")
    deceleration: float = real(0.0, "mm/s²", "additional deceleration")
    velocity: float = real(0.0, "mm/s", "largest additional velocity")
    distance: float = real(0.0, "mm", "additional way in all, without sign")
    rise_end: float = real(0.0, "s", "process time where acceleration ends")
    fall_begin: float = real(0.0, "s", "process time where deceleration begins")
    end: float = real(0.0, "s", "process time where all is covered")
    stopping: int = flag(0, "it was stopped before its end")
    main_way: float = real(0.0, "mm", "way of the main motion since the start")
    position: float = real(0.0, "mm", "additional way covered, without sign")
    set_velocity: float = real(0.0, "mm/s", "what of it the set velocity holds")
    set_acceleration: float = real(0.0, "mm/s²", "what of it the set acceleration holds")
