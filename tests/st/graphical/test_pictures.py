"""Pictures of drawn bodies: rungs, boxes, charts, values."""

import textwrap
from collections.abc import Mapping

from achse.st.graphical.chart_flow import ChartFlow
from achse.st.graphical.charts import read_chart
from achse.st.graphical.networks import read_networks
from achse.st.graphical.pictures import chart_lines, function_chart_lines, network_lines
from achse.st.graphical.plcopen.diagrams import read_diagram
from tests.st.graphical import drawings
from tests.st.graphical.drawings import (
    NEGATED,
    SET,
    assign,
    branches,
    contact,
    fb,
    instructions,
    line,
    network,
    networks,
    series,
)
from tests.st.graphical.plcopen import documents

RUNG = network(
    assign(series(branches(contact("a"), contact("b")), contact("c", NEGATED)), "q", ("s", SET))
)


def drawn(text: str, values: Mapping[str, object]) -> str:
    return "\n".join(network_lines(read_networks(text), values.get))


def test_rung() -> None:
    expected = """
        network 1
            ├─┬┤ a ├┬─┤/c ├─┬( q )┬
              └┤ b ├┘       └(Ss )┘
    """
    assert (
        "\n".join(network_lines(read_networks(networks(RUNG)))) == textwrap.dedent(expected).strip()
    )


def test_power_is_a_double_line() -> None:
    picture = drawn(networks(RUNG), {"a": False, "b": True, "c": False, "q": True, "s": True})
    expected = """
        network 1
            ├═┬┤ a ├┬═┤/c ├═┬( q ) = True┬
              └┤ b ├┘       └(Ss ) = True┘
    """
    assert picture == textwrap.dedent(expected).strip()
    off = drawn(networks(RUNG), {"a": False, "b": True, "c": True})
    assert "┤/c ├─┬" in off


def test_box_with_pins_and_values() -> None:
    timer = fb("TON", "t", [("IN", contact("a")), ("PT", contact("tDown"))])
    picture = drawn(
        networks(network(assign(timer, "q"))), {"a": True, "tDown": "T#1s", "t.Q": True}
    )
    assert "│PT := tDown = T#1s│" in picture
    assert picture.splitlines()[2].strip().startswith("├═┤ a ├═┤IN")
    assert picture.splitlines()[2].endswith("├═( q )")


def test_instructions_and_disabled_networks() -> None:
    text = networks(instructions(line("LD", "a"), line("ST", "b"), label="go"),
                    network(assign(contact("a"), "q"), disabled=True))  # fmt: skip
    assert drawn(text, {"a": 3}) == (
        "go: network 1\n    LD a = 3\n    ST b\nnetwork 2 (commented out)"
    )


def test_chart_has_a_star_at_active_steps() -> None:
    text = drawings.chart(
        drawings.step("Init", initial="TRUE"), drawings.transition("go"),
        drawings.step("Work", main="Run"), drawings.transition("NOT go"), drawings.jump("Init"),
    )  # fmt: skip
    values = {"Work.x": True, "go": False}
    assert chart_lines(ChartFlow(read_chart(text)), values.get) == [
        "  [[Init]]",
        "    ┼ go = False → Work",
        "* [Work]  main Run",
        "    ┼ NOT go → Init",
    ]


def test_function_chart_has_a_line_for_each_element() -> None:
    text = documents.diagram(
        "FBD", documents.value(1, "a"), documents.value(2, "T#1s"),
        documents.block(3, "TON", documents.pin("IN", 1, negated="true"), documents.pin("PT", 2),
                        outputs="Q", instanceName="t"),
        documents.written(4, "q", "3.Q"), documents.value(5, "q"),
        documents.element("return", 6, documents.leads(5)),
    )  # fmt: skip
    assert function_chart_lines(read_diagram(text), {"a": 1, "q": 2}.get) == [
        "   1  t : TON(IN := NOT a = 1, PT := T#1s)",
        "   2  q := t.Q = 2",
        "   3  IF q = 2 THEN RETURN",
    ]
