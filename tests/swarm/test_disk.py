"""The disk of a world: what it keeps when it is full or the power fails."""

from pathlib import Path

import pytest

from achse.swarm.disk import MemoryDisk, PowerCut

PATH, OTHER = Path("a"), Path("b")


def test_files_are_kept() -> None:
    disk = MemoryDisk()
    assert disk.read(PATH) is None
    disk.create(PATH, b"0123456789")
    disk.overwrite(PATH, 2, b"ab")
    disk.replace(PATH, OTHER)
    assert disk.read(PATH) is None
    assert disk.read(OTHER) == b"01ab456789"
    disk.remove(OTHER)
    disk.remove(OTHER)
    with pytest.raises(FileNotFoundError):
        disk.overwrite(OTHER, 0, b"")
    with pytest.raises(FileNotFoundError):
        disk.replace(PATH, OTHER)


def test_full_disk_takes_a_part() -> None:
    disk = MemoryDisk()
    disk.full = True
    with pytest.raises(OSError, match="no space"):
        disk.create(PATH, b"0123456789")
    assert disk.read(PATH) == b"01234"


@pytest.mark.parametrize("after", range(12))
def test_power_fails_after_so_many_bytes(after: int) -> None:
    disk = MemoryDisk()
    disk.cut_after = after

    def write() -> None:
        disk.create(PATH, b"0123456789")
        disk.replace(PATH, OTHER)

    if after < 11:
        with pytest.raises(PowerCut):
            write()
        assert disk.read(PATH) == b"0123456789"[:after]
        assert disk.read(OTHER) is None
    else:
        write()
        assert disk.read(OTHER) == b"0123456789"
