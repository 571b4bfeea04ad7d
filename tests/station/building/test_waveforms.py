"""The values of simulated signals over time."""

import math
import statistics
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter

from achse.station.building.waveforms import CsvError, counter, noise, periodic, read_csv
from achse.station.configuration.signal import SignalConfig

SECOND = 1_000_000_000
CYCLE = 10_000_000


def _config(kind: str, **keys: Any) -> Any:
    return TypeAdapter(SignalConfig).validate_python({"symbol": "M.x", "kind": kind, **keys})


@pytest.mark.parametrize(
    ("kind", "keys", "values"),
    [
        ("sine", {}, [5, 7, 5, 3, 5]),
        ("sine", {"phase": 0.25}, [7, 5, 3, 5, 7]),
        ("ramp", {}, [5, 5.5, 6, 6.5, 5]),
        ("ramp", {"once": True}, [5, 5.5, 6, 6.5, 7]),
        ("triangle", {}, [5, 6, 7, 6, 5]),
        ("square", {}, [7, 7, 5, 5, 7]),
        ("square", {"duty": 0.25}, [7, 5, 5, 5, 7]),
        ("square", {"duty": 0.0}, [5, 5, 5, 5, 5]),
        ("square", {"duty": 1.0}, [7, 7, 7, 7, 7]),
    ],
)
def test_a_quarter_of_the_period_each(kind: str, keys: Any, values: list[float]) -> None:
    wave = periodic(_config(kind, period="4s", amplitude=2, offset=5, **keys))
    assert [wave(n * SECOND) for n in range(5)] == pytest.approx(values)


def test_a_ramp_that_comes_once_stays() -> None:
    wave = periodic(_config("ramp", period="4s", once=True))
    assert (wave(9 * SECOND), wave(10**15)) == (1, 1)


@given(
    st.sampled_from(["sine", "ramp", "triangle", "square"]),
    st.integers(1, 3_600_000_000_000),
    st.floats(-1e6, 1e6),
    st.floats(-1e6, 1e6),
    st.floats(-5, 5),
    st.integers(0, 10**18),
)
def test_it_stays_within_its_amplitude(
    kind: str, period: int, amplitude: float, offset: float, phase: float, now: int
) -> None:
    config = _config(kind, period=f"{period}ns", amplitude=amplitude, offset=offset, phase=phase)
    value = periodic(config)(now)
    low = offset - abs(amplitude) - 1e-6
    assert low <= value <= offset + abs(amplitude) + 1e-6


@pytest.mark.parametrize(
    ("keys", "values"),
    [
        ({}, [0, 1, 2, 3, 4]),
        ({"first": 3, "step": -2}, [3, 1, -1, -3, -5]),
        ({"first": 1, "last": 3}, [1, 2, 3, 1, 2]),
        ({"first": 1, "last": 4, "step": 2}, [1, 3, 1, 3, 1]),
        ({"first": 2, "last": 2}, [2, 2, 2, 2, 2]),
        ({"period": "20ms"}, [0, 0, 1, 1, 2]),
    ],
)
def test_a_counter_counts(keys: Any, values: list[int]) -> None:
    count = counter(_config("counter", **keys), CYCLE)
    assert [count(n * CYCLE) for n in range(5)] == values


def test_noise_is_the_same_each_time_and_another_by_seed_and_symbol() -> None:
    def numbers(**keys: Any) -> list[float]:
        wave = noise(_config("noise", **keys), CYCLE)
        return [wave(n * CYCLE) for n in range(100)]

    assert numbers() == numbers(seed=0)
    assert numbers(seed=1) != numbers()
    other = noise(_config("noise").model_copy(update={"symbol": "M.y"}), CYCLE)
    assert [other(n * CYCLE) for n in range(100)] != numbers()


@pytest.mark.parametrize(("distribution", "deviation"), [("uniform", 1 / 3**0.5), ("normal", 1)])
def test_noise_is_distributed_as_it_says(distribution: str, deviation: float) -> None:
    wave = noise(_config("noise", distribution=distribution, offset=3, amplitude=2), CYCLE)
    values = [wave(n * CYCLE) for n in range(20_000)]
    assert statistics.fmean(values) == pytest.approx(3, abs=0.05)
    assert statistics.stdev(values) == pytest.approx(2 * deviation, rel=0.03)
    if distribution == "uniform":
        assert 1 <= min(values) < max(values) <= 5


def test_noise_stays_for_its_period() -> None:
    wave = noise(_config("noise", period="1s"), CYCLE)
    assert wave(0) == wave(SECOND - 1) != wave(SECOND)


@pytest.fixture
def table(tmp_path: Path) -> Path:
    (tmp_path / "level.csv").write_text("\ufefftime;level\n0;1\n1;3\n4;5\n", encoding="utf-8")
    return tmp_path


def _values(folder: Path, *moments: float, **keys: Any) -> list[float]:
    wave = read_csv(_config("csv", **{"file": "level.csv", **keys}), folder)
    return [wave(round(moment * 1e9)) for moment in moments]


def test_a_file_is_played(table: Path) -> None:
    assert _values(table, 0, 0.9, 1, 3.9, 4, 99) == [1, 1, 3, 3, 5, 5]
    assert _values(table, 0.5, 2.5, interpolate=True) == [2, 4]
    # repeated a line (here 3 s) after its end
    assert _values(table, 6.9, 7, 8, repeat=True) == [5, 1, 3]
    assert _values(table, 0, 1, column="LEVEL", amplitude=10, offset=-1) == [9, 29]
    assert _values(table, 0, 1, column=1) == [0, 1]
    assert _values(table, 0, 0.5, 1, period="500ms", column=2) == [1, 3, 5]


def test_a_file_without_header_and_times(tmp_path: Path) -> None:
    (tmp_path / "level.csv").write_text("1\n2\n\n3\n")
    assert _values(tmp_path, 0, 1, 2, period="1s") == [1, 2, 3]


@pytest.mark.parametrize(
    ("content", "keys", "message"),
    [
        ("a;b\n", {}, "has no values"),
        ("", {}, "has no values"),
        ("1\n2\n", {}, "period: expected"),
        ("0,1\n0,2\n", {}, "line 2: expected a later time"),
        ("t,x\n0,1\n1,soon\n", {}, "line 3, column 2: expected a number, got 'soon'"),
        ("t,x\n0,1\n1\n", {}, "line 3, column 2: expected a number, got ''"),
        ("t,x\n0,nan\n", {}, "expected a number"),
        ("t,level\n0,1\n", {"column": "levle"}, "did you mean 'level'"),
        ("0,1\n", {"column": "x"}, "none, as it has no header"),
        ("0,1\n", {"column": 3}, "1..2, got 3"),
        ("0,1\n", {"time": 0}, "time: expected a column"),
    ],
)
def test_what_cannot_be_played_is_reported(
    tmp_path: Path, content: str, keys: Any, message: str
) -> None:
    (tmp_path / "level.csv").write_text(content)
    with pytest.raises(CsvError, match=message):
        _values(tmp_path, 0, **keys)


def test_a_file_that_cannot_be_read_is_reported(tmp_path: Path) -> None:
    with pytest.raises(CsvError, match="cannot be read"):
        _values(tmp_path, 0)
    (tmp_path / "level.csv").write_bytes(b"\xff\xfe\x00\xd8")
    with pytest.raises(CsvError, match="UTF-8"):
        _values(tmp_path, 0)


@given(st.floats(0, 1e6), st.booleans(), st.booleans())
def test_any_moment_has_a_value(moment: float, repeat: bool, interpolate: bool) -> None:
    from achse.station.building.waveforms import _played

    config = _config("csv", file="x", repeat=repeat, interpolate=interpolate)
    value = _played(config, [0.0, 1e9, 4e9], [1.0, 3.0, 5.0])(round(moment * 1e9))
    assert 1 <= value <= 5
    assert math.isfinite(value)
