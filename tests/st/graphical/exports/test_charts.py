"""Charts in exports: steps with statements, transitions between names."""

import pytest

from achse.st.files.exports import parse_export
from achse.st.graphical.exports.charts import read_exported_flow, read_exported_steps, step_bodies
from achse.st.syntax.cursor import Unexpected
from tests.st.graphical.drawings import Drawn

TIMES = "(* @SFCMAXTIME := '{}' *)\n(* @SFCMINTIME := '{}' *)\n(* @SFCCOMMENT := '' *)\n"
CHART = (
    "INITIAL_STEP Init:\ni := i + 1;\nEND_STEP\n" + TIMES.format("", "T#20ms")
    + "TRANSITION FROM Init TO (A, B):=\ngo (* go *)\nEND_TRANSITION\n"
    "STEP A:\nn := n + 1;\nEND_STEP\n" + TIMES.format("", "")
    + "STEP B:\n\nEND_STEP\n" + TIMES.format("", "")
    + "TRANSITION FROM (A,B) TO Init := TRUE\nEND_TRANSITION\n"
)  # fmt: skip


def test_chart_forks_joins_and_waits_for_the_minimum() -> None:
    text = (
        "PROGRAM MAIN\nVAR go : BOOL; i, n : INT; END_VAR\n(* @END_DECLARATION := '0' *)\n"
        + CHART + "END_PROGRAM\n"
    )  # fmt: skip
    plc = Drawn(parse_export(text, "MAIN.EXP", "MAIN"))
    rows = ["1 | 1 0 1 0", "1 | 2 0 1 0", "1 | 3 0 1 0", "1 | 3 1 0 1", "0 | 4 1 1 0"]
    plc.rows("go", "i n Init.x B.x", rows)


def test_statements_of_steps_have_their_places() -> None:
    bodies = [CHART[body.start : body.end].strip() for body in step_bodies(CHART)]
    assert bodies == ["i := i + 1;", "n := n + 1;"]


def test_steps_and_flow() -> None:
    init, a, b = read_exported_steps(CHART)
    assert (init.name, init.is_initial, init.minimum) == ("Init", True, "T#20ms")
    assert bool(a.main)
    assert not b.main
    fork, join = read_exported_flow(CHART).firings
    assert [step.name for step in fork.activated] == ["A", "B"]
    assert [step.name for step in join.left] == ["A", "B"]
    assert (fork.transition.text, join.transition.text) == ("go", "TRUE")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("TO Init", "TO Nowhere", "expected a step, got 'Nowhere'"),
        ("INITIAL_STEP", "STEP", "expected one initial step, got 0"),
        ("n := n + 1;", "_LD_BODY", "'_LD_BODY' is not supported in a step"),
    ],
)
def test_bad_chart_is_refused(old: str, new: str, message: str) -> None:
    with pytest.raises(Unexpected, match=message):
        read_exported_flow(CHART.replace(old, new))
