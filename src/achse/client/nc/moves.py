"""Completion of a command: conditions that its samples fulfil, or errors that end it.

A completion checks one sample of the axis after the other. It returns True when the command is
done, raises the error that ended it, and raises AxisTimeout for a command that does not become
active, an axis that does not settle, and an axis with a job that does not move.
"""

from math import nan, ulp
from typing import Protocol

from achse.client.nc.errors import AxisAborted, AxisDisabled, AxisFailed, AxisTimeout
from achse.client.nc.status import AxisStatus
from achse.codes import NcError
from achse.codes.axis import MotionState, StateBit

ACTIVE_WITHIN = 1.0
"""Seconds of the controller's time until an accepted command must be the active one, or wait."""

SETTLED_WITHIN = 5.0
"""Seconds from the end of the set-point profile until the axis must be in its window."""

STALLED_AFTER = 10.0
"""Seconds in which an axis with a job must have moved."""

READY_SAMPLES = 3
"""Number of successive samples in which an axis must be ready."""

_NUMBERS = 1 << 16
"""Command numbers are counted in 16 bits."""


class Completion(Protocol):
    """Completion condition of a command."""

    def check(self, status: AxisStatus) -> bool:
        """Return True if the command is done; raises AxisError for its failure."""
        ...


def failure_of(axis: str, status: AxisStatus) -> AxisFailed | None:
    """Return the error of an axis that is in error."""
    if not status.failed:
        return None
    code = status.error_code or NcError.AXIS_NOT_READY.number
    return AxisFailed(code, axis, f"in error at {status.position:.10g}")


def _later(number: int, than: int) -> bool:
    """Return True if a command number was assigned after number `than`; numbers wrap."""
    return 0 < (number - than) % _NUMBERS < _NUMBERS // 2


class _Stall:
    """Detector of an axis that has a job and does not move."""

    def __init__(self, axis: str) -> None:
        self._axis = axis
        self._position = nan
        self._since = 0.0

    def check(self, status: AxisStatus, busy: bool) -> None:
        if status.set_position != self._position or not busy:
            self._position, self._since = status.set_position, status.time
        elif status.time - self._since > STALLED_AFTER:
            override = status.motion_state == MotionState.OVERRIDE_ZERO
            why = "its override is 0 %" if override else "reason unknown"
            raise AxisTimeout(
                0,
                self._axis,
                f"has a command, but is at standstill at {status.position:.10g}"
                f" for {STALLED_AFTER:g} s: {why}",
            )


class CommandCompletion:
    """Completion of a command that has a number.

    `endless`: it is done when it has its velocity. `stops`: it is done at standstill. `target`:
    target position of an absolute command, None if unknown.
    """

    def __init__(
        self,
        axis: str,
        number: int,
        *,
        endless: bool = False,
        stops: bool = False,
        target: float | None = None,
    ) -> None:
        self._axis = axis
        self._number = number
        self._endless = endless
        self._stops = stops
        self._target = target
        self._stall = _Stall(axis)
        self._before: AxisStatus | None = None
        self._was_active = False
        self._compensated = False
        """True if a superposed motion has changed the end of the command."""
        self._idle_since: float | None = None
        self._ended_at: float | None = None

    def check(self, status: AxisStatus) -> bool:
        failure = failure_of(self._axis, status)
        if failure is not None:
            raise failure
        if status.command_number == self._number:
            done = self._active(status)
            self._was_active = True
        else:
            done = self._not_active(status)
        self._before = status
        return done

    def _active(self, status: AxisStatus) -> bool:
        self._compensated |= status.has(StateBit.COMPENSATING)
        if not status.has_job:
            return self._at_rest(status)
        if not self._stops:
            if self._target is None and not self._endless:
                self._target = status.target_position
            if not status.enabled:
                raise AxisDisabled(0, self._axis, f"lost its enable at {status.position:.10g}")
            if status.motion_state == MotionState.CONSTANT_VELOCITY and self._endless:
                return True
        if not (self._endless and status.has(StateBit.CONSTANT_VELOCITY)):
            self._stall.check(status, status.has_job)
        return False

    def _at_rest(self, status: AxisStatus) -> bool:
        if self._stops:
            return status.standstill
        if self._endless or status.has(StateBit.HAS_BEEN_STOPPED) or not self._near(status):
            raise self._aborted(status, "was stopped, or its target changed,")
        if status.in_target:
            return True
        if self._ended_at is None:
            self._ended_at = status.time
        if status.time > self._ended_at + SETTLED_WITHIN:
            raise AxisTimeout(
                0,
                self._axis,
                f"at {status.position:.10g}, not in its window {SETTLED_WITHIN:g} s after the move",
            )
        return False

    def _near(self, status: AxisStatus) -> bool:
        """Return True if the set point is at the target of the command."""
        target = status.target_position if self._target is None else self._target
        away = abs(status.set_position - target)
        return self._compensated or away <= max(_CLOSE, 8 * ulp(target))

    def _not_active(self, status: AxisStatus) -> bool:
        if self._was_active or _later(status.command_number, self._number):
            if self._passed(status):
                return True
            raise self._aborted(status, f"command {status.command_number} took over")
        if status.has_job or status.waiting:
            self._idle_since = None
            self._stall.check(status, status.has_job)
            return False
        if self._idle_since is None:
            self._idle_since = status.time
        if status.time > self._idle_since + ACTIVE_WITHIN:
            raise AxisAborted(
                NcError.PLC_COMMAND_NOT_ACTIVE.number, self._axis, f"command {self._number}"
            )
        return False

    def _passed(self, status: AxisStatus) -> bool:
        """Return True if the command was done when a buffered command took over."""
        if self._stops:
            return True
        if self._endless:
            return self._before is not None and self._before.waiting > 0
        if self._target is None:
            return False
        before = status if self._before is None else self._before
        low, high = sorted((before.set_position, status.set_position))
        # The sample after the handover is beyond the border, the sample before is not.
        near = low - _CLOSE <= self._target <= high + _CLOSE
        return near and (before.waiting > 0 or not self._was_active or not before.has_job)

    def _aborted(self, status: AxisStatus, why: str) -> AxisAborted:
        return AxisAborted(0, self._axis, f"{why} at {status.position:.10g}, before it was done")


_CLOSE = 1e-6
"""Largest distance from the target of an axis that has reached it, units of the axis."""


class EnableCompletion:
    """Completion of enabling: the axis is ready and stays so; an error ends it.

    A PLC that is linked to the axis may take the enables away in its next cycle.
    """

    def __init__(self, axis: str) -> None:
        self._axis = axis
        self._ready = 0

    def check(self, status: AxisStatus) -> bool:
        failure = failure_of(self._axis, status)
        if failure is not None:
            raise failure
        self._ready = self._ready + 1 if status.enabled else 0
        return self._ready >= READY_SAMPLES


class StandstillCompletion:
    """Completion of a stop: no job, and the set point is at standstill."""

    def __init__(self, axis: str) -> None:
        self._axis = axis
        self._stall = _Stall(axis)

    def check(self, status: AxisStatus) -> bool:
        if status.standstill and not status.has_job:
            return True
        failure = failure_of(self._axis, status)
        if failure is not None and status.standstill:
            raise failure
        self._stall.check(status, status.has_job)
        return False


class HomingCompletion:
    """Completion of a homing by the NC, or by the application at its request."""

    def __init__(self, axis: str) -> None:
        self._axis = axis
        self._has_started = False
        self._first: float | None = None
        self._stall = _Stall(axis)

    def check(self, status: AxisStatus) -> bool:
        failure = failure_of(self._axis, status)
        if failure is not None:
            raise failure
        is_busy = status.has(StateBit.HOMING_BUSY) or status.application_request
        if self._first is None:
            self._first = status.time
        if is_busy:
            self._has_started = True
            self._stall.check(status, busy=True)
            return False
        if status.homed and (self._has_started or status.time > self._first):
            return True
        if self._has_started or status.time > self._first + ACTIVE_WITHIN:
            raise AxisAborted(
                0, self._axis, f"homing ended at {status.position:.10g}, the axis is not homed"
            )
        return False
