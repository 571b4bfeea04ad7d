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


def test_five_lines_move_an_axis_in_virtual_time(run: Run) -> None:
    result = run(
        "def test_it_gets_there(achse_axis):\n"
        "    achse_axis.enable()\n"
        "    achse_axis.move_to(100, velocity=200)\n"
        "    assert abs(achse_axis.position() - 100) < 0.1\n"
        "def test_the_others(achse_station, achse_nc):\n"
        "    assert [str(axis) for axis in achse_nc.axes()] == ['X', 'Y', 'C']\n"
        "    assert achse_station.speed == 0\n"
    )
    assert "2 passed" in result.stdout, result.stdout


def test_a_marker_names_the_axis_and_the_time(run: Run) -> None:
    result = run(
        "import pytest\n"
        "@pytest.mark.achse_station(time='real', axis='Y')\n"
        "def test_it(achse_station, achse_axis):\n"
        "    assert (achse_axis.name(), achse_station.speed) == ('Y', 1.0)\n"
    )
    assert "1 passed" in result.stdout, result.stdout


def test_the_plugin_costs_nothing_until_it_is_used(run: Run) -> None:
    result = run(
        "import sys\n"
        "def test_light():\n"
        "    heavy = {'achse.station', 'achse.testing.live', 'pydantic', 'numpy'}\n"
        "    assert not heavy & set(sys.modules)\n"
    )
    assert "1 passed" in result.stdout, result.stdout


def test_a_marker_takes_its_values_in_order_and_refuses_what_it_does_not_have(run: Run) -> None:
    result = run(
        "import pytest\n"
        "@pytest.mark.achse_station(None, 'virtual', 'Y')\n"
        "def test_in_order(achse_station, achse_axis):\n"
        "    assert (achse_axis.name(), achse_station.speed) == ('Y', 0.0)\n"
        "@pytest.mark.achse_station(tim='virtual')\n"
        "def test_unknown(achse_station): pass\n"
        "@pytest.mark.achse_station(None, 'virtual', 'Y', 4)\n"
        "def test_more(achse_station): pass\n"
    )
    assert "1 passed, 2 errors" in result.stdout, result.stdout
    takes = "achse_station takes config, time, axis, host, tcp_port; got "
    assert f"{takes}tim" in result.stdout
    assert f"{takes}None, 'virtual', 'Y', 4" in result.stdout
