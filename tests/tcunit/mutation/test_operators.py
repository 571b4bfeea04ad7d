"""Faults of a text: all that there are by hand, and each does what the changed text does."""

import re
from collections import defaultdict
from functools import cache
from random import Random

from hypothesis import given
from hypothesis import strategies as st

from achse.st.check import check
from achse.st.declare import declare
from achse.st.typed.text import lines_of
from achse.tcunit.mutation.operators import Mutant, MutationOperator, mutants_of
from tests.st.graphical.drawings import Canvas, read, unit
from tests.tcunit.mutation.conftest import PLANTED, Routines, routines_of


def test_faults_by_hand(routines: Routines, planted: str) -> None:
    changes_by_line = defaultdict(list)
    for routine in routines(planted).values():
        for mutant in mutants_of(routine):
            changes_by_line[routine.locate(mutant.at).line].append(mutant.change)
    wanted = {
        number: note[1].split("; ")
        for number, line in enumerate(planted.splitlines(), 1)
        if (note := re.search(r"//= (.*)$", line))
    }
    assert {line: sorted(changes) for line, changes in changes_by_line.items()} == wanted


@cache
def _mutants(text: str) -> list[Mutant]:
    """Mutants that the text can show."""
    mutants = [one for routine in routines_of(text).values() for one in mutants_of(routine)]
    return [mutant for mutant in mutants if mutant.edit is not None]


@given(st.randoms(use_true_random=False))
def test_a_mutant_is_what_the_changed_text_is(random: Random) -> None:
    text = PLANTED.read_text(encoding="utf-8")
    mutant = random.choice(_mutants(text))
    assert mutant.edit is not None
    start, end, new = mutant.edit
    changed = routines_of(text[:start] + new + text[end:])[mutant.routine.key]
    assert changed.body is not None
    assert list(lines_of(changed.body)) == list(lines_of(mutant.body)), mutant.change


def test_a_mutant_knows_its_statement_and_its_elsif(routines: Routines) -> None:
    text = """FUNCTION F : INT
VAR_INPUT n : INT; END_VAR
IF n = 1 THEN
    F := 1;
ELSIF n > 2 THEN
    F := 3;
END_IF
END_FUNCTION
"""
    routine = routines(text)["f"]
    rows = {
        (mutant.change, routine.locate(mutant.statement).line): mutant.branch
        for mutant in mutants_of(routine)
        if mutant.fault in (MutationOperator.BOUNDARY, MutationOperator.STATEMENT)
    }
    branch = rows["> becomes >=", 3]
    assert branch is not None
    assert routine.locate(branch).line == 5
    assert set(rows) == {("> becomes >=", 3), ("statement removed", 4), ("statement removed", 6)}


def test_what_has_no_text_of_its_own_stays(routines: Routines) -> None:
    text = """FUNCTION F : INT
VAR i : INT; END_VAR
FOR i := i TO i BY i DO
    ;
END_FOR
RETURN(i = i);
END_FUNCTION
"""
    changes = [mutant.change for mutant in mutants_of(routines(text)["f"])]
    assert changes == [
        "condition becomes TRUE",
        "condition becomes FALSE",
        "= becomes <>",
        "RETURN removed",
    ]


def test_drawn_bodies_have_faults_by_place() -> None:
    canvas = Canvas()
    q = canvas.output("q")
    _, (sum,) = canvas.box("ADD", "a", "b")
    canvas.connect(sum, q)
    text = unit("PROGRAM MAIN\nVAR\na, b, q : INT;\nEND_VAR", str(canvas))
    project = check(declare([read(text)]))
    assert not project.faults, project.faults
    routine = project.routines["main"]
    changes = sorted((routine.source.place(one.at), one.change) for one in mutants_of(routine))
    assert changes == [
        ("box ADD (2)", "+ becomes -"),
        ("box ADD (2)", "statement removed"),
        ("output q (1)", "statement removed"),
    ]
    assert not any(mutant.edit for mutant in mutants_of(routine))
