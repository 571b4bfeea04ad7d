"""Paths and configurations that a tool may use."""

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.mcp.folder import FolderError, ProjectFolder
from achse.station.configuration.station_file import parse

PARTS = st.sampled_from(
    ["..", ".", "", "press", "POUs", "~", "link", "/", "\\", "machine.st", "C:", "\0", "…", " "]
)


@given(parts=st.lists(PARTS, max_size=8), sign=st.sampled_from(["/", "\\", "//"]))
def test_any_path_is_inside_or_refused(
    tmp_path_factory: pytest.TempPathFactory, parts: list[str], sign: str
) -> None:
    folder = tmp_path_factory.getbasetemp() / "mcp" / "work"
    (folder / "press" / "POUs").mkdir(parents=True, exist_ok=True)
    (folder / "machine.st").touch()
    if not (folder / "link").is_symlink():
        (folder / "link").symlink_to(folder.parent)
    project = ProjectFolder(folder)
    try:
        path = project.path(sign.join(parts))
    except FolderError:
        return
    assert path.is_relative_to(folder.resolve())
    assert path.exists()


@pytest.mark.parametrize(
    "document",
    [
        {"plc": [{"task": [{"programs": ["code.py:MAIN"]}]}]},
        {"plc": [{"sources": "press", "behaviour": ["module:FB_X"]}]},
        {"plc": [{"sources": "../outside"}]},
        {"plc": [{"sources": "press", "libraries": ["/usr/lib"]}]},
        {"plc": [{"symbols": "../outside/plc.tmc"}]},
        {"system": {"root": ".."}},
        {"scope": {"folder": "../outside"}},
        {"table": [{"id": 1, "file": "link/table.csv"}]},
        {"table": [{"id": 1, "file": "\\\\host\\share\\table.csv"}]},
        {"fmu": [{"name": "plant", "file": "plant.fmu"}]},
        {"bus": [{"interface": "eth0"}]},
        {"modbus": {}},
    ],
)
def test_a_station_that_is_not_simulated_or_reads_elsewhere_is_refused(
    folder: Path, document: dict[str, Any]
) -> None:
    (folder / "link").symlink_to(folder.parent)
    (folder.parent / "outside").mkdir()
    with pytest.raises(FolderError):
        ProjectFolder(folder).confined(parse(document, "station.toml"), folder)


def test_a_confined_station_has_no_network_and_keeps_nothing(folder: Path) -> None:
    document = {
        "router": {"static_routes": "routes.xml", "net_id": "5.1.2.3.1.1"},
        "system": {"programs": ["/bin/*"], "persistent_data": "kept.json"},
        "route": [{"name": "other", "net_id": "5.1.2.4.1.1", "host": "10.0.0.1"}],
        "plc": [{"sources": "press", "budget": 1_000_000_000}],
    }
    config = ProjectFolder(folder).confined(parse(document, "station.toml"), folder)
    assert config.route == ()
    assert config.router.static_routes is None
    assert str(config.router.net_id) == "5.1.2.3.1.1"
    assert (config.system.programs, config.system.persistent_data) == ((), None)
    assert config.plc[0].budget == 5_000_000


def test_a_source_that_is_a_link_to_elsewhere_is_refused(folder: Path) -> None:
    secret = folder.parent / "secret.st"
    secret.write_text("PROGRAM SECRET\nEND_PROGRAM\n")
    loose = folder / "loose"
    loose.mkdir()
    (loose / "a.st").symlink_to(secret)
    with pytest.raises(FolderError):
        ProjectFolder(folder).sources(loose)
    assert ProjectFolder(folder, [folder.parent]).sources(loose)
