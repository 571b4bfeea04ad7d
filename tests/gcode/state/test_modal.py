"""Modal words: what they begin with, what they exclude, the words that clients read."""

import pytest

from achse.gcode.canon import LineMove
from achse.gcode.interpretation.interpreter import Interpreter
from achse.gcode.interpretation.machine_data import MachineData
from achse.gcode.state.modal import MODAL_WORDS, ModalState
from achse.gcode.state.offsets import ZeroShift
from achse.gcode.text.program import PartProgram
from tests.gcode.programs import ends, moves, with_tool


def modal_after(text: str, data: MachineData | None = None) -> ModalState:
    interpreter = Interpreter(PartProgram(text), data)
    list(interpreter)
    return interpreter.modal


def test_a_program_begins_with_the_defaults() -> None:
    words = ModalState().words()
    assert len(words) == MODAL_WORDS
    assert words == (1, 17, 40, 53, 0, 71, 90, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0)


def test_words_show_what_is_active() -> None:
    state = modal_after(
        "G0 G18 G60 G700 G91 CFIN FLIN CDON CPCOF D1 T5 S-1\nG55\nMIRROR X Z\n"
        "#set paramVertexSmoothing(3;1;2)#",
        with_tool(),
    )
    assert state.words(0x12345) == (
        *(0, 18, 40, 55, 60, 700, 91, 1, 1, 1, 0, 0b101, 1, 5, 0xFFFFFFFF, 0x2345, 3, 0),
    )
    assert modal_after("G60\nG08").words()[4] == 0


def test_zero_shifts_add_up_and_g53_switches_them_off() -> None:
    data = MachineData()
    data.shifts[ZeroShift.G54_FINE, 0] = 1.0
    data.shifts[ZeroShift.G54_COARSE, 0] = 10.0
    text = "G54\nG58 X100\nG59 X1000\nX5 F600\nG53 X5"
    assert ends(text, data) == [(1116.0, 0.0, 0.0), (5.0, 0.0, 0.0)]


def test_a_programmed_shift_ends_g53() -> None:
    assert ends("G58 X7\nX1 F600\nG53 X1\nG59 X2\nX1") == [
        (8.0, 0.0, 0.0),
        (1.0, 0.0, 0.0),
        (10.0, 0.0, 0.0),
    ]


def test_a_shift_moves_only_axes_that_are_named() -> None:
    data = MachineData()
    for axis in range(3):
        data.shifts[ZeroShift.G54_FINE, axis] = 10.0
    text = "X1 Y2 Z3 F600\nG54\nX4\nX Y\nG91 Z1"
    assert ends(text, data) == [
        (1.0, 2.0, 3.0),
        (14.0, 2.0, 3.0),
        (14.0, 12.0, 3.0),
        (14.0, 12.0, 14.0),
    ]


def test_tool_length_is_along_the_infeed_axis() -> None:
    data = with_tool(length=50.0)
    assert ends("G17 D1 X1 Z5 F600\nG17 P-1 Z5\nD0 Z5\nG19 D1 X1", data) == [
        (1.0, 0.0, 55.0),
        (1.0, 0.0, -45.0),
        (1.0, 0.0, 5.0),
        (51.0, 0.0, 5.0),
    ]


def test_units() -> None:
    result = moves("G70 X1 F60\nG700 X2\nG71 X3\nG710 X4\nG70 G2 X1 I-0.5 J0")
    assert [round(move.end[0], 6) for move in result] == [25.4, 50.8, 3.0, 4.0, 25.4]
    assert [move.velocity for move in result] == [1.0, 25.4, 1.0, 1.0, 1.0]


@pytest.mark.parametrize(
    ("mode", "expected"),
    [("FCONST", [(10.0, 10.0), (20.0, 20.0)]), ("FLIN", [(10.0, 10.0), (10.0, 20.0)])],
)
def test_linear_feed_begins_with_the_last_one(
    mode: str, expected: list[tuple[float, float]]
) -> None:
    result = moves(f"{mode} X1 F600\nX2 F1200")
    assert [(move.start_velocity, move.velocity) for move in result] == expected
    assert all(isinstance(move, LineMove) for move in result)
