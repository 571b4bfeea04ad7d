"""The moving picture: casts become lines with moments, lines become SVG; the axis really moves."""

import json
import xml.etree.ElementTree as ET
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.site.moving import (
    COLUMNS,
    LONGEST_PAUSE_S,
    ROWS,
    TerminalLine,
    axis_positions,
    lines_of,
    moving_picture,
    still_picture,
)

TEXT = st.text(st.characters(codec="utf-8", exclude_categories=["C", "Zl", "Zp"]), max_size=120)
SVG = "{http://www.w3.org/2000/svg}"


def cast_of(lines: list[tuple[float, str]]) -> str:
    events = [[moment, "o", f"{text}\r\n"] for moment, text in lines]
    return "\n".join(json.dumps(each) for each in ({"version": 2}, *events))


@given(st.lists(st.tuples(st.floats(0, 30), TEXT), min_size=1, max_size=60))
def test_lines_of_a_cast_keep_order_and_pauses_are_bounded(lines: list[tuple[float, str]]) -> None:
    shown_lines = lines_of(cast_of(sorted(lines)))
    assert [line.text for line in shown_lines] == [text for _, text in sorted(lines)]
    moments = [0.0, *(line.moment for line in shown_lines)]
    for before, after in pairwise(moments):
        assert 0.0 <= after - before <= LONGEST_PAUSE_S + 1e-9


@pytest.mark.parametrize("header", ["[]", '{"version": 1}'])
def test_a_cast_of_another_form_is_refused(header: str) -> None:
    with pytest.raises(ValueError, match="expected a header of version 2"):
        lines_of(header)


@given(st.lists(TEXT, min_size=1, max_size=60), st.lists(st.floats(0, 100), min_size=2))
def test_pictures_show_the_lines_as_they_are(texts: list[str], positions: list[float]) -> None:
    lines = [TerminalLine(number * 0.1, text) for number, text in enumerate(texts)]
    for drawn, shown in (
        (moving_picture(lines, positions), texts),
        (still_picture(lines, positions), texts[-ROWS:]),
    ):
        inner = ET.fromstring(drawn).find(f"{SVG}svg/{SVG}g")
        assert inner is not None
        drawn_texts = [each.text or "" for each in inner]
        assert [each[: COLUMNS - 1] for each in drawn_texts] == [
            each[: COLUMNS - 1] for each in shown
        ]


def test_the_axis_travels_as_commanded() -> None:
    positions = axis_positions()
    assert positions[0] == 0.0
    assert positions[-1] == pytest.approx(100.0, abs=0.01)
    assert sorted(positions) == positions
    assert 50 < len(positions) < 70
