"""The typed form without unreached units that have faults."""

from achse.iec.layout import TC3_X64
from achse.st.check import check
from achse.st.check.reached import FAULTY
from achse.st.declare import examine
from achse.st.lexis.source import Source
from achse.st.reach import Reach
from achse.st.syntax.parser import parse
from achse.st.typed.project import TypedProject

TEXT = """
PROGRAM MAIN VAR g : GOOD; END_VAR g(); END_PROGRAM
PROGRAM OTHER VAR b : BAD; END_VAR b(); END_PROGRAM
FUNCTION_BLOCK GOOD END_FUNCTION_BLOCK
FUNCTION_BLOCK BAD VAR_STAT s : INT; END_VAR
METHOD m s := nothing; END_METHOD METHOD k END_METHOD END_FUNCTION_BLOCK
"""


def typed(*programs: str) -> TypedProject:
    sources = [parse(Source(TEXT, "all.st"))]
    declarations, error = examine(sources, rules=TC3_X64)
    assert error is None
    return check(declarations, reach=Reach(declarations.names, sources, programs))


def test_faulty_unit_and_what_depends_on_it_are_left_out() -> None:
    project = typed("MAIN")
    assert not project.faults
    assert [fault.message for fault in project.unreached] == ["nothing is named 'nothing' here"]
    assert [key for key in project.routines if "." not in key] == ["main", "good"]
    assert list(project.units) == ["main"]
    assert list(project.blocks) == ["good"]
    assert project.left_out.keys() >= {"other", "bad", "bad.k", "bad.m"}
    assert not project.statics


def test_fault_of_a_reached_unit_leaves_out_its_routine_only() -> None:
    project = typed("MAIN", "OTHER")
    assert [fault.message for fault in project.faults] == ["nothing is named 'nothing' here"]
    assert not project.unreached
    assert project.left_out == {"bad.m": FAULTY}
    assert list(project.units) == ["main", "other"]


def test_without_programs_every_fault_is_an_error() -> None:
    assert len(typed().faults) == 1
