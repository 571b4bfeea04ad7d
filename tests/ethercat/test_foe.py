"""FoE, the slave's end: whole files in packets, and messages of any kind."""

import struct
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import FileRefusal, FoeError
from achse.ethercat.foe import FoeOperation, FoeServer
from achse.ethercat.mailbox import MailboxError


class Files:
    """Files that take `steps` looks until one that was written is there."""

    bootstrap = False
    longest_file = 1000

    def __init__(self, steps: int = 0) -> None:
        self.files: dict[str, bytes] = {}
        self.steps = steps
        self._left = 0

    @property
    def programming(self) -> tuple[int, int] | None:
        if not self._left:
            return None
        self._left -= 1
        return self.steps - self._left, 200_000

    def read_file(self, name: str, password: int) -> bytes:
        if name not in self.files:
            raise FileRefusal(FoeError.NOT_FOUND, "not here")
        return self.files[name]

    def begin_file(self, name: str, password: int) -> None:
        if password:
            raise FileRefusal(FoeError.NO_RIGHTS)

    def write_file(self, name: str, data: bytes) -> None:
        self.files[name] = data
        self._left = self.steps


def message(operation: int, number: int = 0, data: bytes = b"") -> bytes:
    return struct.pack("<BxI", operation, number) + data


def replies(server: FoeServer, *parts: Any) -> list[tuple[int, int, bytes]]:
    answer = server.answer(message(*parts))
    assert not isinstance(answer, int)
    return [(each[0], int.from_bytes(each[2:6], "little"), each[6:]) for each in answer]


@given(st.binary(max_size=1000), st.integers(34, 300), st.integers(34, 300), st.integers(0, 3))
def test_what_is_written_is_read(content: bytes, out: int, into: int, steps: int) -> None:
    files = Files(steps)
    server = FoeServer(files)
    server.reset(out, into)
    assert replies(server, FoeOperation.WRITE, 0, b"name") == [(4, 0, b"")]
    room = out - 12
    parts = [content[at : at + room] for at in range(0, len(content) + 1, room)]
    for number, part in enumerate(parts, 1):
        for busy in range(steps if number == len(parts) else 0):
            ((kind, report, words),) = replies(server, FoeOperation.DATA, number, part)
            assert (kind, words) == (FoeOperation.BUSY, b"programming")
            assert (report & 0xFFFF, report >> 16) == (busy + 1 >> 2, 50_000)
        assert replies(server, FoeOperation.DATA, number, part) == [(4, number, b"")]
    assert files.files == {"name": content}
    read = b""
    answer = replies(server, FoeOperation.READ, 0, b"name\0rest")
    while answer:
        ((kind, number, part),) = answer
        assert kind == FoeOperation.DATA
        assert replies(server, FoeOperation.BUSY, 0) == answer  # told once more
        read += part
        answer = replies(server, FoeOperation.ACKNOWLEDGE, number)
    assert read == content


@given(
    st.lists(st.tuples(st.integers(0, 8), st.integers(0, 3), st.binary(max_size=70)), max_size=20)
)
def test_any_message_is_answered(sent: list[tuple[int, int, bytes]]) -> None:
    server = FoeServer(Files(1))
    server.reset(64, 64)
    for operation, number, data in sent:
        for kind, report, _ in replies(server, operation, number, data):
            assert kind in set(FoeOperation)
            assert kind != FoeOperation.ERROR or report in set(FoeError)


@pytest.mark.parametrize(
    ("sent", "code"),
    [
        ([(1, 0, b"none")], FoeError.NOT_FOUND),
        ([(2, 5, b"x")], FoeError.NO_RIGHTS),
        ([(3, 1, b"x")], FoeError.ILLEGAL),
        ([(9, 1, b"x")], FoeError.ILLEGAL),
        ([(2, 0, b"x"), (3, 2, b"x")], FoeError.PACKET_NUMBER),
        ([(2, 0, b"x"), (3, 1, bytes(1001))], FoeError.DISK_FULL),
    ],
)
def test_refusals(sent: list[tuple[int, int, bytes]], code: FoeError) -> None:
    server = FoeServer(Files())
    server.reset(64, 64)
    answers = [replies(server, *each) for each in sent]
    ((kind, report, _),) = answers[-1]
    assert (kind, report) == (FoeOperation.ERROR, code)
    assert replies(server, FoeOperation.ACKNOWLEDGE, 1) == []


def test_a_message_without_a_head_is_none() -> None:
    assert FoeServer(Files()).answer(b"short") == MailboxError.SIZE_TOO_SHORT
