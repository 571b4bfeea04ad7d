"""Networks of the newer ladder editor."""

import json
from typing import Any

import pytest

from achse.st.check import check
from achse.st.declare import declare
from tests.st.graphical.drawings import Drawn, quoted, read, thing, unit


def node(type: str, **members: Any) -> dict[str, Any]:
    return {"$type": type, **members}


def operand(text: str, *, negated: bool = False) -> dict[str, Any]:
    entry = node("Operand", Expression=text)
    if negated:
        entry["Modifier"] = node("Modifier", Negation=True)
    return entry


def sequence(*elements: dict[str, Any]) -> dict[str, Any]:
    return node("Sequence", Elements=list(elements)) if elements else node("Sequence")


def element(type: str, text: str, *, negated: bool = False) -> dict[str, Any]:
    return node(type, Operand=operand(text, negated=negated))


def block(
    type: str, inputs: dict[str, Any], outputs: dict[str, str | None], **more: Any
) -> dict[str, Any]:
    """A block; an input None is fed by the power line, an output None runs on."""
    pins = [
        node("Input", Pin=node("Pin", Name=name), Sequence=value or sequence())
        for name, value in inputs.items()
    ]
    out = []
    for name, variable in outputs.items():
        one = node("Output", Pin=node("Pin", Name=name))
        if variable is not None:
            one["OutVariable"] = node("OutVariable", Operand=operand(variable))
        out.append(one)
    return node("Block", BlockType=type, Inputs=pins, Outputs=out, **more)


def body(*sequences: dict[str, Any]) -> str:
    networks = [
        node("Network", Id=f"id{number}", Sequence=one) for number, one in enumerate(sequences)
    ]
    text = json.dumps(node("LadderDataModel", Networks=networks)).replace("&", "&amp;")
    root = thing("LadderImplementationObject", quoted("ModelJson", text))
    return f"<LADDER><XmlArchive><Data>{root}</Data></XmlArchive></LADDER>"


def test_power_runs_through_contacts_branches_and_blocks_to_the_coil() -> None:
    timer = block(
        "TON",
        {"IN": None, "PT": sequence(element("InVariable", "T#20MS"))},
        {"Q": None, "ET": ""},
        CallType=2,
        Instance=operand("t"),
    )
    either = node(
        "ParallelClosed",
        Branches=[
            sequence(element("Contact", "a"), element("Contact", "b", negated=True)),
            sequence(element("Contact", "c")),
        ],
    )
    chosen = block("SEL", {"G": None, "A": sequence(element("InVariable", "1")),
                           "B": sequence(element("InVariable", "2"))}, {"": "n"})  # fmt: skip
    text = body(
        sequence(),
        sequence(either, timer, element("Coil", "q"), element("Coil", "nq", negated=True)),
        sequence(element("Contact", "q"), chosen),
    )
    head = "PROGRAM MAIN\nVAR a, b, c, q, nq : BOOL; n : INT; t : TON;\nEND_VAR"
    plc = Drawn(unit(head, text))
    rows = ["1 0 0 | 0 1 1", "0 0 1 | 0 1 1", "1 0 0 | 1 0 2", "1 1 0 | 0 1 1"]
    plc.rows("a b c", "q nq n", rows)


@pytest.mark.parametrize(
    ("item", "why"),
    [
        (node("Jump"), "expected Contact, got 'Jump'"),
        ({**element("Coil", "q"), "Set": True}, "'Set' of a Coil is not supported"),
        (block("F", {}, {}, CallType=9), "call type 9 of F is not supported"),
        (block("F", {"a": None, "b": None}, {}), "the power line of F leads to 2 inputs"),
    ],
)
def test_what_was_not_seen_is_refused_by_name(item: dict[str, Any], why: str) -> None:
    text = unit("PROGRAM MAIN VAR q : BOOL; END_VAR", body(sequence(item)))
    typed = check(declare([read(text)]))
    assert not typed.faults
    assert why in typed.left_out["main"]
