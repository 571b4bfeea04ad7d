"""pytcs, which reads exports of the vendor's scope, finds the same names, times and numbers."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.scope.conftest import recording


@pytest.fixture
def scope_file(witness: Callable[[str], None]) -> Any:
    witness("pytcs")
    import pytcs

    return pytcs.ScopeFile


@pytest.mark.parametrize("backend", ["polars", "pandas"])
def test_an_export_of_every_type_is_read(scope_file: Any, tmp_path: Path, backend: str) -> None:
    data = recording()
    data.save(tmp_path / "a.csv")
    read = scope_file(tmp_path / "a.csv")
    read.load(backend=backend)
    assert list(read) == list(data)
    for name, channel in read.items():
        track = data[name]
        assert channel.values.tolist() == [float(value) for value in track.values]
        assert channel.time.tolist() == track.times_ms
        assert channel.sample_time == track.step_ns / 1e6
        assert channel.info["Data-Type"] == track.type.name
    assert read.run_time.total_seconds() == 0.01
