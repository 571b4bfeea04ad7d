"""Recordings in a few numbers, and as notebooks show them."""

import math
import sys

import pytest

from achse.scope import SCOPE_TYPES, ScopeBlock, ScopeChannel, ScopeData
from achse.scope import summary as module
from achse.scope.summary import html_of, png_of, summary
from tests.scope.conftest import recording


def long_one(values: list[float], name: str = "a") -> ScopeData:
    type = SCOPE_TYPES["REAL64"]
    rows = b"".join(type.word(value).to_bytes(8, "little", signed=True) for value in values)
    block = ScopeBlock(0, 1_000_000, (ScopeChannel(name),), (type,), (len(values),), rows)
    return ScopeData("long", (block,))


def test_the_summary_has_numbers_that_json_has() -> None:
    [row] = summary(long_one([1.0, math.nan, -2.0, math.inf]))
    assert (row["min"], row["max"], row["last"]) == (-2.0, "inf", "inf")
    assert [each["samples"] for each in summary(recording())] == [6] * 10 + [4, 3]
    [row] = summary(long_one([]))
    assert (row["min"], row["last"]) == (None, None)


def test_a_notebook_shows_curves_and_numbers() -> None:
    pytest.importorskip("matplotlib")
    data = recording()
    text = data._repr_html_()
    assert text == html_of(data)
    assert text.startswith('<img alt="curves of GVL.BIT, ')
    assert text.count("<tr>") == 13
    assert "<td>level</td>" in text
    png = data._repr_png_()
    assert png is not None
    assert png.startswith(b"\x89PNG")


def test_without_matplotlib_it_shows_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    data = recording()
    assert png_of(data) is None
    assert data._repr_html_().startswith("<table>")


def test_a_long_recording_is_not_looked_through(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_SHOWN_SAMPLES", 3)
    text = html_of(long_one([1.0] * 4))
    assert "<img" not in text
    assert "4 samples" in text
    assert "min" not in text


@pytest.mark.parametrize("values", [[], [math.nan] * 9, [math.inf, -math.inf]])
def test_whatever_it_holds_can_be_shown(values: list[float]) -> None:
    name = "<script>alert('$x^2 $')</script>"
    text = html_of(long_one(values, name))
    assert "<script" not in text
    assert "&lt;script&gt;" in text
