"""Files of persistent data: the part of a file system that they use, and that of this computer."""

import contextlib
import errno
import os
from pathlib import Path
from typing import Protocol


class FilePort(Protocol):
    """The part of a file system that a snapshot file uses. Each method raises OSError."""

    def read(self, path: Path) -> bytes | None:
        """Return the content, None if there is no file."""

    def create(self, path: Path, content: bytes) -> None:
        """Write a file and wait until it is on the disk."""

    def overwrite(self, path: Path, offset: int, content: bytes) -> None:
        """Write in the middle of a file that exists and wait until it is on the disk."""

    def replace(self, old: Path, new: Path) -> None:
        """Rename a file over another one and wait until the name is on the disk."""

    def remove(self, path: Path) -> None:
        """Remove a file if there is one and wait until the name is gone from the disk."""


class _Disk:
    """The file system of this computer."""

    def read(self, path: Path) -> bytes | None:
        if path.exists() and not path.is_file():  # pipes and devices may never end
            raise OSError(errno.EINVAL, "not a regular file", str(path))
        try:
            return path.read_bytes()
        except FileNotFoundError:
            return None

    def create(self, path: Path, content: bytes) -> None:
        with path.open("wb", buffering=0) as file:
            _write_all(file.fileno(), content)
            os.fsync(file.fileno())

    def overwrite(self, path: Path, offset: int, content: bytes) -> None:
        with path.open("r+b", buffering=0) as file:
            file.seek(offset)
            _write_all(file.fileno(), content)
            _sync_data(file.fileno())

    def replace(self, old: Path, new: Path) -> None:
        os.replace(old, new)
        sync_folder(new.parent)

    def remove(self, path: Path) -> None:
        with contextlib.suppress(FileNotFoundError):
            path.unlink()
            sync_folder(path.parent)


_sync_data = getattr(os, "fdatasync", os.fsync)

DISK: FilePort = _Disk()
"""The file system of this computer."""


def _write_all(number: int, content: bytes) -> None:
    rest = memoryview(content)
    while rest:
        rest = rest[os.write(number, rest) :]


def sync_folder(folder: Path) -> None:
    """Wait until the names in a folder are on the disk, where the system can. Raises OSError."""
    try:
        opened = os.open(folder, os.O_RDONLY)
    except OSError:  # Windows opens no folders, and writes names by itself
        return
    try:
        os.fsync(opened)
    except OSError as failure:  # some network file systems have no such thing
        if failure.errno not in (errno.EINVAL, errno.ENOTSUP):
            raise
    finally:
        os.close(opened)
