"""A project to debug, and an editor that speaks the protocol by hand."""

import asyncio
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any

import pytest

from achse.dap.adapter import Adapter

SOURCE = """\
FUNCTION_BLOCK FB_Count
VAR_INPUT
    nStep : INT;
END_VAR
VAR_OUTPUT
    nTotal : DINT;
END_VAR
VAR
    fbDelay : TON;
    aList : ARRAY [1..200] OF INT;
END_VAR
nTotal := nTotal + F_Double(nStep);
fbDelay(IN := TRUE);
END_FUNCTION_BLOCK

FUNCTION F_Double : DINT
VAR_INPUT
    n : INT;
END_VAR
F_Double := n * 2;
END_FUNCTION

PROGRAM MAIN
VAR
    fbCount : FB_Count;
    nCycle : INT;
    nDivisor : INT := 1;
END_VAR
nCycle := nCycle + 1;
fbCount(nStep := nCycle / nDivisor);
END_PROGRAM
"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    (tmp_path / "main.st").write_text(SOURCE)
    return tmp_path / "main.st"


class Editor:
    """Sends requests, keeps what comes."""

    def __init__(self) -> None:
        self.messages: list[dict[str, Any]] = []
        self.came = asyncio.Event()
        self.adapter = Adapter(self.receive)
        self._seq = 0
        self._seen = 0

    def receive(self, message: dict[str, Any]) -> None:
        self.messages.append(message)
        self.came.set()

    async def ask(self, command: str, **arguments: Any) -> Any:
        """The body of an answer; AssertionError if it is a refusal."""
        answer = await self.answer(command, arguments)
        assert answer["success"], answer
        return answer["body"]

    async def refused(self, command: str, **arguments: Any) -> str:
        """What a refusal says."""
        answer = await self.answer(command, arguments)
        assert not answer["success"], answer
        return str(answer["message"])

    async def answer(self, command: str, arguments: Any) -> dict[str, Any]:
        self._seq += 1
        await self.adapter.handle(
            {"seq": self._seq, "type": "request", "command": command, "arguments": arguments}
        )
        answers = [one for one in self.messages if one.get("request_seq") == self._seq]
        assert len(answers) == 1
        assert answers[0]["command"] == command
        return answers[0]

    async def event(self, name: str) -> Any:
        """The body of the next event of a name."""
        while True:
            for number, one in enumerate(self.messages[self._seen :], self._seen + 1):
                if one["type"] == "event" and one["event"] == name:
                    self._seen = number
                    return one["body"]
            self.came.clear()
            await self.came.wait()

    async def launched(self, program: Path, **settings: Any) -> None:
        await self.ask("initialize", adapterID="achse")
        await self.ask("launch", program=str(program), tcpPort=0, **settings)
        await self.event("initialized")


@pytest.fixture
def converse() -> Callable[[Callable[[Editor], Coroutine[Any, Any, None]]], None]:
    """`converse(script)` runs a coroutine with an editor, and closes what it left open."""

    def run(script: Callable[[Editor], Coroutine[Any, Any, None]]) -> None:
        async def main() -> None:
            editor = Editor()
            try:
                await script(editor)
            finally:
                await editor.adapter.close()
            numbers = [one["seq"] for one in editor.messages]
            assert numbers == list(range(1, len(numbers) + 1))

        asyncio.run(main())

    return run
