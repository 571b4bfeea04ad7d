"""The files of the pages: kept in memory, named by what is there, so that no path leads out."""

import gzip
import hashlib
from importlib.resources import as_file, files
from pathlib import Path
from typing import NamedTuple

_TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".mjs": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".json": "application/json",
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".txt": "text/plain; charset=utf-8",
    ".md": "text/plain; charset=utf-8",
}
"""Content types of the files that are served, by the ending of the name."""


class Page(NamedTuple):
    """A file as it is sent."""

    type: str
    tag: str
    """Changes with the contents."""
    data: bytes
    packed: bytes
    """The same by gzip."""
    written: int
    """Modification time of the file, ns; the file is read again when it changes."""


class Pages:
    """The files below a folder, by their paths; `folder` None: those of the package."""

    def __init__(self, folder: Path | None = None) -> None:
        if folder is None:
            with as_file(files("achse.web") / "pages") as resources:
                folder = Path(resources)
        self._folder = folder
        self._pages: dict[str, Page] = {}
        self.names = self._listed()

    def _listed(self) -> dict[str, Path]:
        return {
            file.relative_to(self._folder).as_posix(): file
            for file in sorted(self._folder.rglob("*"))
            if file.suffix in _TYPES and file.is_file() and not file.is_symlink()
        }

    def find(self, path: str) -> Page | None:
        """Return the file of that path, as `scope/charts.js`; None without one."""
        name = path.strip("/") or "index.html"
        if name not in self.names:
            return None
        file = self.names[name]
        try:
            written = file.stat().st_mtime_ns
            page = self._pages.get(name)
            if page is None or page.written != written:
                page = self._pages[name] = _read(file, written)
        except OSError:
            return None
        return page


def _read(file: Path, written: int) -> Page:
    data = file.read_bytes()
    tag = hashlib.blake2b(data, digest_size=12).hexdigest()
    return Page(_TYPES[file.suffix], f'"{tag}"', data, gzip.compress(data, 9, mtime=0), written)
