"""Trees of networks as the file has them."""

import pytest

from achse.st.graphical.networks import Assignment, Box, DrawnNetwork, NetworkOperand, read_networks
from achse.st.syntax.cursor import Unexpected
from tests.st.graphical.drawings import (
    NEGATED,
    assign,
    box,
    contact,
    instructions,
    line,
    network,
    networks,
    open_end,
    thing,
)


def first(item: str) -> object:
    (drawn,) = read_networks(networks(network(item))).networks
    return drawn.items[0]


def test_a_box_has_its_pins_with_names_types_and_circles() -> None:
    node = first(
        box(
            "F", contact("a"), contact("b"), call="Function", names=["x", "y"],
            types=["BOOL", "INT"], pins=[0, NEGATED], outputs=[("F", None), ("o ", "q")],
        )
    )  # fmt: skip
    assert isinstance(node, Box)
    pins = [(pin.name, pin.type, pin.modifiers) for pin in node.inputs]
    assert pins == [("x", "BOOL", 0), ("y", "INT", NEGATED)]
    slots = [(out.name, out.target and out.target.text, out.is_read) for out in node.outputs]
    assert slots == [("F", None, True), ("o", "q", False)]


def test_en_and_eno_are_not_among_the_pins() -> None:
    node = first(box("ADD", contact("a"), en=open_end(), outputs=[("ENO", None), ("''", "n")]))
    assert isinstance(node, Box)
    assert node.enable is not None
    assert node.enable_output is not None
    assert (len(node.inputs), node.enable_output.is_read, node.outputs[0].name) == (1, True, "")


def test_an_empty_slot_without_a_name_is_left_over() -> None:
    text = box("act", call="Action", outputs=[("", "???")])
    text = text.replace("<v></v>", "")
    node = first(text)
    assert isinstance(node, Box)
    assert node.outputs == ()


def test_networks_have_number_label_view_and_lines() -> None:
    text = networks(
        network(label="On"),
        network(assign(contact("a"), "b"), disabled=True),
        instructions(line("LD", "a"), line("ST", "b")),
        view="Il",
    )
    listed = read_networks(text)
    assert listed.view == "Il"
    facts = [(one.number, one.label, one.is_disabled, len(one.lines)) for one in listed.networks]
    assert facts == [(1, "On", False, 0), (2, "", True, 0), (3, "", False, 2)]
    assert isinstance(listed.networks[1], DrawnNetwork)
    assert listed.networks[1].items == ()
    assert [one.operator for one in listed.networks[2].lines] == ["LD", "ST"]


def test_an_assignment_has_its_targets_in_order() -> None:
    assignment = first(assign(contact("a", NEGATED), "x", ("y", NEGATED)))
    assert isinstance(assignment, Assignment)
    assert [(one.text, one.modifiers) for one in assignment.targets] == [("x", 0), ("y", NEGATED)]
    assert isinstance(assignment.value, NetworkOperand)
    assert assignment.value.modifiers == NEGATED


@pytest.mark.parametrize(
    ("item", "why"),
    [
        (contact("a", 64), "flags 64 are not supported"),
        (box("F", contact("a"), pins=[8]), "flags 8 are not supported on an input"),
        (thing("BoxTreeMux", ""), "'BoxTreeMux' is not supported"),
        (thing("BoxTreeTerminator", thing("BoxTreeTerminator", "", "Input")), "with an input"),
    ],
)
def test_what_the_format_does_not_have_is_named(item: str, why: str) -> None:
    with pytest.raises(Unexpected, match=why):
        first(item)
