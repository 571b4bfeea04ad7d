"""The state of one client."""

from pathlib import Path

import pytest
from lsprotocol import types
from pygls.exceptions import JsonRpcInvalidParams

from achse.lsp.documents import Document
from achse.lsp.editor import Editor, file_of_source, uri_of
from achse.lsp.projects import Projects
from tests.st.workspace.sample import FILES


@pytest.fixture
def editor(project_folder: Path) -> Editor:
    editor = Editor()
    editor.projects = Projects([project_folder])
    return editor


def test_each_place_in_code_is_found_and_shown(editor: Editor, project_folder: Path) -> None:
    for name, text in FILES.items():
        if name.endswith(".TcTTO"):
            continue
        uri, document = uri_of(project_folder / name), Document(text)
        for offset in range(0, len(text), 7):
            position = document.position_at(offset)
            place = editor.place_at(uri, position)
            if place is None:
                continue
            shown = editor.range_of(place.source, place.offset, place.offset)
            assert shown is not None
            assert shown.start == position


def test_places_in_tags_are_not_code(editor: Editor, project_folder: Path) -> None:
    name = "POUs/MAIN.TcPOU"
    for code in ("<POU", "Implementation>", "]]></ST>", "</TcPlcObject>"):
        position = Document(FILES[name]).position_at(FILES[name].index(code) + 3)
        assert editor.place_at(uri_of(project_folder / name), position) is None


def test_uris_stay_as_the_client_wrote_them(editor: Editor, project_folder: Path) -> None:
    uri = uri_of(project_folder / "Functions.st").replace("Functions", "%46unctions")
    editor.open(uri, FILES["Functions.st"], 1)
    assert editor.uri_of(project_folder / "Functions.st") == uri
    assert editor.change(uri, 2, []) == ""
    assert "expected a version after 2" in editor.change(uri, 2, [])
    editor.close(uri)
    assert "expected an open document" in editor.change(uri, 3, [])


def test_only_files_have_places(editor: Editor) -> None:
    for uri in ("untitled:1", "", "file:", "http://x/y.st"):
        with pytest.raises(JsonRpcInvalidParams, match="expected"):
            editor.place_at(uri, types.Position(0, 0))


def test_sources_of_libraries_have_files(editor: Editor, project_folder: Path) -> None:
    (workspace,) = editor.projects.of(project_folder / "Functions.st")
    assert workspace.checking is not None
    timer = workspace.checking.names.scopes.entries["ton"]
    file = file_of_source(timer.source)
    assert file is not None
    assert file.read_text("utf-8") == timer.source.text
