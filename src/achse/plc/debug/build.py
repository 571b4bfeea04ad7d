"""The debug build of a PLC's code: every statement marks its place, every call is on a list."""

from bisect import bisect_left
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from achse.plc.code.execution import Execution
from achse.st.typed.project import Routine, RoutineKind

CallRecord = list[int]
"""Of a running call: number of the present mark, of the routine, address of the instance, offset
of the frame."""


class Mark(NamedTuple):
    """A statement that can be stopped at."""

    routine: Routine
    path: str
    line: int
    place: str = ""
    """Place in a drawing: `network 3, rung 1`; empty in text."""


class _Marks:
    """Marks in the code, by their numbers."""

    def __init__(self) -> None:
        self.marks: list[Mark | None] = [None]
        """Marks by number; 0 is the head of a routine."""
        self.routines: list[Routine] = []
        self._numbers: dict[tuple[str, int], int] = {}
        self._of_routine: dict[str, int] = {}

    def statement(self, routine: Routine, at: int) -> tuple[str, ...]:
        if routine.kind is RoutineKind.LIFE:
            return ()  # start values: no breakpoint stops in a declaration
        number = self._numbers.get((routine.key, at))
        if number is None:
            number = self._numbers[routine.key, at] = len(self.marks)
            place = routine.locate(at)
            drawn = routine.source.place(at)
            self.marks.append(Mark(routine, place.path, place.line, drawn))
        return f"call[0] = {number}", f"if {number} in STOPS: stopped(call)"

    def entry(self, routine: Routine) -> str:
        number = self._of_routine.get(routine.key)
        if number is None:
            number = self._of_routine[routine.key] = len(self.routines)
            self.routines.append(routine)
        this = "0" if routine.this is None else "this"
        return f"call = called({number}, {this}, f)"


class DebugBuild:
    """Functions for debugging beside those of an execution.

    `names` are what the code calls: STOPS, `called`, `returned`, `stopped`, `raised`.
    """

    def __init__(self, execution: Execution, names: Mapping[str, Any]) -> None:
        self._execution = execution
        self._marks = _Marks()
        execution.namespace.update(names)
        self._functions = execution.plain_functions(self._marks)
        self._before: dict[str, Callable[..., Any]] = {}
        by_path: dict[str, list[tuple[int, int]]] = {}
        for number, mark in enumerate(self._marks.marks):
            if mark is not None:
                by_path.setdefault(mark.path, []).append((mark.line, number))
        self._lines = {path: sorted(lines) for path, lines in by_path.items()}

    def install(self) -> None:
        """Let the debug functions run from the next cycle on."""
        execution = self._execution
        self._before = {key: execution.function(key) for key in self._functions}
        execution.replace(self._functions)

    def remove(self) -> None:
        """Let the functions run that were there."""
        self._execution.replace(self._before)

    def mark(self, number: int) -> Mark | None:
        """Return the mark of a number; None for the head of a routine."""
        return self._marks.marks[number]

    def routine(self, number: int) -> Routine:
        return self._marks.routines[number]

    @property
    def paths(self) -> list[str]:
        """The files with statements."""
        return sorted(self._lines)

    def at(self, path: str, line: int) -> tuple[str, int, frozenset[int]] | None:
        """Return the first statements of a file at a line or after it: file, line, their marks.

        A path means the files whose names end with it, or that it ends with; capitals and the
        kind of slashes do not count. None if there is no such file, or nothing after the line.
        """
        for known in matching_paths(path, self._lines):
            lines = self._lines[known]
            first = bisect_left(lines, (line, 0))
            if first < len(lines):
                first_line = lines[first][0]
                return known, first_line, frozenset(n for at, n in lines if at == first_line)
        return None


def matching_paths(path: str, known: Iterable[str]) -> list[str]:
    """Return the known paths that may be meant, the likeliest first."""
    wanted = _parts(path)
    ranked: list[tuple[int, str]] = []
    for one in known:
        parts = _parts(one)
        shared = min(len(parts), len(wanted))
        if shared and parts[-shared:] == wanted[-shared:]:
            ranked.append((-shared, one))
    return [one for _, one in sorted(ranked)]


def _parts(path: str) -> list[str]:
    return [part for part in path.replace("\\", "/").lower().split("/") if part not in ("", ".")]
