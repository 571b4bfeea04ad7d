"""Fields of homing: its step and its latch."""

from achse.motion.fields.declare import InternalFields, States, flag, real, whole


class HomingStep(States):
    """Step of a homing sequence (002 §6.4.4.2)."""

    state: int = whole(0, "1", "step of the homing sequence, 0 = done")


class HomingSequence(InternalFields):
    """Memory of a homing sequence from step to step."""

    begins: int = flag(0, "the sequence begins with the next cycle")
    latch: int = whole(0, "1", "latch of the sync pulse: 0 none, 1 waits, 2 has latched")
    latch_position: float = real(0.0, "mm", "position at the sync pulse or the cam's edge")
    latch_begin: float = real(0.0, "mm", "position where the latch was activated")


class AxisHoming(HomingStep, HomingSequence):
    """Homing of an axis."""
