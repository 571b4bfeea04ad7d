"""State files: text that outlives the program, read whole and replaced whole."""

import contextlib
import errno
import json
import os
from pathlib import Path
from typing import Any

from achse.station.configuration.documents import parse_json

__all__ = ["StateFile", "sync_folder"]


class StateFile:
    """The file at `path`, in UTF-8. Readers see the old text or the new one, no part."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def read(self) -> str | None:
        """The text, None if there is no file. Raises OSError, UnicodeDecodeError."""
        if self.path.exists() and not self.path.is_file():  # pipes and devices may never end
            raise OSError(errno.EINVAL, "not a regular file", str(self.path))
        try:
            return self.path.read_text(encoding="utf-8-sig")
        except FileNotFoundError:
            return None

    def write(self, text: str) -> None:
        """Replace the text. Raises OSError; the old one is then whole.

        It is on the disk when this returns: the power may fail at any moment, and what is found
        then is the old text or the new one.
        """
        fresh = self.path.with_name(self.path.name + ".new")
        try:
            with fresh.open("w", encoding="utf-8") as file:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
            os.replace(fresh, self.path)
        except OSError:
            with contextlib.suppress(OSError):
                fresh.unlink()  # its part of the text would keep the last room of a full disk
            raise
        sync_folder(self.path.parent)

    def read_json(self) -> Any:
        """The document, None if there is no file. Raises OSError, ValueError."""
        text = self.read()
        if text is None:
            return None
        document = parse_json(text)
        if document is None:
            raise ValueError("null")
        return document

    def write_json(self, document: object) -> None:
        """Replace the document. Raises OSError; the old one is then whole."""
        self.write(json.dumps(document, indent=1) + "\n")

    def put_aside(self) -> Path:
        """Make place for another file; where this one then is. Raises OSError."""
        aside = self.path.replace(self.path.with_name(self.path.name + ".damaged"))
        sync_folder(aside.parent)
        return aside


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
