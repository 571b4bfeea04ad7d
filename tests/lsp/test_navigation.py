"""Declarations, references, outlines and calls by a client."""

import pytest
from lsprotocol import types

from tests.lsp.client import InProcessClient, position_of
from tests.st.workspace.sample import FILES

MAIN, DRIVE, FAST = "POUs/MAIN.TcPOU", "POUs/FB_Drive.TcPOU", "POUs/FB_Fast.TcPOU"


@pytest.mark.parametrize(
    ("name", "code", "target", "declared"),
    [
        (MAIN, "fbDrive(bEnable", MAIN, "fbDrive : FB_Drive"),
        (MAIN, "bEnable := TRUE", DRIVE, "bEnable : BOOL"),
        (MAIN, "Move(nSteps", FAST, "Move : DINT"),
        (MAIN, "nCount)", "GVLs/GVL.TcGVL", "nCount"),
        (MAIN, "Idle:", "DUTs/E_State.TcDUT", "Idle"),
        (MAIN, "FB_Drive; //", DRIVE, "FB_Drive\nVAR_INPUT"),
        (MAIN, "cMost", "GVLs/GVL.TcGVL", "cMost"),
        (MAIN, "Position;", DRIVE, "Position : DINT]]"),
        (FAST, "rScale", "DUTs/ST_Data.TcDUT", "rScale"),
        (DRIVE, "Move(1)", DRIVE, "Move : DINT"),
    ],
)
def test_definitions(
    reader: InProcessClient, name: str, code: str, target: str, declared: str
) -> None:
    result = reader.request(types.TEXT_DOCUMENT_DEFINITION, reader.at(name, code, behind=1))
    assert result["uri"] == reader.uri(target)
    assert result["range"]["start"] == position_of(FILES[target], declared)


def test_a_library_is_opened_where_it_is_installed(reader: InProcessClient) -> None:
    result = reader.request(types.TEXT_DOCUMENT_DEFINITION, reader.at(MAIN, "TON;"))
    assert result["uri"].endswith("/tc2_standard/timers.st")


def test_the_type_of_a_variable(reader: InProcessClient) -> None:
    result = reader.request(types.TEXT_DOCUMENT_TYPE_DEFINITION, reader.at(DRIVE, "aBuffer"))
    assert result["uri"] == reader.uri("DUTs/ST_Data.TcDUT")


def test_nothing_is_declared_in_tags_and_words(reader: InProcessClient) -> None:
    for code in ("TcPlcObject", "END_VAR", "POU Name"):
        assert reader.request(types.TEXT_DOCUMENT_DEFINITION, reader.at(MAIN, code)) is None


def test_references_are_in_all_files(reader: InProcessClient) -> None:
    params = reader.at("GVLs/GVL.TcGVL", "cMost")
    result = reader.request(
        types.TEXT_DOCUMENT_REFERENCES, {**params, "context": {"includeDeclaration": True}}
    )
    files = sorted(one["uri"].rpartition("/")[2] for one in result)
    assert files == ["FB_Fast.TcPOU", "GVL.TcGVL", "MAIN.TcPOU", "ST_Data.TcDUT"]
    result = reader.request(
        types.TEXT_DOCUMENT_REFERENCES, {**params, "context": {"includeDeclaration": False}}
    )
    assert len(result) == 3


def test_highlights_distinguish_reads_from_writes(reader: InProcessClient) -> None:
    result = reader.request(
        types.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT, reader.at(DRIVE, "nPosition : DINT")
    )
    assert sorted(one["kind"] for one in result) == [2, 2, 2, 2, 3, 3]


def test_the_outline_of_a_document(reader: InProcessClient) -> None:
    params = {"textDocument": {"uri": reader.uri(DRIVE)}}
    (block,) = reader.request(types.TEXT_DOCUMENT_DOCUMENT_SYMBOL, params)
    assert block["name"] == "FB_Drive"
    assert [one["name"] for one in block["children"]][-3:] == ["Move", "Position", "Halt"]
    for one in block["children"]:
        assert block["range"]["start"]["line"] <= one["range"]["start"]["line"]
        assert one["range"]["end"]["line"] <= block["range"]["end"]["line"]


@pytest.mark.parametrize(
    ("query", "expected"),
    [("fbdrv", {"FB_Drive", "fbDrive"}), ("F_Add", {"F_Add"}), ("zzz", set())],
)
def test_symbols_of_the_workspace(reader: InProcessClient, query: str, expected: set[str]) -> None:
    result = reader.request(types.WORKSPACE_SYMBOL, {"query": query})
    assert {one["name"] for one in result} == expected


def test_calls_in_and_out(reader: InProcessClient) -> None:
    (item,) = reader.request(
        types.TEXT_DOCUMENT_PREPARE_CALL_HIERARCHY, reader.at("Functions.st", "F_Add : DINT")
    )
    (call,) = reader.request(types.CALL_HIERARCHY_INCOMING_CALLS, {"item": item})
    assert call["from"]["name"] == "MAIN"
    calls = reader.request(types.CALL_HIERARCHY_OUTGOING_CALLS, {"item": call["from"]})
    assert {"F_Add", "Move", "Position"} <= {one["to"]["name"] for one in calls}
    assert (
        reader.request(types.TEXT_DOCUMENT_PREPARE_CALL_HIERARCHY, reader.at(MAIN, "nSum")) is None
    )
