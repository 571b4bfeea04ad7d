"""Formatting by a client."""

from typing import Any

from lsprotocol import types

from achse.lsp.documents import Document
from tests.lsp.client import InProcessClient
from tests.st.workspace.sample import FILES

MAIN = "POUs/MAIN.TcPOU"
OPTIONS = {"tabSize": 4, "insertSpaces": True}


def _applied(text: str, edits: list[dict[str, Any]]) -> str:
    document = Document(text)
    for edit in reversed(edits):
        place = edit["range"]
        start, end = (types.Position(**place[key]) for key in ("start", "end"))
        document.edit([(types.Range(start, end), edit["newText"])])
    return document.text


def test_a_document_is_formatted_by_small_edits(client: InProcessClient) -> None:
    messy = (
        FILES[MAIN]
        .replace("    E_State.Idle", "  E_State.Idle")
        .replace("nSum := 0;", "nSum := 0; ")
    )
    client.open(MAIN, messy)
    params = {"textDocument": {"uri": client.uri(MAIN)}, "options": OPTIONS}
    edits = client.request(types.TEXT_DOCUMENT_FORMATTING, params)
    assert [edit["newText"] for edit in edits] == ["    ", ""]
    assert _applied(messy, edits) == FILES[MAIN]


def test_a_range_is_formatted_alone(client: InProcessClient) -> None:
    messy = FILES[MAIN].replace("    E_State.", "  E_State.")
    client.open(MAIN, messy)
    line = messy[: messy.index("E_State.Idle: ")].count("\n")
    place = {"start": {"line": line, "character": 0}, "end": {"line": line + 1, "character": 0}}
    params = {"textDocument": {"uri": client.uri(MAIN)}, "range": place, "options": OPTIONS}
    (edit,) = client.request(types.TEXT_DOCUMENT_RANGE_FORMATTING, params)
    assert edit["range"]["start"]["line"] == line


def test_a_document_in_order_has_no_edits(reader: InProcessClient) -> None:
    params = {"textDocument": {"uri": reader.uri(MAIN)}, "options": OPTIONS}
    assert reader.request(types.TEXT_DOCUMENT_FORMATTING, params) == []
