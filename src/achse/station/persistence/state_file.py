"""State files: text that outlives the program, read whole and replaced whole."""

import contextlib
import json
from pathlib import Path
from typing import Any

from achse.station.configuration.documents import parse_json
from achse.station.persistence.file_port import DISK, FilePort


class StateFile:
    """The file at `path`, in UTF-8. Readers see the old text or the new one, no part."""

    def __init__(self, path: Path, port: FilePort = DISK) -> None:
        self.path = path
        self._port = port

    def read(self) -> str | None:
        """Return the text, None if there is no file. Raises OSError, UnicodeDecodeError."""
        content = self._port.read(self.path)
        return None if content is None else content.decode("utf-8-sig")

    def write(self, text: str) -> None:
        """Replace the text. Raises OSError; the old one is then whole.

        It is on the disk when this returns: the power may fail at any moment, and what is found
        then is the old text or the new one.
        """
        fresh = self.path.with_name(self.path.name + ".new")
        try:
            self._port.create(fresh, text.encode())
            self._port.replace(fresh, self.path)
        except OSError:
            with contextlib.suppress(OSError):
                self._port.remove(fresh)  # its part would keep the last room of a full disk
            raise

    def read_json(self) -> Any:
        """Return the document, None if there is no file. Raises OSError, ValueError."""
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
        aside = self.path.with_name(self.path.name + ".damaged")
        self._port.replace(self.path, aside)
        return aside
