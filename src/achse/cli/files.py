"""Files that commands write: whole or not at all, and never over a file that they did not write."""

import contextlib
import errno
import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from achse.cli.failure import fail


def write_file(
    file: Path, data: bytes, replaces: Callable[[bytes], bool] | None = None, kind: str = ""
) -> None:
    """Write a file; one that is there is replaced at once, or stays as it was.

    With `replaces` a file that is there is replaced only if it says so of its content: `kind` is
    what it then is. An empty one may always be. Other failures end the command, too.
    """
    try:
        if replaces is not None and file.is_file():
            there = file.read_bytes()
            if there.strip() and not replaces(there):
                fail(
                    f"{file} exists and is not {kind}: it is left as it is; say another name",
                    name="FILE_EXISTS",
                )
        if file.exists() and not file.is_file():
            file.write_bytes(data)  # a device or a pipe; a folder is refused by the system
            return
        target = file.resolve()  # a link stays one
        if target.exists() and not os.access(target, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
        try:
            with os.fdopen(handle, "wb") as output:
                output.write(data)
                output.flush()
                os.fsync(output.fileno())  # before the new name, so that no power loss empties it
            os.chmod(name, _mode_of(target))
            os.replace(name, target)
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(name)
            raise
    except OSError as failure:
        fail(f"{file}: {failure.strerror}", name="CANNOT_WRITE")


def _mode_of(file: Path) -> int:
    """Return the rights of a file, or those that a new one gets."""
    with contextlib.suppress(OSError):
        return file.stat().st_mode & 0o7777
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask
