"""Diagnostics: findings of the projects as a client shows them."""

import os

from lsprotocol import types

from achse.codes.links import SITE, finding_link, on_site
from achse.lsp.documents import Document
from achse.lsp.editor import Editor
from achse.st.lexis.codes import Code
from achse.st.lexis.source import Diagnostic

_SEVERITY = {
    "errors": types.DiagnosticSeverity.Error,
    "warnings": types.DiagnosticSeverity.Warning,
    "unreached": types.DiagnosticSeverity.Information,
    "failing": types.DiagnosticSeverity.Warning,
    "lint": types.DiagnosticSeverity.Information,
}


def lsp_diagnostic(finding: Diagnostic, kind: str, document: Document) -> types.Diagnostic:
    """Return a finding as the protocol has it."""
    place = finding.location
    message = f"not reached: {finding.message}" if kind == "unreached" else finding.message
    page = on_site(finding_link(finding.code), os.environ.get(SITE))
    return types.Diagnostic(
        types.Range(
            document.position_of(place.line, place.column),
            document.position_of(finding.end_line, finding.end_column),
        ),
        message,
        severity=_SEVERITY[kind],
        code=str(finding.code),
        source="achse",
        tags=[types.DiagnosticTag.Unnecessary] if finding.code in _UNNECESSARY else None,
        code_description=types.CodeDescription(page) if page else None,
    )


_UNNECESSARY = (Code.UNUSED_VARIABLE, Code.UNREACHABLE)


class Published:
    """Findings that a client has: a list is sent again only if it changed."""

    def __init__(self, editor: Editor) -> None:
        self._editor = editor
        self._published: dict[str, list[types.Diagnostic]] = {}

    def changes(self) -> list[types.PublishDiagnosticsParams]:
        """Return the lists that are other than those that were sent."""
        by_uri: dict[str, list[types.Diagnostic]] = {}
        versions: dict[str, int | None] = {}
        for file, findings in self._editor.projects.findings().items():
            document = self._editor.document_of(file) or Document("")
            uri = self._editor.uri_of(file)
            versions[uri] = document.version
            by_uri[uri] = [lsp_diagnostic(one, kind, document) for one, kind in findings]
        gone = [uri for uri, sent in self._published.items() if sent and uri not in by_uri]
        by_uri |= {uri: [] for uri in gone}
        for uri in gone:
            known = self._editor.document_of(self._editor.file_of(uri))
            versions[uri] = None if known is None else known.version
        changed = {uri: now for uri, now in by_uri.items() if self._published.get(uri) != now}
        self._published |= changed
        return [
            types.PublishDiagnosticsParams(uri, now, versions.get(uri))
            for uri, now in changed.items()
        ]
