"""Pictures: what they have drawn, what they refuse, and that any numbers can be drawn."""

import re
import sys
import warnings
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import achse
from achse.extras import install_command
from achse.gcode.geometry.drawing import PathSample
from achse.plot import Picture, PictureError, PlotExtraMissing, cam, moves, path, recording
from tests.scope.conftest import recording as recorded

pytest.importorskip("matplotlib")

NUMBERS = st.floats(width=32)


def curves(picture: Picture) -> list[list[list[float]]]:
    """The values of the curves of each area."""
    return [[list(line.get_ydata()) for line in area.lines] for area in picture.figure.axes]


def titles(picture: Picture) -> list[str]:
    return [area.get_title(loc="left") for area in picture.figure.axes]


def sample(time: float, value: float) -> Any:
    return SimpleNamespace(
        time=time, position=value, set_position=value + 1, velocity=2 * value,
        set_velocity=2 * value + 1, following_error=-value,
    )  # fmt: skip


def test_a_recording_has_an_area_per_channel_and_the_trigger() -> None:
    data = recorded()
    picture = recording(data, ["level", "GVL.INT8"])
    levels, numbers = curves(picture)
    assert levels[0] == data["level"].values
    assert numbers[0] == data["GVL.INT8"].values
    assert titles(picture)[1] == "GVL.INT8"
    assert picture.figure.axes[0].lines[1].get_xdata()[0] == data.trigger_time
    assert len(recording(data).figure.axes) == 8
    assert len(recording(data, "level").figure.axes) == 1
    assert "2 areas" in repr(picture)
    with pytest.raises(KeyError):
        recording(data, ["nothing"])
    with pytest.raises(PictureError, match="no channel"):
        recording(data, [])


def test_peaks_of_long_recordings_are_seen() -> None:
    values = [0.0] * 50_000
    values[33_333] = 70.0
    values[44_444] = -7.0
    samples = [sample(n / 1000, value) for n, value in enumerate(values)]
    position, *_ = curves(moves(samples))
    assert len(position[0]) <= 4002
    assert (max(position[0]), min(position[0])) == (70.0, -7.0)


def test_moves_have_set_points_beside_what_was() -> None:
    picture = moves([sample(0.0, 1.0), sample(0.1, 3.0)], "mm")
    assert curves(picture) == [[[1, 3], [2, 4]], [[2, 6], [3, 7]], [[-1, -3]]]
    assert titles(picture) == ["position mm", "velocity mm/s", "following error mm"]
    with pytest.raises(PictureError, match="no sample"):
        moves([])


def test_a_cam_with_and_without_what_it_demands() -> None:
    rows = [(0.0, 0.0), (50.0, 10.0), (100.0, 0.0)]
    assert curves(cam(rows)) == [[[0.0, 10.0, 0.0]]]
    demand = SimpleNamespace(position=1.0, velocity=2.0, acceleration=3.0)
    position, velocity, acceleration = curves(cam(rows, [(9.0, demand), (1.0, demand)]))
    assert position == [[1.0, 1.0], [0.0, 10.0, 0.0]]
    assert (velocity, acceleration) == ([[2.0, 2.0]], [[3.0, 3.0]])
    for wrong, message in (([], "no row"), ([(1.0,)], "a master and a slave")):
        with pytest.raises(PictureError, match=message):
            cam(wrong)


def test_a_path_is_seen_along_an_axis() -> None:
    points = [(0.0, 1.0, 2.0), (3.0, 4.0, 5.0)]
    for view, first in {"xy": (0.0, 1.0), "zx": (2.0, 0.0), "yz": (1.0, 2.0)}.items():
        [area] = path(points, view).figure.axes
        assert (area.lines[0].get_xdata()[0], area.lines[0].get_ydata()[0]) == first
        assert (area.get_xlabel(), area.get_ylabel()) == (f"{view[0]} mm", f"{view[1]} mm")
    samples = [PathSample(point, 10.0 * n) for n, point in enumerate(points)]
    area, bar = path(samples).figure.axes
    assert list(area.collections[0].get_array()) == [10.0]
    assert bar.get_ylabel() == "velocity mm/s"
    with pytest.raises(PictureError, match="two points"):
        path(points[:1])
    with pytest.raises(PictureError, match="xy, zx or yz, got 'ab'"):
        path(points, "ab")
    with pytest.raises(PictureError, match="x, y and z"):
        path([(1.0, 2.0)])


def test_files_by_their_endings(tmp_path: Path) -> None:
    picture = achse.plot.cam([(0.0, 0.0), (1.0, 1.0)])
    for ending, begin in {"png": b"\x89PNG", "SVG": b"<?xml", "pdf": b"%PDF"}.items():
        picture.save(tmp_path / f"a.{ending}")
        assert (tmp_path / f"a.{ending}").read_bytes().startswith(begin)
    assert picture._repr_png_() == picture.png
    with pytest.raises(PictureError, match=r"a\.gif: expected a name that ends in"):
        picture.save(str(tmp_path / "a.gif"))
    with pytest.raises(OSError, match="none"):
        picture.save(tmp_path / "none" / "a.png")


def test_names_are_not_formulas_and_not_markup() -> None:
    track = recorded()["level"]
    channel = SimpleNamespace(name=r"$\frac$ <script>", unit="$")
    odd = SimpleNamespace(
        name="", trigger_time=None, tracks=[_Renamed(track, channel)], __getitem__=None
    )
    text = recording(odd).svg
    assert not re.search(r"<script", text)


class _Renamed:
    def __init__(self, track: Any, channel: Any) -> None:
        self.array, self.time_array, self.channel = track.array, track.time_array, channel


def test_without_matplotlib_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(PlotExtraMissing, match=re.escape(install_command("plot"))):
        cam([(0.0, 0.0)])


@settings(max_examples=5, deadline=None)
@given(
    kind=st.sampled_from(["moves", "cam", "path"]),
    values=st.lists(NUMBERS, min_size=2, max_size=30),
    unit=st.text(max_size=5),
    view=st.sampled_from(["xy", "zx", "yz"]),
    velocity=NUMBERS,
)
def test_any_numbers_can_be_drawn(
    kind: str, values: list[float], unit: str, view: str, velocity: float
) -> None:
    """Finite or not; glyphs that no font has are warnings of matplotlib's."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if kind == "moves":
            picture = moves([sample(float(n), value) for n, value in enumerate(values)], unit)
        elif kind == "cam":
            picture = cam([(float(n), value) for n, value in enumerate(values)])
        else:
            picture = path(
                [SimpleNamespace(at=(n, value, 0.0), velocity=velocity)
                 for n, value in enumerate(values)],
                view,
            )  # fmt: skip
        assert picture.png
