"""Object files in the user's cache: made once, loaded by later processes.

A file's name ends with a digest of all that its content follows from: what has changed is another
file, and a stale one is never used. ACHSE_CACHE_DIR moves the cache.
"""

import hashlib
import os
import tempfile
from contextlib import suppress
from pathlib import Path

__all__ = ["ObjectCache", "cache_directory"]

_CHECK = hashlib.sha256().digest_size


def cache_directory() -> Path:
    """Where machine code is kept."""
    named = os.environ.get("ACHSE_CACHE_DIR")
    if named:
        return Path(named)
    home = os.path.join(os.path.expanduser("~"), ".cache")
    return Path(os.environ.get("XDG_CACHE_HOME") or home) / "achse"


class ObjectCache:
    """One object file, by a name that people read and a digest of what it follows from."""

    def __init__(self, name: str, digest: str) -> None:
        self.path = cache_directory() / f"{name}-{digest}.o"
        """Where it is, or would be."""

    def load(self) -> bytes | None:
        """The object file; None if it is not there, or not as it was put there."""
        try:
            content = self.path.read_bytes()
        except OSError:
            return None
        check, code = content[:_CHECK], content[_CHECK:]
        return code if check == hashlib.sha256(code).digest() else None

    def save(self, code: bytes) -> None:
        """Keep the object file, after its hash; a cache that cannot be written does not matter."""
        with suppress(OSError):
            self.path.parent.mkdir(parents=True, exist_ok=True)
            handle, temporary = tempfile.mkstemp(dir=self.path.parent)
            try:
                with os.fdopen(handle, "wb") as file:
                    file.write(hashlib.sha256(code).digest() + code)
                os.replace(temporary, self.path)
            except OSError:
                os.unlink(temporary)
