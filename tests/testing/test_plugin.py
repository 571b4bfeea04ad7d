"""The fixture as its users meet it: a test file of theirs, in a pytest run of its own."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

USERS_FILE = (Path(__file__).parents[1] / "data" / "fifteen_lines.txt").read_text()
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
    result = run(USERS_FILE)
    assert "1 passed" in result.stdout, result.stdout


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
