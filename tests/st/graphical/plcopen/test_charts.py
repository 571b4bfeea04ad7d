"""Sequential function charts in PLCopen XML: branches, actions, conditions."""

import pytest

from achse.st.graphical.plcopen.charts import read_drawn_flow
from achse.st.syntax.cursor import Unexpected
from tests.st.graphical.plcopen.documents import (
    block,
    contact,
    diagram,
    element,
    leads,
    pin,
    program,
    rail,
    text,
    value,
)


def step(id: int, name: str, *sources: int, initial: bool = False, added: str = "") -> str:
    is_initial = str(initial).lower()
    return element("step", id, leads(*sources) + added, name=name, initialStep=is_initial)


def transition(id: int, source: int, condition: str, *, x: int = 0, priority: int = 0) -> str:
    place = f'<position x="{x}" y="0"/>'
    more = f' priority="{priority}"' if priority else ""
    return (
        f'<transition localId="{id}"{more}>{place}{leads(source)}<condition>{condition}</condition>'
        "</transition>\n"
    )


def inline(words: str) -> str:
    return f'<inline name="">{text(words)}</inline>'


def action(name: str, qualifier: str = "N", duration: str = "") -> str:
    inner = name if name.startswith("<") else f'<reference name="{name}"/>'
    return f'<action localId="0" qualifier="{qualifier}" duration="{duration}">{inner}</action>'


def actions(id: int, step: int, *inside: str) -> str:
    return element("actionBlock", id, leads(step) + "".join(inside))


def branch(tag: str, id: int, *sources: int) -> str:
    if tag.endswith("Convergence"):
        return element(tag, id, "".join(leads(one) for one in sources))
    return element(tag, id, leads(*sources))


def test_chart_with_an_action_a_variable_and_statements() -> None:
    body = diagram(
        "SFC", step(1, "Init", 4, initial=True), transition(2, 1, inline("go")),
        step(3, "Work", 2), transition(4, 3, inline("NOT go")),
        actions(5, 3, action("Count"), action("lamp"), action(inline("n := n + 10;"))),
    )  # fmt: skip
    parts = f'<actions><action name="Count"><body>{text("n := n + 1;")}</body></action></actions>'
    plc = program(body, parts=parts, go="BOOL", lamp="BOOL", n="INT")
    rows = ["1 | 0 0", "1 | 11 1", "0 | 22 1", "0 | 33 0", "0 | 33 0"]
    plc.rows("go", "n lamp", rows)


def test_of_alternatives_the_first_by_priority_then_from_left_fires() -> None:
    def chart(**priorities: int) -> str:
        return diagram(
            "SFC", step(1, "S0", 30, initial=True), branch("selectionDivergence", 2, 1),
            transition(3, 2, inline("g"), x=200, priority=priorities.get("a", 0)),
            transition(4, 2, inline("h"), x=100), step(5, "A", 3), step(6, "B", 4),
            transition(7, 5, inline("e")), transition(8, 6, inline("e")),
            branch("selectionConvergence", 30, 7, 8),
        )  # fmt: skip

    names = {"g": "BOOL", "h": "BOOL", "e": "BOOL"}
    rows = ["1 1 0 | 1 0 0", "0 0 1 | 0 0 1", "0 0 0 | 1 0 0", "1 0 0 | 1 0 0", "0 0 0 | 0 1 0"]
    program(chart(), **names).rows("g h e", "S0.x A.x B.x", rows)
    program(chart(a=1), **names).rows("g h e", "A.x B.x", ["1 1 0 | 0 0", "0 0 0 | 1 0"])


def test_simultaneous_branches_join() -> None:
    body = diagram(
        "SFC", step(1, "S0", 20, initial=True), transition(2, 1, inline("go")),
        branch("simultaneousDivergence", 3, 2), step(4, "P1", 3), step(5, "P2", 3),
        transition(6, 4, inline("a")), step(7, "P1b", 6),
        branch("simultaneousConvergence", 8, 7, 5), transition(9, 8, inline("TRUE")),
        element("jumpStep", 10, leads(9), targetName="S0"),
    )  # fmt: skip
    plc = program(body, go="BOOL", a="BOOL")
    rows = ["1 0 | 1 0 0 0", "0 0 | 0 1 1 0", "0 1 | 0 1 1 0", "0 0 | 0 0 1 1", "0 0 | 1 0 0 0"]
    plc.rows("go a", "S0.x P1.x P2.x P1b.x", rows)


def test_qualifiers_and_durations() -> None:
    body = diagram(
        "SFC", step(1, "Init", initial=True), transition(2, 1, inline("TRUE")), step(3, "B", 2),
        actions(4, 3, action("late", "D", "T#20ms"), action("short", "L", "T#10ms")),
    )  # fmt: skip
    plc = program(body, late="BOOL", short="BOOL")
    plc.rows("", "late short", [" | 0 0", " | 0 1", " | 0 0", " | 1 0"])


def test_condition_may_be_a_diagram_with_a_timer() -> None:
    body = diagram(
        "SFC", step(1, "Init", initial=True), rail(10), value(11, "T#20ms"),
        contact(12, "a", 10), block(13, "TON", pin("IN", 12), pin("PT", 11), outputs="Q ET",
                                    instanceName="t"),
        transition(2, 1, leads("13.Q")), step(3, "B", 2),
    )  # fmt: skip
    plc = program(body, a="BOOL", t=".TON")
    plc.rows("a", "B.x", ["1 | 0", "1 | 0", "1 | 0", "1 | 1"])


def test_condition_may_name_a_transition() -> None:
    named = f'<transition name="T1"><body>{text("g AND h")}</body></transition>'
    parts = f"<transitions>{named}</transitions>"
    body = diagram(
        "SFC", step(1, "Init", initial=True), value(5, "g OR h"),
        transition(2, 1, '<reference name="T1"/>'), step(3, "B", 2),
        transition(4, 3, leads(5)), step(6, "C", 4),
    )  # fmt: skip
    plc = program(body, parts=parts, g="BOOL", h="BOOL")
    rows = ["1 0 | 0 0", "1 1 | 0 0", "0 0 | 1 0", "1 0 | 1 0", "0 0 | 0 1"]
    plc.rows("g h", "B.x C.x", rows)


def test_vendor_actions_of_steps_run() -> None:
    def added(entry: str, main: str) -> str:
        facts = {"a6b08bd8-x": entry, "700a583f-x": main}
        inside = "".join(
            f'<attribute guid="{key}">{name}</attribute>' for key, name in facts.items()
        )
        return f'<addData><data name="sfc"><attributes>{inside}</attributes></data></addData>'

    body = diagram("SFC", step(1, "Init", initial=True, added=added("First", "Each")))
    parts = "".join(
        f'<action name="{name}"><body>{text(words)}</body></action>'
        for name, words in (("First", "n := n + 10;"), ("Each", "n := n + 1;"))
    )
    program(body, parts=f"<actions>{parts}</actions>", n="INT").rows("", "n", [" | 11", " | 12"])


@pytest.mark.parametrize(
    ("elements", "message"),
    [
        ((element("macroStep", 1),), "a macro step is not supported"),
        ((step(1, "A", initial=True), step(2, "B", 1)), "expected a transition behind step A"),
        ((step(1, "A"),), "expected one initial step, got 0"),
        (
            (step(1, "A", initial=True), transition(2, 1, inline("TRUE"))),
            "the transition has no target step",
        ),
        (
            (step(1, "A", initial=True), actions(2, 1, action("x", "Q"))),
            "x: 'Q' is not a qualifier",
        ),
        (
            (step(1, "A", initial=True), actions(2, 1, action("x", "D"))),
            "x: qualifier D has no time",
        ),
        (
            (
                step(1, "A", initial=True),
                transition(2, 1, inline("TRUE")),
                element("jumpStep", 3, leads(2), targetName="B"),
            ),
            "expected a step, got 'B'",
        ),
    ],
)
def test_bad_chart_is_refused(elements: tuple[str, ...], message: str) -> None:
    with pytest.raises(Unexpected, match=message):
        read_drawn_flow(diagram("SFC", *elements))
