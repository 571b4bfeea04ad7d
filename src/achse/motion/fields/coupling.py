"""Fields of an axis that follows others, or that others follow."""

from achse.motion.fields.declare import InternalFields, flag, real, reals, whole, wholes

__all__ = ["COUPLING_PARAMETERS", "MASTERS", "CouplingMemory", "LeadingValue"]

MASTERS = 4
"""Axes that one axis can follow at the same time (002 §6.4.4.3, 0x4200 + ID:0x40)."""

COUPLING_PARAMETERS = 4
"""Parameters of a coupling (the same)."""


class CouplingMemory(InternalFields):
    """Whom the axis follows, and by which law; what it shows those that follow it."""

    coupling: int = whole(0, "1", "number of the coupling at work, 0 = none")
    master_count: int = whole(0, "1", "axes that it follows", 0, MASTERS)
    master: list[int] = wholes(MASTERS, "1", "their rows")
    followers: int = whole(0, "1", "axes that follow it")
    coupling_parameter: list[float] = reals(COUPLING_PARAMETERS, "1", "as commanded")
    gear: float = real(0.0, "1", "gear ratio now")
    gear_weight: float = real(1.0, "1", "way of the slave for a master's way and a ratio of 1")
    master_before: list[float] = reals(MASTERS, "mm", "what it saw of them in the last cycle")
    master_moved: int = flag(0, "master 1 moved in the last cycle")
    ratio_place: list[int] = wholes(MASTERS, "1", "number of the gear ratio to each, from 0")
    ratio: list[float] = reals(MASTERS, "1", "gear ratios to several masters")
    in_gear: int = flag(0, "it runs as the ratios say and has nothing to catch up")
    gear_velocity: float = real(0.0, "mm/s", "largest velocity behind several masters; 0 = none")
    gear_acceleration: float = real(0.0, "mm/s²", "acceleration towards them")
    gear_deceleration: float = real(0.0, "mm/s²", "deceleration towards them")
    gear_jerk: float = real(0.0, "mm/s³", "jerk towards them; 0 = not limited")
    slave_base: float = real(0.0, "mm", "set position from which the law counts")
    master_base: list[float] = reals(MASTERS, "mm", "positions of the masters there")
    coupling_dead_time: float = real(
        0.0, "s", "how far ahead followers see an encoder axis", 0.0, 60.0
    )
    coupled_offset: float = real(0.0, "mm", "what superposition has added to the law")


class LeadingValue(InternalFields):
    """Values that the followers of an axis receive from it."""

    position: float = real(0.0, "mm", "position")
    velocity: float = real(0.0, "mm/s", "velocity")
    acceleration: float = real(0.0, "mm/s²", "acceleration")
    jerk: float = real(0.0, "mm/s³", "jerk")
    offset: float = real(0.0, "mm", "position of the axis where followers receive 0")
    by_actual: int = flag(0, "the values come from actual values")
    dead_time: float = real(0.0, "s", "dead time that they are extrapolated by")
    frozen: int = flag(0, "the axis was not ready: followers receive the position of then")
