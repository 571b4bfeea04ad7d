"""A bench for emitted code: variables of a program, statements, and what they come to."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import pytest

from achse.iec import Program, plain
from achse.iec.structs import RecordKind, RecordMeta, StructType
from achse.iec.types import IecType
from achse.iec.variables import Variable
from achse.plc.bodies import Bodies
from achse.plc.code.execution import Execution
from achse.plc.code.faults import FaultReport
from achse.plc.memory import Memory
from achse.plc.program import place
from achse.plc.runtime import PlcRuntime, PlcState
from achse.plc.task import Task
from achse.st.check import check
from achse.st.declare import declare
from achse.st.parser import parse
from achse.st.source import Source
from achse.st.typed.places import Storage, UnitBase, flat
from achse.st.typed.project import Routine, RoutineKind, TypedProject, TypedUnit
from achse.st.typed.statements import TypedStatement


class Bench:
    """One program `MAIN` with variables of the given types, and its body."""

    def __init__(self, types: Mapping[str, IecType[Any]], **options: Any) -> None:
        members: dict[str, Variable[Any, Any]] = {
            name: Variable(type, name=name) for name, type in types.items()
        }
        self.type: StructType[Any] = StructType("MAIN", members, kind=RecordKind.UNIT)
        unit: Any = RecordMeta("MAIN", (Program,), dict(members), iec=self.type)
        self.memory = Memory()
        self.units = place([unit], self.memory)
        self.options = options
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
            self.execution.views.release()
        self.execution = Execution(project, self.memory, placed, **self.options)
        for name, data in values.items():
            self.write(name, data)
        self.execution.refuel()
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


class Ran:
    """Structured Text in a PLC, cycled by hand in virtual time."""

    def __init__(self, text: str, **options: Any) -> None:
        project = declare([parse(Source(text, "test.st"), name="GVL")])
        self.typed = check(project)
        assert not self.typed.faults, "\n".join(map(str, self.typed.faults))
        programs = list(project.programs.values())
        self.task = Task("PlcTask", 10_000_000, [programs[0]])
        self.plc = PlcRuntime([self.task], project.units, bodies=Bodies(self.typed, **options))
        self.name = programs[0].__iec__.name

    def cycle(self, count: int = 1) -> "Ran":
        """So many cycles of 10 ms."""
        self.plc.run_due(self.task.due_ns + (count - 1) * self.task.cycle_ns)
        return self

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


@pytest.fixture(scope="session")
def run() -> Callable[..., Ran]:
    """`run(text)`: a PLC with that source, its first program in a task; one cycle has run."""
    return lambda text, cycles=1, **options: Ran(text, **options).cycle(cycles)


@pytest.fixture(scope="session")
def bench() -> Callable[..., Bench]:
    """`bench(types)`: a program with variables of these types."""
    return Bench
