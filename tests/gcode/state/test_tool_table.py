"""Tools and their file."""

from math import nan
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.gcode.state.tool_table import ToolFileError, ToolParameter, ToolTable


def test_wear_is_added() -> None:
    tools = ToolTable()
    tool = tools[7]
    for parameter, value in (
        (ToolParameter.TYPE, 20.0),
        (ToolParameter.LENGTH, 50.0),
        (ToolParameter.WEAR_LENGTH, -0.5),
        (ToolParameter.RADIUS, 5.0),
        (ToolParameter.WEAR_RADIUS, -0.1),
        (ToolParameter.OFFSET_Y, 3.0),
    ):
        tool[parameter] = value
    assert tool.length == 49.5
    assert tool.radius == pytest.approx(4.9)
    assert tool.offset == (0.0, 3.0, 0.0)
    tool[ToolParameter.TYPE] = 10.0
    assert tool.radius == 0.0
    assert 7 in tools
    assert 8 not in tools
    tools.clear()
    assert 7 not in tools


@pytest.mark.parametrize("place", [0, 256, -1])
def test_places(place: int) -> None:
    with pytest.raises(KeyError):
        ToolTable()[place]
    with pytest.raises(ValueError, match="finite"):
        ToolTable()[1][ToolParameter.LENGTH] = nan


FINITE = st.floats(allow_nan=False, allow_infinity=False)


@given(st.dictionaries(st.integers(1, 255), st.lists(FINITE, min_size=15, max_size=15), max_size=5))
def test_a_file_keeps_every_bit(values: dict[int, list[float]]) -> None:
    tools, again = ToolTable(), ToolTable()
    for place, row in values.items():
        for parameter, value in enumerate(row):
            tools[place][parameter] = value
    again.read(tools.text())
    assert again.text() == tools.text()


def test_files(tmp_path: Path) -> None:
    tools, again = ToolTable(), ToolTable()
    tools[3][ToolParameter.RADIUS] = 2.5
    tools.save(tmp_path / "1.wz")
    again.load(tmp_path / "1.wz")
    assert again[3].radius == 2.5


@pytest.mark.parametrize(
    "line", ["D0 1", "D256 1", "X 1", "D1", "D1 a", "D1 inf", "D1 " + "1 " * 16]
)
def test_a_wrong_file_changes_nothing(line: str) -> None:
    tools = ToolTable()
    tools[9][ToolParameter.RADIUS] = 1.0
    with pytest.raises(ToolFileError, match="line 2"):
        tools.read(f"D1 0 20 5\n{line}")
    assert 9 in tools
    assert 1 not in tools
