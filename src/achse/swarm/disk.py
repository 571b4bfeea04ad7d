"""The disk of a world: files in memory, which may be full, or cut off by a power failure."""

import errno
from pathlib import Path


class PowerCut(BaseException):
    """The power failed within a write: nothing of the program goes on."""


class MemoryDisk:
    """Files by path, as `achse.station.persistence.file_port.FilePort` demands them.

    - `full`: writes fail with ENOSPC, after a part of them.
    - `cut_after`: that many bytes later the power fails.
    """

    def __init__(self) -> None:
        self.files: dict[Path, bytes] = {}
        self.full = False
        self.cut_after: int | None = None

    def read(self, path: Path) -> bytes | None:
        """Return the content, None if there is no file."""
        return self.files.get(path)

    def create(self, path: Path, content: bytes) -> None:
        """Write a file."""
        self.files[path] = b""
        self._write(path, 0, content)

    def overwrite(self, path: Path, offset: int, content: bytes) -> None:
        """Write in the middle of a file that exists."""
        if path not in self.files:
            raise FileNotFoundError(errno.ENOENT, "no such file", str(path))
        self._write(path, offset, content)

    def replace(self, old: Path, new: Path) -> None:
        """Rename a file over another one."""
        self._spend(1)
        if old not in self.files:
            raise FileNotFoundError(errno.ENOENT, "no such file", str(old))
        self.files[new] = self.files.pop(old)

    def remove(self, path: Path) -> None:
        """Remove a file if there is one."""
        self._spend(1)
        self.files.pop(path, None)

    def _write(self, path: Path, offset: int, content: bytes) -> None:
        room = self._room(len(content))
        before = self.files[path]
        self.files[path] = before[:offset] + content[:room] + before[offset + room :]
        if room < len(content):
            if self.full:
                raise OSError(errno.ENOSPC, "no space left", str(path))
            raise PowerCut

    def _room(self, size: int) -> int:
        if self.full:
            return size // 2
        if self.cut_after is not None:
            room = min(size, self.cut_after)
            self.cut_after -= room
            return room
        return size

    def _spend(self, size: int) -> None:
        if self.cut_after is not None and self._room(size) < size:
            raise PowerCut
