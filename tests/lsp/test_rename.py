"""Rename by a client: edits of all files, and what is refused."""

from pathlib import Path

import pytest
from lsprotocol import types

from achse.lsp.documents import Document
from achse.st.workspace import Workspace
from tests.lsp.client import InProcessClient, ServerRefused, opened
from tests.st.graphical.drawings import assign, contact, fb, network, networks, unit
from tests.st.workspace.sample import FILES, write_project
from tests.st.workspace.test_drawn_uses import FILES as DRAWN
from tests.st.workspace.test_drawn_uses import drawn_project

MAIN, DRIVE, FAST = "POUs/MAIN.TcPOU", "POUs/FB_Drive.TcPOU", "POUs/FB_Fast.TcPOU"


def _renamed(client: InProcessClient, name: str, code: str, new: str) -> dict[str, str]:
    """Return the files after a rename."""
    params = {**client.at(name, code), "newName": new}
    edit = client.request(types.TEXT_DOCUMENT_RENAME, params)
    texts = dict(FILES)
    for file in FILES:
        for one in sorted(
            edit["changes"].get(client.uri(file), ()),
            key=lambda one: (one["range"]["start"]["line"], one["range"]["start"]["character"]),
            reverse=True,
        ):
            document = Document(texts[file])
            places = [types.Position(**one["range"][end]) for end in ("start", "end")]
            document.edit([(types.Range(*places), one["newText"])])
            texts[file] = document.text
    return texts


@pytest.mark.parametrize(
    ("name", "code", "old", "new"),
    [
        (MAIN, "nSum : DINT", "nSum", "nTotal"),
        (MAIN, "nCount)", "nCount", "nNumber"),
        (DRIVE, "bEnable", "bEnable", "bRun"),
        (DRIVE, "FB_Drive\nVAR", "FB_Drive", "FB_Motor"),
        (FAST, "Move : DINT", "Move", "Travel"),
        ("DUTs/E_State.TcDUT", "Failed", "Failed", "Broken"),
        ("DUTs/ST_Data.TcDUT", "aValues", "aValues", "aNumbers"),
        ("Functions.st", "F_Add", "F_Add", "F_Sum"),
        ("Functions.st", "Area", "Area", "Surface"),
        (MAIN, "nOld : DINT", "nOld", "nBefore"),
        (DRIVE, "Position : DINT]", "Position", "Place"),
    ],
)
def test_a_rename_changes_the_name_and_nothing_else(
    reader: InProcessClient, name: str, code: str, old: str, new: str
) -> None:
    texts = _renamed(reader, name, code, new)
    assert texts != FILES
    for file, text in texts.items():
        assert text.replace(new, old) == FILES[file]
    assert old not in texts[name].replace("nPosition", "").replace("Moving", "")


def test_a_renamed_project_has_the_same_findings(tmp_path: Path, project_folder: Path) -> None:
    with opened(project_folder) as client:
        texts = _renamed(client, FAST, "Move : DINT", "Travel")
    folder = write_project(tmp_path)
    workspace = Workspace(folder)
    before = workspace.findings
    for file, text in texts.items():
        workspace.edit(folder / file, text.encode())
    assert workspace.findings == before


@pytest.mark.parametrize(
    ("name", "code", "new", "reason"),
    [
        (MAIN, "nSum : DINT", "END_IF", "word of the language"),
        (MAIN, "nSum : DINT", "MAX", "word of the language"),
        (MAIN, "nSum : DINT", "a b", "expected a name"),
        (MAIN, "nSum : DINT", "", "expected a name"),
        (MAIN, "nSum : DINT", "n__x", "expected a name"),
        (MAIN, "nSum : DINT", "ESTATE", "declared in MAIN already"),
        (MAIN, "nSum : DINT", "FB_Fast", "something global"),
        (MAIN, "nSum : DINT", "nCount", "something global"),
        (MAIN, "nOld : DINT", "bAll", "already"),
        (MAIN, "nOld : DINT", "nSum", "already"),
        (DRIVE, "nPosition : DINT", "Halt", "already"),
        (DRIVE, "FB_Drive\nVAR", "F_Add", "global"),
        ("DUTs/E_State.TcDUT", "Idle", "Moving", "already"),
        (MAIN, "TON;", "TOM", "declared in a library"),
        (MAIN, "DINT_TO_REAL", "X", "part of the language"),
        (MAIN, "GVL.", "List", "in the file, not in the code"),
    ],
)
def test_refused_renames(
    reader: InProcessClient, name: str, code: str, new: str, reason: str
) -> None:
    with pytest.raises(ServerRefused, match=reason) as refusal:
        reader.request(types.TEXT_DOCUMENT_RENAME, {**reader.at(name, code), "newName": new})
    assert refusal.value.code == -32803


def test_what_can_be_renamed_is_reported_before(reader: InProcessClient) -> None:
    result = reader.request(types.TEXT_DOCUMENT_PREPARE_RENAME, reader.at(MAIN, "nSum : DINT"))
    assert result["placeholder"] == "nSum"
    with pytest.raises(ServerRefused, match="declared in a library"):
        reader.request(types.TEXT_DOCUMENT_PREPARE_RENAME, reader.at(MAIN, "TON;"))
    assert reader.request(types.TEXT_DOCUMENT_PREPARE_RENAME, reader.at(MAIN, "END_VAR")) is None


def test_names_in_drawn_bodies_are_renamed(tmp_path: Path) -> None:
    drawn_project(tmp_path)
    with opened(tmp_path) as client:
        text = DRAWN["More.st"]
        client.open("More.st", text)
        params = {**client.at("More.st", "bReady", text), "newName": "bFit"}
        changes = client.request(types.TEXT_DOCUMENT_RENAME, params)["changes"]
        (edit,) = changes[client.uri("MAIN.TcPOU")]
        line = DRAWN["MAIN.TcPOU"].split("\n")[edit["range"]["start"]["line"]]
        first, last = (edit["range"][key]["character"] for key in ("start", "end"))
        assert (line[first:last], line.count("stData.bReady")) == ("bReady", 1)


def test_a_pin_that_means_several_things_is_not_renamed(tmp_path: Path) -> None:
    block = "FUNCTION_BLOCK {0}\nVAR_INPUT IN : BOOL; END_VAR\nVAR_OUTPUT Q : BOOL; END_VAR\n"
    text = "".join(f"{block.format(name)}END_FUNCTION_BLOCK\n" for name in ("FB_A", "FB_B"))
    body = networks(
        network(assign(fb("FB_A", "a", [("IN", contact("x"))]), "x")),
        network(assign(fb("FB_B", "b", [("IN", contact("x"))]), "x")),
    )
    (tmp_path / "Blocks.st").write_text(text)
    main = unit("PROGRAM MAIN\nVAR a : FB_A; b : FB_B; x : BOOL; END_VAR", body)
    (tmp_path / "MAIN.TcPOU").write_text(main)
    with opened(tmp_path) as client:
        params = {**client.at("Blocks.st", "IN : BOOL", text), "newName": "bInput"}
        with pytest.raises(ServerRefused, match="several things"):
            client.request(types.TEXT_DOCUMENT_RENAME, params)
