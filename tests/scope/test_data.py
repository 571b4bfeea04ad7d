"""Recordings: numbers of Python and of NumPy, times, files by their endings."""

import sys
from pathlib import Path

import pytest

from achse.scope.data import ScopeData
from achse.scope.types import SCOPE_TYPES, ScopeError
from tests.scope.conftest import BEGIN_NS, MS, recording


def test_every_type_comes_back() -> None:
    data = recording()
    assert data["GVL.BIT"].values == [False, True] * 3
    assert data["GVL.INT8"].values == [-3, -2, -1, 0, 1, 2]
    assert data["GVL.UINT16"].raw == [0, 1, 2, 3, 4, 5]
    assert data["GVL.INT64"].values == [-(n << 40) for n in range(6)]
    assert data["GVL.REAL64"].values == [1e-10, -1e-3, 1e4, -1e11]
    assert data["level"].values == [-1.5, -1.0, -0.5]
    assert data["level"].raw == [-1, 0, 1]


def test_times_count_from_the_first_sample() -> None:
    data = recording()
    assert data["GVL.BIT"].times_ms == [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]
    assert data["level"].times == [0.001, 0.005, 0.009]
    assert (data.begin_ns, data.end_ns) == (BEGIN_NS, BEGIN_NS + 10 * MS)
    assert data.trigger_time == 0.004
    assert len(data) == len(list(data)) == 12
    assert ScopeData("empty", ()).trigger_time is None
    assert ScopeData("empty", ()).end_ns == 0


def test_numpy_has_the_same() -> None:
    numpy = pytest.importorskip("numpy")
    for track in recording().tracks:
        assert track.array.tolist() == track.values
        assert track.time_array.tolist() == track.times
        kind = "<f8" if track.channel.scaled else SCOPE_TYPES[track.type.name].array_code
        assert track.array.dtype == numpy.dtype(kind)


def test_the_ending_determines_the_form(tmp_path: Path) -> None:
    data = recording()
    data.save(tmp_path / "a.csv")
    data.save(str(tmp_path / "a.SCOPE"))
    assert ScopeData.load(tmp_path / "a.SCOPE")["level"].values == [-1.5, -1.0, -0.5]
    with pytest.raises(
        ScopeError, match=r"a\.wav: expected the ending \.csv, \.scope or \.parquet"
    ):
        data.save(tmp_path / "a.wav")


def test_tables_follow() -> None:
    pytest.importorskip("pandas")
    pytest.importorskip("polars")
    data = recording()
    assert list(data.to_pandas().columns) == list(data)
    assert data.to_polars().columns == ["time", *data]


@pytest.mark.parametrize("name", ["array", "time_array"])
def test_arrays_without_numpy_name_the_extra(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.setitem(sys.modules, "numpy", None)
    with pytest.raises(ScopeError, match="needs the extra tables: pip install"):
        getattr(recording()["level"], name)
