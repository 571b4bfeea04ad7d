"""Fault places: places in machine code that a fault comes from or through, and what it is then."""

import ast
from array import array
from collections.abc import Mapping, Sequence
from enum import IntEnum
from functools import lru_cache
from types import CodeType, FrameType, TracebackType
from typing import NamedTuple

from achse.native.backend import MachineFault, OwnFault
from achse.plc.code.faults import ExceptionCode, PlcFault
from achse.plc.code.frames import STACK_SIZE
from achse.st.typed.project import Routine


class FaultKind(IntEnum):
    """Kind of fault at a site."""

    CALL = 0
    """A fault of what is called comes through."""
    BUDGET = 1
    DEPTH = 2
    FRAMES = 3
    DIVIDE = 4
    REAL_DIVIDE = 5
    REAL_INVALID = 6
    BOUNDS = 7
    """With the index, and both bounds in one word."""
    ACCESS = 8
    """With the address."""
    ALIGNMENT = 9
    RAISED = 10
    """With the code."""


class FaultPlace(NamedTuple):
    """A place: number of the routine in its project, offset in its source, what happens there."""

    routine: int
    at: int
    kind: FaultKind


_HALF = 1 << 31
_WORD = (1 << 32) - 1


def _signed(word: int) -> int:
    return (word & _WORD ^ _HALF) - _HALF


class FaultPlaces:
    """All fault places of a module, by the number in its code: from 1 up."""

    def __init__(self, content: bytes = b"") -> None:
        words = array("q", content)
        self._rows = [
            FaultPlace(words[at], words[at + 1], FaultKind(words[at + 2]))
            for at in range(0, len(words), 3)
        ]
        self._numbers: dict[FaultPlace, int] = {}

    def number(self, routine: int, at: int, kind: FaultKind) -> int:
        """Return the number of a site, a new one if there is none like it."""
        site = FaultPlace(routine, at, kind)
        number = self._numbers.get(site)
        if number is None:
            self._rows.append(site)
            number = self._numbers[site] = len(self._rows)
        return number

    @property
    def content(self) -> bytes:
        """All of it, for the cache."""
        return array("q", (word for row in self._rows for word in row)).tobytes()

    def __getitem__(self, number: int) -> FaultPlace:
        return self._rows[number - 1]

    def failure(
        self,
        failure: BaseException,
        places: Sequence[int],
        routines: Sequence[Routine],
        budget: int,
    ) -> BaseException:
        """Return the exception of a fault as plain code raises it, with the places it came
        through."""
        trail = list(places)
        if isinstance(failure, MachineFault):
            is_own = failure.number == OwnFault.TOO_DEEP  # of a call from Python: it has no place
            kind = FaultKind.DEPTH if is_own else self[failure.number].kind
            # A call too deep is its caller's fault.
            if kind is not FaultKind.DEPTH or not (is_own or trail):
                trail.insert(0, failure.number)
            failure = _fault(kind, failure.first, failure.second, budget)
        trace = failure.__traceback__
        for number in trail:
            site = self[number]
            trace = _traced(routines[site.routine], site.at, trace)
        try:
            return failure.with_traceback(trace)
        finally:
            del failure, trace  # this frame is in the traceback: they would refer to each other


def _fault(kind: FaultKind, first: int, second: int, budget: int) -> PlcFault:
    code, says = _MEANINGS[kind]
    word = first & (1 << 64) - 1
    if kind is FaultKind.ACCESS and not word:
        return PlcFault(code, "address 0")
    if kind is FaultKind.RAISED:
        return PlcFault(word & _WORD, says)
    return PlcFault(
        code,
        says.format(
            budget=budget,
            index=first,
            low=_signed(second >> 32),
            high=_signed(second),
            address=word,
            room=STACK_SIZE,
        ),
    )


_MEANINGS: Mapping[FaultKind, tuple[int, str]] = {
    FaultKind.BUDGET: (
        ExceptionCode.CYCLE_TIME_EXCEED,
        "{budget} loop passes and calls in one cycle: an endless loop?",
    ),
    FaultKind.DEPTH: (
        ExceptionCode.STACK_OVERFLOW,
        "calls inside each other are too deep: a recursion without end?",
    ),
    FaultKind.FRAMES: (ExceptionCode.STACK_OVERFLOW, "{room} bytes of frames are full"),
    FaultKind.DIVIDE: (ExceptionCode.DIVIDEBYZERO, ""),
    FaultKind.REAL_DIVIDE: (ExceptionCode.FPU_DIVIDEBYZERO, ""),
    FaultKind.REAL_INVALID: (ExceptionCode.FPU_INVALID_OPERATION, ""),
    FaultKind.BOUNDS: (ExceptionCode.ARRAYBOUNDS, "index {index}, the array has {low}..{high}"),
    FaultKind.ACCESS: (ExceptionCode.ACCESS_VIOLATION, "no memory at address 16#{address:X}"),
    FaultKind.ALIGNMENT: (
        ExceptionCode.MISALIGNMENT,
        "a function block at address 16#{address:X}, not aligned",
    ),
    FaultKind.RAISED: (ExceptionCode.UNKNOWN, "raised by the program"),
}


def _traced(routine: Routine, at: int, inner: TracebackType | None) -> TracebackType:
    """Return a traceback that begins at a place of Structured Text and goes on with another."""
    frame = _frame(routine, routine.locate(at).line)
    try:
        return TracebackType(inner, frame, frame.f_lasti, frame.f_lineno)
    finally:
        del frame  # it knows its callers: this one is among them


@lru_cache(1024)
def _raising(path: str, routine: str, line: int) -> CodeType:
    """Return code that raises `here` at that line of a source: a caught fault comes in each cycle,
    a deep recursion has a place many times."""
    tree = ast.parse("raise here")
    for node in ast.walk(tree):
        if isinstance(node, ast.stmt | ast.expr):
            node.lineno = node.end_lineno = line
            node.col_offset = node.end_col_offset = 0
    code: CodeType = compile(tree, path, "exec")
    return code.replace(co_name=routine, co_qualname=routine)


def _frame(routine: Routine, line: int) -> FrameType:
    """Return a frame of Python that is at that line of the source."""
    code = _raising(routine.source.path, routine.name, line)
    try:
        exec(code, {"here": _HereError})
    except _HereError as here:
        trace = here.__traceback__
        while trace is not None and trace.tb_frame.f_code is not code:
            trace = trace.tb_next
        try:
            if trace is not None:
                return trace.tb_frame
        finally:
            del trace
    raise AssertionError("it raises, there")


class _HereError(Exception):
    """Never seen: it gives a frame."""
