"""Trees of function charts as the file has them."""

import pytest

from achse.st.graphical.function_charts import (
    ChartBox,
    ChartOutput,
    read_explicit_order,
    read_function_chart,
)
from achse.st.syntax.cursor import Unexpected
from tests.st.graphical.drawings import Canvas, explicit_order


def test_boxes_have_type_instance_and_pins_by_position() -> None:
    canvas = Canvas()
    _, (out, _) = canvas.box(
        "TON", "a", None, call="FunctionBlock", instance="t", names=["IN", "PT"],
        outputs=["Q", "ET"], negated=[0], row=9,
    )  # fmt: skip
    canvas.output("q", out, storing="Reset")
    function_chart = read_function_chart(str(canvas))
    box, output = function_chart.ordered
    assert isinstance(box, ChartBox)
    assert isinstance(output, ChartOutput)
    assert (box.call, box.type, box.instance, box.bounds) == ("FunctionBlock", "TON", "t", (10, 9))
    assert [(pin.name, pin.is_negated) for pin in box.inputs] == [("IN", True), ("PT", False)]
    assert [pin.name for pin in box.outputs] == ["Q", "ET"]
    assert (output.text, output.storing) == ("q", "Reset")
    assert dict(function_chart.sources)[output.input.id] == box.outputs[0].id
    assert function_chart.inputs[0].text == "a"
    assert not function_chart.knows_feedback


def test_the_order_is_explicit_as_the_settings_say() -> None:
    settings = [explicit_order(True), explicit_order(False), ""]
    assert [read_explicit_order(one) for one in settings] == [True, False, None]


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ("CFCBoxElement", "CFCJumpElement", "'CFCJumpElement' is not supported in a chart"),
        ('"EnEno">false', '"EnEno">true', "shows EN and ENO"),
        ('"Text">"q"', '"Other">"q"', ""),
        ('t="S">None', 't="S">Toggle', "SetReset Toggle is not supported"),
    ],
)
def test_what_the_format_does_not_have_is_named(old: str, new: str, why: str) -> None:
    canvas = Canvas()
    _, (out,) = canvas.box("NOT", "a")
    canvas.output("q", out)
    text = str(canvas)
    assert old in text
    if why:
        with pytest.raises(Unexpected, match=why):
            read_function_chart(text.replace(old, new))
    else:
        assert read_function_chart(text.replace(old, new)).ordered[1].text == ""  # type: ignore[union-attr]
