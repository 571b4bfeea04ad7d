"""Semantic tokens by a client."""

from lsprotocol import types

from achse.lsp.tokens import LEGEND
from tests.lsp.client import InProcessClient
from tests.st.workspace.sample import FILES

MAIN = "POUs/MAIN.TcPOU"


def test_each_name_has_its_kind(client: InProcessClient) -> None:
    text = FILES[MAIN].replace("fbFast.Move", "(* ä😀 *) fbFast.Move")
    client.open(MAIN, text)
    params = {"textDocument": {"uri": client.uri(MAIN)}}
    data = client.request(types.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL, params)["data"]
    lines = [line.encode("utf-16-le") for line in text.split("\n")]
    kinds = set()
    line = column = 0
    for index in range(0, len(data), 5):
        down, right, length, kind, flags = data[index : index + 5]
        line, column = line + down, right if down else column + right
        word = lines[line][2 * column : 2 * (column + length)].decode("utf-16-le")
        kinds.add((word, LEGEND.token_types[kind], flags))
    assert {
        ("fbDrive", "variable", 1),
        ("FB_Drive", "class", 0),
        ("Move", "method", 0),
        ("nSteps", "parameter", 0),
        ("cMost", "variable", 2),
        ("TON", "class", 4),
        ("Idle", "enumMember", 0),
        ("DINT_TO_REAL", "function", 4),
    } <= kinds
