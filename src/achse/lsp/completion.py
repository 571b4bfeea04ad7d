"""Completion and signature help: what can follow at the cursor, and what a call takes."""

from lsprotocol import types

from achse.lsp.editor import Editor
from achse.lsp.hover import declaration_text, documentation, signature_text
from achse.st.lexis.words import KEYWORDS
from achse.st.workspace.cursor import completions, open_call
from achse.st.workspace.symbols import DeclaredSymbol, SymbolKind

_KINDS = {
    SymbolKind.VARIABLE: types.CompletionItemKind.Variable,
    SymbolKind.CONSTANT: types.CompletionItemKind.Constant,
    SymbolKind.MEMBER: types.CompletionItemKind.Field,
    SymbolKind.ENUM_VALUE: types.CompletionItemKind.EnumMember,
    SymbolKind.TYPE: types.CompletionItemKind.TypeParameter,
    SymbolKind.STRUCTURE: types.CompletionItemKind.Struct,
    SymbolKind.ENUMERATION: types.CompletionItemKind.Enum,
    SymbolKind.BLOCK: types.CompletionItemKind.Class,
    SymbolKind.INTERFACE: types.CompletionItemKind.Interface,
    SymbolKind.PROGRAM: types.CompletionItemKind.Module,
    SymbolKind.FUNCTION: types.CompletionItemKind.Function,
    SymbolKind.LIST: types.CompletionItemKind.Module,
    SymbolKind.METHOD: types.CompletionItemKind.Method,
    SymbolKind.ACTION: types.CompletionItemKind.Method,
    SymbolKind.PROPERTY: types.CompletionItemKind.Property,
    SymbolKind.BUILTIN: types.CompletionItemKind.Function,
}
_MOST = 1_000
_MOST_DOCUMENTED = 100
"""Most items that come with their declaration and comment."""


def complete(editor: Editor, params: types.CompletionParams) -> types.CompletionList:
    """Return what can complete the name at a position."""
    place = editor.place_at(params.text_document.uri, params.position)
    if place is None:
        return types.CompletionList(False, [])
    candidates = completions(place.checking, place.source, place.offset)
    symbols = {(one.name.lower(), one.kind): one for one in reversed(candidates)}
    ordered = list(reversed(symbols.values()))
    call = open_call(place.checking, place.source, place.offset)
    inputs = set() if call is None else set(call.signature.by_name)
    documented = len(ordered) <= _MOST_DOCUMENTED
    items = [
        _item(index, one, is_input=one.name.lower() in inputs, documented=documented)
        for index, one in enumerate(ordered[:_MOST])
    ]
    if not _is_behind_dot(place.source.text, place.offset):
        items += [
            types.CompletionItem(word, kind=types.CompletionItemKind.Keyword, sort_text="~")
            for word in sorted(KEYWORDS)
        ]
    return types.CompletionList(len(ordered) > _MOST, items)


def _is_behind_dot(text: str, offset: int) -> bool:
    head = text[max(offset - 300, 0) : offset].rstrip("_0123456789").rstrip()
    while head and (head[-1].isalnum() or head[-1] == "_"):
        head = head[:-1]
    return head.rstrip().endswith(".")


def _item(
    index: int, symbol: DeclaredSymbol, *, is_input: bool, documented: bool
) -> types.CompletionItem:
    item = types.CompletionItem(symbol.name, kind=_KINDS[symbol.kind], sort_text=f"{index:05}")
    item.detail = f"{symbol.kind.value} in {symbol.container}" if symbol.container else None
    if documented:
        text = f"```iecst\n{declaration_text(symbol)}\n```\n{documentation(symbol)}"
        item.documentation = types.MarkupContent(types.MarkupKind.Markdown, text)
    if is_input and symbol.declared is not None:
        sign = "=>" if symbol.declared[0].section == "VAR_OUTPUT" else ":="
        item.insert_text = f"{symbol.name} {sign} "
    return item


def signature_help(editor: Editor, params: types.SignatureHelpParams) -> types.SignatureHelp | None:
    """Return the parameters of the call that a position is in."""
    place = editor.place_at(params.text_document.uri, params.position)
    call = None if place is None else open_call(place.checking, place.source, place.offset)
    if call is None:
        return None
    name, parameters = signature_text(call.signature)
    keys = list(call.signature.by_name)
    active = keys.index(call.parameter) if call.parameter in keys else call.number
    return types.SignatureHelp(
        [
            types.SignatureInformation(
                f"{name}({', '.join(parameters)})",
                parameters=[types.ParameterInformation(one) for one in parameters],
            )
        ],
        active_signature=0,
        active_parameter=min(active, max(len(parameters) - 1, 0)),
    )
