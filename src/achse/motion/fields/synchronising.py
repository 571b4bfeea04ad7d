"""Fields of a slave that synchronises itself with its master: flying saws."""

from achse.motion.fields.declare import InternalFields, flag, real, reals, whole

__all__ = ["SYNC_PIECES", "SYNC_TERMS", "SynchronisingMemory"]

SYNC_PIECES = 3
"""Pieces of a way to the master: two curves with constant velocity between them at most."""

SYNC_TERMS = 6
"""Terms of a piece: polynomials of the fifth degree."""


class SynchronisingMemory(InternalFields):
    """How the slave comes to run with its master, and how far it is."""

    sync_state: int = whole(0, "MotionState", "11 before it, 12 on the way, 13 runs with it")
    sync_method: int = whole(0, "1", "what makes the set point, see `couplings.approach`")
    sync_mask: int = whole(0, "SynchronisingBit", "checks and operations that are asked for")
    sync_heading: float = real(1.0, "1", "direction of the master, -1 or 1")
    sync_moved: int = flag(0, "the slave moved when it began")
    sync_begin: float = real(0.0, "mm", "position of the master where it begins")
    sync_begin_position: float = real(0.0, "mm", "position of the slave there")
    sync_begin_velocity: float = real(0.0, "mm/s", "velocity of the slave there")
    sync_begin_acceleration: float = real(0.0, "mm/s²", "acceleration of the slave there")
    sync_master_velocity: float = real(0.0, "mm/s", "velocity of the master at coupling")
    sync_master_acceleration: float = real(0.0, "mm/s²", "acceleration of the master there")
    sync_velocity: float = real(0.0, "mm/s", "largest velocity")
    sync_acceleration: float = real(0.0, "mm/s²", "largest acceleration")
    sync_deceleration: float = real(0.0, "mm/s²", "largest deceleration")
    sync_jerk: float = real(0.0, "mm/s³", "largest jerk")
    sync_seen: float = real(0.0, "mm", "what the slave saw of the master in the last cycle")
    sync_lead_velocity: float = real(0.0, "mm/s", "velocity that it was after then")
    sync_lead_acceleration: float = real(0.0, "mm/s²", "acceleration that it was after then")
    sync_offset: float = real(0.0, "mm", "how far it was beside its place then")
    sync_count: int = whole(0, "1", "pieces of the way", 0, SYNC_PIECES)
    sync_length: list[float] = reals(SYNC_PIECES, "mm", "way of the master in each piece")
    sync_terms: list[float] = reals(SYNC_PIECES * SYNC_TERMS, "mm", "terms of each piece")
