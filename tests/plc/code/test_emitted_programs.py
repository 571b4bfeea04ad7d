"""Programs that a PLC has emitted are linked by the next one, with its own files and types."""

from types import CodeType

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.plc.bodies import Bodies
from achse.plc.code.emitted_programs import EmittedProgram, EmittedPrograms
from achse.plc.code.execution import CodeForm
from achse.plc.runtime import PlcRuntime
from achse.plc.task import Task
from achse.st.check import check
from achse.st.declare import declare
from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse

TEXT = """{attribute 'to_string'}
TYPE E : (none, some); END_TYPE
FUNCTION_BLOCK FB
VAR_INPUT n : INT; END_VAR
VAR_OUTPUT s : STRING; END_VAR
s := CONCAT(INT_TO_STRING(n), 'x');
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR fb : FB; new : POINTER TO FB; e : E := E.some; shown : STRING; n, zero : INT; END_VAR
n := n + 2; fb(n := n);
IF new = 0 THEN new := __NEW(FB); END_IF
new^(n := n);
shown := CONCAT(TO_STRING(e), fb.s);
IF n > 4 THEN n := n / zero; END_IF
END_PROGRAM"""


def run(text: str, path: str) -> PlcRuntime:
    """Return a plain PLC after two cycles of a program in the file `path`."""
    project = declare([parse(Source(text, path), name="GVL")])
    task = Task("PlcTask", 10_000_000, [project.programs["main"]])
    bodies = Bodies(check(project), form=CodeForm.PLAIN)
    plc = PlcRuntime([task], project.units, bodies=bodies)
    plc.run_due(20_000_000)
    return plc


def test_next_plc_links_what_the_one_before_has_emitted(monkeypatch: pytest.MonkeyPatch) -> None:
    first = run(TEXT, "a.st")
    with monkeypatch.context() as patch:
        patch.setattr("achse.plc.code.execution.emit_routine", None)
        again = run(TEXT, "b.st")
    assert first.memory.digest() == again.memory.digest()
    assert first.instance("MAIN")["shown"] == again.instance("MAIN")["shown"] == "some4x"
    for plc, path in (first, "a.st"), (again, "b.st"):
        plc.run_due(30_000_000)
        assert plc.fault is not None
        assert (plc.fault.path, plc.fault.line, plc.fault.routine) == (path, 14, "MAIN")


@pytest.mark.parametrize(
    "other",
    [
        TEXT.replace("n + 2", "n + 3"),
        TEXT.replace("n, zero : INT", "zero, n : INT"),
        TEXT.replace("(none, some)", "(some, none)"),
    ],
)
def test_other_programs_are_emitted(other: str) -> None:
    first, second = run(TEXT, "a.st"), run(other, "a.st")
    assert first.memory.digest() != second.memory.digest()


def code_at(line: int) -> CodeType:
    return compile("\n" * line, "", "exec")


@settings(max_examples=25)
@given(st.lists(st.integers(0, 9), max_size=30))
def test_programs_used_last_are_kept(digests: list[int]) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("achse.plc.code.emitted_programs._PROGRAMS", 3)
        programs = EmittedPrograms()
        last: list[int] = []
        for digest in digests:
            assert (programs.get(str(digest)) is not None) == (digest in last)
            programs.add(str(digest), EmittedProgram({}, {}, {}))
            last = [*(each for each in last if each != digest), digest][-3:]


def test_large_programs_are_not_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("achse.plc.code.emitted_programs._ROUTINES", 2)
    programs = EmittedPrograms()
    for count in (2, 3):
        codes = {f"f{number}": code_at(number) for number in range(count)}
        programs.add(str(count), EmittedProgram(codes, {}, {}))
    assert programs.get("2") is not None
    assert programs.get("3") is None
