"""The fixture as its users meet it: test files of theirs, in one pytest run of its own."""

import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

USERS_FILE = (Path(__file__).parents[1] / "data" / "fifteen_lines.txt").read_text()
"""Error code, stale handle, restart, reconnect."""

FILES = {
    "light.py": """
import sys
def test_light():
    heavy = {'achse.station', 'achse.testing.live', 'pydantic', 'numpy'}
    assert not heavy & set(sys.modules)
""",
    "axis.py": """
def test_it_gets_there(achse_axis):
    achse_axis.enable()
    achse_axis.move_to(100, velocity=200)
    assert abs(achse_axis.position() - 100) < 0.1
def test_the_others(achse_station, achse_nc):
    assert [str(axis) for axis in achse_nc.axes()] == ['X', 'Y', 'C']
    assert achse_station.speed == 0
""",
    "marker.py": """
import pytest
@pytest.mark.achse_station(time='real', axis='Y')
def test_real(achse_station, achse_axis):
    assert (achse_axis.name(), achse_station.speed) == ('Y', 1.0)
@pytest.mark.achse_station(None, 'virtual', 'Y')
def test_in_order(achse_station, achse_axis):
    assert (achse_axis.name(), achse_station.speed) == ('Y', 0.0)
@pytest.mark.achse_station(tim='virtual')
def test_unknown(achse_station): pass
@pytest.mark.achse_station(None, 'virtual', 'Y', 4)
def test_more(achse_station): pass
""",
    "broken.py": """
import pytest
@pytest.mark.achse_station(config='nowhere/station.toml')
def test_missing(achse_station): pass
@pytest.mark.achse_station(config={'name': 3})
def test_wrong(achse_station): pass
""",
    "config/conftest.py": """
import pytest
@pytest.fixture
def achse_config():
    return 'station.toml'
""",
    "config/ours.py": """
import pytest
pytestmark = pytest.mark.achse_station(time='virtual')
def test_one(achse_station):
    assert (achse_station.station.config.name, achse_station.time) == ('mine', 0)
@pytest.mark.achse_station(config=None, time=10.0)
def test_two(achse_station):
    assert (achse_station.station.config.name, achse_station.speed) == ('demo', 10)
""",
    "fifteen.py": USERS_FILE,
}
ORDER = ("light.py", "axis.py", "marker.py", "broken.py", "config/ours.py", "fifteen.py")
"""The first one runs before anything of achse is imported."""


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> str:
    """What pytest prints for these files; warnings are errors, nothing is configured."""
    folder = tmp_path_factory.mktemp("users")
    (folder / "config").mkdir()
    (folder / "station.toml").write_text('name = "mine"\n')
    for name, text in FILES.items():
        (folder / name).write_text(text)
    command = [sys.executable, "-m", "pytest", "-v", "-W", "error", "--strict-markers", *ORDER]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True).stdout


@pytest.fixture
def outcomes(report: str) -> Callable[[str], dict[str, str]]:
    """`outcomes("axis.py")`: the outcome of each test of a file by its name."""

    def of_file(name: str) -> dict[str, str]:
        return dict(re.findall(rf"^{re.escape(name)}::(\w+) ([A-Z]+)", report, re.MULTILINE))

    return of_file


Outcomes = Callable[[str], dict[str, str]]


def test_fifteen_lines_with_pyads(
    outcomes: Outcomes, report: str, witness: Callable[[str], None]
) -> None:
    witness("pyads")
    assert USERS_FILE.count("\n") <= 15
    assert list(outcomes("fifteen.py").values()) == ["PASSED"], report


def test_a_marker_and_a_fixture_say_how_the_station_is(outcomes: Outcomes, report: str) -> None:
    assert outcomes("config/ours.py") == {"test_one": "PASSED", "test_two": "PASSED"}, report


def test_five_lines_move_an_axis_in_virtual_time(outcomes: Outcomes, report: str) -> None:
    passed = {"test_it_gets_there": "PASSED", "test_the_others": "PASSED"}
    assert outcomes("axis.py") == passed, report


def test_a_marker_names_the_axis_and_the_time(outcomes: Outcomes, report: str) -> None:
    assert outcomes("marker.py")["test_real"] == "PASSED", report


def test_the_plugin_costs_nothing_until_it_is_used(outcomes: Outcomes, report: str) -> None:
    assert outcomes("light.py") == {"test_light": "PASSED"}, report


def test_a_marker_takes_its_values_in_order_and_refuses_what_it_does_not_have(
    outcomes: Outcomes, report: str
) -> None:
    of_marker = outcomes("marker.py")
    assert of_marker["test_in_order"] == "PASSED", report
    assert (of_marker["test_unknown"], of_marker["test_more"]) == ("ERROR", "ERROR")
    takes = "achse_station takes config, time, axis, host, tcp_port; got "
    assert f"{takes}tim" in report
    assert f"{takes}None, 'virtual', 'Y', 4" in report


def test_a_configuration_that_cannot_be_read_is_one_sentence(
    outcomes: Outcomes, report: str
) -> None:
    assert outcomes("broken.py") == {"test_missing": "ERROR", "test_wrong": "ERROR"}, report
    messages = re.findall(r"^achse_station: (.+)$", report, re.MULTILINE)
    assert [line.partition(": ")[0] for line in messages] == ["nowhere/station.toml", "config"], (
        report
    )
    assert "live.py" not in report
