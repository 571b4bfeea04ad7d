"""The file system of this computer as files of persistent data use it."""

from pathlib import Path

import pytest

from achse.station.persistence.file_port import DISK


def test_content_is_what_was_created_and_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "a"
    assert DISK.read(path) is None
    DISK.create(path, b"0123456789")
    DISK.overwrite(path, 3, b"abc")
    assert DISK.read(path) == b"012abc6789"


def test_renamed_file_takes_the_place_of_the_other(tmp_path: Path) -> None:
    for name in "ab":
        DISK.create(tmp_path / name, name.encode())
    DISK.replace(tmp_path / "a", tmp_path / "b")
    assert DISK.read(tmp_path / "b") == b"a"
    DISK.remove(tmp_path / "b")
    DISK.remove(tmp_path / "b")
    assert not list(tmp_path.iterdir())


def test_folder_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="not a regular file"):
        DISK.read(tmp_path)
