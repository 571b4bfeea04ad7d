"""Fields of homing: its latch."""

from achse.motion.fields.declare import InternalFields, flag, real, whole

__all__ = ["HomingMemory"]


class HomingMemory(InternalFields):
    """What a homing sequence remembers from step to step."""

    homing_begins: int = flag(0, "the sequence begins with the next cycle")
    homing_latch: int = whole(0, "1", "latch of the sync pulse: 0 none, 1 waits, 2 has latched")
    homing_latch_position: float = real(0.0, "mm", "position at the sync pulse or the cam's edge")
    homing_latch_begin: float = real(0.0, "mm", "position where the latch was activated")
