"""The debugger of one PLC: where to stop, how to go on, what is running."""

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING, Any

from achse.plc.code.faults import report_of
from achse.plc.debug.build import CallRecord, DebugBuild, Mark, matching_paths
from achse.plc.debug.carrier import Carrier
from achse.plc.debug.evaluate import EvaluationError, evaluate, text_of
from achse.plc.debug.places import CallView, DebugNames, DebugSpot
from achse.st.typed.project import Routine

if TYPE_CHECKING:
    from achse.plc.runtime import PlcRuntime
    from achse.plc.task import Task

log = logging.getLogger("achse.plc")

_MOST_BREAKPOINTS = 1000
_MOST_CALLS = 200


class DebugError(Exception):
    """Refusal of a request that is impossible now; the message states the reason."""


class StepKind(Enum):
    """End of a step."""

    INTO = "into"
    """To the next statement, in a called routine too."""
    OVER = "over"
    """To the next statement of this routine, or of its caller."""
    OUT = "out"
    """To the caller."""


class StopReason(Enum):
    """Reason why a cycle is stopped."""

    BREAKPOINT = "breakpoint"
    STEP = "step"
    PAUSE = "pause"
    EXCEPTION = "exception"


@dataclass(slots=True)
class Breakpoint:
    """A place to stop at."""

    number: int
    path: str
    line: int
    """Requested line."""
    condition: str = ""
    """An expression that must hold; empty for always."""
    hits_wanted: int = 0
    """Stop from this hit on; 0 and 1: from the first."""
    is_found: bool = False
    """True if there is a statement at the line or after it."""
    found_path: str = ""
    found_line: int = 0
    found_place: str = ""
    """Place in a drawing; empty in text."""
    message: str = ""
    hits: int = 0
    marks: frozenset[int] = field(default_factory=frozenset)


@dataclass(frozen=True, slots=True)
class Stop:
    """Position of a halted cycle."""

    number: int
    """Counts the stops."""
    reason: StopReason
    task: str
    routine: str
    path: str
    line: int
    place: str = ""
    """Place in a drawing: `network 3, rung 1`; empty in text."""
    text: str = ""
    """Message of an exception, or fault of a condition."""
    breakpoints: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class DebugCall:
    """One of the calls inside each other of a halted cycle; the innermost is 0."""

    number: int
    routine: Routine
    path: str
    line: int
    view: CallView
    is_library: bool
    place: str = ""
    """Place in a drawing; empty in text."""


class _Everything:
    """A set with all numbers."""

    def __contains__(self, number: object) -> bool:
        return True


class _Abandoned(BaseException):
    """Ends a halted cycle that is abandoned."""


class Debugger:
    """Stops the tasks of one PLC, and lets them go on.

    `begin` makes the debug build of its code, `end` goes back to the other; in between, `run`
    runs the cycles. Raises `DebugError` for a PLC without Structured Text.
    """

    def __init__(self, plc: "PlcRuntime") -> None:
        self._plc = plc
        if plc.bodies is None or plc.bodies.execution is None:
            raise DebugError(f"{plc.name} runs no Structured Text")
        self.breakpoints: dict[int, Breakpoint] = {}
        self.stop: Stop | None = None
        """Place of a stopped cycle; None while all is running."""
        self.breaks_on_exceptions = True
        self.skips_libraries = True
        """True if steps do not stop in libraries."""
        self.own_paths: frozenset[str] = frozenset()
        """The files of the project itself; none: all are."""
        self.changes = 0
        """Counts stops and going on, so that others see that something happened."""
        self._last = 0
        self._stops = 0
        self._carrier = Carrier()
        self._stack: list[CallRecord] = []
        self._task: Task | None = None
        self._inside = False
        self._abandons = False
        self._step: StepKind | None = None
        self._pauses = False
        self._step_depth = 0
        self._step_task: Task | None = None
        self._last_exception: BaseException | None = None
        self._fuel = 0
        self._at: dict[int, list[Breakpoint]] = {}
        self._build: DebugBuild | None = None
        self._names: DebugNames | None = None
        self._make()

    # the build -------------------------------------------------------------------------------

    @property
    def _execution(self) -> Any:
        assert self._plc.bodies is not None
        return self._plc.bodies.execution

    def _make(self) -> None:
        self._names = DebugNames(self._plc)
        self._build = DebugBuild(
            self._execution,
            {
                "STOPS": frozenset(),
                "called": self._called,
                "returned": self._returned,
                "stopped": self._stopped,
                "raised": self._raised,
            },
        )
        self._build.install()
        self._plc.bind_tasks()
        for breakpoint in self.breakpoints.values():
            self._place(breakpoint)
        self._aim()

    def renew(self) -> None:
        """Make the debug build of the PLC's new code, and find the places again."""
        self._make()

    def end(self) -> None:
        """Forget all breakpoints, let a halted cycle run to its end, and put the
        code back that was there."""
        self.breakpoints.clear()
        self.breaks_on_exceptions = False
        self._step, self._pauses = None, False
        self._aim()
        if self.stop is not None:
            self.go()
        if self._build is not None:
            self._build.remove()
            self._build = None
            self._plc.bind_tasks()
        self.close()

    def close(self) -> None:
        """End the thread; no cycle may be halted."""
        self._carrier.close()

    @property
    def build(self) -> DebugBuild:
        """The code with its marks."""
        assert self._build is not None
        return self._build

    @property
    def names(self) -> DebugNames:
        """Names that expressions may use."""
        assert self._names is not None
        return self._names

    # breakpoints -----------------------------------------------------------------------------

    def add(self, path: str, line: int, condition: str = "", hits: int = 0) -> Breakpoint:
        """Set a breakpoint at the first statement at a line or after it.

        One whose place is not found waits for an online change that brings it. Raises
        `DebugError` if there are too many.
        """
        if len(self.breakpoints) >= _MOST_BREAKPOINTS:
            raise DebugError(f"{_MOST_BREAKPOINTS} breakpoints are there")
        self._last += 1
        breakpoint = Breakpoint(self._last, path, line, condition.strip(), hits)
        self.breakpoints[breakpoint.number] = breakpoint
        self._place(breakpoint)
        self._aim()
        return breakpoint

    def clear(self, numbers: Sequence[int] | None = None) -> None:
        """Forget breakpoints, or all. KeyError for one that is not there."""
        for number in list(self.breakpoints) if numbers is None else numbers:
            del self.breakpoints[number]
        self._aim()

    def _place(self, breakpoint: Breakpoint) -> None:
        place = self.build.at(breakpoint.path, breakpoint.line)
        breakpoint.is_found = place is not None
        breakpoint.marks = frozenset()
        breakpoint.message = ""
        if place is None:
            known = matching_paths(breakpoint.path, self.build.paths)
            breakpoint.message = (
                f"no statement at line {breakpoint.line} or after it"
                if known
                else f"no file of this PLC with statements is named {breakpoint.path!r}"
            )
        else:
            breakpoint.found_path, breakpoint.found_line, breakpoint.marks = place
            mark = self.build.mark(min(breakpoint.marks))
            breakpoint.found_place = "" if mark is None else mark.place

    def _aim(self) -> None:
        """Let the code stop where it has to be looked at."""
        self._at = {}
        for breakpoint in self.breakpoints.values():
            for number in breakpoint.marks:
                self._at.setdefault(number, []).append(breakpoint)
        everything = self._step is not None or self._pauses
        self._execution.namespace["STOPS"] = _Everything() if everything else frozenset(self._at)

    # cycles ----------------------------------------------------------------------------------

    def run(self, task: "Task", cycle: Callable[[], object]) -> None:
        """Run a cycle until it ends or halts. The PLC is notified of its end."""
        self._task = task
        self._stack.clear()
        self._last_exception = None
        self._advance(lambda: self._carrier.run(cycle))

    def _advance(self, go: Callable[[], bool]) -> None:
        self._inside = True
        try:
            ended = go()
        finally:
            self._inside = False
        if not ended:
            self._fuel = self._execution.namespace["F"][0]
            self._execution.frames.hold()
            return
        failure = self._carrier.failure
        task = self._task
        assert task is not None
        if isinstance(failure, _Abandoned):
            failure = None
        if failure is not None and not isinstance(failure, Exception):
            raise failure
        self._plc.end_cycle(task, failure)

    def _resume(self) -> None:
        if self.stop is None:
            raise DebugError("no cycle is halted")
        self.stop = None
        self.changes += 1
        self._execution.namespace["F"][0] = self._fuel
        self._execution.frames.let_go()
        assert self._task is not None
        self._plc.resume_cycle(self._task)
        self._advance(self._carrier.resume)

    def go(self) -> None:
        """Go on. Raises `DebugError` if no cycle is halted."""
        self._step, self._pauses = None, False
        self._aim()
        self._resume()

    def step(self, how: StepKind) -> None:
        """Go on for one step; from the last statement of a cycle to the first of the next.

        Raises `DebugError` if no cycle is halted.
        """
        if self.stop is None:
            raise DebugError("no cycle is halted")
        self._step, self._pauses = how, False
        self._step_depth = len(self._stack)
        self._step_task = self._task
        self._aim()
        self._resume()
        if self.stop is None and self._step is not None:
            self._step = StepKind.INTO  # the cycle is over: the first statement of its next one
            self._aim()

    def pause(self) -> None:
        """Stop at the next statement of any task."""
        if self.stop is None:
            self._pauses = True
            self._aim()

    def abandon(self) -> None:
        """End a halted cycle, without its rest: the PLC stops or begins again."""
        if self.stop is None:
            return
        self._abandons = True
        try:
            while self.stop is not None:
                self.stop = None
                self._execution.frames.let_go()
                self._advance(self._carrier.resume)
        finally:
            self._abandons = False
            self._execution.frames.clear()
            self._stack.clear()
            self.changes += 1

    # what the code calls ---------------------------------------------------------------------

    def _called(self, routine: int, this: int, frame: int) -> CallRecord:
        call = [0, routine, this, frame]
        self._stack.append(call)
        return call

    def _returned(self, call: CallRecord) -> None:
        del self._stack[-1:]

    def _stopped(self, call: CallRecord) -> None:
        if not self._inside:
            return  # a method that a client calls meanwhile
        if self._abandons:
            raise _Abandoned
        mark = self.build.mark(call[0])
        assert mark is not None
        hit, text = self._hits(call)
        if hit:
            numbers = tuple(breakpoint.number for breakpoint in hit)
            self._hold(mark, StopReason.BREAKPOINT, text, numbers)
        elif self._pauses:
            self._hold(mark, StopReason.PAUSE)
        elif self._is_step(mark):
            self._hold(mark, StopReason.STEP)

    def _hits(self, call: CallRecord) -> tuple[list[Breakpoint], str]:
        """Return the breakpoints that stop here, and what is wrong with a condition."""
        hits, text = [], ""
        for breakpoint in self._at.get(call[0], ()):
            if breakpoint.condition:
                try:
                    view = CallView(self.build.routine(call[1]), call[2], call[3])
                    value = evaluate(breakpoint.condition, self.names, view)
                    if not (value.read() if isinstance(value, DebugSpot) else value):
                        continue
                except (EvaluationError, ArithmeticError) as failure:
                    text = f"condition {breakpoint.condition!r}: {failure}"
            breakpoint.hits += 1
            if breakpoint.hits >= breakpoint.hits_wanted:
                hits.append(breakpoint)
        return hits, text

    def _is_step(self, mark: Mark) -> bool:
        step = self._step
        if step is None or self._task is not self._step_task:
            return False
        if self.skips_libraries and self._is_library(mark.path):
            return False
        depth = len(self._stack)
        return (
            step is StepKind.INTO
            or (step is StepKind.OVER and depth <= self._step_depth)
            or (step is StepKind.OUT and depth < self._step_depth)
        )

    def _is_library(self, path: str) -> bool:
        return bool(self.own_paths) and path not in self.own_paths

    def _raised(self, call: CallRecord, failure: BaseException) -> None:
        if not self._inside or self._abandons or failure is self._last_exception:
            return
        self._last_exception = failure
        if not self.breaks_on_exceptions:
            return
        mark = self.build.mark(call[0])
        if mark is None:
            routine = self.build.routine(call[1])
            place = routine.locate(routine.at)
            mark = Mark(routine, place.path, place.line)
        assert self._plc.bodies is not None
        report = report_of(failure, ())
        text = f"{report.name}: {report.message}" if report.message else report.name
        self._hold(mark, StopReason.EXCEPTION, text)

    def _hold(
        self, mark: Mark, reason: StopReason, text: str = "", numbers: tuple[int, ...] = ()
    ) -> None:
        """Halt here until a client steps, runs on or abandons the cycle."""
        assert self._task is not None
        self._step, self._pauses = None, False
        self._stops += 1
        self.changes += 1
        self.stop = Stop(
            self._stops,
            reason,
            self._task.name,
            mark.routine.name,
            mark.path,
            mark.line,
            mark.place,
            text,
            numbers,
        )
        log.info("%s: %s in %s (%s:%s)", self._plc.name, reason.value, *self.stop_place)
        self._aim()
        self._carrier.hold()
        if self._abandons:
            raise _Abandoned

    @property
    def stop_place(self) -> tuple[str, str, int]:
        """Routine, file and line where a cycle is halted."""
        assert self.stop is not None
        return self.stop.routine, self.stop.path, self.stop.line

    # looking ---------------------------------------------------------------------------------

    def calls(self) -> list[DebugCall]:
        """Return the calls of the halted cycle, the innermost first; at most 200."""
        if self.stop is None:
            return []
        calls = []
        for number, call in enumerate(reversed(self._stack[-_MOST_CALLS:])):
            routine = self.build.routine(call[1])
            mark = self.build.mark(call[0])
            place = routine.locate(routine.at)
            path, line = (place.path, place.line) if mark is None else (mark.path, mark.line)
            view = CallView(routine, call[2], call[3])
            drawn = "" if mark is None else mark.place
            is_library = self._is_library(path)
            calls.append(DebugCall(number, routine, path, line, view, is_library, drawn))
        return calls

    def view(self, number: int = 0) -> CallView | None:
        """Return the call of that number; None while all is running. Raises `DebugError`."""
        calls = self.calls()
        if not calls:
            return None
        if not 0 <= number < len(calls):
            raise DebugError(f"there are {len(calls)} calls, got number {number}")
        return calls[number].view

    def evaluate(self, text: str, number: int = 0) -> str:
        """Return the value of an expression, as a literal. Raises `EvaluationError`."""
        return text_of(evaluate(text, self.names, self.view(number)))
