"""Conditions of an axis to wait for: a word, a state, a bit of its status, or a function."""

import difflib
from collections.abc import Callable

from achse.client.nc.moves import failure_of
from achse.client.nc.status import AxisStatus, PlcOpenState
from achse.codes.axis import StateBit

AxisCondition = str | PlcOpenState | StateBit | Callable[[AxisStatus], object]

CONDITIONS: dict[str, Callable[[AxisStatus], bool]] = {
    "in target": lambda status: status.in_target,
    "standstill": lambda status: status.standstill,
    "moving": lambda status: not status.standstill,
    "idle": lambda status: not status.has_job and not status.waiting,
    "enabled": lambda status: status.enabled,
    "disabled": lambda status: not status.enabled,
    "homed": lambda status: status.homed,
    "referenced": lambda status: status.homed,
    "constant velocity": lambda status: status.has(StateBit.CONSTANT_VELOCITY),
    "failed": lambda status: status.failed,
}
"""Functions by condition word; underscores count as spaces, case does not count."""


def condition_of(condition: AxisCondition) -> tuple[Callable[[AxisStatus], object], str]:
    """Return the function of a condition and its name. ValueError for an unknown word."""
    if isinstance(condition, StateBit):
        bit = condition
        return lambda status: status.has(bit), bit.name.lower().replace("_", " ")
    if isinstance(condition, PlcOpenState):
        state = condition
        return lambda status: status.state is state, state.value
    if isinstance(condition, str):
        word = condition.strip().lower().replace("_", " ")
        if word not in CONDITIONS:
            near = difflib.get_close_matches(word, CONDITIONS)
            hint = f"; did you mean {near[0]!r}?" if near else ""
            raise ValueError(f"expected one of {', '.join(CONDITIONS)}, got {condition!r}{hint}")
        return CONDITIONS[word], word
    if callable(condition):
        return condition, "its condition"
    raise ValueError(f"a condition is a word, a state, a bit or a function, got {condition!r:.60}")


class ConditionCompletion:
    """Completion of a wait for a condition; a new error of the axis ends it."""

    def __init__(self, axis: str, holds: Callable[[AxisStatus], object]) -> None:
        self._axis = axis
        self._holds = holds
        self._failed: bool | None = None

    def check(self, status: AxisStatus) -> bool:
        if self._holds(status):
            return True
        failure = failure_of(self._axis, status)
        if self._failed is None:
            self._failed = failure is not None  # the condition may be the end of an old error
        if failure is not None and not self._failed:
            raise failure
        return False
