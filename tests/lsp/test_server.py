"""The server as a client sees it: findings, edits, and messages that are wrong."""

import asyncio
import io
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lsprotocol import types

from achse.lsp.server import BoundedInput, MessageTooLong, new_server
from achse.st.files.files import SOURCES
from achse.testing import VirtualTimeLoop
from tests.lsp.client import InProcessClient, ServerRefused, opened, position_of
from tests.st.workspace.sample import FILES, cold_findings, write_project

MAIN = "POUs/MAIN.TcPOU"


def _range(text: str, code: str) -> dict[str, Any]:
    return {"start": position_of(text, code), "end": position_of(text, code, len(code))}


def test_capabilities(project_folder: Path) -> None:
    with opened(project_folder) as client:
        capabilities = client.server.protocol.server_capabilities
    assert capabilities.position_encoding == "utf-16"
    assert capabilities.rename_provider is not None
    assert capabilities.semantic_tokens_provider is not None


def test_findings_come_after_an_edit_and_go_again(client: InProcessClient) -> None:
    client.open(MAIN)
    client.pause()
    assert not client.diagnostics(MAIN)
    client.change(MAIN, {"range": _range(FILES[MAIN], "nSum := 0"), "text": "nSum := 'ä😀'"})
    client.pause()
    (finding,) = client.diagnostics(MAIN) or []
    assert finding["code"].startswith("ST")
    assert finding["source"] == "achse"
    assert finding["severity"] == 1
    changed = FILES[MAIN].replace("nSum := 0", "nSum := 'ä😀'")
    assert finding["range"] == _range(changed, "'ä😀'")
    client.change(MAIN, {"range": _range(changed, "'ä😀'"), "text": "0"})
    client.pause()
    assert client.diagnostics(MAIN) == []


def test_findings_in_other_files_come_too(client: InProcessClient) -> None:
    name = "GVLs/GVL.TcGVL"
    client.open(name)
    client.change(name, {"range": _range(FILES[name], "cMost"), "text": "cLeast"})
    client.pause()
    assert [one["code"] for one in client.diagnostics("DUTs/ST_Data.TcDUT") or []]
    client.notify(types.TEXT_DOCUMENT_DID_CLOSE, {"textDocument": {"uri": client.uri(name)}})
    client.pause()
    assert client.diagnostics("DUTs/ST_Data.TcDUT") == []


@settings(max_examples=10)
@given(data=st.data())
def test_any_incremental_edits_have_the_findings_of_a_cold_check(
    project_folder: Path, data: st.DataObject
) -> None:
    with opened(project_folder) as client:
        name = data.draw(st.sampled_from([MAIN, "Functions.st", "POUs/FB_Drive.TcPOU"]))
        client.open(name)
        text = FILES[name]
        for _ in range(data.draw(st.integers(1, 4))):
            start = data.draw(st.integers(0, len(text)))
            end = data.draw(st.integers(start, min(start + 10, len(text))))
            new = data.draw(
                st.sampled_from(
                    ("", "x", "\n", "😀", ";", "'ä", "nSum := 1;\r\n", "<", "&amp;", "]]>", '"')
                )
            )
            place = {
                "start": _position(text, start),
                "end": _position(text, end),
            }
            client.change(name, {"range": place, "text": new})
            text = text[:start] + new + text[end:]
        client.pause()
        document = client.server.editor.document_of(project_folder / name)
        assert document is not None
        assert document.text == text
        cold = cold_findings(
            project_folder,
            {project_folder / name: text},
            predefined=_runtime(client),
        )
        shown = {
            (note["params"]["uri"], one["message"].removeprefix("not reached: "))
            for note in _last_notes(client)
            for one in note["params"]["diagnostics"]
        }
        names = {file.name for file in project_folder.rglob("*") if file.suffix.lower() in SOURCES}
        expected = {
            (client.uri(one.location.path), one.message)
            for kind in cold
            for one in kind
            if one.location.path.rpartition("/")[2] in names
        }
        assert shown == expected


def _runtime(client: InProcessClient) -> Any:
    from achse.plc.system_info import lists_of_runtime

    (workspace,) = client.server.editor.projects
    return lists_of_runtime(workspace.tasks)


def _last_notes(client: InProcessClient) -> list[dict[str, Any]]:
    last = {
        note["params"]["uri"]: note
        for note in client.notes
        if note["method"] == types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS
    }
    return list(last.values())


def _position(text: str, offset: int) -> dict[str, int]:
    head = text[:offset].replace("\r\n", "\n").replace("\r", "\n")
    last = head.rpartition("\n")[2]
    return {"line": head.count("\n"), "character": len(last.encode("utf-16-le")) // 2}


# wrong messages -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "params",
    [
        {"textDocument": {"uri": "untitled:x"}, "position": {"line": 0, "character": 0}},
        {"textDocument": {"uri": "file:///no/such.st"}, "position": {"line": 0, "character": 0}},
        {"textDocument": {"uri": "file:///a\0b"}, "position": {"line": 0, "character": 0}},
        {"textDocument": {"uri": ""}, "position": {"line": 0, "character": 0}},
    ],
)
def test_a_document_that_is_no_file_is_refused(
    client: InProcessClient, params: dict[str, Any]
) -> None:
    with pytest.raises(ServerRefused, match="expected"):
        client.request(types.TEXT_DOCUMENT_HOVER, params)
    assert client.request(types.TEXT_DOCUMENT_HOVER, client.at(MAIN, "fbDrive")) is not None


@pytest.mark.parametrize("place", [(10_000, 0), (1 << 31, 5)])
def test_a_line_behind_the_end_is_refused(client: InProcessClient, place: tuple[int, int]) -> None:
    position = {"line": place[0], "character": place[1]}
    params = {"textDocument": {"uri": client.uri(MAIN)}, "position": position}
    with pytest.raises(ServerRefused, match="position") as refusal:
        client.request(types.TEXT_DOCUMENT_DEFINITION, params)
    assert refusal.value.code == -32602


def test_wrong_changes_are_logged_and_the_server_goes_on(client: InProcessClient) -> None:
    client.change("Functions.st", {"text": "never opened"})
    client.open(MAIN)
    client.change(MAIN, {"text": FILES[MAIN]}, version=-3)
    far = {"start": {"line": 99_999, "character": 7}, "end": {"line": 0, "character": 0}}
    client.change(MAIN, {"range": far, "text": "x"})
    client.pause()
    logged = [note["params"]["message"] for note in client.notes if "logMessage" in note["method"]]
    assert any("Functions.st" in one for one in logged)
    assert any("expected a version after 1, got -3" in one for one in logged)
    assert client.request(types.WORKSPACE_SYMBOL, {"query": "F_Add"})


def test_unknown_methods_and_cancellations_are_answered(client: InProcessClient) -> None:
    with pytest.raises(ServerRefused):
        client.request("achse/nothing", {})
    client.notify("$/cancelRequest", {"id": 12_345})
    client.notify("$/unheard", {"x": 1})
    assert client.request(types.WORKSPACE_SYMBOL, {"query": "F_Add"})


def test_requests_too_early_twice_or_too_late_are_refused(project_folder: Path) -> None:
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        client = InProcessClient(new_server(), runner, project_folder)
        with pytest.raises(ServerRefused, match="initialize first") as refusal:
            client.request(types.WORKSPACE_SYMBOL, {"query": "F_Add"})
        assert refusal.value.code == -32002
    with opened(project_folder) as client:
        with pytest.raises(ServerRefused, match="expected once") as refusal:
            client.request(types.INITIALIZE, {"processId": None, "capabilities": {}})
        assert refusal.value.code == -32600
        assert client.request(types.WORKSPACE_SYMBOL, {"query": "F_Add"})
        client.request(types.SHUTDOWN, None)
        with pytest.raises(ServerRefused, match="after shutdown"):
            client.request(types.WORKSPACE_SYMBOL, {"query": "F_Add"})
        client.server.protocol._shutdown = False  # the client of this test does it again


def test_options_of_the_wrong_kind_are_refused(project_folder: Path) -> None:
    for options in ({"libraries": "one"}, {"defines": [1]}, ["x"]):
        with (
            pytest.raises(ServerRefused, match="initializationOptions"),
            opened(project_folder, options),
        ):
            pass


def test_a_huge_document_is_kept_and_not_checked(client: InProcessClient) -> None:
    client.open("Functions.st", "x;" * (1 << 23) + ";")
    client.pause()
    assert client.request(types.WORKSPACE_SYMBOL, {"query": "F_Add"})


def test_files_that_change_on_disk_are_read_again(tmp_path: Path) -> None:
    folder = write_project(tmp_path)
    with opened(folder) as client:
        file = folder / "DUTs" / "E_State.TcDUT"
        file.write_text(FILES["DUTs/E_State.TcDUT"].replace("Moving", "Running"))
        changes = [{"uri": client.uri("DUTs/E_State.TcDUT"), "type": 2}]
        client.notify(types.WORKSPACE_DID_CHANGE_WATCHED_FILES, {"changes": changes})
        client.pause()
        assert client.diagnostics(MAIN)


@pytest.mark.parametrize("count", [3, 30])
def test_many_files_that_change_at_once_have_the_findings_of_each(
    tmp_path: Path, count: int
) -> None:
    folder = write_project(tmp_path)
    names = [f"More{number}.st" for number in range(count)]
    good = {name: f"FUNCTION F_{name[:-3]} : INT\nEND_FUNCTION\n" for name in names}
    bad = {name: text.replace(" : INT\n", " : INT\nnothing := 1;\n") for name, text in good.items()}
    for name, text in good.items():
        (folder / name).write_text(text)
    with opened(folder) as client:
        for name, text in bad.items():
            (folder / name).write_text(text)
        changes = [{"uri": client.uri(name), "type": 2} for name in names]
        changes.append({"uri": "untitled:x", "type": 2})
        client.notify(types.WORKSPACE_DID_CHANGE_WATCHED_FILES, {"changes": changes})
        client.pause()
        assert [len(client.diagnostics(name) or ()) for name in names] == [1] * count
        for name, text in good.items():
            client.open(name, text)
        client.pause()
        assert [client.diagnostics(name) for name in names] == [[]] * count
        for name in names:
            client.notify(
                types.TEXT_DOCUMENT_DID_CLOSE, {"textDocument": {"uri": client.uri(name)}}
            )
        client.pause()
        assert [len(client.diagnostics(name) or ()) for name in names] == [1] * count


def test_a_client_that_can_is_requested_to_watch_files(project_folder: Path) -> None:
    watching = {"workspace": {"didChangeWatchedFiles": {"dynamicRegistration": True}}}
    with opened(project_folder, capabilities=watching) as client:
        (request,) = (one for one in client.notes if one["method"] == "client/registerCapability")
        (registered,) = request["params"]["registrations"]
        assert registered["method"] == types.WORKSPACE_DID_CHANGE_WATCHED_FILES
        client.feed({"jsonrpc": "2.0", "id": request["id"], "result": None})
        assert client.request(types.WORKSPACE_SYMBOL, {"query": "F_Add"})


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-32"])
def test_positions_are_in_the_units_that_both_agree_on(project_folder: Path, encoding: str) -> None:
    capabilities = {"general": {"positionEncodings": [encoding]}}
    with opened(project_folder, capabilities=capabilities) as client:
        text = FILES[MAIN].replace("nSum := 0;", "(* ä😀 *) nSum := 0;")
        client.open(MAIN, text)
        line = next(one for one in text.split("\n") if "ä😀" in one)
        codec, width = {"utf-8": ("utf-8", 1), "utf-16": ("utf-16-le", 2)}.get(
            encoding, ("utf-32-le", 4)
        )
        column = len(line[: line.index("nSum")].encode(codec)) // width
        position = {"line": text.split("\n").index(line), "character": column}
        params = {"textDocument": {"uri": client.uri(MAIN)}, "position": position}
        result = client.request(types.TEXT_DOCUMENT_HOVER, params)
        assert "nSum : DINT" in result["contents"]["value"]
        assert result["range"]["start"] == position


def test_nothing_is_written(tmp_path: Path) -> None:
    folder = write_project(tmp_path)
    before = {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()}
    with opened(folder) as client:
        client.open(MAIN)
        client.request(types.TEXT_DOCUMENT_RENAME, {**client.at(MAIN, "nSum"), "newName": "nAll"})
        client.pause()
    after = {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()}
    assert after == before


def test_a_message_longer_than_any_ends_the_stream() -> None:
    stream = BoundedInput(io.BytesIO(b"Content-Length: 3\r\n\r\nabc" + b"x" * 10_000))
    assert stream.readline() == b"Content-Length: 3\r\n"
    assert (stream.readline(), stream.read(3)) == (b"\r\n", b"abc")
    assert len(stream.readline()) < 10_000
    with pytest.raises(MessageTooLong, match="expected up to"):
        stream.read(10**24)
    with pytest.raises(MessageTooLong, match="5000 digits"):
        BoundedInput(io.BytesIO(b"Content-Length: " + b"9" * 5000 + b"\r\n")).readline()


@pytest.mark.parametrize("header", [b"content-length:3\r\n", b"CONTENT-LENGTH: 3 \r\n"])
def test_the_header_of_a_message_is_without_case(header: bytes) -> None:
    assert BoundedInput(io.BytesIO(header)).readline() == b"Content-Length: 3\r\n"
