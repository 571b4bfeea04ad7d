"""Object files and lists in the user's cache: made once, loaded by later processes.

A file's name ends with a digest of all that its content follows from: what has changed is another
file, and a stale one is never used. ACHSE_CACHE_DIR moves the cache. Files that were not used for
the longest time go when all are more than 256 MiB. Any number of processes may use it at once: a
file is there whole or not at all, and one that goes is made again.

What others than this user may have written is not loaded: it would run with the user's rights.
"""

import hashlib
import logging
import os
import stat
import tempfile
from contextlib import suppress
from pathlib import Path

log = logging.getLogger("achse.native")

_CHECK = hashlib.sha256().digest_size

_OBJECT, _TEMPORARY = ".o", ".part"

_LARGEST = 256 << 20
"""Bytes of all files: some hundred large projects."""

_UNSEEN = 1 / 16
"""Part of `_LARGEST` that a process may save before it looks at the whole folder again."""

_ABANDONED_S = 3600.0
"""A temporary file that old is of a process that was ended while it wrote."""


_looks: dict[Path, tuple[int, int]] = {}
"""By folder: bytes of all files at the last look of this process, and bytes it saved since."""


def cache_directory() -> Path:
    """Return the directory of machine code."""
    named = os.environ.get("ACHSE_CACHE_DIR")
    if named:
        return Path(named)
    home = os.path.join(os.path.expanduser("~"), ".cache")
    return Path(os.environ.get("XDG_CACHE_HOME") or home) / "achse"


class ObjectCache:
    """One object file, by a name that people read and a digest of what it follows from."""

    def __init__(self, name: str, digest: str) -> None:
        self.path = cache_directory() / f"{name}-{digest}{_OBJECT}"
        """File of the machine code, which need not exist."""

    def load(self) -> bytes | None:
        """Return the object file; None if it is not there, or not as it was put there.

        One in a folder that others own or may write to is not loaded, nor one of theirs.
        """
        try:
            with self.path.open("rb") as file:
                opened = os.fstat(file.fileno())
                why = _distrusted(self.path.parent) or _reason(self.path, opened)
                if why:
                    log.warning("a file in the cache is made again, not loaded: %s", why)
                    return None
                content = file.read()
        except (OSError, MemoryError):
            return None
        with suppress(OSError):
            os.utime(self.path)  # it was used now
        check, code = content[:_CHECK], content[_CHECK:]
        return code if check == hashlib.sha256(code).digest() else None

    def save(self, code: bytes) -> None:
        """Keep the object file, after its hash; a cache that cannot be written does not matter."""
        with suppress(OSError):
            folder = self.path.parent
            folder.parent.mkdir(parents=True, exist_ok=True)
            folder.mkdir(mode=0o700, exist_ok=True)
            if _distrusted(folder):
                return
            handle, temporary = tempfile.mkstemp(_TEMPORARY, dir=folder)
            try:
                with os.fdopen(handle, "wb") as file:
                    file.write(hashlib.sha256(code).digest() + code)
                os.replace(temporary, self.path)
            except OSError:
                os.unlink(temporary)
            _keep_small(folder, self.path)


def _keep_small(folder: Path, newest: Path) -> None:
    """Make room if the files may be too large: a look at a full folder takes milliseconds."""
    used, saved = _looks.get(folder, (_LARGEST, 0))
    saved += newest.stat().st_size
    if used + saved > _LARGEST or saved > _LARGEST * _UNSEEN:
        used, saved = _make_room(folder, newest), 0
    _looks[folder] = used, saved


def _make_room(folder: Path, newest: Path) -> int:
    """Remove the files that were not used for the longest time if all are too large, until a
    process can save `_UNSEEN` more; return the bytes of the rest.

    Only our own kinds of files; others may remove some of them meanwhile.
    """
    files: list[tuple[float, int, Path]] = []
    now = newest.stat().st_mtime  # written just now
    for path in folder.iterdir():
        if path.suffix not in (_OBJECT, _TEMPORARY) or path == newest:
            continue
        with suppress(OSError):
            facts = path.lstat()
            if path.suffix == _OBJECT:
                files.append((facts.st_mtime, facts.st_size, path))
            elif now - facts.st_mtime > _ABANDONED_S:
                path.unlink()
    files.sort()
    used = newest.stat().st_size + sum(size for _, size, _ in files)
    wanted = used if used <= _LARGEST else _LARGEST * (1 - _UNSEEN)
    for _, size, path in files:
        if used <= wanted:
            break
        with suppress(OSError):
            path.unlink()
        used -= size
    return used


def _distrusted(path: Path) -> str:
    """Return the reason why others may have written `path`; empty if only this user may.

    On Windows nothing is looked at: the folders of a user are the user's.
    """
    try:
        return _reason(path, path.stat())
    except OSError as failure:
        return f"{path}: {failure.strerror}"


def _reason(path: Path, facts: os.stat_result) -> str:
    """Return the reason why others may have written what has these `facts`; empty if there is
    none.
    """
    if not hasattr(os, "getuid"):
        return ""
    if facts.st_uid != os.getuid():
        return f"{path} belongs to user {facts.st_uid}, this is user {os.getuid()}"
    if facts.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        return f"others may write to {path}, its mode is {stat.S_IMODE(facts.st_mode):o}"
    return ""
