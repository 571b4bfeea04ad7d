"""Rename: edits of a name in all files of a project; nothing else in a file changes.

A rename is refused if a name could mean something else afterwards: the new name must be unused
wherever the old one is known.
"""

import re
from collections.abc import Iterator
from pathlib import Path

from lsprotocol import types
from pygls.exceptions import JsonRpcException

from achse.lsp.editor import CursorPlace, Editor
from achse.lsp.navigation import uses_of
from achse.st.check.builtins import is_builtin
from achse.st.check.warm import WarmChecking
from achse.st.files.forms import Content, suffixes_of
from achse.st.graphical.body import GraphicalBody
from achse.st.lexis.words import KEYWORDS
from achse.st.syntax.units import Action, FunctionBlock, GlobalList, Interface, Method, Property
from achse.st.workspace.drawn_uses import ambiguous_names
from achse.st.workspace.symbols import DeclaredSymbol, SymbolKind

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_REQUEST_FAILED = -32803
_MOST_NAME = 255
_IN_XML = suffixes_of(Content.ENVELOPE)


class RenameRefused(JsonRpcException):
    """A name cannot be renamed, or not to that."""

    CODE = _REQUEST_FAILED
    MESSAGE = "rename refused"


def prepare_rename(
    editor: Editor, params: types.PrepareRenameParams
) -> types.PrepareRenamePlaceholder | None:
    """Return the name at a position. Raises `RenameRefused` if it cannot be renamed."""
    place = editor.place_at(params.text_document.uri, params.position, is_drawn=True)
    use = None if place is None else editor.use_at(place)
    if place is None or use is None:
        return None
    _check_symbol(use.symbol)
    where = editor.range_of(place.source, use.at, use.end)
    if where is None:
        return None
    return types.PrepareRenamePlaceholder(where, use.symbol.name)


def _check_symbol(symbol: DeclaredSymbol) -> None:
    source = symbol.source
    if source is None:
        raise RenameRefused(f"'{symbol.name}' is part of the language")
    if not source.file or source.library:
        raise RenameRefused(f"'{symbol.name}' is declared in a library")
    if symbol.at is None:
        raise RenameRefused(
            f"the name of {symbol.kind.value} '{symbol.name}' is in the file, not in the code:"
            " rename it in the project's tool"
        )


def rename(editor: Editor, params: types.RenameParams) -> types.WorkspaceEdit | None:
    """Return the edits that give a name another one. Raises `RenameRefused`."""
    place = editor.place_at(params.text_document.uri, params.position, is_drawn=True)
    use = None if place is None else editor.use_at(place)
    if place is None or use is None:
        return None
    _check_symbol(use.symbol)
    new = params.new_name
    _check_name(new)
    group = _same_contract(place, use.symbol)
    uses = {
        (source.file, occurrence.at): (source, occurrence)
        for symbol in group
        for source, occurrence in uses_of(place.workspace, symbol)
    }
    if new.lower() != use.symbol.name.lower():
        _check_unused(place, group, new)
    _check_drawings(place, group)
    edits: dict[str, list[types.TextEdit]] = {}
    for source, occurrence in uses.values():
        location = editor.location_of(source, occurrence.at, occurrence.end)
        file = None if location is None else editor.file_of(location.uri)
        document = None if file is None else editor.document_of(file)
        if location is None or document is None:
            raise RenameRefused(f"expected {source.path} to be readable")
        if document.text_of(location.range).lower() != use.symbol.name.lower():
            line = location.range.start.line + 1
            raise RenameRefused(
                f"{source.path}:{line}: expected '{use.symbol.name}' in the file,"
                f" got {document.text_of(location.range)[:40]!r}: the line has XML entities"
            )
        edits.setdefault(location.uri, []).append(types.TextEdit(location.range, new))
    for uri, more in _names_in_xml(editor, group, new):
        edits.setdefault(uri, []).append(more)
    return types.WorkspaceEdit(changes=edits)


def _check_name(name: str) -> None:
    if not _NAME.fullmatch(name) or len(name) > _MOST_NAME or "__" in name:
        raise RenameRefused(f"expected a name of letters, digits and single _, got {name[:80]!r}")
    if name.upper() in KEYWORDS or is_builtin(name):
        raise RenameRefused(f"'{name}' is a word of the language")


def _same_contract(place: CursorPlace, symbol: DeclaredSymbol) -> list[DeclaredSymbol]:
    """Return a symbol with those that must have the same name: the methods and properties of
    bases, interfaces and derived blocks."""
    if symbol.kind not in (SymbolKind.METHOD, SymbolKind.PROPERTY) or symbol.entry is None:
        return [symbol]
    checking = place.checking
    key = symbol.name.lower()
    related = {symbol.entry}
    units = [
        one
        for one in checking.names.scopes.entries.values()
        if isinstance(one.tree, FunctionBlock | Interface)
    ]
    grows = True
    while grows:
        grows = False
        for unit in units:
            above = [*checking.blocks.chain(unit), *checking.blocks.bases_of_interface(unit)]
            interfaces = checking.blocks.interfaces(unit)
            above += [one for one in units if one.name.lower() in interfaces]
            line = {one for one in above if key in checking.blocks.own_parts(one)}
            if line & related and not line <= related:
                related |= line
                grows = True
    overrides = []
    for unit in related:
        part = checking.blocks.own_parts(unit)[key]
        override = DeclaredSymbol(
            part.name, symbol.kind, unit.source, part, unit.name, None, unit, identity=id(part)
        )
        _check_symbol(override)
        overrides.append(override)
    return overrides


def _check_unused(place: CursorPlace, group: list[DeclaredSymbol], new: str) -> None:
    """Raise `RenameRefused` if the new name is taken where the old one is declared or used."""
    checking, key = place.checking, new.lower()
    scopes = checking.names.scopes
    for symbol in group:
        owner = symbol.container.rpartition(".")[2]
        if _is_taken(checking, symbol, key):
            where = symbol.container or "the project"
            raise RenameRefused(f"'{new}' is declared in {where} already ({owner or 'a unit'})")
    globally = scopes.find(new) is not None or key in scopes.globals or key in scopes.loose_values
    if globally and any(symbol.kind is not SymbolKind.MEMBER for symbol in group):
        raise RenameRefused(f"'{new}' is the name of something global")
    sources = {id(symbol.source) for symbol in group}
    for parsed in place.workspace.all_sources:
        if key not in parsed.source.text.lower():
            continue
        known = place.workspace.uses_of(parsed.source)
        is_near = id(parsed.source) in sources or any(
            one.symbol == symbol for one in known for symbol in group
        )
        for other in known:
            if other.symbol.name.lower() == key and is_near and _may_meet(other.symbol, group):
                raise RenameRefused(f"'{new}' means something in {parsed.source.path} already")


def _check_drawings(place: CursorPlace, group: list[DeclaredSymbol]) -> None:
    """Raise `RenameRefused` if a drawn body may use the name where its place is not known."""
    checking, key = place.checking, group[0].name.lower()
    for routine in checking.routines.created:
        body = routine.body
        if not isinstance(body, GraphicalBody) or checking.checked(routine.key) is None:
            continue
        if key in body.text.lower() and key in ambiguous_names(body, checking.uses_of(routine)):
            raise RenameRefused(
                f"'{group[0].name}' means several things in a drawn body of {routine.name}"
            )


def _may_meet(other: DeclaredSymbol, group: list[DeclaredSymbol]) -> bool:
    """Return True unless both names are only used behind a dot, of different owners."""
    apart = (SymbolKind.MEMBER, SymbolKind.ENUM_VALUE)
    return not all(
        symbol.kind in apart and other.kind in apart and symbol.container != other.container
        for symbol in group
    )


def _is_taken(checking: WarmChecking, symbol: DeclaredSymbol, key: str) -> bool:
    if symbol.entry is None:
        return False
    scopes = checking.names.scopes
    tree = symbol.entry.tree
    if scopes.own(key, scopes.scope(symbol.entry)) is not None:
        return True
    if isinstance(tree, FunctionBlock | Interface) and checking.blocks.part(symbol.entry, key):
        return True
    values = getattr(getattr(tree, "type", None), "values", ())
    return any(value.name.lower() == key for value in values)


# names outside of the code ------------------------------------------------------------------------


def _names_in_xml(
    editor: Editor, group: list[DeclaredSymbol], new: str
) -> Iterator[tuple[str, types.TextEdit]]:
    """Edits of the attributes `Name` of units and parts in their XML files."""
    for symbol in group:
        source = symbol.source
        if source is None or not source.file.lower().endswith(_IN_XML):
            continue
        is_part = isinstance(symbol.node, Method | Property | Action)
        is_unit = symbol.entry is not None and symbol.node is symbol.entry.tree
        if not (is_part or is_unit) or isinstance(symbol.node, GlobalList):
            continue
        file = editor.file_of(editor.uri_of(Path(source.file)))
        document = editor.document_of(file)
        if document is None:
            continue
        tags = "Method|Property|Action" if is_part else "POU|DUT|Itf"
        old = re.escape(symbol.name)
        patterns = [rf'<(?:{tags})\b[^>]*?\bName="({old})"']
        if is_part:
            patterns.append(rf'<LineIds\b[^>]*?\bName="[^".]*\.({old})[".]')
        else:
            patterns.append(rf'<LineIds\b[^>]*?\bName="({old})[".]')
        for pattern in patterns:
            for match in re.finditer(pattern, document.text, re.IGNORECASE):
                where = types.Range(
                    document.position_at(match.start(1)), document.position_at(match.end(1))
                )
                yield editor.uri_of(file), types.TextEdit(where, new)
