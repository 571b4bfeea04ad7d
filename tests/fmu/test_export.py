"""The archive of a unit."""

import io
import json
import zipfile
from pathlib import Path

import pytest

from achse.fmu import Export, ExportError, export
from achse.fmu.compiler import binary_name, platform_folder
from tests.fmu.shims import kept_shims


def test_archive_has_description_binary_sources_and_station(unit: Export) -> None:
    with zipfile.ZipFile(io.BytesIO(unit.archive)) as archive:
        names = archive.namelist()
        assert names[0] == "modelDescription.xml"
        assert f"binaries/{platform_folder(3)}/{binary_name('cell')}" in names
        assert {"sources/unit.c", "sources/buildDescription.xml"} <= set(names)
        assert "resources/station/cell.st" in names
        document = json.loads(archive.read("resources/unit.json"))
        assert document["station"] == "station/station.toml"
        assert len(document["variables"]) == len(unit.variables)
    assert unit.has_states


def test_equal_stations_give_equal_archives(station_file: Path, compiler: str) -> None:
    first, second = export(station_file), export(station_file)
    assert first.archive == second.archive


def test_numbers_of_64_bits_are_left_out_of_fmi_2(station_file: Path, compiler: str) -> None:
    from achse.fmu.variables import VariableChoice

    with kept_shims():
        result = export(station_file, fmi=2, choice=VariableChoice(locals=["MAIN.n*"]))
    assert [each.name for each in result.left_out] == ["MAIN.nSum"]


@pytest.mark.parametrize("fmi", [1, 4])
def test_other_versions_are_refused(station_file: Path, fmi: int) -> None:
    with pytest.raises(ExportError, match=f"expected version 2 or 3, got {fmi}"):
        export(station_file, fmi=fmi)


def test_bus_on_an_interface_is_refused(station_file: Path) -> None:
    with station_file.open("a") as file:
        file.write('[[bus]]\ninterface = "eth1"\n')
    with pytest.raises(ExportError, match=r"bus\[1\].interface: expected virtual slaves"):
        export(station_file)
