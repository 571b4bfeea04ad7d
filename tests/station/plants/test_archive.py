"""Archives of strangers."""

import io
import stat
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from achse.station.plants import archive as module
from achse.station.plants.archive import UnitArchive
from achse.station.plants.errors import PlantError
from tests.station.plant_units import description


def packed(tmp_path: Path, entries: dict[str, bytes], mode: int = 0) -> Path:
    file = tmp_path / "unit.fmu"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("modelDescription.xml", description("tank", 3))
        for name, data in entries.items():
            entry = zipfile.ZipInfo(name)
            entry.filename = name  # as it is, with backslashes
            entry.external_attr = mode << 16
            archive.writestr(entry, data)
    return file


def test_unit_is_unpacked_and_removed(plant_units: Path) -> None:
    unit = UnitArchive(plant_units / "tank.fmu")
    assert (unit.folder / "modelDescription.xml").is_file()
    assert unit.description.identifier == "tank"
    unit.close()
    assert not unit.folder.exists()


@pytest.mark.parametrize(
    "name", ["../evil", "a/../../evil", "/tmp/evil", "a\\..\\..\\evil", "C:evil", "a/b:c"]
)
def test_names_that_lead_out_are_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(PlantError, match="expected files below the folder of the unit"):
        UnitArchive(packed(tmp_path, {name: b"x"}))
    assert not (tmp_path.parent / "evil").exists()


@pytest.mark.parametrize("kind", [stat.S_IFLNK, stat.S_IFCHR, stat.S_IFIFO])
def test_links_and_devices_are_refused(tmp_path: Path, kind: int) -> None:
    with pytest.raises(PlantError, match="expected files below the folder"):
        UnitArchive(packed(tmp_path, {"resources/x": b"/etc/passwd"}, kind | 0o777))


def test_size_is_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_MOST_BYTES", 1000)
    with pytest.raises(PlantError, match=r"expected at most .* with 1000 bytes in a unit"):
        UnitArchive(packed(tmp_path, {"resources/x": bytes(100_000)}))


def test_description_is_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_LONGEST_DESCRIPTION", 100)
    with pytest.raises(PlantError, match=r"modelDescription\.xml: expected at most 100 bytes"):
        UnitArchive(packed(tmp_path, {}))


def test_missing_binary_is_named_with_those_there(tmp_path: Path) -> None:
    with pytest.raises(PlantError, match=r"expected binaries/.*tank.* for: moon-riscv"):
        UnitArchive(packed(tmp_path, {"binaries/moon-riscv/tank.so": b""}))


def _without_description() -> bytes:
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as archive:
        archive.writestr("x", "y")
    return data.getvalue()


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (lambda: b"", "expected a unit"),
        (lambda: b"PK\3\4rubbish", "expected a unit"),
        (_without_description, "expected modelDescription.xml in the unit"),
    ],
)
def test_other_files_are_refused(
    tmp_path: Path, content: Callable[[], bytes], complaint: str
) -> None:
    file = tmp_path / "unit.fmu"
    file.write_bytes(content())
    with pytest.raises(PlantError, match=complaint):
        UnitArchive(file)


def test_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(PlantError, match=r"none\.fmu: No such file"):
        UnitArchive(tmp_path / "none.fmu")


def test_damaged_content_is_refused_and_removed(tmp_path: Path, plant_units: Path) -> None:
    data = bytearray((plant_units / "tank.fmu").read_bytes())
    at = data.index(b"\x7fELF") if b"\x7fELF" in data else len(data) // 2
    data[at] ^= 0xFF
    file = tmp_path / "unit.fmu"
    file.write_bytes(data)
    with pytest.raises(PlantError, match="CRC"):
        UnitArchive(file)
