"""Files that go into a unit."""

from pathlib import Path

import pytest

from achse.fmu.errors import ExportError
from achse.fmu.packing import files_read, packed_files, refuse_absolute_paths
from achse.station import Station


def test_files_that_the_station_reads_are_packed(station_file: Path, tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("not read")
    with files_read() as read:
        Station.load(station_file)
    packed = packed_files(station_file, read, [])
    assert set(packed.files) == {"station/station.toml", "station/cell.st"}
    assert packed.station == "station/station.toml"


def test_files_beside_the_station_keep_their_places(station_file: Path, tmp_path: Path) -> None:
    below = tmp_path / "line" / "station.toml"
    below.parent.mkdir()
    below.write_text(station_file.read_text().replace('"cell.st"', '"../cell.st"'))
    programs = tmp_path / "line" / "programs"
    programs.mkdir()
    (programs / "part.nc").write_text("N10 M30")
    with files_read() as read:
        Station.load(below)
    packed = packed_files(below, read, [programs])
    assert set(packed.files) == {
        "station/line/station.toml", "station/cell.st", "station/line/programs/part.nc",
    }  # fmt: skip


def test_python_classes_are_packed_as_sources(tmp_path: Path) -> None:
    (tmp_path / "machine.py").write_text(
        "from achse.iec import UDINT, Program, var\n\n\n"
        "class MAIN(Program):\n    nCycle = var(UDINT)\n\n    def cycle(self) -> None: ...\n"
    )
    file = tmp_path / "station.toml"
    file.write_text('[[plc]]\n[[plc.task]]\nprograms = ["machine.py:MAIN"]\n')
    for _ in range(2):  # the second time it may be compiled already
        with files_read() as read:
            Station.load(file)
        assert "station/machine.py" in packed_files(file, read, []).files


def test_nothing_is_collected_outside(station_file: Path) -> None:
    with files_read() as read:
        pass
    station_file.read_text()
    assert read == set()


def test_written_files_are_not_packed(tmp_path: Path) -> None:
    with files_read() as read:
        (tmp_path / "log.txt").write_text("x")
    assert not [each for each in read if each.name == "log.txt"]


def test_absolute_paths_are_refused(station_file: Path) -> None:
    sources = station_file.parent / "cell.st"
    station_file.write_text(station_file.read_text().replace("cell.st", sources.as_posix()))
    with pytest.raises(ExportError, match=r"plc\[1\]\.sources: expected a path relative"):
        refuse_absolute_paths(station_file)


def test_missing_file_to_include_is_named(station_file: Path, tmp_path: Path) -> None:
    with pytest.raises(ExportError, match="--include: expected a file or folder"):
        packed_files(station_file, set(), [tmp_path / "nothing"])
