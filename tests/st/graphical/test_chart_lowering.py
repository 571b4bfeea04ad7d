"""Charts as statements: order of a call, qualifiers, branches, flags; worked examples."""

import pytest

from achse.st.check import check
from achse.st.declare import declare
from tests.st.graphical.drawings import (
    Drawn,
    assign,
    box,
    branch,
    chart,
    contact,
    jump,
    macro,
    network,
    networks,
    part,
    read,
    segment,
    sfc_flags,
    step,
    transition,
    unit,
)


def drawn(variables: str, *elements: str, parts: str = "", flags: tuple[str, ...] = ()) -> Drawn:
    head = f"PROGRAM MAIN\nVAR\n{variables}\nEND_VAR"
    return Drawn(unit(head, chart(*elements), parts, sfc_flags(*flags) if flags else ""))


def action(name: str, text: str) -> str:
    return part("Action", name, text)


def active(plc: Drawn, *steps: str) -> str:
    return " ".join(name for name in steps if plc[f"{name}.x"])


def test_a_main_action_runs_in_active_steps_an_iec_action_once_more() -> None:
    plc = drawn(
        "a, b : INT;",
        step("Init", initial="TRUE"),
        transition("TRUE"),
        step("S1", ("B", "N"), main="A"),
        transition("TRUE"),
        jump("Init"),
        parts=action("A", "a := a + 1;") + action("B", "b := b + 1;"),
    )
    rows = []
    for _ in range(7):
        plc.cycle()
        rows.append(f"{active(plc, 'Init', 'S1')} {plc['a']} {plc['b']}")
    expected = ["Init 0 0", "S1 1 1", "Init 1 2", "S1 2 3", "Init 2 4", "S1 3 5", "Init 3 6"]
    assert rows == expected


def test_exit_entry_main_actions_and_then_iec_actions_by_name() -> None:
    names = "entryA mainA exitA entryB mainB exitB"
    parts = "".join(action(name, f"log := CONCAT(log, '{name} ');") for name in names.split())
    for name in ("Alpha", "Zed"):
        text = f"log := CONCAT(log, SEL(_{name}._x, '{name}0 ', '{name}1 '));"
        parts += action(name, text)
    plc = drawn(
        "t, u : BOOL; log : STRING(255);",
        step("A", initial="TRUE", entry="entryA", main="mainA", exit="exitA"),
        transition("t"),
        step("B", ("Zed", "N"), ("Alpha", "N"), entry="entryB", main="mainB", exit="exitB"),
        transition("u"),
        jump("a"),
        parts=parts,
    )
    rows = [
        ("0 0", "A", "entryA mainA"),
        ("1 0", "A", "mainA"),
        ("0 0", "B", "exitA entryB mainB Alpha1 Zed1"),
        ("0 1", "B", "mainB Alpha1 Zed1"),
        ("0 0", "A", "exitB entryA mainA Alpha0 Zed0"),
        ("0 0", "A", "mainA"),
    ]
    for row, name, log in rows:
        t, u = map(int, row.split())
        plc.cycle(t=bool(t), u=bool(u), log="")
        assert (active(plc, "A", "B"), plc["log"].strip()) == (name, log)


def test_of_alternatives_the_leftmost_true_transition_fires() -> None:
    back = [
        segment(transition(c), step(s), transition("e"), jump("S0"))
        for c, s in zip("abc", "LMR", strict=True)
    ]
    plc = drawn("a, b, c, e : BOOL;", step("S0", initial="TRUE"), branch(*back))
    rows = ["0 0 0 0 S0", "0 1 1 0 S0", "1 0 0 0 M", "0 0 0 1 M", "0 0 1 1 S0", "0 0 1 1 R"]
    for row in rows:
        *values, name = row.split()
        plc.cycle(**dict(zip("abce", (word == "1" for word in values), strict=True)))
        assert active(plc, "S0", "L", "M", "R") == name


def test_a_parallel_branch_is_joined_when_all_last_steps_are_active() -> None:
    plc = drawn(
        "go, a, join, back : BOOL;",
        step("S0", initial="TRUE"),
        transition("go"),
        branch(
            segment(step("P1"), transition("a"), step("P1b")), segment(step("P2")), parallel=True
        ),
        transition("join"),
        step("S9"),
        transition("back"),
        jump("S0"),
        flags=("CurrentStep",),
    )
    rows = ["0 0 1 0 | S0", "1 0 1 0 | S0", "1 0 1 0 | P1 P2", "1 1 1 0 | P1 P2",
            "0 1 1 0 | P1b P2", "0 0 0 1 | S9", "0 0 1 1 | S0", "0 0 1 1 | S0"]  # fmt: skip
    for number, row in enumerate(rows, 1):
        inputs, _, names = row.partition(" | ")
        values = dict(zip(("go", "a", "join", "back"), inputs.split(), strict=True))
        plc.cycle(**{name: word == "1" for name, word in values.items()})
        assert active(plc, "S0", "P1", "P1b", "P2", "S9") == names
        if 3 <= number <= 5:
            assert plc["SFCCurrentStep"] == "P2"


Actions = list[tuple[str, str]]


def _trace(names: str, b: Actions, e: Actions, go: tuple[int, ...]) -> list[str]:
    """Cycles as `f`, `1` or `-` for each action: final scan, executed, not executed."""
    parts = "".join(
        action(name, f"s{name} := SEL(_{name}._x, 'f', '1');") for name in names.split()
    )
    variables = "goC, goE, goA : BOOL; " + "".join(f"s{name} : STRING;" for name in names.split())
    plc = drawn(
        variables,
        step("A", initial="TRUE"), transition("TRUE"),
        step("B", *b), transition("goC"),
        step("C"), transition("goE"),
        step("E", *e), transition("goA"),
        jump("A"),
        parts=parts,
    )  # fmt: skip
    rows = []
    for cycle in range(1, 13):
        values = {f"s{name}": "-" for name in names.split()}
        flags = {key: cycle >= at for key, at in zip(("goC", "goE", "goA"), go, strict=True)}
        plc.cycle(**values, **flags)
        trace = " ".join(plc[f"s{name}"] for name in names.split())
        rows.append(f"{active(plc, 'A', 'B', 'C', 'E')} {trace}")
    return rows


def test_qualifiers_n_s_l_d_p_and_r() -> None:
    b = [("aN", "N"), ("aS", "S"), ("aL", "L T#30MS"), ("aD", "D, T#20MS"), ("aP", "p")]
    assert _trace("aD aL aN aP aS", b, [("aS", "R")], (6, 8, 10)) == [
        "A - - - - -", "B - 1 1 1 1", "B - 1 1 f 1", "B 1 1 1 - 1", "B 1 f 1 - 1", "B 1 - 1 - 1",
        "C f - f - 1", "C - - - - 1", "E - - - - f", "E - - - - -", "A - - - - -", "B - 1 1 1 1",
    ]  # fmt: skip


def test_qualifiers_with_stored_times_and_pulses_at_both_ends() -> None:
    b = [("aSD", "SD T#30MS"), ("aDS", "DS T#30MS"), ("aSL", "SL T#30MS"),
         ("aP1", "P1"), ("aP0", "P0")]  # fmt: skip
    e = [("aSD", "R"), ("aDS", "R"), ("aSL", "R")]
    assert _trace("aDS aP0 aP1 aSD aSL", b, e, (3, 7, 99))[:9] == [
        "A - - - - -", "B - - f - 1", "B - - - - 1", "C - f - - 1", "C - - - 1 f", "C - - - 1 -",
        "C - - - 1 -", "E - - - f -", "E - - - - -",
    ]  # fmt: skip


def test_init_reset_and_pause() -> None:
    plc = drawn(
        "na, nb : INT;",
        step("A", initial="TRUE", main="mainA"),
        transition("TRUE"),
        step("B", main="mainB"),
        transition("FALSE"),
        jump("A"),
        parts=action("mainA", "na := na + 1;") + action("mainB", "nb := nb + 1;"),
        flags=("Init", "Reset", "Pause", "CurrentStep"),
    )
    rows = ["0 0 0 | A 1 0", "0 0 0 | B 1 1", "0 0 1 | B 1 1", "0 0 0 | B 1 2", "1 0 0 | A 1 2",
            "1 0 0 | A 1 2", "0 0 0 | A 2 2", "0 0 0 | B 2 3", "0 1 0 | A 3 3", "0 1 0 | A 4 3",
            "0 0 0 | B 4 4", "0 0 0 | B 4 5"]  # fmt: skip
    for row in rows:
        inputs, _, expected = row.partition(" | ")
        init, reset, pause = (word == "1" for word in inputs.split())
        plc.cycle(SFCInit=init, SFCReset=reset, SFCPause=pause)
        assert f"{plc['SFCCurrentStep']} {plc['na']} {plc['nb']}" == expected


def test_a_step_that_is_active_too_long_is_an_error_until_it_is_quit() -> None:
    plc = drawn(
        "",
        step("A", initial="TRUE", maximum="T#20MS", minimum="T#40MS"),
        transition("TRUE"),
        step("B"),
        transition("FALSE"),
        jump("A"),
        flags=("Error", "ErrorStep", "ErrorPOU", "QuitError", "Trans"),
    )
    rows = [(plc.cycle()["SFCError"], plc["SFCErrorStep"], plc["SFCTrans"]) for _ in range(5)]
    assert rows == [
        (False, "", False), (False, "", False), (False, "", False),
        (True, "A", False), (True, "A", True),
    ]  # fmt: skip
    assert plc["SFCErrorPOU"] == "MAIN"
    plc.cycle(SFCQuitError=True)
    assert (plc["SFCError"], active(plc, "A", "B")) == (False, "A")
    plc.cycle(SFCQuitError=False)
    assert active(plc, "A", "B") == "B"


def test_tip_mode_fires_by_edges_of_tip_only() -> None:
    plc = drawn(
        "",
        step("A", initial="TRUE"),
        transition("TRUE"),
        step("B"),
        transition("FALSE"),
        jump("A"),
        flags=("Tip", "TipMode"),
    )
    rows = [
        (1, 0, "A"),
        (1, 0, "A"),
        (1, 1, "A"),
        (1, 1, "B"),
        (0, 0, "B"),
        (0, 1, "B"),
        (0, 1, "A"),
    ]
    for mode, tip, name in rows:
        plc.cycle(SFCTipMode=bool(mode), SFCTip=bool(tip))
        assert active(plc, "A", "B") == name


def test_transition_objects_macros_and_boolean_variables() -> None:
    drawn_part = networks(
        network(assign(box("OR", contact("go"), contact("now")), "TGo")), view="Fbd"
    )
    plc = drawn(
        "go, now, lamp : BOOL; far : ARRAY [0..1] OF BOOL;",
        step("A", initial="TRUE"),
        macro(transition("tgo"), step("B", ("lamp", "N"), ("far[1]", "N"))),
        transition("TBack"),
        jump("A"),
        parts=part("Transition", "TGo", drawn_part) + part("Transition", "TBack", "B.t >= T#10MS"),
    )
    rows = []
    for go in (0, 1, 0, 0, 0):
        plc.cycle(go=bool(go))
        rows.append((active(plc, "A", "B"), plc["lamp"], plc["far"][1]))
    assert rows == [
        ("A", False, False), ("A", False, False), ("B", True, True),
        ("B", True, True), ("A", False, False),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("elements", "why"),
    [
        ([step("A")], "expected one initial step, got 0"),
        ([step("A", initial="TRUE"), step("B")], "expected a transition behind step A"),
        ([step("A", initial="TRUE"), transition("TRUE")], "the transition has no target step"),
        ([step("A", initial="TRUE"), transition("x"), jump("Z")], "a jump to 'Z'"),
        (
            [step("A", initial="TRUE"), transition("nope"), jump("A")],
            "transition behind A: nothing is named 'nope' here",
        ),
        (
            [step("A", initial="TRUE", main="nope"), transition("TRUE"), jump("A")],
            "step A: no function or instance is named 'nope'",
        ),
    ],
)
def test_what_is_wrong_with_a_chart_names_step_or_transition(elements: list[str], why: str) -> None:
    text = unit("PROGRAM MAIN VAR x : BOOL; END_VAR", chart(*elements))
    faults = check(declare([read(text)])).faults
    assert any(why in fault.message for fault in faults), faults
