"""Names in drawn bodies."""

from pathlib import Path

from achse.st.graphical.body import GraphicalBody
from achse.st.workspace import Workspace
from achse.st.workspace.drawn_uses import ambiguous_names
from achse.st.workspace.uses import SymbolUse
from tests.st.graphical.drawings import assign, contact, fb, network, networks, series, unit

DECLARATION = """PROGRAM MAIN
VAR
    bStart : BOOL;
    bDone : BOOL;
    stData : ST_Data;
    tOne : TON;
    tTwo : TOF;
END_VAR"""
BODY = networks(
    network(assign(series(contact("bStart"), contact("stData.bReady")), "GVL.bAll")),
    network(
        assign(fb("TON", "tOne", [("IN", contact("bStart")), ("PT", contact("T#1s"))]), "bDone")
    ),
)
FILES = {
    "MAIN.TcPOU": unit(DECLARATION, BODY),
    "More.st": "TYPE ST_Data : STRUCT bReady : BOOL; END_STRUCT END_TYPE",
    "GVL.st": "VAR_GLOBAL bAll : BOOL; END_VAR",
}


def drawn_project(folder: Path, **changed: str) -> Workspace:
    """Return a project whose program is drawn."""
    for name, text in {**FILES, **changed}.items():
        (folder / name).write_text(text)
    return Workspace(folder)


def _drawn(workspace: Workspace) -> list[SymbolUse]:
    source = workspace.sources[[one.source.path for one in workspace.sources].index("MAIN.TcPOU")]
    return [use for use in workspace.uses_of(source.source) if use.at > len(source.source.text)]


def test_names_in_a_drawing_have_symbols_and_places(tmp_path: Path) -> None:
    workspace = drawn_project(tmp_path)
    assert not workspace.findings.errors
    lines = FILES["MAIN.TcPOU"].split("\n")
    source = next(one.source for one in workspace.sources if one.source.path == "MAIN.TcPOU")
    names = []
    for use in _drawn(workspace):
        place = source.locate(use.at)
        word = lines[place.line - 1][place.column - 1 :][: use.end - use.at]
        assert word.lower() == use.symbol.name.lower()
        assert source.drawn_offset_at(place.line, place.column) == use.at
        names.append(word)
    expected = "bStart stData bReady GVL bAll TON tOne IN PT bStart bDone"
    assert sorted(set(names)) == sorted(set(expected.split()) & set(names))
    assert {"bStart", "stData", "bReady", "bAll", "tOne", "IN", "PT", "bDone"} <= set(names)
    assert names.count("bStart") == 2


def test_a_place_outside_of_a_drawing_is_in_none(tmp_path: Path) -> None:
    workspace = drawn_project(tmp_path)
    source = next(one.source for one in workspace.sources if one.source.path == "MAIN.TcPOU")
    assert source.drawn_offset_at(1, 1) is None
    assert source.drawn_offset_at(10_000, 1) is None


def test_a_pin_of_two_blocks_means_several_things(tmp_path: Path) -> None:
    both = networks(
        network(assign(fb("TON", "tOne", [("IN", contact("bStart"))]), "bDone")),
        network(assign(fb("TOF", "tTwo", [("IN", contact("bStart"))]), "bDone")),
    )
    workspace = drawn_project(tmp_path, **{"MAIN.TcPOU": unit(DECLARATION, both)})
    assert not workspace.findings.errors
    checking = workspace.checking
    assert checking is not None
    routine = checking.checked("main")
    assert routine is not None
    assert isinstance(routine.body, GraphicalBody)
    assert "in" in ambiguous_names(routine.body, checking.uses_of(routine))
    assert "in" not in {use.symbol.name.lower() for use in _drawn(workspace)}
