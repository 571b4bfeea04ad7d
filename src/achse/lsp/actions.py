"""Code actions: the near miss that a finding names, put in place of the name."""

import re

from lsprotocol import types

from achse.lsp.editor import Editor

_NEAR = re.compile(r"; near: ([A-Za-z_][\w.]*)$")
_QUOTED = re.compile(r"'([^']+)'")


def code_actions(editor: Editor, params: types.CodeActionParams) -> list[types.CodeAction]:
    """Return an action for each finding in a range that names something near."""
    uri = params.text_document.uri
    document = editor.document_of(editor.file_of(uri))
    if document is None:
        return []
    actions = []
    for one in params.context.diagnostics:
        near = _NEAR.search(one.message)
        named = _QUOTED.search(one.message)
        if one.source != "achse" or near is None or named is None:
            continue
        written = document.text_of(one.range)
        if written.lower() != named[1].rpartition(".")[2].lower():
            continue
        name = _declared_name(editor, uri, near[1])
        edit = types.WorkspaceEdit(changes={uri: [types.TextEdit(one.range, name)]})
        actions.append(
            types.CodeAction(
                f"Write {name}",
                types.CodeActionKind.QuickFix,
                [one],
                is_preferred=True,
                edit=edit,
            )
        )
    return actions


def _declared_name(editor: Editor, uri: str, key: str) -> str:
    """Return a name as it is declared: findings of bodies name it in lower case."""
    for workspace, checking, source in editor.sources_of(uri):
        entry = checking.names.scopes.find(key)
        if entry is not None:
            return entry.name
        for parsed in (source, *(one.source for one in workspace.all_sources)):
            spelled = re.search(rf"\b{re.escape(key)}\b", parsed.text, re.IGNORECASE)
            if spelled is not None:
                return spelled[0]
    return key
