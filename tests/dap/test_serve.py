"""The adapter as editors reach it: standard streams and TCP, with frames by hand."""

import asyncio
import json
import subprocess
from pathlib import Path
from typing import Any

import pytest

from achse.dap.protocol import FrameReader, encode_frame
from achse.dap.serve import OpenToAllError, serve_tcp
from tests.warm_commands import WarmCommands


def request(number: int, command: str, **arguments: Any) -> bytes:
    return encode_frame(
        {"seq": number, "type": "request", "command": command, "arguments": arguments}
    )


def test_standard_streams(project: Path, warm_commands: WarmCommands) -> None:
    program = subprocess.run(
        [warm_commands.folder / "achse", "plc", "debug"],
        input=request(1, "initialize")
        + request(2, "launch", program=str(project), tcpPort=0)
        + request(3, "threads")
        + request(4, "disconnect"),
        capture_output=True,
        check=True,
    )
    messages = FrameReader().feed(program.stdout)
    answers = {one["request_seq"]: one for one in messages if one["type"] == "response"}
    assert [answers[number]["success"] for number in (1, 2, 3, 4)] == [True] * 4
    assert answers[3]["body"]["threads"] == [{"id": 1, "name": "PlcTask"}]
    assert messages[-1]["event"] == "terminated"
    assert b"Traceback" not in program.stderr


def test_bytes_that_are_no_frames_end_the_conversation(warm_commands: WarmCommands) -> None:
    program = subprocess.run(
        [warm_commands.folder / "achse", "plc", "debug"],
        input=b"GET / HTTP/1.1\r\n\r\n",
        capture_output=True,
        check=True,
    )
    assert program.stdout == b""
    assert b"a head has fields" in program.stderr


def test_an_address_that_others_reach_needs_a_word() -> None:
    with pytest.raises(OpenToAllError, match="--let-everybody-in"):
        asyncio.run(serve_tcp("0.0.0.0", 0))


def test_tcp_serves_several_editors_and_drops_what_is_no_frame() -> None:
    async def main() -> None:
        where: asyncio.Future[tuple[str, int]] = asyncio.get_running_loop().create_future()
        server = asyncio.create_task(
            serve_tcp("127.0.0.1", 0, lambda host, port: where.set_result((host, port)))
        )
        host, port = await where
        for garbage in (b"\0" * 10_000, b"Content-Length: 9999999999\r\n\r\n", b""):
            reader, writer = await asyncio.open_connection(host, port)
            writer.write(garbage)
            writer.write_eof()
            assert await reader.read() == b""
            writer.close()
        reader, writer = await asyncio.open_connection(host, port)
        writer.write(request(1, "initialize") + request(2, "nothing"))
        frames = FrameReader()
        messages: list[Any] = []
        while len(messages) < 2:
            messages += frames.feed(await reader.read(1 << 16))
        assert [one["success"] for one in messages] == [True, False]
        assert json.dumps(messages[0]["body"])
        writer.close()
        many = [await asyncio.open_connection(host, port) for _ in range(12)]
        await asyncio.sleep(0)
        for _, one in many:
            one.close()
        server.cancel()
        await asyncio.gather(server, return_exceptions=True)

    asyncio.run(main())
