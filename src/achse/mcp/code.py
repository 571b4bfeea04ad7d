"""Code of a project: symbols by name, the text of one unit, and edits of one place."""

import re
from collections.abc import Iterator
from pathlib import Path

from achse.iec.nearest import did_you_mean
from achse.mcp.folder import FolderError, ProjectFolder
from achse.mcp.results import CodeExcerpt, SymbolMatch, SymbolMatches
from achse.st.files.files import content_of
from achse.st.files.forms import Content, has_content
from achse.st.files.sections import replace_source
from achse.st.lexis.source import Source
from achse.st.syntax.units import Action
from achse.st.workspace import Workspace
from achse.st.workspace.cursor import first_offset
from achse.st.workspace.symbols import DeclaredSymbol, Outline, SymbolKind
from achse.st.workspace.uses import outline_in

_PARTS = (SymbolKind.METHOD, SymbolKind.ACTION, SymbolKind.PROPERTY)
_NOT_IN_XML = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Source: XML 1.0, Char."""
_CDATA = re.compile(r"<!\[CDATA\[(.*?)\]\]>", re.DOTALL)


class CodeError(ValueError):
    """No such symbol, or a text that is not there once."""


def _outlines(workspace: Workspace) -> Iterator[tuple[Source, Outline]]:
    if workspace.checking is None:
        return
    for parsed in workspace.sources:
        for outline in outline_in(workspace.checking, parsed.source):
            yield parsed.source, outline


def _named(prefix: str, outline: Outline) -> Iterator[tuple[str, DeclaredSymbol]]:
    symbol = outline.symbol
    name = f"{prefix}.{symbol.name}" if prefix else symbol.name
    yield name, symbol
    for child in outline.children:
        yield from _named(name, child)


def find_symbols(
    workspace: Workspace, folder: ProjectFolder, pattern: str, most: int
) -> SymbolMatches:
    """Return symbols whose whole name has a text in it, without case; units first."""
    wanted = pattern.lower()
    matches: list[tuple[int, SymbolMatch]] = []
    for source, outline in _outlines(workspace):
        for name, symbol in _named("", outline):
            if wanted in name.lower():
                line = source.locate(symbol.place).line
                file = folder.name(Path(source.file))
                entry = SymbolMatch(name=name, kind=symbol.kind.value, file=file, line=line)
                matches.append((name.count("."), entry))
    matches.sort(key=lambda one: one[0])
    symbols = [entry for _, entry in matches[:most]]
    return SymbolMatches(symbols=symbols, left_out=max(0, len(matches) - most))


def read_unit(workspace: Workspace, folder: ProjectFolder, name: str, most: int) -> CodeExcerpt:
    """Return the code of a unit or of a part of it, `FB_Press` or `FB_Press.Close`.

    A unit's code is without that of its parts, which are named. Raises CodeError.
    """
    wanted = name.strip().lower()
    known: list[str] = []
    for source, outline in _outlines(workspace):
        routines = [("", outline), *((outline.symbol.name, part) for part in _parts(outline))]
        for owner, routine in routines:
            symbol = routine.symbol
            full = f"{owner}.{symbol.name}" if owner else symbol.name
            known.append(full)
            if full.lower() == wanted:
                start, end = _extent(workspace, source, symbol)
                text = source.text[start:end].strip("\n")
                names = [part.symbol.name for part in _parts(outline)] if not owner else []
                return CodeExcerpt(
                    name=full,
                    kind=symbol.kind.value,
                    file=folder.name(Path(source.file)),
                    line=source.locate(start).line,
                    text=text[:most],
                    parts=[f"{full}.{each}" for each in names],
                    left_out=max(0, len(text) - most),
                )
    raise CodeError(f"no unit or part {name!r:.80} in the project{did_you_mean(name, known)}")


def _parts(outline: Outline) -> list[Outline]:
    """Return the methods, actions and properties of a unit."""
    return [child for child in outline.children if child.symbol.kind in _PARTS]


def _extent(workspace: Workspace, source: Source, symbol: DeclaredSymbol) -> tuple[int, int]:
    """Return where the code of a unit or part begins, and where that of the next one does."""
    assert workspace.checking is not None
    start, end = _start_of(source, _place(symbol)), len(source.text)
    if isinstance(symbol.node, Action) and not symbol.node.body:
        return start, start
    for outline in outline_in(workspace.checking, source):
        for each in (outline, *_parts(outline)):
            other = _start_of(source, _place(each.symbol))
            if start < other < end:
                end = other
    return start, end


def _place(symbol: DeclaredSymbol) -> int:
    """Return an offset in the code of a symbol; an action in an XML file has its body alone."""
    node = symbol.node
    if isinstance(node, Action) and not node.at and isinstance(node.body, tuple) and node.body:
        return first_offset(node.body[0])
    return symbol.place


def _start_of(source: Source, at: int) -> int:
    """Return where the code begins that an offset is in: a part of a file, or a line of a text."""
    if len(source.pieces) > 1:
        return max((each.start for each in source.pieces if each.start <= at), default=0)
    return source.text.rfind("\n", 0, at) + 1


def edit_file(
    workspace: Workspace, folder: ProjectFolder, file: str, old: str, new: str
) -> tuple[Path, int]:
    """Replace a text that is in the code of one source once; return the file and the line.

    Of an XML file only code is changed. Raises CodeError, FolderError, OSError.
    """
    path = folder.path(file)
    if not workspace.has(path) or not path.is_file():
        raise FolderError(f"{file!r:.120} is not a source of the project")
    try:
        text = content_of(path, path.name).decode("utf-8")
    except UnicodeDecodeError:
        raise CodeError(f"{file}: expected UTF-8") from None
    if "\r\n" in text:
        old, new = (each.replace("\r\n", "\n").replace("\n", "\r\n") for each in (old, new))
    is_xml = not has_content(path, Content.TEXT)
    if is_xml and "]]>" in new:
        raise CodeError("new: expected code, got ']]>', which ends it in an XML file")
    if is_xml and (wrong := _NOT_IN_XML.search(new)):
        raise CodeError(f"new: expected code, got {wrong[0]!r}, which XML cannot have")
    code = [(m.start(1), m.end(1)) for m in _CDATA.finditer(text)] if is_xml else [(0, len(text))]
    places = [at for start, end in code if old for at in _all_places(text, old, start, end)]
    if len(places) != 1:
        count = "nowhere" if not places else f"{len(places)} times"
        raise CodeError(f"old: expected a text that is in the code of {file} once, it is {count}")
    at = places[0]
    edited = text[:at] + new + text[at + len(old) :]
    replace_source(path, edited.encode("utf-8"))
    return path, text.count("\n", 0, at) + 1


def _all_places(text: str, part: str, start: int, end: int) -> Iterator[int]:
    at = text.find(part, start, end)
    while at >= 0:
        yield at
        at = text.find(part, at + 1, end)
