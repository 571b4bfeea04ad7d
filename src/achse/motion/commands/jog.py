"""Manual travel: start types whose velocity or distance is a parameter of the axis (004 §3.1.2)."""

from collections.abc import Mapping
from dataclasses import dataclass

from achse.codes.axis import JogType, StartType
from achse.motion.axis import Axis


@dataclass(frozen=True, slots=True)
class Jog:
    """One of the types: endless at a velocity of the axis, or a step at the commanded velocity.

    `parameters` name velocity or distance, for positive and negative travel; without them `step`
    is the distance in axis units.
    """

    parameters: tuple[str, str] = ("", "")
    step: float = 0.0
    endless: bool = False


_SLOW, _FAST, _RAPID = "jog_velocity_slow", "jog_velocity_fast", "rapid_traverse_velocity"

_KINDS = {
    JogType.SLOW: Jog((_SLOW, _SLOW), endless=True),
    JogType.FAST: Jog((_FAST, _FAST), endless=True),
    JogType.RAPID: Jog((_RAPID, _RAPID), endless=True),
    JogType.PULSE: Jog(("pulse_distance_positive", "pulse_distance_negative")),
    JogType.STEP_0_001: Jog(step=0.001),
    JogType.STEP_0_01: Jog(step=0.01),
    JogType.STEP_0_1: Jog(step=0.1),
    JogType.STEP_1: Jog(step=1.0),
}

JOGS: Mapping[int, Jog] = {
    kind + negative: jog for kind, jog in _KINDS.items() for negative in (0, 1)
}
"""The start types 272 … 1313; odd ones lead to smaller positions."""


def as_plain_start(axis: Axis, start_type: int, velocity: float) -> tuple[StartType, float, float]:
    """Start type, distance and velocity that a jog stands for."""
    jog = JOGS[start_type]
    negative = start_type & 1
    name = jog.parameters[negative]
    value: float = getattr(axis, name) if name else jog.step
    if jog.endless:
        kind = StartType.ENDLESS_NEGATIVE if negative else StartType.ENDLESS_POSITIVE
        return kind, 0.0, value
    return StartType.RELATIVE, -value if negative else value, velocity
