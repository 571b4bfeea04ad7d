"""A demo station whose scope server has a folder."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.station import Station
from achse.station.configuration.documents import parse_toml
from achse.station.configuration.station_file import parse
from achse.station.station import DEMO


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Where the scope server's files are."""
    recordings = tmp_path / "recordings"
    recordings.mkdir()
    return recordings


MakeStation = Callable[..., Station]


@pytest.fixture
def make_station(tmp_path: Path, folder: Path) -> MakeStation:
    """The demo with keys of [scope] of one's own."""

    def make(**scope: Any) -> Station:
        document = parse_toml(DEMO.read_text(encoding="utf-8"))
        document["scope"] = {"folder": folder.name} | scope
        return Station(parse(document, "demo"), base=tmp_path)

    return make


@pytest.fixture
def station(make_station: MakeStation) -> Station:
    """Its one view records two values of the demo."""
    view = {
        "name": "press",
        "record_length": "500ms",
        "channels": ["500:Axes.X.ActPos", "MAIN.nCounter"],
    }
    return make_station(view=[view])


@pytest.fixture
def scope(station: Station, client_of: Any) -> Any:
    """A client of port 14000."""
    return client_of(station.router, 14000)
