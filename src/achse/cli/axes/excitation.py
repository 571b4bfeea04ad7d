"""An excitation of an axis: a function that moves it until its time is over."""

from collections.abc import Mapping
from math import inf
from typing import Any, NamedTuple

from achse.cli.axes.move import ACTIVE_WITHIN, CommandOutcome
from achse.cli.axes.nc import NcAxis
from achse.cli.output import decimal
from achse.codes.axis import StateBit


class Excitation(NamedTuple):
    """A function by its name, with its arguments, and how many seconds of the axis' time it has."""

    function: str
    arguments: tuple[float, ...]
    seconds: float

    @property
    def endless(self) -> bool:
        return True

    async def begin(self, axis: NcAxis) -> "ExcitationOutcome":
        await axis.remote.call(self.function, *self.arguments)
        return ExcitationOutcome(axis, self.seconds)


class ExcitationOutcome(CommandOutcome):
    """Outcome of an excitation: it ends by itself or with its time, and is done at standstill."""

    def __init__(self, axis: NcAxis, seconds: float) -> None:
        super().__init__(axis)
        self._seconds = seconds
        self._has_started = self._released = False
        self._accepted_at = inf

    def add(self, seconds: float, values: Mapping[str, Any], *, before: bool = False) -> None:
        state = values["state_dword"]
        going_on = bool(state & StateBit.HAS_JOB)
        self.target = values["actual_position"]
        if not self._has_started and not going_on:
            self.began = seconds
            if before:
                return
            self._accepted_at = min(self._accepted_at, seconds)
        self._has_started |= going_on
        self.trouble = self.failure(values)
        if self.trouble is not None or self.interrupted:
            return
        if self._released:
            self.is_finished = bool(state & StateBit.NOT_MOVING) and not going_on
        elif going_on:
            self.is_overdue = self._released = seconds - self.began >= self._seconds
        elif self._has_started and not state & StateBit.HAS_BEEN_STOPPED:
            self.is_finished = True
        elif self._has_started or seconds > self._accepted_at + ACTIVE_WITHIN:
            here = f"{decimal(self.target)} {self.axis.unit}"
            what = "was stopped" if self._has_started else "did not begin"
            self.trouble = f"{self.axis}: {what} at {here}"
