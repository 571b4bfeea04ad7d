"""A move from its start to its end: commanded, followed sample by sample, and reported."""

import asyncio
import contextlib
import sys
from collections.abc import Mapping, Sequence
from math import inf
from typing import Any, NamedTuple, Protocol

from achse.ams.errors import describe_code
from achse.cli.axes.nc import NcAxis
from achse.cli.axes.trace import Trace
from achse.cli.failure import in_json
from achse.cli.output import decimal
from achse.codes import NcError
from achse.codes.axis import MotionState, OperationModeBit, StartType, StateBit

ENDLESS = (StartType.ENDLESS_POSITIVE, StartType.ENDLESS_NEGATIVE)

ACTIVE_WITHIN = 1.0
"""Seconds of the station's time until an accepted command must be the active one."""

SETTLED_WITHIN = 5.0
"""Seconds from the end of the set-point profile until the axis must be in its window."""


AFTERWARDS = 0.1
"""Seconds that the trace goes on when the move is done, to show how the axis comes to rest."""


LINE_EVERY = 5.0
"""Seconds of the axis' time between lines of progress."""


class Errand(Protocol):
    """Command to an axis that can be followed."""

    @property
    def endless(self) -> bool:
        """True if no target exists to measure progress by."""

    async def begin(self, axis: NcAxis) -> "CommandOutcome":
        """Command it. Raises AdsError."""


class Order(NamedTuple):
    """A move. Zeros in the dynamics mean those of the axis."""

    start_type: StartType
    position: float
    velocity: float
    acceleration: float = 0.0
    deceleration: float = 0.0
    jerk: float = 0.0

    @property
    def endless(self) -> bool:
        return self.start_type in ENDLESS

    async def begin(self, axis: NcAxis) -> "MoveOutcome":
        return MoveOutcome(axis, self, await start(axis, self))


class Course(NamedTuple):
    """Course of a command: it took `seconds`; `trouble` is the reason of its failure, None if it
    was done."""

    trace: Trace
    target: float
    seconds: float
    trouble: str | None
    steps: Sequence[tuple[float, str]] = ()
    """Moments that have a name, in seconds since the first sample."""


async def start(axis: NcAxis, order: Order) -> int:
    """Command the move by universal start; gives the command's number. Raises AdsError."""
    number, _ = await axis.remote.call(
        "universal_axis_start",
        order.start_type,
        end_position=order.position,
        velocity=order.velocity,
        acceleration=order.acceleration,
        deceleration=order.deceleration,
        jerk=order.jerk,
    )
    return int(number)


async def own_velocity(axis: NcAxis) -> tuple[float, str]:
    """Return the velocity of a move that names none, and its name: rapid traverse or the
    largest."""
    rapid = float(await axis.remote.parameters["rapid_traverse_velocity"])
    largest = float(await axis.remote.parameters["max_velocity"])
    if 0 < rapid <= largest:
        return rapid, "rapid traverse velocity"
    return largest, "largest velocity"


async def _started(axis: NcAxis, errand: Errand) -> "CommandOutcome":
    """Command it. If cancelled, wait for the answer first: the axis may move."""
    starting = asyncio.ensure_future(errand.begin(axis))
    try:
        return await asyncio.shield(starting)
    except asyncio.CancelledError:
        outcome = await starting
        await _interrupt(axis, outcome)
        return outcome


async def _interrupt(axis: NcAxis, outcome: "CommandOutcome") -> None:
    """Stop the axis after a cancellation."""
    task = asyncio.current_task()
    assert task is not None
    task.uncancel()
    outcome.interrupted = True
    await axis.remote.call("stop")


async def follow(axis: NcAxis, errand: Errand, sample_time: float) -> Course:
    """Command an axis and watch it until the command is done, or has failed.

    A move to a target is done when the axis is in its window, an endless one when it has its
    velocity. Cancelling stops the axis: the course then ends at standstill with that reason.
    """
    trace = Trace(axis.unit)
    progress = _Progress(axis, errand)  # its imports take time in which samples would queue
    async with axis.samples(sample_time) as samples:
        with progress:
            first = await anext(samples)
            trace.add(first.filetime, axis.sample(first.value))
            outcome = await _started(axis, errand)
            before = samples.pending  # of a time at which the NC may not have known the command
            while not outcome.is_finished and outcome.trouble is None:
                try:
                    sample = await anext(samples)
                except asyncio.CancelledError:
                    if outcome.interrupted:
                        raise
                    await _interrupt(axis, outcome)
                    continue
                values = axis.sample(sample.value)
                seconds = trace.add(sample.filetime, values)
                outcome.add(seconds, values, before=before > 0)
                if outcome.is_overdue:
                    outcome.is_overdue = False
                    await axis.remote.call("stop")
                before -= 1
                progress.show(seconds, values)
        while outcome.is_finished and trace.times[-1] < seconds + AFTERWARDS:
            sample = await anext(samples)
            trace.add(sample.filetime, axis.sample(sample.value))
        took = seconds - outcome.began
        return Course(trace, outcome.target, took, outcome.trouble, outcome.steps)


class CommandOutcome:
    """Evaluation of the samples of a command: it goes on, is done, or is in trouble."""

    def __init__(self, axis: NcAxis, target: float = 0.0) -> None:
        self.axis = axis
        self.target = target
        self.is_finished = False
        self.trouble: str | None = None
        self.is_overdue = False
        """True if its time is over: `follow` then stops the axis, and continues until it is at
        standstill."""
        self.interrupted = False
        """True if the axis was commanded to stop; the standstill is the end."""
        self.began = 0.0
        """Time at which the command was last seen not yet active."""
        self.steps: list[tuple[float, str]] = []

    def add(self, seconds: float, values: Mapping[str, Any], *, before: bool = False) -> None:
        """Evaluate a sample, taken so many seconds after the first.

        `before`: perhaps before the command was accepted. At many times the speed of the clock
        seconds pass between the command and its answer.
        """
        raise NotImplementedError

    def failure(self, values: Mapping[str, Any]) -> str | None:
        """Return the reason that ends any command: an error, or the stop after an interruption;
        else None."""
        here = f"{decimal(values['actual_position'])} {self.axis.unit}"
        if values["error_code"]:
            return f"{self.axis}: {describe_code(values['error_code'])} At {here}."
        if self.interrupted and values["state_dword"] & StateBit.NOT_MOVING:
            return f"interrupted: {self.axis} stopped at {here}"
        return None


class MoveOutcome(CommandOutcome):
    """Outcome of a move."""

    def __init__(self, axis: NcAxis, order: Order, number: int) -> None:
        super().__init__(axis, order.position)
        self.order = order
        self.number = number
        self._was_active = False
        self._accepted_at = inf
        self._ended_at = inf

    def add(self, seconds: float, values: Mapping[str, Any], *, before: bool = False) -> None:
        state = values["state_dword"]
        here = f"{decimal(values['actual_position'])} {self.axis.unit}"
        active = values["set_command_number"] == self.number
        if active:
            self.target = values["target_position"]
        elif not self._was_active:
            self.began = seconds
            if before:
                return
            self._accepted_at = min(self._accepted_at, seconds)
        self.trouble = self.failure(values)
        if self.trouble is not None or self.interrupted:
            pass
        elif not active:
            if self._was_active:
                self.trouble = f"{self.axis}: another command took over at {here}"
            elif seconds > self._accepted_at + ACTIVE_WITHIN:
                code = describe_code(NcError.PLC_COMMAND_NOT_ACTIVE.number)
                self.trouble = f"{self.axis}: {code}"
        elif state & StateBit.HAS_JOB:
            cruising = values["motion_state"] == MotionState.CONSTANT_VELOCITY
            self.is_finished = self.order.endless and cruising
        elif state & StateBit.HAS_BEEN_STOPPED:
            self.trouble = f"{self.axis}: stopped at {here}, before it was done"
        elif _in_window(values):
            self.is_finished = True
        else:
            self._ended_at = min(self._ended_at, seconds)
            if seconds > self._ended_at + SETTLED_WITHIN:
                self.trouble = (
                    f"{self.axis}: at {here}, not in its window {SETTLED_WITHIN:g} s after the move"
                )
        self._was_active = active


def _in_window(values: Mapping[str, Any]) -> bool:
    """Return True if the axis is in its target window, as far as the NC monitors one."""
    watched = values["operation_mode_and_cycle"]
    if watched & OperationModeBit.TARGET_POSITION_MONITORING:
        return bool(values["state_dword"] & StateBit.IN_TARGET_POSITION)
    if watched & OperationModeBit.POSITION_AREA_MONITORING:
        return bool(values["state_dword"] & StateBit.IN_POSITION_AREA)
    return True


class _Progress:
    """A bar on stderr while the axis moves; without a terminal, a line now and then."""

    def __init__(self, axis: NcAxis, errand: Errand) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        self._axis = axis
        self._endless = errand.endless
        self._begin: float | None = None
        self._next_line = LINE_EVERY
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(bar_width=36),
            TextColumn("{task.fields[figures]}"),
            TimeElapsedColumn(),
            console=Console(stderr=True),
            transient=True,
            disable=not sys.stderr.isatty(),
        )
        self._task = self._bar.add_task(str(axis), total=None, figures="")

    def __enter__(self) -> "_Progress":
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        with contextlib.suppress(OSError):
            self._bar.stop()

    def show(self, seconds: float, values: Mapping[str, Any]) -> None:
        """Show where the axis is, so many seconds after the begin."""
        position, unit = values["actual_position"], self._axis.unit
        if self._begin is None:
            self._begin = position
        if not self._endless:
            total = abs(values["target_position"] - self._begin)
            done = min(abs(position - self._begin), total)
            self._bar.update(self._task, total=total or 1.0, completed=done or total == 0.0)
        figures = f"{position:10.3f} {unit}  {values['actual_velocity']:9.2f} {unit}/s"
        if not self._bar.disable:
            self._bar.update(self._task, figures=figures)
        elif seconds >= self._next_line and not in_json():
            self._next_line = seconds + LINE_EVERY
            with contextlib.suppress(OSError):  # the terminal has gone: the axis is watched on
                print(f"{self._axis}: {figures.strip()}", file=sys.stderr, flush=True)
