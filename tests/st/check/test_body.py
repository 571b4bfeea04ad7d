"""A routine while it is checked: faults cost a statement, warnings of libraries are not told."""

from collections.abc import Callable

from achse.st.check import check
from achse.st.declare import declare
from achse.st.syntax.parser import parse
from achse.st.typed.project import TypedProject

LIBRARY = "FUNCTION F_Lib : INT VAR d : DINT; END_VAR F_Lib := d; END_FUNCTION"


def test_every_fault_of_a_body_is_reported(typed: Callable[[str], TypedProject]) -> None:
    project = typed("PROGRAM MAIN\nVAR n : INT; END_VAR\nn := a;\nn := 1;\nn := b;\nEND_PROGRAM")
    assert [fault.location.line for fault in project.faults] == [3, 5]
    assert project.left_out == {"main": "it has faults"}
    assert "main" not in project.routines


def test_a_fault_shows_its_line_and_a_caret(typed: Callable[[str], TypedProject]) -> None:
    (fault,) = typed("PROGRAM MAIN\nVAR n : INT; END_VAR\n    n := missing;\nEND_PROGRAM").faults
    assert str(fault) == (
        "x.st:3:10: nothing is named 'missing' here\n"
        "        n := missing;\n"
        "             ^"
    )  # fmt: skip


def test_warnings_about_libraries_are_not_the_users() -> None:
    own = parse("PROGRAM MAIN VAR n : INT; END_VAR n := F_Lib(); END_PROGRAM")
    project = check(declare([own], libraries=[parse(LIBRARY)]))
    assert "f_lib" in project.routines
    assert project.warnings == ()
    assert [str(one.message) for one in check(declare([parse(LIBRARY)])).warnings] == [
        "a DINT is cut to go into a INT"
    ]


def test_what_the_frame_has_in_memory_is_known(typed: Callable[[str], TypedProject]) -> None:
    project = typed(
        """
        FUNCTION F : INT
        VAR n, m : INT; p : POINTER TO INT; s : STRING; a : ARRAY [0..1] OF INT; END_VAR
        p := ADR(n); m := n.1;
        END_FUNCTION
        """.replace("m := n.1", "m.3 := TRUE")
    )
    assert project.routines["f"].addressed == {"n", "m", "s", "a"}
