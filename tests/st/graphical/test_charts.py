"""Trees of charts as the file has them."""

import pytest

from achse.st.graphical.charts import (
    Alternative,
    ChartJump,
    ChartStep,
    ChartTransition,
    Macro,
    Simultaneous,
    read_chart,
    read_flags,
)
from achse.st.syntax.cursor import Unexpected
from tests.st.graphical.drawings import (
    branch,
    chart,
    jump,
    macro,
    segment,
    sfc_flags,
    step,
    transition,
)


def test_steps_have_actions_and_times_and_branches_their_segments() -> None:
    elements = read_chart(
        chart(
            step("A", ("b", "N"), ("c", "sd, T#5S"), initial="TRUE", main="m", minimum="T#1S"),
            transition("x > 1;"),
            branch(segment(step("B")), segment(step("C")), parallel=True, name="both"),
            branch(segment(transition("y"), jump("A"))),
            macro(step("D")),
        )
    ).elements
    first = elements[0]
    assert isinstance(first, ChartStep)
    assert (first.is_initial, first.main, first.entry, first.minimum) == (True, "m", "", "T#1S")
    actions = [(one.name, one.qualifier, one.time) for one in first.associations]
    assert actions == [("b", "N", ""), ("c", "SD", "T#5S")]
    kinds = [ChartStep, ChartTransition, Simultaneous, Alternative, Macro]
    assert [type(one) for one in elements] == kinds
    assert isinstance(elements[1], ChartTransition)
    assert elements[1].text == "x > 1"
    assert isinstance(elements[2], Simultaneous)
    assert (elements[2].label, len(elements[2].segments)) == ("both", 2)
    assert isinstance(elements[3], Alternative)
    assert elements[3].segments[0][1] == ChartJump("A")


def test_what_is_left_out_of_the_build_does_nothing() -> None:
    (element,) = read_chart(chart(step("A", ("b", "N"), main="m", exclude="TRUE"))).elements
    assert isinstance(element, ChartStep)
    assert (element.main, element.associations) == ("", ())


def test_flags_are_those_that_the_chart_uses() -> None:
    text = sfc_flags("Init", "CurrentStep", "SFCErrorAnalyzation")
    expected = {"init": True, "currentstep": True, "erroranalyzation": True}
    assert read_flags(text) == expected
    assert read_flags(text.replace(">true<", ">false<", 1)).keys() == expected.keys() - {"init"}
    assert read_flags("") == read_flags("<ObjectProperties>SFCProperty<XmlArchive") == {}


@pytest.mark.parametrize(
    ("element", "why"),
    [
        (step("A", ("b", "Q")), "b: 'Q' is not a qualifier"),
        (step("A", ("b", "L")), "b: qualifier L has no time"),
        ('<o t="SFCOther"></o>', "'SFCOther' is not supported in a chart"),
    ],
)
def test_what_the_format_does_not_have_is_named(element: str, why: str) -> None:
    with pytest.raises(Unexpected, match=why):
        read_chart(chart(element))
