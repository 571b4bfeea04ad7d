"""The pytest plugin: the fixtures `achse_station`, `achse_nc` and `achse_axis`, without anything to
import or configure, and the unit tests of PLC projects as items.

A project's tests are collected where a test run names it (`pytest plc/Press.plcproj`), or where
`achse_plc_tests` in the configuration of pytest does. The project runs once, while pytest collects.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from achse.client.nc.blocking import RemoteAxis, RemoteNc
    from achse.testing.live import LiveStation

MARKER = "achse_station"

_PROJECTS = "achse_plc_tests"
_LIBRARIES = "achse_plc_libraries"
_ENDINGS = (".plcproj", ".toml", ".st", ".sln", ".tsproj", ".tspproj")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the settings of PLC projects."""
    parser.addini(
        _PROJECTS,
        "Projects with TcUnit tests: station.toml, .sln, .tsproj, .plcproj, .st; from this folder.",
        type="paths",
        default=[],
    )
    parser.addini(
        _LIBRARIES,
        "Sources of libraries that these use, TcUnit's too (or set ACHSE_TCUNIT).",
        type="paths",
        default=[],
    )


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """Take a project that is named for it."""
    if file_path.suffix.lower() not in _ENDINGS:
        return None
    named = file_path in parent.config.getini(_PROJECTS)
    if not named and not parent.session.isinitpath(file_path):
        return None
    from achse.testing.plc_items import PlcProject

    return PlcProject.from_parent(parent, path=file_path)


def pytest_configure(config: pytest.Config) -> None:
    """Make the marker known."""
    config.addinivalue_line(
        "markers",
        f'{MARKER}(config=None, time="real", axis=None): how the station of the fixture is;'
        " see LiveStation; axis: name or id of the axis of `achse_axis`",
    )


_IN_ORDER, _BY_NAME = ("config", "time", "axis"), ("host", "tcp_port")
"""Arguments of the marker: in order or by name, and by name only."""


@pytest.fixture
def achse_config() -> Any:
    """Return the configuration of `achse_station`: None for the demo station.

    Override this in your conftest.py to return a path, a StationConfig, or a function that makes a
    Station.
    """
    return None


@pytest.fixture
def achse_station(request: pytest.FixtureRequest, achse_config: Any) -> "Iterator[LiveStation]":
    """A running station of this test's own: `.host`, `.net_id`, `.fault(…)`, `.restart()`, …

    `@pytest.mark.achse_station(time="virtual", config="station.toml")` says how it is to be. Its
    time is virtual unless said otherwise where the test has `achse_nc` or `achse_axis`.
    """
    from achse.station import ConfigError
    from achse.testing.live import LiveStation

    settings: dict[str, Any] = {"config": achse_config}
    if {"achse_nc", "achse_axis"} & set(request.fixturenames):
        settings["time"] = "virtual"
    settings |= _marked(request)
    settings.pop("axis", None)
    station = LiveStation(settings.pop("config"), **settings)
    refusal = None
    try:
        station.start()
    except ConfigError as failure:
        refusal = str(failure)
    except FileNotFoundError as failure:
        refusal = f"{failure.filename}: expected a station.toml, found no file"
    if refusal is not None:
        pytest.fail(f"{MARKER}: {refusal}", pytrace=False)
    try:
        yield station
    finally:
        station.stop()


@pytest.fixture
def achse_nc(achse_station: "LiveStation") -> "Iterator[RemoteNc]":
    """The NC of `achse_station`, blocking; in virtual time, waiting for an axis lets time pass."""
    with achse_station.connect() as client:
        yield client.nc


@pytest.fixture
def achse_axis(request: pytest.FixtureRequest, achse_nc: "RemoteNc") -> "RemoteAxis":
    """An axis of `achse_station`, in virtual time: the first one unless the marker names another.

    def test_it_gets_there(achse_axis):
        achse_axis.enable()
        achse_axis.move_to(100, velocity=200)
        assert abs(achse_axis.position() - 100) < 0.1
    """
    which = _marked(request).get("axis")
    return achse_nc.axes()[0] if which is None else achse_nc.axis(which)


def _marked(request: pytest.FixtureRequest) -> dict[str, Any]:
    """Return the arguments of a test's markers; pytest.UsageError for unknown ones.

    The marker nearest to the test has precedence.
    """
    said: dict[str, Any] = {}
    for marker in reversed(list(request.node.iter_markers(MARKER))):
        unknown = sorted(marker.kwargs.keys() - {*_IN_ORDER, *_BY_NAME})
        if unknown or len(marker.args) > len(_IN_ORDER):
            arguments = ", ".join([*map(repr, marker.args), *unknown])
            takes = ", ".join((*_IN_ORDER, *_BY_NAME))
            raise pytest.UsageError(f"{MARKER} takes {takes}; got {arguments:.200}")
        said |= dict(zip(_IN_ORDER, marker.args, strict=False)) | marker.kwargs
    return said
