"""Code actions by a client."""

import pytest
from lsprotocol import types

from tests.lsp.client import InProcessClient
from tests.st.workspace.sample import FILES

MAIN = "POUs/MAIN.TcPOU"


@pytest.mark.parametrize(
    ("right", "wrong"), [("nSum := 0", "nSumm := 0"), ("fbFast : FB_Fast", "fbFast : FB_Fasst")]
)
def test_the_near_miss_is_put_in_its_place(client: InProcessClient, right: str, wrong: str) -> None:
    text = FILES[MAIN].replace(right, wrong)
    client.open(MAIN, text)
    client.pause()
    diagnostics = client.diagnostics(MAIN) or []
    near = [one for one in diagnostics if "; near: " in one["message"]]
    params = {
        "textDocument": {"uri": client.uri(MAIN)},
        "range": near[0]["range"],
        "context": {"diagnostics": diagnostics},
    }
    action = client.request(types.TEXT_DOCUMENT_CODE_ACTION, params)[0]
    (edit,) = action["edit"]["changes"][client.uri(MAIN)]
    client.change(MAIN, {"range": edit["range"], "text": edit["newText"]})
    document = client.server.editor.document_of(client.folder / MAIN)
    assert document is not None
    assert document.text == FILES[MAIN]


def test_other_findings_have_no_action(client: InProcessClient) -> None:
    client.open(MAIN)
    place = client.at(MAIN, "nSum")["position"]
    finding = {"range": {"start": place, "end": place}, "message": "x", "source": "other"}
    params = {
        "textDocument": {"uri": client.uri(MAIN)},
        "range": finding["range"],
        "context": {"diagnostics": [finding]},
    }
    assert client.request(types.TEXT_DOCUMENT_CODE_ACTION, params) == []
