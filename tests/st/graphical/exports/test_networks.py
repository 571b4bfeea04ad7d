"""Networks in exports: rungs, boxes on the rung, boxes with pins in order."""

import pytest

from achse.st.files.exports import parse_export
from achse.st.graphical.exports.networks import read_exported_networks
from achse.st.syntax.cursor import Unexpected
from tests.st.graphical.drawings import Drawn

OPEN = "_NETWORK\n_COMMENT\n''\n_END_COMMENT\n"
END = "_EXPRESSION\n_POSITIV\n"


def contact(name: str, sign: str = "_POSITIV") -> str:
    return f"_LD_CONTACT\n{name}\n_EXPRESSION\n{sign}\n"


def outputs(*targets: str) -> str:
    """`q`, `S q`, `R q`, `/q` as targets."""
    kinds = {"S": "_POSITIV\n_SET", "R": "_NEGATIV\n_SET", "/": "_NEGATIV\n_NO_SET"}
    lines = [f"_OUTPUTS : {len(targets)}\n"]
    for target in targets:
        sign, _, name = target.rpartition(" ")
        lines.append(f"_OUTPUT\n{kinds.get(sign, '_POSITIV' + chr(10) + '_NO_SET')}\n{name}\n")
    return "".join(lines)


def rung(tree: str, *targets: str, enabled: tuple[str, ...] = ()) -> str:
    boxes = f"ENABLELIST : {len(enabled)}\n{''.join(enabled)}ENABLELIST_END\n"
    return OPEN + "_LD_ASSIGN\n" + tree + END + boxes + outputs(*targets)


def operand(name: str, sign: str = "_POSITIV") -> str:
    return f"_OPERAND\n_EXPRESSION\n{sign}\n{name}\n"


def program(variables: str, view: str, *networks: str) -> Drawn:
    body = f"_{view}_BODY\n_NETWORKS : {len(networks)}\n" + "".join(networks)
    head = f"PROGRAM MAIN\nVAR {variables} END_VAR\n(* @END_DECLARATION := '0' *)\n"
    return Drawn(parse_export(head + body + "\nEND_PROGRAM\n", "MAIN.EXP", "MAIN"))


def test_contacts_feed_coils() -> None:
    either = "_LD_OR\n_LD_OPERATOR : 2\n" + contact("a") + contact("b") + END
    tree = "_LD_AND\n_LD_OPERATOR : 2\n" + either + contact("c", "_NEGATIV") + END
    plc = program("a, b, c, q, nq : BOOL;", "LD", rung(tree, "q", "/ nq"))
    plc.rows("a b c", "q nq", ["0 0 0 | 0 1", "1 0 0 | 1 0", "0 1 0 | 1 0", "1 1 1 | 0 1"])


def test_set_and_reset_coils() -> None:
    plc = program("s, r, q : BOOL;", "LD", rung(contact("s"), "S q"), rung(contact("r"), "R q"))
    plc.rows("s r", "q", ["1 0 | 1", "0 0 | 1", "1 1 | 0", "0 0 | 0"])


def test_rung_enables_boxes() -> None:
    box = (
        "_ASSIGN\n_OPERATOR\n_BOX_EXPR: 2\n_ENABLED\n" + operand("n") + operand("1") + END + "ADD\n"
        + END + outputs("n")
    )  # fmt: skip
    plc = program("en, q : BOOL; n : INT;", "LD", rung(contact("en"), "q", enabled=(box,)))
    plc.rows("en", "n q", ["0 | 0 0", "1 | 1 1", "1 | 2 1", "0 | 2 0"])
    always = program("en, q : BOOL; n : INT;", "LD", rung("_EMPTY\n", enabled=(box,)))
    always.rows("en", "n", ["0 | 1", "0 | 2"])


def test_pins_of_a_block_are_in_the_order_of_its_declaration() -> None:
    call = (
        OPEN + "_ASSIGN\n_FUNCTIONBLOCK\nt\n_BOX_EXPR : 2\n" + operand("x", "_NEGATIV")
        + operand("T#20ms") + END + "TON\n" + outputs("elapsed") + END + outputs("q")
    )  # fmt: skip
    plc = program("x, q : BOOL; t : TON; elapsed : TIME;", "FBD", call)
    plc.rows("x", "q", ["0 | 0", "0 | 0", "0 | 1", "1 | 0"])


def test_function_gets_its_inputs_in_order() -> None:
    tree = "_OPERATOR\n_BOX_EXPR : 3\n" + operand("x") + operand("3") + operand("5") + END + "SEL\n"
    plc = program("x : BOOL; n : INT;", "FBD", OPEN + "_ASSIGN\n" + tree + END + outputs("n"))
    plc.rows("x", "n", ["0 | 3", "1 | 5"])


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (
            "_LD_BODY\n_NETWORKS : 1\n_NETWORK\n_LD_ASSIGN\n_LD_EDGE\n",
            "'_LD_EDGE' is not supported",
        ),
        ("_LD_BODY\n_NETWORKS : x\n", "expected _NETWORKS : NUMBER"),
        ("_FBD_BODY\n_NETWORKS : 1\n_NETWORK\n_JUMP\n", "'_JUMP' is not supported here"),
        ("_FBD_BODY\n_NETWORKS : 1\n_NETWORK\n_ASSIGN\n", "'' is not supported here"),
    ],
)
def test_what_was_not_seen_is_refused(body: str, message: str) -> None:
    with pytest.raises(Unexpected, match=message):
        read_exported_networks(body)
