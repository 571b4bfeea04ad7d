"""Navigation: declarations, references, outlines, and who calls whom."""

from collections.abc import Iterable, Iterator
from typing import Any

from lsprotocol import types

from achse.lsp.editor import CursorPlace, Editor
from achse.st.check.warm import WarmChecking
from achse.st.lexis.source import Source
from achse.st.workspace import Workspace
from achse.st.workspace.cursor import routine_at
from achse.st.workspace.symbols import DeclaredSymbol, Outline, SymbolKind
from achse.st.workspace.uses import SymbolUse, outline_in

KINDS = {
    SymbolKind.VARIABLE: types.SymbolKind.Variable,
    SymbolKind.CONSTANT: types.SymbolKind.Constant,
    SymbolKind.MEMBER: types.SymbolKind.Field,
    SymbolKind.ENUM_VALUE: types.SymbolKind.EnumMember,
    SymbolKind.TYPE: types.SymbolKind.TypeParameter,
    SymbolKind.STRUCTURE: types.SymbolKind.Struct,
    SymbolKind.ENUMERATION: types.SymbolKind.Enum,
    SymbolKind.BLOCK: types.SymbolKind.Class,
    SymbolKind.INTERFACE: types.SymbolKind.Interface,
    SymbolKind.PROGRAM: types.SymbolKind.Module,
    SymbolKind.FUNCTION: types.SymbolKind.Function,
    SymbolKind.LIST: types.SymbolKind.Namespace,
    SymbolKind.METHOD: types.SymbolKind.Method,
    SymbolKind.ACTION: types.SymbolKind.Method,
    SymbolKind.PROPERTY: types.SymbolKind.Property,
    SymbolKind.BUILTIN: types.SymbolKind.Function,
}
_CALLED = (
    SymbolKind.FUNCTION,
    SymbolKind.METHOD,
    SymbolKind.ACTION,
    SymbolKind.PROGRAM,
    SymbolKind.PROPERTY,
)
_MOST_SYMBOLS = 500


def _use_at(editor: Editor, params: Any) -> tuple[CursorPlace, SymbolUse] | None:
    place = editor.place_at(params.text_document.uri, params.position, is_drawn=True)
    use = None if place is None else editor.use_at(place)
    return None if place is None or use is None else (place, use)


def definition(editor: Editor, params: types.DefinitionParams) -> types.Location | None:
    """Return where the name at a position is declared."""
    hit = _use_at(editor, params)
    return None if hit is None else editor.declaration_of(hit[1].symbol)


def type_definition(editor: Editor, params: types.TypeDefinitionParams) -> types.Location | None:
    """Return where the type of the variable at a position is declared."""
    hit = _use_at(editor, params)
    if hit is None or hit[1].symbol.declared is None or hit[1].symbol.source is None:
        return None
    symbol, spec = hit[1].symbol, hit[1].symbol.declared[1].type
    while (inner := getattr(spec, "element", getattr(spec, "target", None))) is not None:
        spec = inner
    name = getattr(spec, "name", None)
    if name is None or symbol.entry is None:
        return None
    entry = hit[0].checking.names.scopes.find(name, symbol.entry.space)
    if entry is None:
        return None
    return editor.location_of(entry.source, entry.at, entry.at + len(entry.name))


def uses_of(workspace: Workspace, symbol: DeclaredSymbol) -> Iterator[tuple[Source, SymbolUse]]:
    """Return all uses of a symbol in a project and in the user's libraries."""
    name = symbol.name.lower()
    for parsed in workspace.all_sources:
        if parsed.source.drawings or name in parsed.source.text.lower():
            for use in workspace.uses_of(parsed.source):
                if use.symbol == symbol:
                    yield parsed.source, use


def references(editor: Editor, params: types.ReferenceParams) -> list[types.Location] | None:
    """Return where the name at a position is used."""
    hit = _use_at(editor, params)
    if hit is None:
        return None
    with_declaration = params.context.include_declaration
    places = (
        editor.location_of(source, use.at, use.end)
        for source, use in uses_of(hit[0].workspace, hit[1].symbol)
        if with_declaration or not use.is_declaration
    )
    return [place for place in places if place is not None]


def highlights(
    editor: Editor, params: types.DocumentHighlightParams
) -> list[types.DocumentHighlight] | None:
    """Return the uses in the document of the name at a position: read, or written to."""
    hit = _use_at(editor, params)
    if hit is None:
        return None
    place, at = hit
    result = []
    for use in place.workspace.uses_of(place.source):
        where = editor.range_of(place.source, use.at, use.end)
        if use.symbol == at.symbol and where is not None:
            behind = place.source.text[use.end : use.end + 80].lstrip()
            kind = types.DocumentHighlightKind.Read
            if behind.startswith(":=") or use.is_declaration:
                kind = types.DocumentHighlightKind.Write
            result.append(types.DocumentHighlight(where, kind))
    return result


# outlines -----------------------------------------------------------------------------------------


def document_symbols(
    editor: Editor, params: types.DocumentSymbolParams
) -> list[types.DocumentSymbol]:
    """Return what a document declares, as a tree."""
    for _, checking, source in editor.sources_of(params.text_document.uri):
        return [
            symbol
            for outline in outline_in(checking, source)
            if (symbol := _document_symbol(editor, source, outline)) is not None
        ]
    return []


def _document_symbol(
    editor: Editor, source: Source, outline: Outline
) -> types.DocumentSymbol | None:
    symbol = outline.symbol
    at = symbol.place
    end = at + len(symbol.name) if symbol.at is not None else at
    name = editor.range_of(source, at, end)
    if name is None:
        return None
    children = [
        child_symbol
        for child in outline.children
        if (child_symbol := _document_symbol(editor, source, child)) is not None
    ]
    everything = [name, *(child.range for child in children)]
    whole = types.Range(
        min((one.start for one in everything), key=_place),
        max((one.end for one in everything), key=_place),
    )
    detail = symbol.kind.value
    return types.DocumentSymbol(
        symbol.name, KINDS[symbol.kind], whole, name, detail, None, None, children
    )


def _place(position: types.Position) -> tuple[int, int]:
    return position.line, position.character


def workspace_symbols(
    editor: Editor, params: types.WorkspaceSymbolParams
) -> list[types.WorkspaceSymbol]:
    """Return the symbols of all projects with these letters in their name, in this order."""
    editor.update()
    wanted = params.query.lower()
    symbols: dict[tuple[str, str, int], types.WorkspaceSymbol] = {}
    for workspace in editor.projects:
        if workspace.checking is None:
            continue
        for symbol in _all_symbols(workspace, workspace.checking):
            if not _has_letters(symbol.name.lower(), wanted):
                continue
            location = editor.declaration_of(symbol)
            if location is not None:
                key = (location.uri, symbol.name, location.range.start.line)
                symbols.setdefault(
                    key,
                    types.WorkspaceSymbol(
                        location,
                        symbol.name,
                        KINDS[symbol.kind],
                        container_name=symbol.container or None,
                    ),
                )
            if len(symbols) >= _MOST_SYMBOLS:
                return list(symbols.values())
    return list(symbols.values())


def _all_symbols(workspace: Workspace, checking: WarmChecking) -> Iterator[DeclaredSymbol]:
    for parsed in workspace.all_sources:
        yield from _flat(outline_in(checking, parsed.source), 2)


def _flat(outlines: Iterable[Outline], depth: int) -> Iterator[DeclaredSymbol]:
    for outline in outlines:
        yield outline.symbol
        if depth > 1:
            yield from _flat(outline.children, depth - 1)


def _has_letters(name: str, wanted: str) -> bool:
    rest = iter(name)
    return all(letter in rest for letter in wanted)


# calls --------------------------------------------------------------------------------------------


def call_items(
    editor: Editor, params: types.CallHierarchyPrepareParams
) -> list[types.CallHierarchyItem] | None:
    """Return the routine that is named at a position."""
    hit = _use_at(editor, params)
    if hit is None or hit[1].symbol.kind not in (*_CALLED, SymbolKind.BLOCK):
        return None
    item = _item(editor, hit[1].symbol)
    return None if item is None else [item]


def _item(editor: Editor, symbol: DeclaredSymbol) -> types.CallHierarchyItem | None:
    location = editor.declaration_of(symbol)
    if location is None:
        return None
    return types.CallHierarchyItem(
        symbol.name,
        KINDS[symbol.kind],
        location.uri,
        location.range,
        location.range,
        None,
        symbol.container or symbol.kind.value,
        data=[symbol.container, symbol.name],
    )


def _symbol_of_item(
    editor: Editor, item: types.CallHierarchyItem
) -> tuple[Workspace, WarmChecking, DeclaredSymbol] | None:
    for workspace, checking, source in editor.sources_of(item.uri):
        for symbol in _flat(outline_in(checking, source), 2):
            if [symbol.container, symbol.name] == item.data:
                return workspace, checking, symbol
    return None


def incoming_calls(
    editor: Editor, params: types.CallHierarchyIncomingCallsParams
) -> list[types.CallHierarchyIncomingCall] | None:
    """Return the routines that name a routine."""
    callee = _symbol_of_item(editor, params.item)
    if callee is None:
        return None
    workspace, checking, symbol = callee
    callers: dict[str, tuple[DeclaredSymbol, list[types.Range]]] = {}
    for source, use in uses_of(workspace, symbol):
        routine = None if use.is_declaration else routine_at(checking, source, use.at)
        place = editor.range_of(source, use.at, use.end)
        if routine is None or place is None:
            continue
        caller = _symbol_of_routine(checking, source, routine.entry.name, routine.tree)
        if caller is not None and caller != symbol:
            callers.setdefault(routine.key, (caller, []))[1].append(place)
    items = ((_item(editor, caller), places) for caller, places in callers.values())
    return [
        types.CallHierarchyIncomingCall(item, places) for item, places in items if item is not None
    ]


def _symbol_of_routine(
    checking: WarmChecking, source: Source, unit: str, tree: Any
) -> DeclaredSymbol | None:
    for symbol in _flat(outline_in(checking, source), 2):
        inner = (symbol.node, getattr(symbol.node, "get", None), getattr(symbol.node, "set", None))
        if any(one is tree for one in inner if one is not None):
            return symbol
    return None


def outgoing_calls(
    editor: Editor, params: types.CallHierarchyOutgoingCallsParams
) -> list[types.CallHierarchyOutgoingCall] | None:
    """Return the routines that a routine names."""
    caller = _symbol_of_item(editor, params.item)
    if caller is None or caller[2].source is None:
        return None
    workspace, checking, symbol = caller
    source = symbol.source
    assert source is not None
    called: dict[DeclaredSymbol, list[types.Range]] = {}
    for use in workspace.uses_of(source):
        if use.symbol.kind not in _CALLED or use.is_declaration or use.symbol == symbol:
            continue
        routine = routine_at(checking, source, use.at)
        if routine is None:
            continue
        owner = _symbol_of_routine(checking, source, routine.entry.name, routine.tree)
        place = editor.range_of(source, use.at, use.end)
        if owner == symbol and place is not None:
            called.setdefault(use.symbol, []).append(place)
    items = ((_item(editor, one), places) for one, places in called.items())
    return [
        types.CallHierarchyOutgoingCall(item, places) for item, places in items if item is not None
    ]
