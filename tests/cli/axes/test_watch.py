"""On a terminal a watched axis is a picture."""

from collections.abc import Callable
from typing import Any

import pytest


def test_the_picture_has_a_line_of_figures_and_two_curves(
    cli: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("achse.cli.axes.watch.on_terminal", lambda: True)
    result = cli("axis", "show", "X", "--watch", "-n", "4", "-c", "0.01")
    title, *picture = result.stdout.splitlines()
    assert title.split()[1] == "X"
    assert [line.split()[0] for line in picture if "mm" in line] == ["position", "velocity"]


def test_a_line_says_position_velocity_and_state(cli: Callable[..., Any]) -> None:
    [line] = cli("axis", "show", "C", "--watch", "-n", "1").stdout.splitlines()
    assert line.split()[1:] == ["C", "0.0000", "degree", "0.0000", "degree/s", "Disabled"]
