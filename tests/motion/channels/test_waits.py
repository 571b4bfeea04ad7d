"""The table of waits: whole, drawn as it is, and one with the table of transitions."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from achse.motion.channels import waits
from achse.motion.channels.states import ACTIVE_STATES, TRANSITIONS, InterpreterState
from achse.motion.channels.waits import WAITS, WaitEnd, WaitReason

PAGE = Path(__file__).parents[3] / "docs/explanation/waits-of-a-part-program.md"
_SHOWN = {WaitEnd.MOTION: "motion", WaitEnd.PLC: "the PLC", WaitEnd.REST: "rest"}


def drawn() -> Iterator[tuple[str, ...]]:
    """The cells of each row, as docstring and page show them."""
    for reason, row in WAITS.items():
        functions = ", ".join(f"0x{function:02X}" for function in row.functions)
        ends = [_SHOWN[row.ended_by]] if row.ended_by in _SHOWN else []
        ends += [f"function {functions}"] if functions else []
        after = "-" if row.then is None else row.then.name
        yield row.state.name, f"{reason.name}: {reason.value}", ", ".join(ends), after


def test_every_reason_has_a_row() -> None:
    assert list(WAITS) == list(WaitReason)


def test_docstring_draws_the_table() -> None:
    lines = (waits.__doc__ or "").splitlines()
    table = [line.split("  ") for line in lines if line.startswith("    ")][1:]
    cells = [tuple(cell.strip() for cell in line if cell.strip()) for line in table]
    assert cells == list(drawn())


def test_page_draws_the_table() -> None:
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    table = [line.strip("| ").split(" | ") for line in lines if line.startswith("| `")]
    cells = [tuple(cell.replace("`", "").strip() for cell in line) for line in table]
    assert cells == list(drawn())


@pytest.mark.parametrize("reason", WaitReason)
def test_events_of_a_row_lead_to_its_states(reason: WaitReason) -> None:
    row = WAITS[reason]
    if row.begins is not None:
        ways = {after for (_, event), after in TRANSITIONS.items() if event is row.begins}
        assert ways == {row.state}
    if row.ends is not None:
        after = TRANSITIONS[row.state, row.ends]
        if row.then is None:
            assert after in ACTIVE_STATES
        else:
            assert after is WAITS[row.then].state


def test_states_without_a_wait_are_those_in_which_blocks_run() -> None:
    reached = set(TRANSITIONS.values()) | {InterpreterState.IDLE}
    assert reached - {row.state for row in WAITS.values()} == {
        InterpreterState.STARTED,
        InterpreterState.RUNNING,
    }
