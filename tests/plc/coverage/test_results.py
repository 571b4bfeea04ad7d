"""Drawn bodies: coverage names networks, boxes, steps and transitions."""

from achse.plc.code.execution import CodeForm
from achse.plc.coverage.html import page_of
from achse.plc.coverage.results import RoutineCoverage
from achse.plc.coverage.text import summary_of
from tests.plc.coverage.conftest import Counting
from tests.st.graphical.drawings import (
    Canvas,
    assign,
    chart,
    contact,
    jump,
    network,
    networks,
    part,
    read,
    step,
    transition,
    unit,
)


def _main(text: str, form: CodeForm) -> tuple[Counting, RoutineCoverage]:
    counting = Counting(read(text), form).run(3)
    (file,) = counting.result.files
    return counting, next(one for one in file.routines if one.name == "MAIN")


def _places(routine: RoutineCoverage) -> dict[str, int]:
    return {one.place: one.hits for one in routine.statements}


def test_networks_of_a_ladder(form: CodeForm) -> None:
    rungs = (network(assign(contact(name), "q")) for name in "ab")
    text = unit("PROGRAM MAIN\nVAR\na, b, q : BOOL;\nEND_VAR", networks(*rungs))
    _, main = _main(text, form)
    assert _places(main) == {"network 1, rung 1": 3, "network 2, rung 1": 3}


def test_boxes_of_a_function_chart(form: CodeForm) -> None:
    canvas = Canvas()
    q = canvas.output("q")
    _, (sum,) = canvas.box("ADD", "a", "b")
    canvas.connect(sum, q)
    _, main = _main(unit("PROGRAM MAIN\nVAR\na, b, q : INT;\nEND_VAR", str(canvas)), form)
    assert _places(main) == {"output q (1)": 3, "box ADD (2)": 3}


def test_steps_that_are_never_left_and_transitions_that_never_fire(form: CodeForm) -> None:
    elements = (
        step("Init", initial="TRUE"),
        transition("TRUE"),
        step("S1", main="A"),
        transition("FALSE"),
        jump("Init"),
    )
    head = "PROGRAM MAIN\nVAR\na : INT;\nEND_VAR"
    text = unit(head, chart(*elements), part("Action", "A", "a := a + 1;"))
    counting, main = _main(text, form)
    assert _places(main) == {
        "step Init": 1,
        "step S1": 0,
        "transition behind Init": 1,
        "transition behind S1": 0,
    }
    assert "step S1, transition behind S1" in summary_of(counting.result)
    assert "MAIN: step S1</td>" in page_of(counting.result)
