"""Ladders and function block diagrams in PLCopen XML: worked examples."""

import pytest

from achse.st.graphical.plcopen.diagrams import read_diagram
from achse.st.syntax.cursor import Unexpected
from tests.st.graphical.plcopen.documents import (
    block,
    coil,
    contact,
    diagram,
    element,
    leads,
    pin,
    pou,
    program,
    rail,
    text,
    value,
    written,
)


def test_contacts_in_parallel_and_series_feed_a_coil_and_a_negated_one() -> None:
    body = diagram(
        "LD", rail(), contact(1, "a", 0), contact(2, "b", 0),
        contact(3, "c", 1, 2, negated="true"), coil(4, "q", 3), coil(5, "nq", 3, negated="true"),
    )  # fmt: skip
    plc = program(body, a="BOOL", b="BOOL", c="BOOL", q="BOOL", nq="BOOL")
    plc.rows("a b c", "q nq", ["0 0 0 | 0 1", "1 0 0 | 1 0", "0 1 0 | 1 0", "1 1 1 | 0 1"])


def test_coil_hands_its_power_on() -> None:
    body = diagram("LD", rail(), contact(1, "a", 0), coil(2, "q", 1), coil(3, "p", 2))
    program(body, a="BOOL", q="BOOL", p="BOOL").rows("a", "q p", ["1 | 1 1", "0 | 0 0"])


def test_coils_that_double_their_sources_are_led_through_once() -> None:
    doubling = "".join(coil(n, "p", n - 1, n - 1) for n in range(2, 60))
    body = diagram("LD", rail(), contact(1, "a", 0), doubling, coil(60, "q", 59))
    program(body, a="BOOL", q="BOOL", p="BOOL").rows("a", "q p", ["1 | 1 1", "0 | 0 0"])


@pytest.mark.parametrize("is_set_last", [False, True])
def test_of_set_and_reset_the_lower_network_wins(is_set_last: bool) -> None:
    tops = (50, 10) if is_set_last else (10, 50)
    body = diagram(
        "LD", rail(), contact(1, "s", 0, y=tops[0]), coil(2, "q", 1, storage="set", y=tops[0]),
        contact(3, "r", 0, y=tops[1]), coil(4, "q", 3, storage="reset", y=tops[1]),
    )  # fmt: skip
    plc = program(body, s="BOOL", r="BOOL", q="BOOL")
    third = "1 1 | 1" if is_set_last else "1 1 | 0"
    plc.rows("s r", "q", ["1 0 | 1", "0 0 | 1", third, "0 1 | 0"])


def test_each_edge_has_its_own_memory_and_negation_comes_first() -> None:
    body = diagram(
        "LD", rail(), contact(1, "x", 0, edge="rising"), coil(2, "p", 1),
        contact(3, "x", 0, edge="falling", negated="true"), coil(4, "fn", 3),
        contact(5, "x", 0), coil(6, "c", 5, edge="rising"),
    )  # fmt: skip
    plc = program(body, x="BOOL", p="BOOL", fn="BOOL", c="BOOL")
    plc.rows("x", "p fn c", ["0 | 0 0 0", "1 | 1 1 1", "1 | 0 0 0", "0 | 0 0 0", "1 | 1 1 1"])


def test_eno_enables_the_next_box_and_results_stay() -> None:
    body = diagram(
        "LD", rail(), contact(1, "en", 0), value(2, "src"), value(3, "1"),
        block(4, "MOVE", pin("EN", 1), pin("IN", 2), outputs="ENO OUT"), written(5, "x", "4.OUT"),
        block(6, "ADD", pin("EN", "4.ENO"), pin("IN1", "4.OUT"), pin("IN2", 3), outputs="ENO OUT"),
        written(7, "y", "6.OUT"), coil(8, "lamp", "6.ENO"),
    )  # fmt: skip
    plc = program(body, en="BOOL", lamp="BOOL", src="INT", x="INT", y="INT")
    rows = ["0 5 | 0 0 0", "1 5 | 5 6 1", "0 9 | 5 6 0", "1 9 | 9 10 1"]
    plc.rows("en src", "x y lamp", rows)


def test_jump_and_return() -> None:
    body = diagram(
        "FBD", value(1, "a", y=1), element("jump", 2, leads(1), y=1, label="Skip"),
        value(3, "cnt", y=2), value(4, "1", y=2), block(5, "ADD", pin("A", 3), pin("B", 4), y=2),
        written(6, "cnt", 5, y=2), element("label", 7, y=3, label="skip"), value(8, "b", y=4),
        element("return", 9, leads(8), y=4), value(10, "cnt", y=5), written(11, "out", 10, y=5),
    )  # fmt: skip
    plc = program(body, a="BOOL", b="BOOL", cnt="INT", out="INT")
    plc.rows("a b", "cnt out", ["0 0 | 1 1", "1 0 | 1 1", "0 1 | 2 1", "1 1 | 2 1", "0 0 | 3 3"])


def test_numbers_say_the_order() -> None:
    body = diagram(
        "FBD", value(1, "a"), value(2, "10"),
        block(3, "ADD", pin("A", 1), pin("B", 2), executionOrderId=2),
        written(4, "q", 3, executionOrderId=1),
    )  # fmt: skip
    program(body, a="INT", q="INT").rows("a", "q", ["1 | 0", "2 | 11", "3 | 12"])


def test_without_numbers_data_flow_says_the_order() -> None:
    body = diagram(
        "FBD", written(4, "q", 3, y=1), block(3, "ADD", pin("A", 1), pin("B", 2), y=9),
        value(1, "a", y=8), value(2, "10", y=7),
    )  # fmt: skip
    program(body, a="INT", q="INT").rows("a", "q", ["1 | 11", "2 | 12"])


def test_block_gets_the_standard_names_of_its_pins() -> None:
    body = diagram(
        "FBD", value(1, "s"), value(2, "r", negated="true"),
        block(3, "SR", pin("S1", 1), pin("R", 2), outputs="Q1", instanceName="f"),
        written(4, "q", "3.Q1"),
    )  # fmt: skip
    plc = program(body, s="BOOL", r="BOOL", q="BOOL", f=".SR")
    plc.rows("s r", "q", ["1 1 | 1", "0 1 | 1", "0 0 | 0", "1 0 | 1"])


def test_function_of_the_user_may_name_its_result_as_it_likes() -> None:
    more = pou(
        "Twice",
        "<interface><returnType><INT/></returnType><inputVars><variable name='n'><type><INT/>"
        "</type></variable></inputVars></interface>",
        text("Twice := 2 * n;"),
        "function",
    )
    body = diagram("FBD", value(1, "a"), block(2, "Twice", pin("n", 1)), written(3, "q", "2.OUT"))
    program(body, more, a="INT", q="INT").rows("a", "q", ["3 | 6"])


def test_concat_may_have_more_inputs() -> None:
    pins = (pin("IN1", 1), pin("IN2", 2), pin("IN3", 1))
    body = diagram(
        "FBD", value(1, "'a'"), value(2, "'b'"), block(3, "CONCAT", *pins), written(4, "s", 3),
        value(5, "s"), block(6, "LEN", pin("IN", 5)), written(7, "n", 6),
    )  # fmt: skip
    program(body, s="string", n="INT").rows("", "n", [" | 3"])


def test_connectors_are_lines() -> None:
    body = diagram(
        "FBD", value(1, "a"), element("connector", 2, leads(1), name="line"),
        element("continuation", 3, name="line"), written(4, "q", 3),
    )  # fmt: skip
    program(body, a="INT", q="INT").rows("a", "q", ["7 | 7"])


def test_in_out_variable_is_read_and_written() -> None:
    both = element("inOutVariable", 2, leads(1) + "<expression>q</expression>", y=5)
    body = diagram("FBD", value(1, "a", y=5), both, written(3, "p", 2, y=6))
    program(body, a="INT", q="INT", p="INT").rows("a", "q p", ["4 | 4 4"])


def test_in_out_pin_takes_the_variable() -> None:
    more = pou(
        "Counter",
        "<interface><inOutVars><variable name='n'><type><INT/></type></variable></inOutVars>"
        "</interface>",
        text("n := n + 1;"),
        "functionBlock",
    )
    box = element(
        "block", 2, "<inputVariables/><inOutVariables>" + pin("n", 1) + "</inOutVariables>"
        "<outputVariables/>", typeName="Counter", instanceName="c",
    )  # fmt: skip
    program(diagram("FBD", value(1, "q"), box), more, q="INT", c=".Counter").rows(
        "", "q", [" | 1", " | 2"]
    )


@pytest.mark.parametrize(
    ("elements", "message"),
    [
        (element("actionBlock", 1), "'actionBlock' is not supported in a diagram"),
        (rail() + contact(1, "a", 0) + block(1, "ADD"), "several elements have localId '1'"),
        (contact(1, "a"), "nothing leads to the contact a"),
        (written(1, "q", 1, edge="both"), "edge both is not supported"),
        (value(2, "a") + written(1, "q", 2, storage="keep"), "storage keep"),
        (written(1, "q", 2) + element("continuation", 2, name="n"), "no connector is named 'n'"),
        (
            value(1, "a") + block(2, "SUB", pin("A"), pin("B", 1)),
            "nothing leads to A of SUB",
        ),
        (
            element("connector", 1, leads(1), name="") + written(2, "q", 1),
            "connectors lead in a circle",
        ),
    ],
)
def test_what_is_not_supported_is_refused(elements: str, message: str) -> None:
    with pytest.raises(Unexpected, match=message):
        read_diagram(diagram("FBD", elements))
