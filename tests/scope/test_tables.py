"""Tables: pandas, polars and Parquet have the numbers of the recording, and gaps elsewhere."""

import builtins
from pathlib import Path
from typing import Any

import pytest

from achse.scope.data import ScopeData
from achse.scope.tables import to_pandas, to_polars, write_parquet
from achse.scope.types import ScopeError
from tests.scope.conftest import recording


def test_pandas_has_a_column_per_channel() -> None:
    pytest.importorskip("pandas")
    frame = to_pandas(recording())
    assert frame.index.name == "time"
    for track in recording().tracks:
        column = frame[track.channel.name].dropna()
        assert [float(value) for value in column] == list(map(float, track.values))
        assert list(column.index) == track.times
    assert to_pandas(ScopeData("empty", ())).empty


def test_polars_and_parquet_have_the_same(tmp_path: Path) -> None:
    polars = pytest.importorskip("polars")
    frame = to_polars(recording())
    for track in recording().tracks:
        part = frame.select("time", track.channel.name).drop_nulls()
        assert part.get_column(track.channel.name).to_list() == track.values
        assert part.get_column("time").to_list() == track.times
    write_parquet(recording(), tmp_path / "a.parquet")
    assert polars.read_parquet(tmp_path / "a.parquet").equals(frame)
    assert to_polars(ScopeData("empty", ())).is_empty()


@pytest.mark.parametrize("name", ["pandas", "polars"])
def test_without_the_extra_it_says_what_to_install(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = builtins.__import__

    def without(wanted: str, *rest: Any) -> Any:
        if wanted == name:
            raise ImportError(f"no {name}", name=name)
        return real(wanted, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(ScopeError, match=rf"a table \({name}\) needs the extra tables: pip"):
        (to_pandas if name == "pandas" else to_polars)(recording())
