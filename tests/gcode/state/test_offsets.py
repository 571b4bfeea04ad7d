"""Zero shifts and their file."""

from math import inf
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.gcode.state.offsets import ShiftFileError, ZeroShift, ZeroShifts


def test_fine_and_coarse_add_up() -> None:
    shifts = ZeroShifts()
    shifts[ZeroShift.G57_FINE, 2] = 1.0
    shifts[ZeroShift.G57_COARSE, 2] = 2.0
    shifts.program(59, 1, 7.0)
    assert shifts.adjustable(57) == (0.0, 0.0, 3.0)
    assert shifts.adjustable(56) == (0.0, 0.0, 0.0)
    assert shifts.programmed(59) == (0.0, 7.0, 0.0)
    assert shifts.programmed(58) == (0.0, 0.0, 0.0)
    shifts.clear()
    assert shifts.adjustable(57) == (0.0, 0.0, 0.0)


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=30, max_size=30))
def test_a_file_keeps_every_bit(values: list[float]) -> None:
    shifts, again = ZeroShifts(), ZeroShifts()
    for place, value in enumerate(values):
        shifts[ZeroShift(place // 3 + 1), place % 3] = value
    again.read(shifts.text())
    assert again.text() == shifts.text()
    assert again[ZeroShift.G59, 2] == values[-1]


def test_files(tmp_path: Path) -> None:
    shifts = ZeroShifts()
    shifts.program(58, 0, 1.5)
    shifts.save(tmp_path / "1.nps")
    again = ZeroShifts()
    again.load(tmp_path / "1.nps")
    assert again.programmed(58) == (1.5, 0.0, 0.0)


@pytest.mark.parametrize("text", ["G60 1 2 3", "G54F 1 2", "G54F a b c", "G54F 1 2 inf", "\xff"])
def test_a_wrong_file_changes_nothing(text: str) -> None:
    shifts = ZeroShifts()
    with pytest.raises(ShiftFileError, match="line 2"):
        shifts.read(f"G58 1 1 1\n{text}")
    assert shifts.programmed(58) == (0.0, 0.0, 0.0)
    with pytest.raises(ValueError, match="finite"):
        shifts[ZeroShift.G58, 0] = inf
