"""Networks as statements: contacts, coils, boxes, wires, branches, jumps; worked examples."""

from datetime import timedelta

import pytest

from achse.st.check import check
from achse.st.declare import declare
from tests.st.graphical.drawings import (
    FALLING,
    JUMP,
    NEGATED,
    RESET,
    RETURN,
    RISING,
    SET,
    Drawn,
    assign,
    box,
    branches,
    contact,
    fb,
    network,
    networks,
    open_end,
    parallel,
    part,
    read,
    series,
    unit,
    wire,
)

HEAD = "PROGRAM MAIN\nVAR\n{}\nEND_VAR"


def drawn(variables: str, *items: str, view: str = "Ld", others: tuple[str, ...] = ()) -> Drawn:
    return Drawn(unit(HEAD.format(variables), networks(*items, view=view)), *others)


def test_contacts_in_parallel_and_series_feed_a_coil_and_a_negated_one() -> None:
    rung = series(branches(contact("a"), contact("b")), contact("c", NEGATED))
    plc = drawn("a, b, c, q, nq : BOOL;", network(assign(rung, "q", ("nq", NEGATED))))
    rows = ["0 0 0 | 0 1", "1 0 0 | 1 0", "0 1 0 | 1 0", "1 1 1 | 0 1"]
    plc.rows("a b c", "q nq", rows)


@pytest.mark.parametrize("is_set_last", [False, True])
def test_of_set_and_reset_the_later_network_wins(is_set_last: bool) -> None:
    both = [network(assign(contact("s"), ("q", SET))), network(assign(contact("r"), ("q", RESET)))]
    if is_set_last:
        both.reverse()
    last = network(assign(contact("q"), ("nq", NEGATED)))
    plc = drawn("s, r, q, nq : BOOL;", *both, last)
    third = "1 1 | 1 0" if is_set_last else "1 1 | 0 1"
    plc.rows("s r", "q nq", ["1 0 | 1 0", "0 0 | 1 0", third, "1 0 | 1 0", "0 1 | 0 1"])


def test_each_edge_has_its_own_memory_and_negation_comes_first() -> None:
    def add() -> str:
        return box("ADD", contact("n"), contact("1"), en=contact("x", RISING),
                   outputs=[("ENO", ""), ("''", "n")])  # fmt: skip

    plc = drawn(
        "x, p, pn, fn : BOOL; n : INT;",
        network(assign(contact("x", RISING), "p")),
        network(assign(contact("x", NEGATED + RISING), "pn")),
        network(assign(contact("x", NEGATED + FALLING), "fn")),
        network(add()),
        network(add()),
    )
    rows = ["0 | 0 1 0 0", "0 | 0 0 0 0", "1 | 1 0 1 2", "1 | 0 0 0 2", "0 | 0 1 0 2",
            "0 | 0 0 0 2", "1 | 1 0 1 4", "0 | 0 1 0 4"]  # fmt: skip
    plc.rows("x", "p pn fn n", rows)


def test_eno_enables_the_next_box() -> None:
    move = box("MOVE", contact("src"), en=contact("en"), outputs=[("ENO", None), ("''", "x")])
    add = box("ADD", contact("x"), contact("1"), en=move, outputs=[("ENO", None), ("''", "y")])
    plc = drawn("en, lamp : BOOL; src, x, y : INT;", network(assign(add, "lamp")))
    plc.rows("en src", "x y lamp", ["0 5 | 0 0 0", "1 5 | 5 6 1", "0 9 | 5 6 0", "1 9 | 9 10 1"])


def test_an_operator_with_en_assigns_its_result_while_en_is_true() -> None:
    add = box("ADD", contact("n"), contact("1"), en=contact("x"), eno=False, outputs=[("", None)])
    plc = drawn("x : BOOL; n : INT;", network(assign(add, "n")), view="Fbd")
    plc.rows("x", "n", ["0 | 0", "1 | 1", "0 | 1", "1 | 2"])


def test_en_of_an_older_editor_shows_by_its_name() -> None:
    null = ('<v n="EN">true</v>', '<n n="EN" />'), ('<v n="ENO">false</v>', '<n n="ENO" />')
    timer = box("TON", contact("TRUE"), contact("T#0MS"), en=contact("x"), eno=False, instance="t",
                call="FunctionBlock", names=["IN", "PT"], outputs=[("Q", None)])  # fmt: skip
    for old, new in null:
        assert old in timer
        timer = timer.replace(old, new)
    plc = drawn("x, q : BOOL; t : TON;", network(assign(timer, "q")), view="Fbd")
    plc.rows("x", "q", ["0 | 0", "1 | 1"])


def test_en_that_a_block_declares_itself_is_an_input() -> None:
    block = """FUNCTION_BLOCK FB VAR_INPUT EN : BOOL; END_VAR VAR_OUTPUT n, m : INT; END_VAR
    n := n + 1; IF EN THEN m := n; END_IF END_FUNCTION_BLOCK"""
    call = box("FB", en=contact("x"), eno=False, instance="f", call="FunctionBlock",
               outputs=[("n", "n"), ("m", "m")])  # fmt: skip
    plc = drawn("x : BOOL; n, m : INT; f : FB;", network(call), others=(block,))
    plc.rows("x", "n m", ["0 | 1 0", "1 | 2 2", "0 | 3 2"])


def test_a_label_that_is_no_name_is_a_remark() -> None:
    more = box("ADD", contact("n"), contact("1"), outputs=[("", None)])
    twice = (network(assign(more, "n"), label="//Counts up") for _ in range(2))
    plc = drawn("n : INT;", *twice, view="Fbd")
    plc.rows("", "n", ["| 2", "| 4"])


@pytest.mark.parametrize("sequential", [False, True])
def test_a_bridged_timer_is_called_only_in_the_sequential_form(sequential: bool) -> None:
    timer = fb("TON", "t", [("IN", open_end()), ("PT", contact("T#30MS"))],
               [("Q", None), ("ET", "")])  # fmt: skip
    both = parallel([contact("over"), timer], contact("a"), sequential=sequential)
    plc = drawn("a, over, q : BOOL; t : TON;", network(assign(both, "q")))
    inputs = ["1 0", "1 0", "1 1", "1 0", "0 1", "1 1", "1 0", "1 0", "1 0", "1 0"]
    expected = (
        [(0, 0), (0, 10), (1, 20), (1, 30), (0, 0), (1, 0), (0, 10), (0, 20), (1, 30), (1, 30)]
        if sequential
        else [(0, 0), (0, 10), (1, 10), (1, 30), (0, 0), (1, 0), (0, 0), (0, 10), (0, 20), (1, 30)]
    )
    for row, (q, elapsed) in zip(inputs, expected, strict=True):
        a, over = map(int, row.split())
        plc.cycle(a=bool(a), over=bool(over))
        outcome = (plc["q"], plc["t.ET"] // timedelta(milliseconds=1))
        assert outcome == (bool(q), elapsed)


def test_a_wire_keeps_its_value_when_its_operands_change() -> None:
    above = box("GT", contact("n"), contact("3"), outputs=[("", None)])
    more = box("ADD", contact("n"), contact("1"), outputs=[("", None)])
    chosen = box("SEL", wire(1), more, contact("0"), outputs=[("", None)])
    plc = drawn(
        "flag : BOOL; n : INT := 3;",
        network(wire(1, above), assign(chosen, "n"), assign(wire(1), "flag")),
        view="Fbd",
    )
    plc.rows("", "flag n", ["| 0 4", "| 1 0", "| 0 1", "| 0 2", "| 0 3", "| 0 4"])


def test_jumps_and_returns_leave_out_networks() -> None:
    more = box("ADD", contact("cnt"), contact("1"), outputs=[("", None)])
    plc = drawn(
        "a, b : BOOL; cnt, out : INT;",
        network(assign(contact("a"), ("Skip", JUMP))),
        network(assign(more, "cnt")),
        network(assign(contact("b"), ("???", RETURN)), label="skip"),
        network(assign(contact("cnt"), "out")),
        view="Fbd",
    )
    plc.rows("a b", "cnt out", ["0 0 | 1 1", "1 0 | 1 1", "0 1 | 2 1", "1 1 | 2 1", "0 0 | 3 3"])


def test_networks_run_from_top_to_bottom() -> None:
    first, second = network(assign(contact("y", NEGATED), "x")), network(assign(contact("x"), "y"))
    variables = "x, y : BOOL;"
    drawn(variables, first, second).rows("", "x y", ["| 1 1", "| 0 0", "| 1 1", "| 0 0"])
    drawn(variables, second, first).rows("", "x y", ["| 1 0", "| 0 1", "| 1 0", "| 0 1", "| 1 0"])


def test_disabled_networks_and_unfinished_rungs_do_nothing() -> None:
    plc = drawn(
        "q : BOOL;",
        network(assign(contact("???"), "???"), disabled=True, label="twice"),
        network(label="twice"),
        network(assign(open_end(), "q")),
    )
    plc.rows("", "q", ["| 0"])


def test_an_execute_box_runs_its_text_and_methods_and_actions_are_called() -> None:
    text = box("EXECUTE", call="None", en=contact("a"), text="n := n + 1;\nact();",
               outputs=[("ENO", None)])  # fmt: skip
    method = box("Twice", contact("n"), call="Method", names=["x"], outputs=[("Twice", "m")])
    action = box("act", call="Action", outputs=[("", "")])
    act = part("Action", "act", networks(network(assign(contact("TRUE"), "done"))))
    twice = part(
        "Method", "Twice", "Twice := 2 * x;", "METHOD Twice : INT VAR_INPUT x : INT; END_VAR"
    )
    body = networks(network(assign(text, "ran")), network(method), network(action))
    plc = Drawn(unit(HEAD.format("a, ran, done : BOOL; n, m : INT;"), body, act + twice))
    plc.rows("a", "ran n m done", ["0 | 0 0 0 1", "1 | 1 1 2 1", "1 | 1 2 4 1"])


def test_function_outputs_are_set_and_negated_at_their_pins() -> None:
    call = box(
        "F", contact("a"), call="Function", names=["x"],
        outputs=[("F", "n"), ("o", ("q", NEGATED)), ("p", ("s", SET))],
    )  # fmt: skip
    function = """FUNCTION F : INT VAR_INPUT x : BOOL; END_VAR VAR_OUTPUT o, p : BOOL; END_VAR
    o := p := x; F := SEL(x, 1, 2); END_FUNCTION"""
    text = unit(HEAD.format("a, q, s : BOOL; n : INT;"), networks(network(call), view="Fbd"))
    plc = Drawn(text, function)
    plc.rows("a", "n q s", ["0 | 1 1 0", "1 | 2 0 1", "0 | 1 1 1"])


@pytest.mark.parametrize(
    ("type", "value", "shown"), [("LREAL", "2", "2"), ("DINT", "-7", "-7"), ("WORD", "9", "9")]
)
def test_function_output_that_is_read_has_its_own_type(type: str, value: str, shown: str) -> None:
    call = box(
        "F", contact("a"), call="Function", names=["x"], outputs=[("o", None)], output_types=[type]
    )
    function = f"""FUNCTION F VAR_INPUT x : BOOL; END_VAR VAR_OUTPUT o : {type}; END_VAR
    o := {value}; END_FUNCTION"""
    body = networks(network(assign(call, "n")), view="Fbd")
    plc = Drawn(unit(HEAD.format(f"a : BOOL; n : {type};"), body), function)
    plc.rows("a", "n", [f"1 | {shown}"])


def test_what_was_read_before_a_box_keeps_its_value() -> None:
    """`a AND box` where the box writes `a`: the contact in front was read first."""
    call = box("ADD", contact("n"), contact("1"), en=contact("TRUE"),
               outputs=[("ENO", None), ("", "n")])  # fmt: skip
    sum = box("ADD", contact("n"), box("SEL", call, contact("0"), contact("10")))
    plc = drawn("n, m : INT;", network(assign(sum, "m")), view="Fbd")
    plc.rows("", "n m", ["| 1 10", "| 2 11"])


def test_a_fault_names_network_rung_and_box() -> None:
    body = networks(network(), network(assign(contact("a"), "a"), assign(contact("nope"), "a")))
    parsed = read(unit(HEAD.format("a : BOOL;"), body))
    (fault,) = check(declare([parsed])).faults
    assert fault.message == "network 2, rung 2: nothing is named 'nope' here"
    lines = unit(HEAD.format("a : BOOL;"), body).split("\n")
    assert "Operand" in lines[fault.location.line - 1]


@pytest.mark.parametrize(
    ("item", "why"),
    [
        ('<o t="BoxTreeMux"></o>', "'BoxTreeMux' is not supported in a network"),
        (assign(contact("???"), "a"), "an operand is not filled in: expected an expression"),
        (assign(contact("a"), ("a", RISING)), "an edge on the coil a is not supported"),
        (assign(wire(3), "a"), "wire 3 is read before it is defined"),
        (fb("TON", "", [("IN", contact("a"))]), "the box TON has no instance"),
    ],
)
def test_a_body_that_is_refused_is_a_warning_and_cannot_be_called(item: str, why: str) -> None:
    parsed = read(unit(HEAD.format("a : BOOL;"), networks(network(item))))
    typed = check(declare([parsed]))
    assert not typed.faults
    assert any(why in warning.message for warning in typed.warnings)
    assert why in typed.left_out["main"]
    assert "main" not in typed.routines


def test_a_label_stands_at_one_network() -> None:
    body = networks(network(label="On"), network(label="ON"))
    (fault,) = check(declare([read(unit(HEAD.format("a : BOOL;"), body))])).faults
    assert "label ON is at network 1 already" in fault.message
