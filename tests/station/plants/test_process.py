"""Units that work, and units that do harm."""

import gc
import math
import os
import select
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from achse.station.plants.archive import UnitArchive
from achse.station.plants.errors import PlantError
from achse.station.plants.process import UnitProcess

NOTHING, CRASH, HANG, END, FAILS, NOT_A_NUMBER, PRINT, DISCARD = range(8)
INFINITE, HUGE, TINY, WARNS, FATAL, EVENT, TERMINATES, EARLY = range(8, 16)


@pytest.fixture(params=["wild2", "wild"])
def wild(request: pytest.FixtureRequest, plant_units: Path) -> Iterator[UnitProcess]:
    archive = UnitArchive(plant_units / f"{request.param}.fmu")
    process = UnitProcess(archive, "wild", 600.0)
    yield process
    process.close()
    assert process._process.returncode is not None
    assert not archive.folder.exists()


def step(process: UnitProcess, deed: float, at: float = 0.0, count: int = 1) -> list[float]:
    outputs = [process.description.number("value")]
    return process.step(at, 0.01, count, [deed], outputs)


def start(process: UnitProcess, **values: float) -> list[float]:
    about = process.description
    return process.start([about.number("deed")], [about.number("value")], values)


def test_steps_give_outputs(wild: UnitProcess) -> None:
    assert start(wild, added=0.5) == [0.0]
    assert step(wild, NOTHING) == [1.5]
    assert step(wild, NOTHING, 0.01, count=4) == [7.5]


@pytest.mark.parametrize(("deed", "value"), [(HUGE, 1e308), (TINY, 5e-324), (WARNS, 1), (EVENT, 1)])
def test_odd_steps_are_steps(wild: UnitProcess, deed: int, value: float) -> None:
    start(wild)
    assert step(wild, deed) == [value]
    assert step(wild, NOTHING, 0.01) == [value + 1.0]


def test_what_a_unit_prints_harms_no_other(wild: UnitProcess) -> None:
    start(wild)
    assert step(wild, PRINT, count=20) == [20.0]


@pytest.mark.parametrize(
    ("deed", "complaint"),
    [
        (CRASH, "its process ended by signal 11: .*about to crash"),
        (END, "its process ended with exit code 7: the licence has expired"),
        (FAILS, "status 3.*the solver did not converge"),
        (DISCARD, "status 2"),
        (NOT_A_NUMBER, "value: expected a finite number, got nan"),
        (INFINITE, "value: expected a finite number, got -inf"),
        (FATAL, "status 4.*out of memory"),
        (TERMINATES, "the unit ended its simulation at 0.01 s"),
        (EARLY, "the unit ended its simulation at 0.01 s"),
        (2**31, r"deed: expected -2.14748e\+09 to 2.14748e\+09, got 2.14748e\+09"),
        (math.nan, "deed: expected .*, got nan"),
        (math.inf, "deed: expected .*, got inf"),
    ],
)
def test_failures_have_their_reason(wild: UnitProcess, deed: float, complaint: str) -> None:
    if deed in (TERMINATES, EARLY) and wild.description.fmi == 2:
        pytest.skip("FMI 2.0 has statuses alone")
    start(wild)
    step(wild, NOTHING)
    with pytest.raises(PlantError, match=f"(?s){complaint}"):
        step(wild, deed, 0.01)
    assert wild._process.returncode is not None
    with pytest.raises(PlantError):
        step(wild, NOTHING)


def test_unit_that_hangs_is_ended(plant_units: Path) -> None:
    process = UnitProcess(UnitArchive(plant_units / "wild.fmu"), "wild", 600.0)
    start(process)
    process._channel.settimeout(0.05)
    process._timeout_s = 0.05
    with pytest.raises(PlantError, match=r"no answer in 0\.05 s, its process was ended"):
        step(process, HANG)
    assert process._process.returncode == -9


def test_forgotten_process_ends(plant_units: Path) -> None:
    process = UnitProcess(UnitArchive(plant_units / "tank.fmu"), "tank", 600.0)
    child, folder = process._process, process.archive.folder
    del process
    gc.collect()
    assert child.returncode is not None
    assert not folder.exists()


PARENT = """
import sys
from achse.station.plants.archive import UnitArchive
from achse.station.plants.process import UnitProcess

process = UnitProcess(UnitArchive(__import__("pathlib").Path(sys.argv[1])), "wild", 600.0)
about = process.description
if sys.argv[2] != "begin":
    process.start([about.number("deed")], [about.number("value")], {})
print(process._process.pid, process.archive.folder, flush=True)
if sys.argv[2] == "hang":
    process.step(0.0, 0.01, 1, [2.0], [about.number("value")])
sys.stdin.read()
"""


@pytest.mark.parametrize("state", ["begin", "wait", "hang"])
@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGTERM])
def test_unit_ends_with_a_killed_station(
    plant_units: Path, state: str, end: signal.Signals
) -> None:
    """Its process ends, and its folder is removed."""
    parent = subprocess.Popen(
        [sys.executable, "-c", PARENT, str(plant_units / "wild.fmu"), state],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert parent.stdout is not None
    assert parent.stdin is not None
    with parent.stdout, parent.stdin:
        number, folder = parent.stdout.readline().split()
        assert Path(folder).exists()
        parent.send_signal(end)
        parent.wait()
    for _ in range(600):
        status = Path(f"/proc/{number}/stat")
        if not status.exists() or status.read_text().split()[2] == "Z":
            assert not Path(folder).exists()
            return
        select.select([], [], [], 0.1)
    pytest.fail("the process of the unit is still there")


def test_missing_fmpy_is_named(plant_units: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    archive = UnitArchive(plant_units / "tank.fmu")
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(PlantError, match="an FMU needs the extra fmu: pip install"):
        UnitProcess(archive, "tank", 1.0)
    archive.close()


def test_other_systems_are_refused(plant_units: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    archive = UnitArchive(plant_units / "tank.fmu")
    monkeypatch.setattr(os, "name", "nt")
    with pytest.raises(PlantError, match="expected Linux or macOS"):
        UnitProcess(archive, "tank", 1.0)
    monkeypatch.undo()
    archive.close()
