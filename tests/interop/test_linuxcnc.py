"""LinuxCNC's interpreter gives the same moves as ours, to the four decimals that it prints."""

from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from achse.gcode.canon import ArcMove, LineMove
from achse.gcode.errors import GcodeError
from achse.gcode.interpretation.interpreter import Interpreter, RunState
from achse.gcode.interpretation.machine_data import MachineData
from achse.gcode.state.offsets import ZeroShift
from achse.gcode.state.tool_table import ToolParameter
from achse.gcode.text.program import PartProgram
from tests.interop.linuxcnc.cases import BY_HAND, CASES, COMPENSATED
from tests.interop.linuxcnc.rs274 import SYSTEMS, Refused, WitnessMove, of_ours, run, translated

RADIUS = 2.0
SHIFTS = {"G54": (10.0, 20.0, 30.0), "G55": (-5.5, 0.25, 7.0), "G56": (1.0, 0.0, -1.0),
          "G57": (100.0, 200.0, 0.5)}  # fmt: skip
THEIR_SHIFTS = "G21\n" + "".join(
    f"G10 L2 P{SYSTEMS[name][0]} X{x} Y{y} Z{z}\n" for name, (x, y, z) in SHIFTS.items()
)


def machine() -> MachineData:
    """The machine that the programs run on: tool 1 with a radius, tool 2 with a length, shifts."""
    data = MachineData()
    data.tools[1][ToolParameter.RADIUS] = RADIUS
    data.tools[2][ToolParameter.LENGTH] = 50.0
    for name, values in SHIFTS.items():
        for axis, value in enumerate(values):
            data.shifts[ZeroShift[f"{name}_FINE"], axis] = value
    return data


def ours(text: str) -> list[WitnessMove]:
    interpreter = Interpreter(PartProgram(text), machine())
    moves = [of_ours(each) for each in interpreter if isinstance(each, LineMove | ArcMove)]
    assert interpreter.state is RunState.ENDED
    return moves


def real(moves: list[WitnessMove]) -> list[WitnessMove]:
    """Without lines that go nowhere: `G1 F600` makes one there."""
    witnessed: list[WitnessMove] = []
    at = (0.0, 0.0, 0.0)
    for move in moves:
        if move.centre is not None or any(
            abs(a - b) > 2 * move.grain for a, b in zip(at, move.end, strict=True)
        ):
            witnessed.append(move)
        at = move.end
    return witnessed


def assert_same(mine: list[WitnessMove], theirs: list[WitnessMove]) -> None:
    mine, theirs = real(mine), real(theirs)
    shown = "\n".join(f"{a}\n{b}\n" for a, b in zip(mine, theirs, strict=False))
    assert len(mine) == len(theirs), shown
    for number, (a, b) in enumerate(zip(mine, theirs, strict=True)):
        assert a.agrees(b), f"move {number}:\n{shown}"


@pytest.mark.parametrize("name", CASES)
def test_the_same_moves(name: str, witness: Callable[[str], None], tmp_path: Path) -> None:
    witness("rs274")
    assert_same(ours(CASES[name]), run(THEIR_SHIFTS + translated(CASES[name]), tmp_path))


@pytest.mark.parametrize("name", COMPENSATED)
def test_the_same_moves_beside_the_contour(
    name: str, witness: Callable[[str], None], tmp_path: Path
) -> None:
    """From the second contour element on: where the entry ends is each interpreter's own rule."""
    witness("rs274")
    text = COMPENSATED[name]
    theirs = real(run(translated(text, {1: 2 * RADIUS}), tmp_path))
    before = text.split("G41")[0].split("G42")[0]
    entry = len(real(ours(before))) + 1
    mine = real(ours(text))
    assert len(mine) > entry + 2
    assert_same(mine[entry:], theirs[entry:])


@pytest.mark.parametrize("name", BY_HAND)
def test_the_same_moves_by_other_words(
    name: str, witness: Callable[[str], None], tmp_path: Path
) -> None:
    witness("rs274")
    text, other = BY_HAND[name]
    assert_same(ours(text), run(f"{THEIR_SHIFTS}G90 G17 G40 G54\n{other}\n", tmp_path))


NUMBERS = st.floats(-200.0, 200.0).map(lambda value: f"{value:.3f}")
ARRIVED = "\nG90 G1 X1 Y2 Z3"
"""Behind a new frame: what an incremental word means there differs between the two."""
STEPS = st.one_of(
    st.builds("G{} X{} Y{}".format, st.integers(0, 1), NUMBERS, NUMBERS),
    st.builds("G1 Z{}".format, NUMBERS),
    st.builds(
        "G{} G91 X{} Y{} Z{} B{}".format,
        st.integers(2, 3),
        *(NUMBERS,) * 3,
        st.floats(300.0, 900.0).map(lambda value: f"{value:.2f}"),
    ),
    st.builds("G{} I{} J{}".format, st.integers(2, 3), NUMBERS, NUMBERS),
    st.sampled_from(["G90", "G91"]),
    st.sampled_from(["G54", "G55", "G56", "G57", "G53"]).map(lambda word: word + ARRIVED),
    st.builds(
        f"ROT Z{{}}{ARRIVED}\nG91 X{{}} Y{{}}\nG3 I{{}} J5\nROT Z0{ARRIVED}".format,
        *(NUMBERS,) * 4,
    ),
)


@settings(
    max_examples=12,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(st.lists(STEPS, min_size=3, max_size=15).map("\n".join))
def test_random_programs(witness: Callable[[str], None], tmp_path: Path, text: str) -> None:
    """What both run is the same; each may refuse an arc that the other one takes."""
    witness("rs274")
    text = "F600\n" + text
    try:
        mine = ours(text)
        theirs = run(THEIR_SHIFTS + translated(text), tmp_path)
    except (GcodeError, Refused):
        return
    assert_same(mine, theirs)
