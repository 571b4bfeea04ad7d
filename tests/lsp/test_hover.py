"""Hover by a client."""

import pytest
from lsprotocol import types

from achse.codes.links import SITE
from tests.lsp.client import InProcessClient
from tests.st.workspace.sample import FILES

MAIN = "POUs/MAIN.TcPOU"


@pytest.mark.parametrize(
    ("name", "code", "parts"),
    [
        (MAIN, "fbDrive(", ["fbDrive : FB_Drive; // VAR", "the drive", "in `MAIN`"]),
        ("GVLs/GVL.TcGVL", "fbSpare", ["fbSpare AT %MB100 : FB_Drive; // VAR_GLOBAL"]),
        ("DUTs/ST_Data.TcDUT", "rScale", ["rScale : REAL := 1.5", "scale"]),
        (MAIN, "Moving:", ["E_State.Moving := 1"]),
        (MAIN, "Move(nSteps", ["METHOD FB_Fast.Move : DINT", "nSteps : DINT; // VAR_INPUT"]),
        (MAIN, "F_Add(", ["FUNCTION F_Add : DINT", "a : DINT"]),
        (MAIN, "Position;", ["PROPERTY FB_Drive.Position : DINT (GET)"]),
        (MAIN, "FB_Drive; //", ["FUNCTION_BLOCK FB_Drive", "nLimit : INT := 10"]),
        (MAIN, "TON;", ["FUNCTION_BLOCK TON", "library tc2_standard"]),
        (MAIN, "DINT_TO_REAL", ["function of the language"]),
        (MAIN, "ST_Data;", ["TYPE ST_Data : STRUCT"]),
        (MAIN, "GVL.", ["VARIABLE LIST GVL"]),
        (MAIN, "MAIN\nVAR", ["PROGRAM MAIN"]),
    ],
)
def test_hover(reader: InProcessClient, name: str, code: str, parts: list[str]) -> None:
    result = reader.request(types.TEXT_DOCUMENT_HOVER, reader.at(name, code))
    for part in parts:
        assert part in result["contents"]["value"]
    start, end = result["range"]["start"], result["range"]["end"]
    line = FILES[name].split("\n")[start["line"]]
    assert code.startswith(line[start["character"] : end["character"]])


def test_a_block_of_a_library_leads_to_its_page(
    reader: InProcessClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(SITE, "https://docs.example")
    result = reader.request(types.TEXT_DOCUMENT_HOVER, reader.at(MAIN, "TON;"))
    page = "https://docs.example/reference/plc-library-tc2_standard/#TON"
    assert f"library [tc2_standard]({page})" in result["contents"]["value"]


def test_nothing_is_known_about_words(reader: InProcessClient) -> None:
    for code in ("PROGRAM", "END_CASE", "Version"):
        assert reader.request(types.TEXT_DOCUMENT_HOVER, reader.at(MAIN, code)) is None
