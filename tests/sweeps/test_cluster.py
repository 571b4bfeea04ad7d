"""Sweeps in this process and over workers: one digest, resumed, and no run lost with a worker."""

from pathlib import Path
from typing import Any

import pytest

import achse
from achse.sweeps import Sweep, SweepError

SOURCE = """
import os, random
from pathlib import Path

def run(*, gain: float, seed: int) -> dict[str, float]:
    place = Path(__file__).parent
    (place / f"{os.getpid()}.pid").touch()
    if seed == 3 and not (place / "died").exists():
        (place / "died").touch()
        if (place / "die").exists():
            os.kill(os.getpid(), 9)
    return {"value": gain * random.Random(seed).random()}
"""
GAINS = {"gain": [1.0, 2.0, 4.0]}


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    file = tmp_path / "scenario.py"
    file.write_text(SOURCE)
    return file


def test_in_this_process(scenario: Path) -> None:
    reports: list[tuple[int, int]] = []
    sweep = achse.sweep(
        scenario, GAINS, seeds=5, workers=0, progress=lambda *each: reports.append(each)
    )
    assert isinstance(sweep, Sweep)
    assert [row["run"] for row in sweep.rows] == list(range(15))
    assert sweep.rows[1]["gain"] == 1.0
    assert sweep.rows[6]["value"] == 2 * sweep.rows[1]["value"]
    assert (reports[0], reports[-1]) == ((0, 15), (15, 15))
    assert sweep.failed == []
    assert 0 < sweep.efficiency <= 1


def test_a_sweep_that_was_interrupted_goes_on(scenario: Path, tmp_path: Path) -> None:
    file = tmp_path / "found.parquet"
    ran: list[int] = []

    class Stopped(Exception):
        pass

    def stop(done: int, _all: int) -> None:
        ran.append(done)
        if done >= 7:
            raise Stopped

    settings: dict[str, Any] = {"seeds": 5, "workers": 0, "file": file}
    with pytest.raises(Stopped):
        achse.sweep(scenario, GAINS, progress=stop, **settings)
    assert not file.exists()
    ran.clear()
    sweep = achse.sweep(scenario, GAINS, progress=lambda done, _all: ran.append(done), **settings)
    assert ran[0] >= 7
    assert file.exists()
    whole = achse.sweep(scenario, GAINS, seeds=5, workers=0)
    assert sweep.digest == whole.digest


def test_a_worker_that_dies_loses_nothing(scenario: Path, tmp_path: Path) -> None:
    alone = achse.sweep(scenario, GAINS, seeds=8, workers=0)
    (tmp_path / "died").unlink()
    (tmp_path / "die").touch()
    sweep = achse.sweep(scenario, GAINS, seeds=8, workers=2, file=tmp_path / "found.parquet")
    assert (tmp_path / "died").exists()
    assert [row["run"] for row in sweep.rows] == list(range(24))
    assert sweep.digest == alone.digest
    assert len(list(tmp_path.glob("*.pid"))) >= 3  # this process, and workers


def test_what_cannot_be_is_reported(scenario: Path, tmp_path: Path) -> None:
    with pytest.raises(SweepError, match="workers are 0 or more"):
        achse.sweep(scenario, GAINS, workers=-1)
    with pytest.raises(FileNotFoundError):
        achse.sweep(tmp_path / "none.py", GAINS, workers=0)
