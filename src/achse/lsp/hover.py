"""Hover: the declaration of a name with its address, initial value, comment and attributes."""

import os

from lsprotocol import types

from achse.codes.links import SITE, library_link, on_site
from achse.lsp.editor import Editor
from achse.st.check.signatures import Signature
from achse.st.lexis.source import Source
from achse.st.syntax.printer import print_expression, print_initial, print_type
from achse.st.syntax.tree import Declaration, EnumValue, Note, VarBlock
from achse.st.syntax.units import (
    Function,
    FunctionBlock,
    Method,
    Property,
    TypeDeclaration,
)
from achse.st.workspace.symbols import DeclaredSymbol, SymbolKind


def hover(editor: Editor, params: types.HoverParams) -> types.Hover | None:
    """Return what is known about the name at a position."""
    place = editor.place_at(params.text_document.uri, params.position, is_drawn=True)
    use = None if place is None else editor.use_at(place)
    if place is None or use is None:
        return None
    text = f"```iecst\n{declaration_text(use.symbol)}\n```"
    more = documentation(use.symbol)
    return types.Hover(
        types.MarkupContent(types.MarkupKind.Markdown, f"{text}\n\n{more}" if more else text),
        editor.range_of(place.source, use.at, use.end),
    )


def declaration_text(symbol: DeclaredSymbol) -> str:
    """Return the declaration of a symbol in Structured Text, without its body."""
    if symbol.declared is not None:
        return _variable(symbol.name, *symbol.declared)
    node, name = symbol.node, symbol.name
    owner = f"{symbol.container}." if symbol.container else ""
    match node:
        case EnumValue(value=value):
            written = "" if value is None else f" := {print_expression(value)}"
            return f"{owner}{name}{written}"
        case Property(type=type):
            access = " ".join(
                word for word, one in (("GET", node.get), ("SET", node.set)) if one is not None
            )
            return f"PROPERTY {owner}{name} : {print_type(type)} ({access})"
        case Method() | Function():
            word = "METHOD" if isinstance(node, Method) else "FUNCTION"
            returns = "" if node.returns is None else f" : {print_type(node.returns)}"
            return "\n".join([f"{word} {owner}{name}{returns}", *_parameters(node.blocks)])
        case FunctionBlock():
            extends = "" if node.extends is None else f" EXTENDS {node.extends.name}"
            return "\n".join([f"FUNCTION_BLOCK {name}{extends}", *_parameters(node.blocks)])
        case TypeDeclaration(type=type):
            return f"TYPE {name} : {print_type(type)}"
    if symbol.kind is SymbolKind.BUILTIN:
        return f"{name} (* function of the language *)"
    return f"{symbol.kind.value.upper()} {owner}{name}"


def _variable(name: str, block: VarBlock, declaration: Declaration) -> str:
    words = " ".join((block.section, *block.qualifiers))
    at = "" if declaration.address is None else f" AT {declaration.address.text}"
    initial = ""
    if declaration.initial is not None:
        initial = f" := {print_initial(declaration.initial)}"
    return f"{name}{at} : {print_type(declaration.type)}{initial}; // {words}"


def _parameters(blocks: tuple[VarBlock, ...]) -> list[str]:
    return [
        f"    {_variable(item.name, block, declaration)}"
        for block in blocks
        if block.section in ("VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT")
        for declaration in block.variables
        for item in declaration.names
    ]


def signature_text(routine: Signature) -> tuple[str, list[str]]:
    """Return the name of a routine, and its parameters as they are declared."""
    parameters = [f"{one.variable.name} : {one.type.name}" for one in routine.by_name.values()]
    return routine.name, parameters


def documentation(symbol: DeclaredSymbol) -> str:
    """Return the comment, the attributes and the library of a symbol, as Markdown."""
    note: Note | None = getattr(symbol.node, "note", None)
    if symbol.declared is not None:
        note = symbol.declared[1].note
    lines = []
    if note is not None:
        lines += [line.strip() for line in note.comment.splitlines() if line.strip()]
        lines += [
            f"`{{attribute '{name}'" + (f" := '{value}'" if value else "") + "}`"
            for name, value in note.attributes
        ]
    if symbol.container:
        lines.append(f"in `{symbol.container}`")
    library = _library_of(symbol.source)
    if library:
        unit = symbol.container.partition(".")[0] or symbol.name
        is_shipped = symbol.source is not None and not symbol.source.file
        link = library_link(library, unit) if is_shipped else None
        page = on_site(link, os.environ.get(SITE))
        lines.append(f"library [{library}]({page})" if page else f"library {library}")
    return "  \n".join(lines)


def _library_of(source: Source | None) -> str:
    """Return the folder of a library that comes with achse."""
    if source is None or source.file:
        return "" if source is None else source.library
    return source.path.partition("/")[0]
