"""Workers that die, hang or are ended: the sweep goes on, and says which run it was."""

import importlib
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import achse
from achse.sweeps import SweepError, deadline

SOURCE = """
import os, sys, threading
from achse.sweeps import deadline

hangs = threading.Event()

class Watch(getattr(deadline._Watch, "original", deadline._Watch)):
    # a run has taken its time when it says so
    original = getattr(deadline._Watch, "original", deadline._Watch)

    def __init__(self, *arguments):
        hangs.clear()
        super().__init__(*arguments)

    def _run(self, seconds):
        hangs.wait()
        super()._run(0.0)

    def end(self):
        super().end()
        hangs.set()  # its thread ends

deadline._Watch = Watch

def run(*, how: str, seed: int) -> dict[str, int]:
    if seed == 1:
        deadline._GRACE = 0.2 if how == "sleeps" else 1e9
        if how in ("loops", "sleeps"):
            hangs.set()
        if how == "dies":
            os._exit(1)
        if how == "leaves":
            sys.exit(1)
        if how == "loops":
            while True:
                pass
        if how == "sleeps":
            threading.Event().wait()
    return {"pid": os.getpid()}
"""


@pytest.fixture
def scenario(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The file of SOURCE; what it replaces in this process, which loads it too, comes back."""
    for name in ("_Watch", "_GRACE"):
        monkeypatch.setattr(deadline, name, getattr(deadline, name))
    file = tmp_path / "scenario.py"
    file.write_text(SOURCE)
    return file


def test_runs_that_kill_hang_or_leave_cost_their_own_rows_only(scenario: Path) -> None:
    ways = ["goes", "dies", "leaves", "loops", "sleeps"]
    reports: list[tuple[int, int]] = []
    sweep = achse.sweep(
        scenario,
        {"how": ways},
        seeds=3,
        workers=2,
        longest=2.0,
        progress=lambda *p: reports.append(p),
    )
    assert [row["run"] for row in sweep.rows] == list(range(15))
    errors = {str(row["how"]): str(row["error"]).partition(":")[0] for row in sweep.failed}
    assert errors == {
        "dies": "WorkerDied",
        "leaves": "SystemExit",
        "loops": "RunTooLong",
        "sleeps": "WorkerDied",
    }
    assert {row["seed"] for row in sweep.failed} == {1}
    assert reports[-1] == (15, 15)
    assert os.getpid() not in {row.get("pid") for row in sweep.rows}


def test_rows_are_not_lost_where_a_cluster_does_not_end_in_order(
    scenario: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    cluster = importlib.import_module("distributed").SpecCluster
    correct = cluster._correct_state_internal
    failed: list[Any] = []

    async def end_workers_then_fail(self: Any) -> None:
        await correct(self)
        if not self.worker_spec and not failed:
            failed.append(self)
            raise AssertionError("can only join a started process")

    monkeypatch.setattr(cluster, "_correct_state_internal", end_workers_then_fail)
    sweep = achse.sweep(scenario, {"how": ["goes"]}, seeds=3, workers=2)
    assert [row["error"] for row in sweep.rows] == [""] * 3
    assert "did not end its cluster in order" in caplog.text
    assert failed[0].status.name == failed[0].scheduler.status.name == "closed"


def test_a_scheduler_that_is_not_there_is_reported(
    scenario: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("achse.sweeps.workers._SOMEBODY_WITHIN", 0.2)
    with pytest.raises(SweepError, match="no Dask scheduler with workers at tcp:"):
        achse.sweep(scenario, {"how": ["goes"]}, scheduler="tcp://127.0.0.1:9")
    with pytest.raises(SweepError, match="no Dask scheduler"):
        achse.sweep(scenario, {"how": ["goes"]}, scheduler="nowhere://")


def test_what_a_limit_may_be(scenario: Path) -> None:
    for wrong in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(SweepError, match="the longest time of a run"):
            achse.sweep(scenario, {"how": ["goes"]}, workers=0, longest=wrong)


SLOW = """
import threading
from pathlib import Path

def run(*, seed: int) -> dict[str, int]:
    if seed >= 20 and (Path(__file__).parent / "slow").exists():
        threading.Event().wait()
    return {"x": seed}
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Ctrl-C goes to a group of processes")
def test_ctrl_c_ends_workers_too_and_the_sweep_goes_on_later(tmp_path: Path) -> None:
    scenario, slow = tmp_path / "scenario.py", tmp_path / "slow"
    scenario.write_text(SLOW)
    slow.touch()
    parts = tmp_path / "scenario.parquet.parts"
    command = ["sweep", str(scenario), "--seeds", "22", "--workers", "2", "--json"]
    running = subprocess.Popen(
        [sys.executable, "-m", "achse", *command],
        start_new_session=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    while not (parts.is_dir() and len(list(parts.glob("part-*.json"))) == 20):
        assert running.poll() is None, running.communicate()
    os.killpg(running.pid, signal.SIGINT)
    out, err = running.communicate()
    assert (running.returncode, out, err) == (130, b"", b"")  # the pipes are closed by all of them
    slow.unlink()
    sweep = achse.sweep(scenario, seeds=22, workers=0, file=parts.with_suffix(""))
    assert sweep.digest == achse.sweep(scenario, seeds=22, workers=0).digest
    assert not parts.exists()
