"""The binary form of recordings: `.scope` files, and the samples that a device sends.

A file is `ACHSCOPE`, UINT32 version 1, UINT32 n, n bytes of JSON (name, trigger_ns, blocks), then
chunks. A chunk is UINT32 block, UINT32 rows, UINT64 number of its first row, and the rows: a word
of 8 bytes for each channel of the block. All numbers are little endian. The value is in the first
bytes of its word, the others are 0. A file that ends early is read as far as it goes.
"""

import json
import struct
import sys
from array import array
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO, NamedTuple, Self

from achse.scope.channel import channel_of
from achse.scope.data import ScopeBlock, ScopeData
from achse.scope.types import SCOPE_TYPES, WORD, ScopeError

MAGIC = b"ACHSCOPE"
CHUNK = struct.Struct("<IIQ")
_HEAD = struct.Struct("<8sII")
_VERSION = 1
_LONGEST_HEADER = 64 * 1024 * 1024
_PIECE = 1 << 18
"""Bytes of a chunk in files: others come to their turn between two."""


class ScopeChunk(NamedTuple):
    """Rows of one block."""

    block: int
    size: int
    """Number of rows."""
    first: int
    """Number of the first row since the start of the recording."""
    rows: bytes


def encode_chunk(block: int, count: int, first: int, rows: bytes) -> bytes:
    """Return a chunk as it is sent and written."""
    return CHUNK.pack(block, count, first) + _little(rows)


def _little(rows: bytes) -> bytes:
    if sys.byteorder == "little":
        return rows
    words = array("q")
    words.frombytes(rows)
    words.byteswap()
    return words.tobytes()


def chunks_in(data: bytes, widths: Mapping[int, int]) -> Iterator[ScopeChunk]:
    """Yield the chunks in `data`; `widths` are the channels of each block. A broken end is left
    out.

    Raises ScopeError for a block that is not there.
    """
    place = 0
    while place + CHUNK.size <= len(data):
        block, count, first = CHUNK.unpack_from(data, place)
        if block not in widths:
            raise ScopeError(f"chunk of block {block}, there are {len(widths)}")
        place += CHUNK.size
        row = WORD * widths[block]
        there = min(count, (len(data) - place) // row) if row else 0
        yield ScopeChunk(block, there, first, _little(data[place : place + there * row]))
        place += count * row


def header_of(data: ScopeData) -> dict[str, Any]:
    """Return the header of a file, which comes before the samples."""
    return {
        "name": data.name,
        "trigger_ns": data.trigger_ns,
        "blocks": [
            {
                "begin_ns": block.begin_ns,
                "step_ns": block.step_ns,
                "channels": [
                    {**channel.document(), "type": type.name}
                    for channel, type in zip(block.channels, block.types, strict=True)
                ],
                "lengths": [None if length == block.count else length for length in block.lengths],
            }
            for block in data.blocks
        ],
    }


class ScopeWriter:
    """A file that grows while a recording goes on. Raises OSError."""

    def __init__(self, path: Path, header: Mapping[str, Any]) -> None:
        self._stream: BinaryIO = path.open("wb")
        text = json.dumps(header).encode()
        self._stream.write(_HEAD.pack(MAGIC, _VERSION, len(text)) + text)

    def write(self, block: int, count: int, first: int, rows: bytes | bytearray) -> None:
        """Add rows of a block."""
        self._stream.write(encode_chunk(block, count, first, bytes(rows)))

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._stream.close()


def write_scope(data: ScopeData, path: Path) -> None:
    """Write a whole recording. Raises OSError."""
    with ScopeWriter(path, header_of(data)) as writer:
        for number, block in enumerate(data.blocks):
            row = WORD * len(block.channels)
            most = max(_PIECE // row, 1) if row else 1
            for first in range(0, block.count, most):
                rows = block.rows[first * row : (first + most) * row]
                writer.write(number, len(rows) // row, first, rows)


def read_scope(path: Path) -> ScopeData:
    """Return the recording in a file. Raises ScopeError, OSError."""
    content = path.read_bytes()
    if len(content) < _HEAD.size or not content.startswith(MAGIC):
        raise ScopeError(f"{path.name}: not a recording in binary form (.scope)")
    _, version, size = _HEAD.unpack_from(content)
    if version != _VERSION or size > _LONGEST_HEADER:
        raise ScopeError(f"{path.name}: expected version {_VERSION}, got {version}")
    try:
        header = json.loads(content[_HEAD.size : _HEAD.size + size])
        return _data(header, content[_HEAD.size + size :])
    except (LookupError, TypeError, ValueError, AttributeError, RecursionError) as fault:
        raise ScopeError(f"{path.name}: its header is broken: {fault}") from None


def _data(header: dict[str, Any], content: bytes) -> ScopeData:
    heads: list[dict[str, Any]] = header["blocks"]
    widths = {number: len(head["channels"]) for number, head in enumerate(heads)}
    rows: dict[int, list[bytes]] = {number: [] for number in widths}
    firsts: dict[int, int] = {}
    for chunk in chunks_in(content, widths):
        firsts.setdefault(chunk.block, chunk.first)
        rows[chunk.block].append(chunk.rows)
    blocks = []
    for number, head in enumerate(heads):
        channels = tuple(channel_of(each) for each in head["channels"])
        whole = b"".join(rows[number])
        count = len(whole) // (WORD * max(len(channels), 1))
        blocks.append(
            ScopeBlock(
                begin_ns=int(head["begin_ns"]),
                step_ns=int(head["step_ns"]),
                channels=channels,
                types=tuple(SCOPE_TYPES[channel.type] for channel in channels),
                lengths=tuple(
                    count if length is None else min(max(int(length), 0), count)
                    for length in head.get("lengths") or [None] * len(channels)
                ),
                rows=whole,
            )
        )
    trigger = header.get("trigger_ns")
    return ScopeData(str(header["name"]), tuple(blocks), None if trigger is None else int(trigger))
