"""The state behind one client: its documents, its projects, and what is at a position."""

from importlib.resources import files
from pathlib import Path
from typing import NamedTuple

from lsprotocol import types
from pygls.exceptions import JsonRpcInvalidParams
from pygls.uris import from_fs_path, to_fs_path

from achse.lsp.documents import LARGEST, Document, Encoding, read_document
from achse.lsp.projects import Projects
from achse.st.check.warm import WarmChecking
from achse.st.files.reading import file_key
from achse.st.lexis.source import Source
from achse.st.workspace import Workspace
from achse.st.workspace.symbols import DeclaredSymbol
from achse.st.workspace.uses import SymbolUse

_MOST_READ = 256
"""Documents on disk that are kept, as long as their files do not change."""


class CursorPlace(NamedTuple):
    """A position inside of code."""

    workspace: Workspace
    checking: WarmChecking
    source: Source
    offset: int


def uri_of(file: Path) -> str:
    return from_fs_path(str(file)) or ""


class Editor:
    """Documents and projects of one client."""

    def __init__(self) -> None:
        self.encoding = Encoding()
        self.projects = Projects()
        self.documents: dict[str, Document] = {}
        """Open documents by `file_key`."""
        self._on_disk: dict[str, tuple[tuple[int, int, int], Document | None]] = {}
        """Documents of files that are not open by `file_key`, with the state of each file."""
        self._uris: dict[str, str] = {}
        self._changed: dict[str, Path] = {}

    # documents -------------------------------------------------------------------------------

    def file_of(self, uri: str) -> Path:
        """Return the file of a URI. Raises `JsonRpcInvalidParams` for another scheme."""
        path = to_fs_path(uri) if uri.startswith("file:") else None
        if not path or "\0" in path:
            raise JsonRpcInvalidParams(f"expected the URI of a file, got {uri[:200]!r}")
        return Path(path)

    def uri_of(self, file: Path) -> str:
        """Return the URI of a file, as the client wrote it if the file is open."""
        return self._uris.get(file_key(file)) or uri_of(file)

    def open(self, uri: str, text: str, version: int) -> None:
        """Take a document that the client opened."""
        file = self.file_of(uri)
        key = file_key(file)
        self._uris[key] = uri
        self.documents[key] = Document(text, self.encoding, version)
        self._changed[key] = file

    def change(
        self, uri: str, version: int, changes: list[types.TextDocumentContentChangeEvent]
    ) -> str:
        """Take changes of a document; return what is wrong with them, or nothing."""
        file = self.file_of(uri)
        key = file_key(file)
        document = self.documents.get(key)
        if document is None:
            return f"expected an open document, got a change of {uri[:200]!r}"
        wrong = ""
        if document.version is not None and version <= document.version:
            wrong = f"expected a version after {document.version}, got {version} of {uri[:200]!r}"
        document.edit(
            (change.range if isinstance(change, _PARTIAL) else None, change.text)
            for change in changes
        )
        document.version = version
        self._changed[key] = file
        return wrong

    def close(self, uri: str) -> None:
        """Forget a document: the file on disk counts again."""
        file = self.file_of(uri)
        key = file_key(file)
        if self.documents.pop(key, None) is not None:
            self._changed.pop(key, None)
            self.projects.close(file)

    def update(self) -> None:
        """Let the projects check what changed since."""
        if not self._changed:
            return
        changed, self._changed = self._changed, {}
        contents = {}
        for key, file in changed.items():
            document = self.documents.get(key)
            if document is not None and len(document.text) <= LARGEST:
                contents[file] = document.text.encode("utf-8", "replace")
        self.projects.edit(contents)

    def document_of(self, file: Path) -> Document | None:
        """Return the document of a file, open or on disk."""
        key = file_key(file)
        return self.documents.get(key) or self._read(key, file)

    def _read(self, key: str, file: Path) -> Document | None:
        try:
            status = file.stat()
        except (OSError, ValueError):
            self._on_disk.pop(key, None)
            return None
        stamp = status.st_mtime_ns, status.st_ctime_ns, status.st_size
        known = self._on_disk.pop(key, None)
        if known is None or known[0] != stamp:
            known = stamp, read_document(file, self.encoding)
        self._on_disk[key] = known
        while len(self._on_disk) > _MOST_READ:
            del self._on_disk[next(iter(self._on_disk))]
        return known[1]

    # places ----------------------------------------------------------------------------------

    def sources_of(self, uri: str) -> list[tuple[Workspace, WarmChecking, Source]]:
        """Return the sources that a document is in the projects. Raises `JsonRpcInvalidParams`
        if it is not a file."""
        self.update()
        file = self.file_of(uri)
        sources = []
        for workspace in self.projects.of(file):
            source = workspace.source_of(file)
            if source is not None and workspace.checking is not None:
                sources.append((workspace, workspace.checking, source))
        return sources

    def place_at(
        self, uri: str, position: types.Position, *, is_drawn: bool = False
    ) -> CursorPlace | None:
        """Return the code at a position, that of a drawing too with `is_drawn`; None outside of
        code."""
        document = self.document_of(self.file_of(uri))
        if document is None:
            raise JsonRpcInvalidParams(f"expected a file that can be read, got {uri[:200]!r}")
        if not 0 <= position.line < document.line_count or position.character < 0:
            got = f"{position.line}:{position.character}"
            raise JsonRpcInvalidParams(
                f"expected a position in lines 0 to {document.line_count - 1}, got {got}"
            )
        for workspace, checking, source in self.sources_of(uri):
            place = document.place_of(position)
            offset = source.offset_at(*place)
            if offset is None and is_drawn:
                offset = source.drawn_offset_at(*place)
            if offset is not None:
                return CursorPlace(workspace, checking, source, offset)
        return None

    def use_at(self, place: CursorPlace) -> SymbolUse | None:
        """Return the name at a place, also that which ends there."""
        return place.workspace.use_at(place.source, place.offset)

    def range_of(self, source: Source, at: int, end: int) -> types.Range | None:
        """Return the range of some code in its document; None if there is no such file."""
        file = file_of_source(source)
        document = None if file is None else self.document_of(file)
        if document is None:
            return None
        first = source.locate(at)
        last = source.locate(max(end - 1, at))
        return types.Range(
            document.position_of(first.line, first.column),
            document.position_of(last.line, last.column + (end > at)),
        )

    def location_of(self, source: Source, at: int, end: int) -> types.Location | None:
        """Return the location of some code; None if there is no such file."""
        file, place = file_of_source(source), self.range_of(source, at, end)
        if file is None or place is None:
            return None
        return types.Location(self.uri_of(file), place)

    def declaration_of(self, symbol: DeclaredSymbol) -> types.Location | None:
        """Return the location of the name of a symbol, or of its code."""
        if symbol.source is None:
            return None
        at = symbol.at
        if at is None:
            return self.location_of(symbol.source, symbol.place, symbol.place)
        return self.location_of(symbol.source, at, at + len(symbol.name))


_PARTIAL = types.TextDocumentContentChangePartial


def file_of_source(source: Source) -> Path | None:
    """Return the file of a source, also of a library that comes with achse; None without one."""
    if source.file:
        return Path(source.file)
    folder, slash, _ = source.path.partition("/")
    if slash and folder:
        shipped = Path(str(files("achse.libraries"))) / source.path
        return shipped if shipped.is_file() else None
    return None
