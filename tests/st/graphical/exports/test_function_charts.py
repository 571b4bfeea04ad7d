"""Continuous function charts in exports: elements with numbers, pins without names."""

import pytest

from achse.st.files.exports import parse_export
from achse.st.graphical.exports.function_charts import read_exported_function_chart
from achse.st.syntax.cursor import Unexpected
from tests.st.graphical.drawings import Drawn


def element(id: int, type: str, inside: str) -> str:
    return f"_ELEMENT\n_ID: {id}\n_MACROID: -1\n_POS: 3, {id}\n_TYPE: {type}\n{inside}_END\n"


def source(id: int, place: int = 0, negate: int = 0) -> str:
    return f"_INPUTID: {id}\n_INPUTIDX: {place}\n_NEGATE: {negate}\n"


def value(id: int, text: str) -> str:
    return element(id, "_INPUT", f"_TEXT: {text}\n_NEGATE: 0\n_CONNECTOR: \n")


def written(id: int, text: str, pin: str, storing: str = "_NONE") -> str:
    return element(id, "_OUTPUT", f"_TEXT: {text}\n{pin}_SETRESET: {storing}\n")


def box(id: int, type: str, instance: str, *pins: str, outputs: int = 1, eno: int = 0) -> str:
    inside = f"_INSTANCE: {int(bool(instance))}\n_INSTANCENAME: {instance}\n_TYPENAME: {type}\n"
    inside += f"_ENENO: {eno}\n_INPUTS: {len(pins)}\n"
    inside += "".join(f"_IN\n{pin}_END\n" for pin in pins)
    inside += f"_OUTPUTS: {outputs}\n" + "_OUT\n_NEGATE: 0\n_CONNECTOR: \n_END\n" * outputs
    return element(id, "_BOX", inside + "_PARAMETERS: 0\n")


def program(variables: str, *elements: str, more: str = "") -> Drawn:
    head = f"PROGRAM MAIN\nVAR {variables} END_VAR\n(* @END_DECLARATION := '0' *)\n_CFC_BODY\n"
    text = more + head + "".join(elements) + "\nEND_PROGRAM\n"
    return Drawn(parse_export(text, "MAIN.EXP", "MAIN"))


def test_pins_of_a_block_are_in_the_order_of_its_declaration() -> None:
    plc = program(
        "x, q, done : BOOL; t : TON; n : TIME;",
        value(1, "x"),
        value(2, "T#20MS"),
        box(3, "TON", "t", source(1, negate=1), source(2), outputs=2),
        written(4, "q", source(3)),
        written(5, "n", source(3, 1)),
        written(6, "done", source(3), "_SET"),
    )
    plc.rows("x", "q done", ["0 | 0 0", "0 | 0 0", "0 | 1 1", "1 | 0 1"])


def test_elements_run_in_the_order_of_the_file() -> None:
    plc = program(
        "a, q : INT;",
        value(1, "a"),
        value(2, "10"),
        written(3, "q", source(4)),
        box(4, "ADD", "", source(1), source(2)),
    )
    plc.rows("a", "q", ["1 | 0", "2 | 11", "3 | 12"])


def test_box_without_instance_calls_a_program_or_function() -> None:
    more = (
        "FUNCTION Twice : INT\nVAR_INPUT n : INT; END_VAR\n(* @END_DECLARATION := '0' *)\n"
        "Twice := 2 * n;\nEND_FUNCTION\n"
        "PROGRAM Other\nVAR n : INT; END_VAR\n(* @END_DECLARATION := '0' *)\n"
        "n := n + 1;\nEND_PROGRAM\n"
    )
    plc = program(
        "a, q, p : INT;",
        value(1, "a"),
        box(2, "Twice", "", source(1)),
        written(3, "q", source(2)),
        box(4, "Other", "", outputs=0),
        value(5, "Other.n"),
        written(6, "p", source(5)),
        more=more,
    )
    plc.rows("a", "q p", ["1 | 2 1", "4 | 8 2"])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (element(1, "_JUMP", ""), "'_JUMP' is not supported in a chart"),
        (box(1, "ADD", "", eno=1), "the box ADD shows EN and ENO"),
        (written(1, "q", source(2), "_BOTH"), "_SETRESET _BOTH is not supported"),
        (element(1, "_INPUT", "").replace("_ID: 1\n", ""), "expected _ID: NUMBER"),
        ("_ELEMENT\n_ID: 1\n", "an element is not closed"),
    ],
)
def test_what_was_not_seen_is_refused(text: str, message: str) -> None:
    with pytest.raises(Unexpected, match=message):
        read_exported_function_chart(text)
