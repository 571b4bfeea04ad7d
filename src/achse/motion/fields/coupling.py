"""Fields of an axis that follows others, or that others follow."""

from achse.motion.fields.declare import InternalFields, States, flag, floats, ints, real, whole

MASTERS = 4
"""Axes that one axis can follow at the same time (002 §6.4.4.3, 0x4200 + ID:0x40)."""

COUPLING_PARAMETERS = 4
"""Parameters of a coupling (the same)."""


class SlaveCoupling(InternalFields):
    """Coupling of a slave: its law, its masters and the progress of the law."""

    law: int = whole(0, "1", "number of the coupling in force, 0 = none")
    master_count: int = whole(0, "1", "axes that it follows", 0, MASTERS)
    masters: list[int] = ints(MASTERS, "1", "rows of these axes")
    parameters: list[float] = floats(COUPLING_PARAMETERS, "1", "parameters as commanded")
    slave_base: float = real(0.0, "mm", "set position from which the law counts")
    master_bases: list[float] = floats(MASTERS, "mm", "positions of the masters there")
    masters_before: list[float] = floats(MASTERS, "mm", "positions of the masters a cycle before")
    master_moved: int = flag(0, "master 1 moved in the last cycle")
    offset: float = real(0.0, "mm", "distance that superposition has added to the law")
    gear: float = real(0.0, "1", "gear ratio now")
    gear_weight: float = real(1.0, "1", "slave distance per master distance at a ratio of 1")
    ratio_places: list[int] = ints(MASTERS, "1", "number of the ratio to each master, from 0")
    ratios: list[float] = floats(MASTERS, "1", "gear ratios to several masters")
    in_gear: int = flag(0, "the slave runs as the ratios say and is not behind")
    velocity: float = real(0.0, "mm/s", "largest velocity behind several masters; 0 = none")
    acceleration: float = real(0.0, "mm/s²", "acceleration towards them")
    deceleration: float = real(0.0, "mm/s²", "deceleration towards them")
    jerk: float = real(0.0, "mm/s³", "jerk towards them; 0 = not limited")


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


class Fading(States):
    """Difference between what followers receive and the values of the axis, while it fades."""

    position_difference: float = real(0.0, "mm", "while set values fade to actual values")
    relative_velocity: float = real(0.0, "mm/s", "while set values fade")
    relative_acceleration: float = real(0.0, "mm/s²", "while set values fade")


class Followers(InternalFields):
    """Followers of an axis."""

    followers: int = whole(0, "1", "axes that follow it")
    coupling_dead_time: float = real(
        0.0, "s", "time by which followers extrapolate an encoder axis", 0.0, 60.0
    )
