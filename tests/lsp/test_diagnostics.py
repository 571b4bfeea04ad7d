"""Findings as diagnostics."""

from pathlib import Path

import pytest
from lsprotocol import types

from achse.codes.links import SITE
from achse.lsp.diagnostics import Published, lsp_diagnostic
from achse.lsp.documents import Document
from achse.lsp.editor import Editor
from achse.st.lexis.codes import Code
from achse.st.lexis.source import Source
from tests.lsp.client import opened


def test_a_finding_has_code_range_and_severity() -> None:
    source = Source("x := '😀' + nothing;")
    finding = source.fault(source.text.index("nothing"), "wrong", Code.UNKNOWN_NAME)
    diagnostic = lsp_diagnostic(finding, "errors", Document(source.text))
    assert diagnostic.range == types.Range(types.Position(0, 12), types.Position(0, 19))
    assert (diagnostic.code, diagnostic.severity) == (Code.UNKNOWN_NAME.value, 1)
    assert lsp_diagnostic(finding, "unreached", Document("")).message == "not reached: wrong"


def test_a_finding_leads_to_the_page_of_its_code(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(SITE, "https://docs.example/achse/")
    finding = Source("x;").fault(0, "wrong", Code.UNKNOWN_NAME)
    diagnostic = lsp_diagnostic(finding, "errors", Document("x;"))
    assert diagnostic.code_description is not None
    assert diagnostic.code_description.href.startswith("https://docs.example/achse/")
    assert Code.UNKNOWN_NAME.value.lower() in diagnostic.code_description.href.lower()


UNUSED = "FUNCTION A : INT\nVAR nUnused : INT; END_VAR\nnOld := 1;\nEND_FUNCTION\n"


def test_rules_of_the_linter_are_shown_after_a_longer_pause(tmp_path: Path) -> None:
    (tmp_path / "achse.toml").write_text('[lint]\nselect = ["LT1"]\nfail = ["LT1003"]\n')
    (tmp_path / "a.st").write_text(UNUSED)
    with opened(tmp_path) as client:
        client.pause(0.1)
        assert [one["code"] for one in client.diagnostics("a.st") or ()] == ["ST3001"]
        client.pause(1.0)
        diagnostics = client.diagnostics("a.st") or []
        assert [(one["code"], one["severity"]) for one in diagnostics] == [
            ("ST3001", 1),
            ("LT1001", 3),
        ]
        assert diagnostics[1]["tags"] == [types.DiagnosticTag.Unnecessary.value]
        client.open("a.st", UNUSED.replace("nOld", "nUnused"))
        client.pause(1.0)
        assert [one["code"] for one in client.diagnostics("a.st") or ()] == ["LT1003"]
        assert (client.diagnostics("a.st") or [])[0]["severity"] == 2


def test_faulty_options_of_the_linter_are_reported_once(tmp_path: Path) -> None:
    (tmp_path / "achse.toml").write_text("[lint]\nselekt = []\n")
    (tmp_path / "a.st").write_text(UNUSED)
    with opened(tmp_path) as client:
        client.pause()
        client.open("a.st", UNUSED)
        client.pause()
        shown = [one for one in client.notes if one["method"] == types.WINDOW_SHOW_MESSAGE]
        assert len(shown) == 1
        assert "expected key of [lint]" in shown[0]["params"]["message"]


def test_nothing_is_sent_twice() -> None:
    assert Published(Editor()).changes() == []
