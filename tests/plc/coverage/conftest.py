"""A PLC whose code counts, in both forms."""

from collections.abc import Callable
from pathlib import Path

import pytest

from achse.native.backend import compiler_installed
from achse.plc import PlcRuntime, Task
from achse.plc.bodies import Bodies
from achse.plc.code.execution import CodeForm
from achse.plc.coverage.counters import is_own
from achse.plc.coverage.results import CoverageResult, measured
from achse.st.check import check
from achse.st.declare import Declarations, declare
from achse.st.lexis.source import Source
from achse.st.syntax.parser import Parsed, parse

FORMS = [CodeForm.PLAIN, *([CodeForm.MACHINE] if compiler_installed() else [])]

DECISIONS = Path(__file__).parents[2] / "data" / "coverage" / "decisions.st"

COUNTED = Path(__file__).parents[2] / "data" / "coverage" / "counted.st"

LEAVING = COUNTED.with_name("leaving.st")

_CYCLE_NS = 10_000_000


class Counting:
    """A PLC with the program MAIN; `result` is what has run."""

    def __init__(self, text: str | Parsed, form: CodeForm, *, conditions: bool = False) -> None:
        self._form, self._conditions = form, conditions
        declared = declare([parse(Source(text, "a.st")) if isinstance(text, str) else text])
        task = Task("PlcTask", _CYCLE_NS, [declared.programs["main"]])
        self.plc = PlcRuntime([task], declared.units, bodies=self._bodies(declared))
        assert not self.plc.failure, self.plc.failure

    def _bodies(self, declared: Declarations) -> Bodies:
        project = check(declared)
        assert not project.faults, project.faults
        return Bodies(project, form=self._form, covered=is_own, conditions=self._conditions)

    def run(self, cycles: int = 1) -> "Counting":
        for _ in range(cycles):
            self.plc.run_due(self.plc.tasks[0].due_ns)
        return self

    def change(self, text: str) -> None:
        """Put another text in its place by online change."""
        declared = declare([parse(Source(text, "a.st"))])
        programs = {"PlcTask": [declared.programs["main"]]}
        self.plc.online_change(declared.units, programs, bodies=self._bodies(declared))

    @property
    def counts(self) -> list[int]:
        bodies = self.plc.bodies
        assert bodies is not None
        assert bodies.execution is not None
        assert bodies.execution.coverage is not None
        return list(bodies.execution.coverage.counts)

    @property
    def result(self) -> CoverageResult:
        bodies = self.plc.bodies
        assert bodies is not None
        assert bodies.execution is not None
        assert bodies.execution.coverage is not None
        return measured([bodies.execution.coverage])


@pytest.fixture(params=FORMS, ids=lambda form: str(form.value))
def form(request: pytest.FixtureRequest) -> CodeForm:
    code_form: CodeForm = request.param
    return code_form


@pytest.fixture
def count(form: CodeForm) -> Callable[[str], Counting]:
    """`count(text)`: a PLC whose code counts, before its first cycle."""
    return lambda text: Counting(text, form)


@pytest.fixture
def result(count: Callable[[str], Counting]) -> CoverageResult:
    """Coverage of the routines that were counted by hand, after a cycle."""
    return count(COUNTED.read_text(encoding="utf-8")).run().result
