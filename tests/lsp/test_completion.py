"""Completion and signature help by a client."""

import pytest
from lsprotocol import types

from tests.lsp.client import InProcessClient
from tests.st.workspace.sample import FILES

MAIN = "POUs/MAIN.TcPOU"


def _typed(client: InProcessClient, code: str) -> dict[str, object]:
    text = FILES[MAIN].replace("nSum := F_Add", f"{code}\nnSum := F_Add")
    client.open(MAIN, text)
    return client.at(MAIN, code, text, len(code))


@pytest.mark.parametrize(
    ("code", "labels", "keywords"),
    [
        ("fbDrive.", ["bEnable", "nLimit", "bDone"], False),
        ("eState := E_State.", ["Idle", "Moving", "Failed"], False),
        ("fb", ["fbDrive", "fbFast"], True),
    ],
)
def test_items(client: InProcessClient, code: str, labels: list[str], keywords: bool) -> None:
    result = client.request(types.TEXT_DOCUMENT_COMPLETION, _typed(client, code))
    names = [one["label"] for one in result["items"]]
    assert names[: len(labels)] == labels
    assert ("END_IF" in names) is keywords
    assert "documentation" in result["items"][0]


def test_inputs_and_outputs_of_a_block_come_with_their_sign(client: InProcessClient) -> None:
    result = client.request(types.TEXT_DOCUMENT_COMPLETION, _typed(client, "fbDrive("))
    texts = {one["label"]: one.get("insertText") for one in result["items"]}
    assert texts["bEnable"] == "bEnable := "
    assert texts["bDone"] == "bDone => "
    assert texts["nSum"] is None


def test_outside_of_code_nothing_completes(client: InProcessClient) -> None:
    params = client.at(MAIN, "<POU", behind=2)
    assert client.request(types.TEXT_DOCUMENT_COMPLETION, params)["items"] == []


@pytest.mark.parametrize(
    ("code", "label", "active"),
    [
        ("nSum := F_Add(1, ", "F_Add(a : DINT, b : DINT)", 1),
        ("fbFast.Move(", "FB_Fast.Move(nSteps : DINT)", 0),
        ("fbDrive(nLimit := ", "FB_Drive(bEnable : BOOL, nLimit : INT, bDone : BOOL)", 1),
    ],
)
def test_signatures(client: InProcessClient, code: str, label: str, active: int) -> None:
    result = client.request(types.TEXT_DOCUMENT_SIGNATURE_HELP, _typed(client, code))
    assert result["signatures"][0]["label"] == label
    assert result["activeParameter"] == active
    params = _typed(client, "nSum := 1; ")
    assert client.request(types.TEXT_DOCUMENT_SIGNATURE_HELP, params) is None
