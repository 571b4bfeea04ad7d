"""The fixture as its users meet it: a test file of theirs, in a pytest run of its own."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

USERS_FILE = """\
import pyads
import pytest

def test_our_program_survives_what_happens_to_a_plc(achse_station):
    with pyads.Connection(achse_station.net_id, 851, achse_station.host) as plc:
        plc.set_timeout(200)
        handle = plc.get_handle("GVL.nInt")
        achse_station.fault("error", symbol="GVL.nInt", code=0x706, count=1)
        for code, event in (1798, None), (1809, "online_change"):
            event and achse_station.fault(event)
            with pytest.raises(pyads.ADSError, match=str(code)):
                plc.read_by_name("", pyads.PLCTYPE_INT, handle=handle)
        achse_station.restart()
    with plc:
        assert plc.read_by_name("GVL.nInt", pyads.PLCTYPE_INT) == -16
"""
"""Error code, stale handle, restart, reconnect."""

Run = Callable[[str], "subprocess.CompletedProcess[str]"]


@pytest.fixture
def run(tmp_path: Path) -> Run:
    """Run a test file with pytest, warnings as errors, nothing configured."""

    def run_it(text: str, conftest: str = "") -> "subprocess.CompletedProcess[str]":
        (tmp_path / "test_ours.py").write_text(text)
        (tmp_path / "conftest.py").write_text(conftest)
        return subprocess.run(
            [sys.executable, "-m", "pytest", "-q", "-W", "error", "--strict-markers", tmp_path],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=60,
        )

    return run_it


def test_fifteen_lines_with_pyads(run: Run, witness: Callable[[str], None]) -> None:
    witness("pyads")
    assert USERS_FILE.count("\n") <= 15
    for _ in range(5):
        before = os.times()
        result = run(USERS_FILE)
        after = os.times()
        assert "1 passed" in result.stdout, result.stdout
        took = float(result.stdout.split(" in ")[-1].split("s")[0])
        worked = after.children_user + after.children_system
        worked -= before.children_user + before.children_system
        if took < 2.0:
            break
    else:  # a run that hardly got the processor says nothing
        assert worked < 0.8 * (after.elapsed - before.elapsed), took


def test_a_marker_and_a_fixture_say_how_the_station_is(tmp_path: Path) -> None:
    (tmp_path / "station.toml").write_text('name = "mine"\n')
    (tmp_path / "conftest.py").write_text(
        "import pytest\n@pytest.fixture\ndef achse_config():\n    return 'station.toml'\n"
    )
    (tmp_path / "test_ours.py").write_text(
        "import pytest\n"
        "pytestmark = pytest.mark.achse_station(time='virtual')\n"
        "def test_one(achse_station):\n"
        "    assert (achse_station.station.config.name, achse_station.time) == ('mine', 0)\n"
        "@pytest.mark.achse_station(config=None, time=10.0)\n"
        "def test_two(achse_station):\n"
        "    assert (achse_station.station.config.name, achse_station.speed) == ('demo', 10)\n"
    )
    result = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-W", "error", "--strict-markers"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert "2 passed" in result.stdout, result.stdout


def test_the_plugin_costs_nothing_until_it_is_used(run: Run) -> None:
    result = run(
        "import sys\n"
        "def test_light():\n"
        "    heavy = {'achse.station', 'achse.testing.live', 'pydantic', 'numpy'}\n"
        "    assert not heavy & set(sys.modules)\n"
    )
    assert "1 passed" in result.stdout, result.stdout
