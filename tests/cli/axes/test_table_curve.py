"""What a table demands, which limits it breaks, and its pictures."""

from pathlib import Path

import pytest
import typer

from achse.cli.axes.table_curve import Curve, SlaveLimits, curve_of
from achse.client.nc import FunctionPoint
from achse.motion.states import CamInterpolation

STROKE = [FunctionPoint(0.0, 0.0, 5), FunctionPoint(180.0, 100.0, 0)]


def curve(velocity: float = 720.0) -> Curve:
    return curve_of(STROKE, CamInterpolation.LINEAR, False, velocity)


def test_extremes_are_those_of_the_law() -> None:
    """POLY5, 0 … 180 → 100 at 720."""
    extremes = curve().extremes
    assert extremes[0] == pytest.approx((0.0, 100.0))
    assert extremes[1] == pytest.approx((0.0, 750.0), abs=1e-9)
    assert extremes[2] == pytest.approx((-9237.604307034, 9237.604307034))
    assert extremes[3] == pytest.approx((-192000.0, 384000.0))


def test_limits_that_hold_and_limits_that_do_not() -> None:
    laws = curve()
    assert laws.violations(SlaveLimits()) == []
    assert laws.violations(SlaveLimits(0.0, 100.0, 750.0, 9237.7, 384000.0)) == []
    broken = laws.violations(SlaveLimits(1.0, 99.0, 700.0, 9000.0, 300000.0))
    assert [(each.quantity, each.limit) for each in broken] == [
        ("position", 1.0),
        ("position", 99.0),
        ("velocity", 700.0),
        ("acceleration", -9000.0),
        ("acceleration", 9000.0),
        ("jerk", 300000.0),
    ]
    [(begin, end)] = broken[2].spans
    assert begin < 90.0 < end


def test_spans_are_apart() -> None:
    rows = [(0.0, 0.0), (10.0, 10.0), (20.0, 10.0), (30.0, 20.0)]
    law = curve_of(rows, CamInterpolation.LINEAR, False, 1.0)
    [broken] = law.violations(SlaveLimits(max_velocity=0.5))
    assert len(broken.spans) == 2
    assert broken.spans[0][1] <= 10.0 <= 20.0 <= broken.spans[1][0]


def test_what_is_no_function_ends_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(typer.Exit):
        curve_of([(1.0, 0.0), (0.0, 0.0)], CamInterpolation.LINEAR, False, 1.0)
    assert "rise" in capsys.readouterr().err


def test_a_picture_for_terminals() -> None:
    text = curve().text(SlaveLimits(max_velocity=700.0), "mm", 80).plain
    assert "velocity mm/s  beyond its limit" in text
    assert "jerk mm/s³\n" in text
    assert max(map(len, text.splitlines())) <= 80
    assert text.splitlines()[-1].endswith("master")


@pytest.mark.parametrize("ending", ["svg", "png", "pdf"])
def test_pictures_in_files(tmp_path: Path, ending: str) -> None:
    pytest.importorskip("matplotlib")
    file = tmp_path / f"stroke.{ending}"
    curve().save(file, SlaveLimits(max_velocity=700.0), "mm", "a stroke")
    assert file.stat().st_size > 1000


def test_other_endings_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    with pytest.raises(typer.Exit):
        curve().save(tmp_path / "stroke.txt", SlaveLimits(), "mm", "")
    with pytest.raises(typer.Exit):
        curve().save(tmp_path / "no" / "stroke.svg", SlaveLimits(), "mm", "")
    assert capsys.readouterr().err.count("stroke") == 2
