"""Heads: learnt once, forgotten together, and never learnt from frames that must be decoded."""

from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AmsAddress, Command, Flags, Frame
from achse.ams.frame import TCP_HEADER
from achse.transport.connections.known.heads import KnownHeads
from achse.transport.connections.known.single import HEAD_SIZE, MOST_HEADS

LIMIT = 200
ONE, OTHER = AmsAddress("5.0.0.1.1.1:851"), AmsAddress("5.0.0.2.1.1:30000")


class Lengths(KnownHeads[int]):
    """Heads of reads, with the length of their frames."""

    def __init__(self) -> None:
        super().__init__(SimpleNamespace(owner=SimpleNamespace(max_length=LIMIT)))  # type: ignore[arg-type]
        self.learnt = 0

    def _learn(self, head: bytes, command: int, flags: int, size: int, length: int) -> int | None:
        self.learnt += 1
        return length if command == Command.READ else None


def encoded(data: bytes, invoke_id: int = 1, error: int = 0, source: AmsAddress = OTHER) -> bytes:
    frame = Frame(ONE, source, Command.READ, Flags.ADS_COMMAND, error, invoke_id, data).encode()
    return TCP_HEADER.pack(0, len(frame)) + frame


@given(st.binary(max_size=150), st.lists(st.integers(0, 0xFFFF_FFFF), min_size=1, max_size=5))
def test_head_is_learnt_once(data: bytes, invoke_ids: list[int]) -> None:
    heads = Lengths()
    for invoke_id in invoke_ids:
        frame = encoded(data, invoke_id=invoke_id)
        assert heads._known(b"before" + frame, 6) == len(frame)
    assert heads.learnt == 1
    heads.clear()
    heads._known(encoded(data), 0)
    assert heads.learnt == 2


@pytest.mark.parametrize(
    "frame",
    [
        encoded(bytes(LIMIT)),
        encoded(b"", error=7),
        encoded(b"")[: HEAD_SIZE + 3],
        b"\1" + encoded(b"")[1:],
        TCP_HEADER.pack(0, 40) + encoded(b"1")[TCP_HEADER.size :],
    ],
    ids=["too long", "error", "cut", "TCP command", "lengths"],
)
def test_frame_that_must_be_decoded_is_not_learnt(frame: Any) -> None:
    heads = Lengths()
    assert heads._known(frame, 0) is None
    assert heads.learnt == 0


def test_heads_begin_again_when_they_are_too_many() -> None:
    heads = Lengths()
    for port in range(MOST_HEADS + 1):
        heads._known(encoded(b"", source=AmsAddress.of(OTHER.net_id, port)), 0)
    assert len(heads._heads) == 1
