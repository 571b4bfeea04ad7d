"""Function charts as statements: order, results that go back, composers; worked examples."""

import pytest

from achse.st.check import check
from achse.st.declare import declare
from tests.st.graphical.drawings import Canvas, Drawn, explicit_order, part, read, unit


def drawn(
    variables: str, canvas: Canvas, *others: str, parts: str = "", order: bool | None = None
) -> Drawn:
    settings = "" if order is None else explicit_order(order)
    text = unit(f"PROGRAM MAIN\nVAR\n{variables}\nEND_VAR", str(canvas), parts, settings)
    return Drawn(text, *others)


@pytest.mark.parametrize("is_explicit", [True, False])
def test_an_output_in_front_of_its_box_is_a_cycle_late_in_explicit_order(is_explicit: bool) -> None:
    canvas = Canvas()
    q = canvas.output("q")
    _, (sum,) = canvas.box("ADD", "a", "b")
    canvas.connect(sum, q)
    plc = drawn("a, q : INT; b : INT := 10;", canvas, order=is_explicit)
    rows = ["1 | 0", "2 | 11", "3 | 12"] if is_explicit else ["1 | 11", "2 | 12", "3 | 13"]
    plc.rows("a", "q", rows)


def test_a_feedback_begins_at_its_start() -> None:
    canvas = Canvas()
    (_, back), (either,) = canvas.box("OR", "a", None, start=True, row=2)
    _, (both,) = canvas.box("AND", either, "r", negated=[1], start=False, row=1)
    canvas.connect(both, back)
    canvas.output("q", both)
    plc = drawn("a, r, q : BOOL;", canvas, order=False)
    plc.rows("a r", "q", ["0 0 | 0", "1 0 | 1", "0 0 | 1", "0 1 | 0", "0 0 | 0"])


def test_instances_are_read_when_their_consumer_runs() -> None:
    canvas = Canvas()
    q = canvas.output("q")
    _, (edge,) = canvas.box(
        "R_TRIG", "a", call="FunctionBlock", instance="t", names=["CLK"], outputs=["Q"]
    )
    canvas.connect(edge, q)
    canvas.output("s", edge, storing="Set")
    canvas.output("p", edge)
    plc = drawn("a, q, s, p : BOOL; t : R_TRIG;", canvas)
    plc.rows("a", "q s p", ["1 | 0 1 1", "1 | 1 1 0", "0 | 0 1 0"])


def test_a_result_that_goes_back_into_an_instance_arrives_in_the_next_cycle() -> None:
    """No declaration tells the type of `f.n + 1`: the input of the instance keeps it."""
    canvas = Canvas()
    (back,), (out,) = canvas.box(
        "FB", None, call="FunctionBlock", instance="f", names=["i"], outputs=["o"]
    )
    _, (sum,) = canvas.box("ADD", out, "f.n")
    canvas.connect(sum, back)
    canvas.output("q", out)
    block = """FUNCTION_BLOCK FB VAR_INPUT i : INT; END_VAR
    VAR_OUTPUT o : INT; n : INT := 1; END_VAR
    o := i; END_FUNCTION_BLOCK"""
    drawn("q : INT; f : FB;", canvas, block).rows("", "q", ["| 0", "| 1", "| 2"])


def test_composers_selectors_functions_methods_and_programs() -> None:
    canvas = Canvas()
    _, (double,) = canvas.box("F", "n", call="Function", names=["x"], outputs=["F"])
    _, (triple,) = canvas.box("M", double, call="LocalMethod", names=["x"], outputs=["M"])
    canvas.box("Other", triple, call="Program", names=["i"], outputs=["o"])
    canvas.output("m", triple)
    function = "FUNCTION F : INT VAR_INPUT x : INT; END_VAR F := 2 * x; END_FUNCTION"
    program = """PROGRAM Other VAR_INPUT i : INT; END_VAR VAR_OUTPUT o : INT; END_VAR
    o := i; END_PROGRAM"""
    head = "METHOD M : INT VAR_INPUT x : INT; END_VAR"
    plc = drawn(
        "n, m : INT;", canvas, function, program, parts=part("Method", "M", "M := 3 * x;", head)
    )
    plc.rows("n", "m", ["1 | 6", "2 | 12"])


def test_what_is_wrong_with_a_chart_names_box_or_output() -> None:
    canvas = Canvas()
    canvas.output("q", "nope")
    text = unit("PROGRAM MAIN VAR q : BOOL; END_VAR", str(canvas))
    (fault,) = check(declare([read(text)])).faults
    assert fault.message == "output q (1): nothing is named 'nope' here"


def test_a_connection_whose_end_is_gone_counts_for_nothing() -> None:
    canvas = Canvas()
    canvas.connect(4711, canvas.output("q"))
    drawn("q : BOOL := TRUE;", canvas).rows("", "q", ["| 1"])
