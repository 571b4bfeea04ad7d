"""Homing from its start to its end, step by step."""

from collections.abc import Mapping
from math import inf
from typing import Any

from achse.cli.axes.move import ACTIVE_WITHIN, CommandOutcome
from achse.cli.axes.nc import NcAxis
from achse.cli.output import decimal
from achse.codes.axis import HomingState, OperationModeBit, StateBit


class Homing:
    """Homing as the reference mode of the axis says."""

    endless = True

    async def begin(self, axis: NcAxis) -> "HomingOutcome":
        await axis.remote.home(wait=False)
        return HomingOutcome(axis)


class HomingOutcome(CommandOutcome):
    """Outcome of a homing by the NC, or by the application at its request."""

    def __init__(self, axis: NcAxis) -> None:
        super().__init__(axis)
        self._has_started = False
        self._accepted_at = inf

    def add(self, seconds: float, values: Mapping[str, Any], *, before: bool = False) -> None:
        state, step = values["state_dword"], values["homing_state"]
        requested = values["operation_mode_and_cycle"] & OperationModeBit.APPLICATION_REQUEST
        going_on = bool(state & StateBit.HOMING_BUSY or requested)
        if not self._has_started and not going_on:
            self.began = seconds
            if before:
                return
            self._accepted_at = min(self._accepted_at, seconds)
        self._has_started |= going_on
        if step and step in HomingState.__members__.values():
            name = HomingState(step).name
            if not self.steps or self.steps[-1][1] != name:
                self.steps.append((seconds - self.began, name))
        self.trouble = self.failure(values)
        if self.trouble is not None or self.interrupted or going_on:
            return
        if self._has_started or seconds > self._accepted_at + ACTIVE_WITHIN:
            self.target = values["actual_position"]
            self.is_finished = bool(state & StateBit.HOMED)
            if not self.is_finished:
                here = f"{decimal(self.target)} {self.axis.unit}"
                self.trouble = f"{self.axis}: homing ended at {here}, the axis is not homed"
