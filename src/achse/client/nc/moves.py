"""A commanded move from its acceptance to its end: done, or ended by something else.

The judges look at one sample of the axis after the other. They raise what ended the motion, answer
True when it is done, and never wait for what cannot come: a command that does not become active, an
axis that does not settle, one that has a job and does not move.
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
"""So many samples in a row must show that an axis is ready."""

_NUMBERS = 1 << 16
"""Command numbers are counted in 16 bits."""


class MotionJudge(Protocol):
    """Says what a sample means for what was commanded."""

    def see(self, status: AxisStatus) -> bool:
        """True when it is done. Raises AxisError for what ended it."""
        ...


def failure_of(axis: str, status: AxisStatus) -> AxisFailed | None:
    """The error of an axis that is in error."""
    if not status.failed:
        return None
    code = status.error_code or NcError.AXIS_NOT_READY.number
    return AxisFailed(code, axis, f"in error at {status.position:.10g}")


def _later(number: int, than: int) -> bool:
    """Return True if a command number was assigned after number `than`; numbers wrap."""
    return 0 < (number - than) % _NUMBERS < _NUMBERS // 2


class _Stall:
    """Notices an axis that has a job and does not move."""

    def __init__(self, axis: str) -> None:
        self._axis = axis
        self._position = nan
        self._since = 0.0

    def see(self, status: AxisStatus, busy: bool) -> None:
        if status.set_position != self._position or not busy:
            self._position, self._since = status.set_position, status.time
        elif status.time - self._since > STALLED_AFTER:
            override = status.motion_state == MotionState.OVERRIDE_ZERO
            why = "its override is 0 %" if override else "it does not say why"
            raise AxisTimeout(
                0,
                self._axis,
                f"has a command, but stands still at {status.position:.10g}"
                f" for {STALLED_AFTER:g} s: {why}",
            )


class CommandJudge:
    """The judge of a command that has a number.

    `endless`: it is done when it has its velocity. `stops`: coming to rest is what it is for.
    `target`: where an absolute one goes to, None if not known.
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
        """A superposed motion leads elsewhere than the command alone."""
        self._idle_since: float | None = None
        self._ended_at: float | None = None

    def see(self, status: AxisStatus) -> bool:
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
            self._stall.see(status, status.has_job)
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
            self._stall.see(status, status.has_job)
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
        # The sample after the handover is beyond the border; the one before is not yet there.
        near = low - _CLOSE <= self._target <= high + _CLOSE
        return near and (before.waiting > 0 or not self._was_active or not before.has_job)

    def _aborted(self, status: AxisStatus, why: str) -> AxisAborted:
        return AxisAborted(0, self._axis, f"{why} at {status.position:.10g}, before it was done")


_CLOSE = 1e-6
"""Units of the axis; nearer than this is there."""


class EnableJudge:
    """The judge of enabling: an axis in error does not get ready, and it has to stay ready.

    A PLC that is linked to the axis may take the enables away in its next cycle.
    """

    def __init__(self, axis: str) -> None:
        self._axis = axis
        self._ready = 0

    def see(self, status: AxisStatus) -> bool:
        failure = failure_of(self._axis, status)
        if failure is not None:
            raise failure
        self._ready = self._ready + 1 if status.enabled else 0
        return self._ready >= READY_SAMPLES


class RestJudge:
    """The judge of a stop: done when nothing is at work and the set point stands."""

    def __init__(self, axis: str) -> None:
        self._axis = axis
        self._stall = _Stall(axis)

    def see(self, status: AxisStatus) -> bool:
        if status.standstill and not status.has_job:
            return True
        failure = failure_of(self._axis, status)
        if failure is not None and status.standstill:
            raise failure
        self._stall.see(status, status.has_job)
        return False


class ReferencingJudge:
    """The judge of a homing, which the NC does, or asks the application to do."""

    def __init__(self, axis: str) -> None:
        self._axis = axis
        self._has_started = False
        self._first: float | None = None
        self._stall = _Stall(axis)

    def see(self, status: AxisStatus) -> bool:
        failure = failure_of(self._axis, status)
        if failure is not None:
            raise failure
        going_on = status.has(StateBit.HOMING_BUSY) or status.application_request
        if self._first is None:
            self._first = status.time
        if going_on:
            self._has_started = True
            self._stall.see(status, busy=True)
            return False
        if status.homed and (self._has_started or status.time > self._first):
            return True
        if self._has_started or status.time > self._first + ACTIVE_WITHIN:
            raise AxisAborted(
                0, self._axis, f"homing ended at {status.position:.10g}, the axis is not homed"
            )
        return False
