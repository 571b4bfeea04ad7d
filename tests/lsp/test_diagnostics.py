"""Findings as diagnostics."""

import pytest
from lsprotocol import types

from achse.codes.links import SITE
from achse.lsp.diagnostics import Published, lsp_diagnostic
from achse.lsp.documents import Document
from achse.lsp.editor import Editor
from achse.st.lexis.codes import Code
from achse.st.lexis.source import Source


def test_a_finding_has_code_range_and_severity() -> None:
    source = Source("x := '😀' + nothing;")
    finding = source.fault(source.text.index("nothing"), "wrong", Code.UNKNOWN_NAME)
    found = lsp_diagnostic(finding, "errors", Document(source.text))
    assert found.range == types.Range(types.Position(0, 12), types.Position(0, 19))
    assert (found.code, found.severity) == (Code.UNKNOWN_NAME.value, 1)
    assert lsp_diagnostic(finding, "unreached", Document("")).message == "not reached: wrong"


def test_a_finding_leads_to_the_page_of_its_code(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(SITE, "https://docs.example/achse/")
    finding = Source("x;").fault(0, "wrong", Code.UNKNOWN_NAME)
    found = lsp_diagnostic(finding, "errors", Document("x;"))
    assert found.code_description is not None
    assert found.code_description.href.startswith("https://docs.example/achse/")
    assert Code.UNKNOWN_NAME.value.lower() in found.code_description.href.lower()


def test_nothing_is_sent_twice() -> None:
    assert Published(Editor()).changes() == []
