"""File services as pyads uses them; on Windows targets names are the same in any case."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from achse.station import StationConfig
from achse.testing import LiveStation

pyads = pytest.importorskip("pyads", exc_type=Exception)  # type: ignore[arg-type]

OPEN, CLOSE, READ, FIND, DELETE = 120, 121, 122, 133, 131
FOR_READING, ANYWHERE = 0x1_0001, 0x1_0000
NOT_FOUND = 0x70C


@pytest.fixture
def system(tmp_path: Path) -> Iterator[Any]:
    """pyads on the system service of a station that shows `tmp_path`."""
    config = StationConfig.model_validate({"system": {"root": str(tmp_path)}})
    with LiveStation(config) as station:
        connection = pyads.Connection(station.net_id, 10_000, station.host)
        connection.open()
        yield connection
        connection.close()


def test_a_file_is_opened_found_and_deleted_by_its_name_in_any_case(
    system: Any, tmp_path: Path
) -> None:
    (tmp_path / "Recipes").mkdir()
    file = tmp_path / "Recipes" / "Red.TXT"
    file.write_text("speed=20")
    name = "recipes\\red.txt"
    handle = system.read_write(OPEN, FOR_READING, pyads.PLCTYPE_UDINT, name, pyads.PLCTYPE_STRING)
    content = system.read_write(READ, handle, pyads.PLCTYPE_BYTE * 8, None, None)
    assert bytes(content) == b"speed=20"
    system.read_write(CLOSE, handle, None, None, None)
    entry = system.read_write(FIND, 1, pyads.PLCTYPE_BYTE * 324, name, pyads.PLCTYPE_STRING)
    assert bytes(entry)[48:56] == b"Red.TXT\0"
    system.read_write(DELETE, ANYWHERE, None, name, pyads.PLCTYPE_STRING)
    assert not file.exists()
    with pytest.raises(pyads.ADSError) as refusal:
        system.read_write(OPEN, FOR_READING, pyads.PLCTYPE_UDINT, name, pyads.PLCTYPE_STRING)
    assert refusal.value.err_code == NOT_FOUND
