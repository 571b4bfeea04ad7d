"""A disk in memory whose power fails: what was not yet written comes in any part, or not at all."""

import errno
import os
from collections.abc import Callable
from pathlib import Path

__all__ = ["FailingDisk", "PowerCutError"]


class PowerCutError(BaseException):
    """The power was cut: the process is gone."""


class FailingDisk:
    """Files by path. `left` operations succeed; the next one ends with `cut`.

    `mix(old, new)` returns what is on the disk of an overwritten part when the power is cut,
    `is_kept()` if a name (a rename, a removal) is on the disk then.
    """

    def __init__(self) -> None:
        self.files: dict[Path, bytes] = {}
        self.left: int | None = None
        self.error: int | None = None
        self.mix: Callable[[bytes, bytes], bytes] = lambda old, new: old
        self.is_kept: Callable[[], bool] = lambda: False
        self.done: list[str] = []

    def _begin(self, what: str) -> bool:
        """Count an operation; True if it is the one that the power cut meets."""
        if self.error is not None:
            raise OSError(self.error, os.strerror(self.error))
        self.done.append(what)
        if self.left is None:
            return False
        self.left -= 1
        return self.left < 0

    def read(self, path: Path) -> bytes | None:
        return self.files.get(path)

    def create(self, path: Path, content: bytes) -> None:
        if self._begin("create"):
            self.files[path] = self.mix(bytes(len(content)), content)
            raise PowerCutError
        self.files[path] = content

    def overwrite(self, path: Path, offset: int, content: bytes) -> None:
        if path not in self.files:
            raise FileNotFoundError(errno.ENOENT, "no such file", str(path))
        old, end = self.files[path], offset + len(content)
        assert end <= len(old), "a file that grows needs place on the disk"
        is_cut = self._begin("overwrite")
        new = self.mix(old[offset:end], content) if is_cut else content
        self.files[path] = old[:offset] + new + old[end:]
        if is_cut:
            raise PowerCutError

    def replace(self, old: Path, new: Path) -> None:
        is_cut = self._begin("replace")
        if not is_cut or self.is_kept():
            self.files[new] = self.files.pop(old)
        if is_cut:
            raise PowerCutError

    def remove(self, path: Path) -> None:
        is_cut = self._begin("remove")
        if not is_cut or self.is_kept():
            self.files.pop(path, None)
        if is_cut:
            raise PowerCutError
