"""`achse lsp` over standard streams, as an editor starts it."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from achse.lsp.editor import uri_of
from tests.st.workspace.sample import write_project


def _framed(message: dict[str, Any]) -> bytes:
    body = json.dumps({"jsonrpc": "2.0", **message}).encode()
    return b"Content-Length: %d\r\n\r\n%s" % (len(body), body)


def _messages(data: bytes) -> list[dict[str, Any]]:
    messages = []
    while data:
        head, _, rest = data.partition(b"\r\n\r\n")
        length = int(head.partition(b"Content-Length: ")[2].split(b"\r\n")[0])
        messages.append(json.loads(rest[:length]))
        data = rest[length:]
    return messages


def _initialize(folder: Path) -> dict[str, Any]:
    folders = [{"uri": uri_of(folder), "name": "project"}]
    params: dict[str, Any] = {"processId": None, "capabilities": {}, "workspaceFolders": folders}
    return {"id": 1, "method": "initialize", "params": params}


def test_a_client_that_does_not_read_the_log_is_served(tmp_path: Path) -> None:
    folder = write_project(tmp_path)
    wrong = {"method": "textDocument/hover", "params": {"position": "x" * 2000}}
    sent = [
        _framed(_initialize(folder)),
        *(_framed({"id": 100 + number, **wrong}) for number in range(200)),
        _framed({"id": 2, "method": "workspace/symbol", "params": {"query": "F_Add"}}),
        _framed({"id": 3, "method": "shutdown"}),
        _framed({"method": "exit"}),
    ]
    command = [sys.executable, "-m", "achse", "lsp"]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, **pipes) as server:  # type: ignore[call-overload]
        server.stdin.write(b"".join(sent))
        server.stdin.flush()
        answers = {one.get("id") for one in _messages(server.stdout.read())}
        assert {2, 3} <= answers
        assert server.wait(600) == 0


@pytest.mark.parametrize("ending", [b"", b"Content-Length: 9\r\n\r\nnot JSON!"])
def test_the_server_answers_and_ends_with_its_client(tmp_path: Path, ending: bytes) -> None:
    folder = write_project(tmp_path)
    sent = [
        _framed(_initialize(folder)),
        _framed({"method": "initialized", "params": {}}),
        ending,
        _framed({"id": 2, "method": "workspace/symbol", "params": {"query": "F_Add"}}),
    ]
    ran = subprocess.run(
        [sys.executable, "-m", "achse", "lsp"],
        input=b"".join(sent),
        capture_output=True,
        timeout=600,
        check=False,
    )
    answers = {one["id"]: one["result"] for one in _messages(ran.stdout) if "result" in one}
    assert answers[1]["serverInfo"]["name"] == "achse"
    assert [one["name"] for one in answers[2]] == ["F_Add"]
    assert ran.returncode == 0
