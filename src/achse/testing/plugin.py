"""The pytest plugin: the fixture `achse_station`, without anything to import or configure."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from achse.testing.live import LiveStation

__all__ = ["achse_config", "achse_station", "pytest_configure"]

MARKER = "achse_station"


def pytest_configure(config: pytest.Config) -> None:
    """Make the marker known."""
    config.addinivalue_line(
        "markers",
        f'{MARKER}(config=None, time="real"): how the station of the fixture is; see LiveStation',
    )


@pytest.fixture
def achse_config() -> Any:
    """What `achse_station` runs: a path, a StationConfig, or a function that makes a Station.

    None is the demo station. Override this in your conftest.py.
    """
    return None


@pytest.fixture
def achse_station(request: pytest.FixtureRequest, achse_config: Any) -> "Iterator[LiveStation]":
    """A running station of this test's own: `.host`, `.net_id`, `.fault(…)`, `.restart()`, …

    `@pytest.mark.achse_station(time="virtual", config="station.toml")` says how it is to be.
    """
    from achse.testing.live import LiveStation

    settings: dict[str, Any] = {"config": achse_config}
    for marker in reversed(list(request.node.iter_markers(MARKER))):
        settings |= marker.kwargs
    with LiveStation(settings.pop("config"), **settings) as station:
        yield station
