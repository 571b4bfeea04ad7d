"""A bench for emitted code: variables of a program, statements, and what they come to."""

import ctypes
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from mmap import PAGESIZE, mmap
from pathlib import Path
from typing import Any

import pytest

from achse.iec import Buffer, Program, plain
from achse.iec.structs import RecordKind, RecordMeta, StructType
from achse.iec.types import IecType
from achse.iec.variables import Variable
from achse.native.backend import compiler_installed
from achse.plc.bodies import Bodies
from achse.plc.code.execution import CodeForm, Execution
from achse.plc.code.faults import ExceptionCode, FaultReport
from achse.plc.memory import Area, Memory
from achse.plc.program import place
from achse.plc.runtime import PlcRuntime, PlcState
from achse.plc.system_info import system_info_list
from achse.plc.task import Task
from achse.st.check import check
from achse.st.declare import Declarations, declare
from achse.st.files.defines import SourceDefines
from achse.st.lexis.pragmas import needs_declarations
from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse
from achse.st.typed.places import Storage, UnitBase, flat
from achse.st.typed.project import Routine, RoutineKind, TypedProject, TypedUnit
from achse.st.typed.statements import TypedStatement

BEST = CodeForm.MACHINE if compiler_installed() else CodeForm.PLAIN


_SMALL = tuple(area for area in Area if area is not Area.HEAP)
"""Areas that are compared after each cycle; the heap of 4 MB once all have run."""

_CHUNK = 1 << 16
"""Bytes that are compared at once."""


PAGES = Path("/proc/self/pagemap")
_ENTRY = 8
"""Bytes of each page there."""

_IN_USE = 0x40
"""Bits of the last byte: the page is in memory, or was moved out."""


class Bench:
    """One program `MAIN` with variables of the given types, and its body."""

    def __init__(
        self, types: Mapping[str, IecType[Any]], form: CodeForm = CodeForm.PLAIN, **options: Any
    ) -> None:
        members: dict[str, Variable[Any, Any]] = {
            name: Variable(type, name=name) for name, type in types.items()
        }
        self.type: StructType[Any] = StructType("MAIN", members, kind=RecordKind.UNIT)
        unit: Any = RecordMeta("MAIN", (Program,), dict(members), iec=self.type)
        self.memory = Memory()
        self.units = place([unit], self.memory)
        self.options = {"form": form, **options}
        self.execution: Execution | None = None

    def storage(self, name: str, offset: int = 0, **more: Any) -> Storage:
        """A variable, or a part of it."""
        variable = self.type.member(name)
        type = more.pop("type", flat(variable.type))
        return Storage(UnitBase("MAIN", variable), offset, type, name=name, **more)

    def routine(self, body: Sequence[TypedStatement]) -> Routine:
        """The body of MAIN."""
        frame: StructType[Any] = StructType("MAIN", {})
        source = Source("x" * 10_000, "MAIN.st")
        return Routine(
            "main", "MAIN", RoutineKind.PROGRAM, "main", source, 0, None, (), None, frame, (),
            tuple(body),
        )  # fmt: skip

    def run(self, *body: TypedStatement, **values: bytes) -> None:
        """Put values in, run the body once."""
        unit = TypedUnit(self.type, is_program=True, body="main")
        project = TypedProject({"main": self.routine(body)}, {}, {}, {"main": unit}, {})
        placed = [each for one in self.units for each in one.variables]
        if self.execution is not None:
            self.execution.release()
        self.execution = Execution(project, self.memory, placed, **self.options)
        for name, data in values.items():
            self.write(name, data)
        self.execution.reset_budget()
        self.execution.function("main")()

    def write(self, name: str, data: bytes) -> None:
        """The bytes of a variable."""
        area, offset = self._place(name)
        self.memory[area].write(offset, data)

    def read(self, name: str) -> bytes:
        """The bytes of a variable."""
        area, offset = self._place(name)
        return self.memory[area].read(offset, self.type.member(name).type.size)

    def _place(self, name: str) -> tuple[Any, int]:
        for one in self.units:
            for each in one.variables:
                if each.name == f"MAIN.{name}":
                    return each.area, each.offset
        raise KeyError(name)


@lru_cache(64)
def checked(text: str, check_bounds: bool = True) -> tuple[Declarations, TypedProject]:
    """What the front end makes of a source: a PLC and its twin, and the next one, share it."""
    source = Source(text, "test.st")
    parsed = parse(source, name="GVL")
    if needs_declarations(text):
        parsed = parse(source, name="GVL", defines=SourceDefines({}, parsed, [parsed]))
    project = declare([parsed])
    system = system_info_list([Task()], app_name="", project_name="", port=0, timestamp=0)
    return project, check(project, predefined=[system], check_bounds=check_bounds)


class Ran:
    """Structured Text in a PLC, cycled by hand in virtual time.

    As machine code it has a twin of plain code, which begins each cycle with the same memory and
    has to end it with the same memory; not so with services, which answer only once.
    """

    def __init__(
        self,
        text: str,
        form: CodeForm = BEST,
        *,
        has_twin: bool = True,
        check_bounds: bool = True,
        **options: Any,
    ) -> None:
        project, self.typed = checked(text, check_bounds)
        assert not self.typed.faults, "\n".join(map(str, self.typed.faults))
        programs = list(project.programs.values())
        self.task = Task("PlcTask", 10_000_000, [programs[0]])
        bodies = Bodies(self.typed, form=form, **options)
        self.plc = PlcRuntime([self.task], project.units, bodies=bodies)
        self.name = programs[0].__iec__.name
        self.twin: Ran | None = None
        if form is CodeForm.MACHINE and has_twin and "services" not in options:
            self.twin = Ran(text, CodeForm.PLAIN, check_bounds=check_bounds, **options)
            self._compare(self.twin)

    @property
    def plain_routines(self) -> Mapping[str, str]:
        """Routines that are not machine code, and why."""
        assert self.plc.bodies is not None
        assert self.plc.bodies.execution is not None
        return self.plc.bodies.execution.plain_routines

    def cycle(self, count: int = 1) -> "Ran":
        """So many cycles of 10 ms."""
        if self.twin is None:
            self.plc.run_due(self.task.due_ns + (count - 1) * self.task.cycle_ns)
            return self
        if count:
            self._copy_to(self.twin)
        for rest in range(count - 1, -1, -1):
            self.plc.run_due(self.task.due_ns)
            self.twin.plc.run_due(self.task.time_ns)
            self._compare(self.twin, Area if rest == 0 else _SMALL)
        return self

    def _copy_to(self, twin: "Ran") -> None:
        """What a test put into this memory is in the other, too."""
        if self.plc.restarts > twin.plc.restarts:
            twin.plc.reset()
            twin.plc.run()
        for area in Area:
            here, there = self.plc.memory[area].data, twin.plc.memory[area].data
            for start, ours, _ in _differences(here, there):
                there[start : start + len(ours)] = ours

    def _compare(self, twin: "Ran", areas: Iterable[Area] = Area) -> None:
        ours, theirs = self.plc.fault, twin.plc.fault
        if ours is not None and theirs is not None and ours.code == ExceptionCode.STACK_OVERFLOW:
            # How deep calls can be is up to the stack of Python and that of the processor.
            assert theirs.code == ours.code
            return
        assert (self.plc.state, str(ours)) == (twin.plc.state, str(theirs))
        for area in areas:
            here, there = self.plc.memory[area].data, twin.plc.memory[area].data
            assert len(here) == len(there)
            for start, ours_here, theirs_here in _differences(here, there):
                _raise_difference(area, start, ours_here, theirs_here)

    def __getitem__(self, path: str) -> Any:
        """A variable of the program as a plain value."""
        value: Any = self.plc.instance(self.name)
        for part in path.split("."):
            value = value[part]
        return plain(value)

    @property
    def stopped(self) -> FaultReport:
        """Why it was stopped."""
        assert self.plc.state is PlcState.EXCEPTION
        assert self.plc.fault is not None, self.plc.failure
        return self.plc.fault


def _differences(here: Buffer, there: Buffer) -> Iterator[tuple[int, Buffer, Buffer]]:
    """Yield the chunks that differ, with their offset."""
    for start in sorted({*_touched(here), *_touched(there)}):
        ours, theirs = here[start : start + _CHUNK], there[start : start + _CHUNK]
        if ours != theirs:
            yield start, ours, theirs


def _touched(data: Buffer) -> Iterable[int]:
    """Return the offsets of chunks; of sparse memory, of those in which a page was ever used: the
    others are zeros, and looking at them would give them pages."""
    starts = range(0, len(data), _CHUNK)
    if not isinstance(data, mmap) or not PAGES.exists():
        return starts
    address = ctypes.addressof(ctypes.c_char.from_buffer(data))
    with PAGES.open("rb", buffering=0) as pages:
        pages.seek(address // PAGESIZE * _ENTRY)
        last_bytes = pages.read(len(data) // PAGESIZE * _ENTRY)[_ENTRY - 1 :: _ENTRY]
    if max(last_bytes, default=0) < _IN_USE:
        return ()
    each = _CHUNK // PAGESIZE
    return [
        start
        for number, start in enumerate(starts)
        if max(last_bytes[number * each : (number + 1) * each]) >= _IN_USE
    ]


def _raise_difference(area: Area, start: int, here: Buffer, there: Buffer) -> None:
    where = next(at for at in range(len(here)) if here[at] != there[at])
    piece = slice(max(where - 16, 0), where + 16)
    raise AssertionError(
        f"{area.value} differs at byte {start + where}: {bytes(here[piece])!r} as machine"
        f" code, {bytes(there[piece])!r} as plain code"
    )


FORMS = [
    CodeForm.PLAIN,
    pytest.param(
        CodeForm.MACHINE,
        marks=pytest.mark.skipif(not compiler_installed(), reason="llvmlite is not installed"),
    ),
]


@pytest.fixture(scope="session", params=FORMS, ids=lambda form: form.value)
def form(request: pytest.FixtureRequest) -> CodeForm:
    """Plain code and machine code: what a test says holds for both."""
    code_form: CodeForm = request.param
    return code_form


@pytest.fixture(scope="session")
def run(form: CodeForm) -> Callable[..., Ran]:
    """`run(text)`: a PLC with that source, its first program in a task; one cycle has run."""
    return lambda text, cycles=1, **options: Ran(text, form, **options).cycle(cycles)


@pytest.fixture(scope="session")
def bench(form: CodeForm) -> Callable[..., Bench]:
    """`bench(types)`: a program with variables of these types."""
    return lambda types, **options: Bench(types, form, **options)
