"""Fields of a slave that synchronises itself with its master: flying saws."""

from achse.motion.fields.declare import InternalFields, flag, floats, real, whole

SYNC_SPANS = 3
"""Spans of a way to the master: two curves with constant velocity between them at most."""

SYNC_TERMS = 6
"""Terms of a span: polynomials of the fifth degree."""


class Synchronisation(InternalFields):
    """Way of a slave to run with its master, and how far it is."""

    state: int = whole(0, "MotionState", "11 before it, 12 on the way, 13 runs with it")
    method: int = whole(0, "1", "what makes the set point, see `couplings.flying_saws.approach`")
    mask: int = whole(0, "SynchronisingBit", "requested checks and operations")
    heading: float = real(1.0, "1", "direction of the master, -1 or 1")
    moved: int = flag(0, "the slave moved when it began")
    begin: float = real(0.0, "mm", "position of the master where it begins")
    begin_position: float = real(0.0, "mm", "position of the slave there")
    begin_velocity: float = real(0.0, "mm/s", "velocity of the slave there")
    begin_acceleration: float = real(0.0, "mm/s²", "acceleration of the slave there")
    master_velocity: float = real(0.0, "mm/s", "velocity of the master at coupling")
    master_acceleration: float = real(0.0, "mm/s²", "acceleration of the master there")
    velocity: float = real(0.0, "mm/s", "largest velocity")
    acceleration: float = real(0.0, "mm/s²", "largest acceleration")
    deceleration: float = real(0.0, "mm/s²", "largest deceleration")
    jerk: float = real(0.0, "mm/s³", "largest jerk")
    last_master_position: float = real(0.0, "mm", "leading position of the last cycle")
    pursued_velocity: float = real(0.0, "mm/s", "velocity that it pursued then")
    pursued_acceleration: float = real(0.0, "mm/s²", "acceleration that it pursued then")
    offset: float = real(0.0, "mm", "how far it was beside its place then")
    count: int = whole(0, "1", "spans of the way", 0, SYNC_SPANS)
    length: list[float] = floats(SYNC_SPANS, "mm", "way of the master in each span")
    terms: list[float] = floats(SYNC_SPANS * SYNC_TERMS, "mm", "terms of each span")
