"""A client in the process of the server: messages go to the protocol and come back as JSON."""

import asyncio
import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from lsprotocol import types

from achse.lsp.editor import uri_of
from achse.lsp.server import LspServer, new_server
from achse.testing import VirtualTimeLoop
from tests.st.workspace.sample import FILES

__all__ = ["InProcessClient", "ServerRefused", "opened"]


class ServerRefused(Exception):
    """The server answered with an error."""

    def __init__(self, code: int, message: str) -> None:
        super().__init__(message)
        self.code, self.message = code, message


class InProcessClient:
    """A client of one server, which runs in a loop with virtual time."""

    def __init__(self, server: LspServer, runner: asyncio.Runner, folder: Path) -> None:
        self.server = server
        self.folder = folder
        self.notes: list[dict[str, Any]] = []
        self._runner = runner
        self._answers: dict[Any, dict[str, Any]] = {}
        self._number = 0
        self._version = 1
        server.protocol.set_writer(self, include_headers=False)

    # the writer of the server ----------------------------------------------------------------

    def write(self, data: bytes) -> None:
        """Take a message of the server."""
        message = json.loads(data)
        if "method" in message:
            self.notes.append(message)
        else:
            self._answers[message["id"]] = message

    def close(self) -> None:
        """Do nothing: there is no stream."""

    # messages --------------------------------------------------------------------------------

    def feed(self, message: Any) -> None:
        """Give the server a message, whatever it is."""

        async def handle() -> None:
            protocol = self.server.protocol
            body = json.dumps(message)
            protocol.handle_message(json.loads(body, object_hook=protocol.structure_message))
            await asyncio.sleep(0)

        self._runner.run(handle())

    def notify(self, method: str, params: Any) -> None:
        """Send a notification."""
        self.feed({"jsonrpc": "2.0", "method": method, "params": params})

    def request(self, method: str, params: Any) -> Any:
        """Return the result of a request. Raises `ServerRefused`."""
        self._number += 1
        self.feed({"jsonrpc": "2.0", "id": self._number, "method": method, "params": params})
        answer = self._answers.pop(self._number)
        if "error" in answer:
            raise ServerRefused(answer["error"]["code"], answer["error"]["message"])
        return answer.get("result")

    def pause(self, seconds: float = 1.0) -> None:
        """Let virtual time pass."""
        self._runner.run(asyncio.sleep(seconds))

    # documents -------------------------------------------------------------------------------

    def uri(self, name: str) -> str:
        """Return the URI of a file of the project."""
        return uri_of(self.folder / name)

    def open(self, name: str, text: str | None = None) -> None:
        """Open a file of the project."""
        text = FILES[name] if text is None else text
        document = {"uri": self.uri(name), "languageId": "iecst", "version": 1, "text": text}
        self.notify(types.TEXT_DOCUMENT_DID_OPEN, {"textDocument": document})

    def change(self, name: str, *changes: dict[str, Any], version: int | None = None) -> None:
        """Change a document."""
        self._version += 1
        number = self._version if version is None else version
        document = {"uri": self.uri(name), "version": number}
        params = {"textDocument": document, "contentChanges": list(changes)}
        self.notify(types.TEXT_DOCUMENT_DID_CHANGE, params)

    def at(self, name: str, code: str, text: str | None = None, behind: int = 0) -> dict[str, Any]:
        """Return the parameters of a request about the place of some code in a file."""
        place = position_of(FILES[name] if text is None else text, code, behind)
        return {"textDocument": {"uri": self.uri(name)}, "position": place}

    def diagnostics(self, name: str) -> list[dict[str, Any]] | None:
        """Return the last diagnostics of a file; None if there were none."""
        rows = None
        for note in self.notes:
            if note["method"] == types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS:
                params = note["params"]
                rows = params["diagnostics"] if params["uri"] == self.uri(name) else rows
        return rows


def position_of(text: str, code: str, behind: int = 0) -> dict[str, int]:
    """Return the position of some code in UTF-16, plus some characters."""
    assert code in text
    head = text[: text.index(code) + behind]
    line = head.count("\n")
    last = head.rpartition("\n")[2]
    return {"line": line, "character": len(last.encode("utf-16-le")) // 2}


@contextmanager
def opened(
    folder: Path, options: Any = None, capabilities: Any = None
) -> Iterator[InProcessClient]:
    """Return a client whose server knows a folder."""
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        client = InProcessClient(new_server(), runner, folder)
        client.request(
            types.INITIALIZE,
            {
                "processId": None,
                "capabilities": capabilities or {},
                "workspaceFolders": [{"uri": uri_of(folder), "name": "project"}],
                "initializationOptions": options,
            },
        )
        client.notify(types.INITIALIZED, {})
        yield client
        client.request(types.SHUTDOWN, None)
