"""Automatic order of function charts."""

from achse.st.graphical.execution_order import execution_order
from achse.st.graphical.function_charts import ChartBox, ChartOutput, ChartPin, Ordered


def box(name: str, row: int, column: int = 0, *, start: bool = False) -> ChartBox:
    return ChartBox("Operator", name, "", (), (), start, (column, row))


def output(name: str, row: int) -> ChartOutput:
    return ChartOutput(name, ChartPin(0, "", False), "None", (0, row))


def order(elements: list[Ordered], *edges: tuple[int, int]) -> str:
    ordered = execution_order(elements, edges)
    return " ".join(
        one.text if isinstance(one, ChartOutput) else getattr(one, "type", "") for one in ordered
    )


def test_producers_come_first_then_what_is_higher_then_what_is_left_of_it() -> None:
    elements: list[Ordered] = [box("a", 5), box("b", 1, 9), box("c", 1, 2), box("d", 0)]
    assert order(elements) == "d c b a"
    assert order(elements, (0, 3), (1, 2)) == "b c a d"


def test_an_output_comes_right_behind_its_producer() -> None:
    elements: list[Ordered] = [box("a", 2), box("b", 1), output("qa", 9), output("qb", 8)]
    assert order(elements, (0, 2), (1, 3)) == "b qb a qa"


def test_a_loop_begins_at_its_mark_or_at_its_highest_element() -> None:
    edges = [(0, 1), (1, 0), (1, 2)]
    assert order([box("a", 2), box("b", 1), box("behind", 0)], *edges) == "b behind a"
    marked: list[Ordered] = [box("a", 2, start=True), box("b", 1), box("behind", 0)]
    assert order(marked, *edges) == "a b behind"
