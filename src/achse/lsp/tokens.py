"""Semantic tokens: the kind of each name in a document, as colours need it."""

from lsprotocol import types

from achse.lsp.editor import Editor
from achse.st.workspace.symbols import SymbolKind

_TYPES = {
    SymbolKind.VARIABLE: types.SemanticTokenTypes.Variable,
    SymbolKind.CONSTANT: types.SemanticTokenTypes.Variable,
    SymbolKind.MEMBER: types.SemanticTokenTypes.Property,
    SymbolKind.ENUM_VALUE: types.SemanticTokenTypes.EnumMember,
    SymbolKind.TYPE: types.SemanticTokenTypes.Type,
    SymbolKind.STRUCTURE: types.SemanticTokenTypes.Struct,
    SymbolKind.ENUMERATION: types.SemanticTokenTypes.Enum,
    SymbolKind.BLOCK: types.SemanticTokenTypes.Class,
    SymbolKind.INTERFACE: types.SemanticTokenTypes.Interface,
    SymbolKind.PROGRAM: types.SemanticTokenTypes.Class,
    SymbolKind.FUNCTION: types.SemanticTokenTypes.Function,
    SymbolKind.LIST: types.SemanticTokenTypes.Namespace,
    SymbolKind.METHOD: types.SemanticTokenTypes.Method,
    SymbolKind.ACTION: types.SemanticTokenTypes.Method,
    SymbolKind.PROPERTY: types.SemanticTokenTypes.Property,
    SymbolKind.BUILTIN: types.SemanticTokenTypes.Function,
}
_LISTED = list(dict.fromkeys([*_TYPES.values(), types.SemanticTokenTypes.Parameter]))
_MODIFIERS = [
    types.SemanticTokenModifiers.Declaration,
    types.SemanticTokenModifiers.Readonly,
    types.SemanticTokenModifiers.DefaultLibrary,
]
_PARAMETERS = ("VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT")

LEGEND = types.SemanticTokensLegend(
    [str(one.value) for one in _LISTED], [str(one.value) for one in _MODIFIERS]
)


def semantic_tokens(editor: Editor, params: types.SemanticTokensParams) -> types.SemanticTokens:
    """Return the names of a document with their kinds."""
    document = editor.document_of(editor.file_of(params.text_document.uri))
    rows: list[tuple[int, int, int, int, int]] = []
    for workspace, _, source in editor.sources_of(params.text_document.uri)[:1]:
        for use in workspace.uses_of(source):
            symbol = use.symbol
            place = source.locate(use.at)
            if document is None:
                continue
            start = document.position_of(place.line, place.column)
            kind = _TYPES[symbol.kind]
            if symbol.declared is not None and symbol.declared[0].section in _PARAMETERS:
                kind = types.SemanticTokenTypes.Parameter
            flags = use.is_declaration | (symbol.kind is SymbolKind.CONSTANT) << 1
            flags |= (symbol.source is None or not symbol.source.file) << 2
            length = use.end - use.at  # names have a unit for each character
            rows.append((start.line, start.character, length, _LISTED.index(kind), flags))
    rows.sort()
    data: list[int] = []
    line = column = 0
    for at, character, length, kind_number, flags in rows:
        data += [at - line, character - (column if at == line else 0), length, kind_number, flags]
        line, column = at, character
    return types.SemanticTokens(data)
