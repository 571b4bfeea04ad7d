"""Names in sources with what they mean."""

import re
from pathlib import Path

import pytest
from hypothesis import given, settings

from achse.st.lexis.words import KEYWORDS
from achse.st.workspace import Workspace
from achse.st.workspace.symbols import SymbolKind
from achse.st.workspace.uses import outline_in, use_at, uses_in
from tests.st.workspace.sample import FILES, Edit, edited, edits, write_project

_NOT_DECLARED = {
    "PUBLIC",
    "DINT",
    "REAL",
    "BOOL",
    "INT",
    "TRUE",
    "FALSE",
    "T",
    "S",
    "MB100",
    "CONSTANT",
}
_IDENTIFIER = re.compile(r"[A-Za-z_]\w*")
_NO_CODE = re.compile(r"//[^\n]*|\(\*.*?\*\)")


def test_each_name_of_the_sources_has_a_meaning(workspace: Workspace) -> None:
    assert workspace.checking is not None
    for parsed in workspace.sources:
        text = _NO_CODE.sub(lambda match: " " * len(match[0]), parsed.source.text)
        starts = {use.at for use in uses_in(workspace.checking, parsed.source)}
        names = [
            match[0]
            for match in _IDENTIFIER.finditer(text)
            if match.start() not in starts and match[0].upper() not in KEYWORDS | _NOT_DECLARED
        ]
        assert names == []


def test_uses_lead_to_the_declaration(workspace: Workspace, sample_folder: Path) -> None:
    checking = workspace.checking
    source = workspace.source_of(sample_folder / "POUs" / "MAIN.TcPOU")
    assert checking is not None
    assert source is not None
    targets = {
        (source.text[use.at : use.end], use.symbol.container, use.symbol.kind)
        for use in uses_in(checking, source)
        if not use.is_declaration
    }
    assert {
        ("nCount", "GVL", SymbolKind.VARIABLE),
        ("bEnable", "FB_Drive", SymbolKind.VARIABLE),
        ("Move", "FB_Fast", SymbolKind.METHOD),
        ("Position", "FB_Drive", SymbolKind.PROPERTY),
        ("Idle", "E_State", SymbolKind.ENUM_VALUE),
        ("aValues", "ST_Data", SymbolKind.MEMBER),
        ("cMost", "GVL", SymbolKind.CONSTANT),
        ("PT", "TON", SymbolKind.VARIABLE),
        ("DINT_TO_REAL", "", SymbolKind.BUILTIN),
    } <= targets


def test_a_use_alone_is_that_among_all(workspace: Workspace) -> None:
    checking = workspace.checking
    assert checking is not None
    for parsed in workspace.sources:
        source = parsed.source
        uses = uses_in(checking, source)
        for offset in range(0, len(source.text), 3):
            expected = next((use for use in uses if use.at <= offset <= use.end), None)
            assert use_at(checking, source, offset) == expected


def test_the_outline_has_units_parts_and_variables(
    workspace: Workspace, sample_folder: Path
) -> None:
    checking = workspace.checking
    source = workspace.source_of(sample_folder / "POUs" / "FB_Drive.TcPOU")
    assert checking is not None
    assert source is not None
    (block,) = outline_in(checking, source)
    assert block.symbol.name == "FB_Drive"
    names = [child.symbol.name for child in block.children]
    assert names == [
        *("bEnable", "nLimit", "bDone", "nPosition", "aBuffer", "Move", "Position", "Halt")
    ]
    assert [one.symbol.name for one in block.children[5].children] == ["nSteps"]


@settings(max_examples=10)
@given(edits=edits())
def test_asking_for_meanings_changes_no_findings(
    tmp_path_factory: pytest.TempPathFactory, edits: list[Edit]
) -> None:
    folder = write_project(tmp_path_factory.mktemp("asked"))
    workspace = Workspace(folder)
    texts: dict[str, str] = {}
    for edit in edits:
        name = edit.file
        texts[name] = edited(texts.get(name, FILES[name]), edit)
        workspace.edit(folder / name, texts[name].encode())
        findings = workspace.findings
        if workspace.checking is not None:
            for parsed in workspace.sources:
                uses_in(workspace.checking, parsed.source)
        workspace.judge()
        assert workspace.findings == findings
