"""Sum commands: many requests of one kind as one Read Write (003 0xF080..0xF086).

The parts are ordinary requests, and each part's outcome is `(result, data)`, whether it travelled
in a sum or alone: `outcome` reads the answer of one sent alone. Layouts as real clients and
targets use them; 003 prints shorter ones for 0xF085.
"""

import struct
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple, TypeVar

from achse.ams import Command, DecodeError, Frame
from achse.ams.commands import (
    AddNotificationRequest,
    AddNotificationResponse,
    DataResponse,
    DeleteNotificationRequest,
    ReadRequest,
    ReadWriteRequest,
    WriteRequest,
    decode_response,
)
from achse.codes import ReservedGroup

MAX_PARTS = 500
"""The limit the manuals give (003)."""

MAX_BYTES = 0x4_0000
"""A sum is split before its data, either way, outgrows this; router memory is small."""

Part = (
    ReadRequest
    | WriteRequest
    | ReadWriteRequest
    | AddNotificationRequest
    | DeleteNotificationRequest
)
P = TypeVar("P", bound=Part)


class Outcome(NamedTuple):
    """Result code of one part and its data: what was read, or the notification handle."""

    result: int
    data: bytes


_PART = struct.Struct("<III")
_READ_WRITE_PART = struct.Struct("<IIII")
_RESULT = struct.Struct("<I")
_PAIR = struct.Struct("<II")


class _Sum(NamedTuple):
    """One sum command: its group, the command of a part sent alone, and its layout."""

    group: int
    command: Command
    pack: "Callable[[Sequence[Part]], bytes]"
    answer_size: "Callable[[Sequence[Part]], int]"
    unpack: "Callable[[Sequence[Part], bytes], list[Outcome]]"


def _pack_reads(parts: Sequence[Part]) -> bytes:
    return b"".join([part.encode() for part in parts])


def _pack_writes(parts: Sequence[Part]) -> bytes:
    heads = []
    datas = []
    for part in parts:
        assert isinstance(part, WriteRequest)
        heads.append(_PART.pack(part.index_group, part.index_offset, len(part.data)))
        datas.append(part.data)
    return b"".join(heads + datas)


def _pack_read_writes(parts: Sequence[Part]) -> bytes:
    heads = []
    datas = []
    for part in parts:
        assert isinstance(part, ReadWriteRequest)
        heads.append(
            _READ_WRITE_PART.pack(
                part.index_group, part.index_offset, part.read_length, len(part.data)
            )
        )
        datas.append(part.data)
    return b"".join(heads + datas)


def _read_length(part: Part) -> int:
    match part:
        case ReadRequest(length=length) | ReadWriteRequest(read_length=length):
            return length
        case _:
            return 0


def _results_and_reads(parts: Sequence[Part]) -> int:
    return 4 * len(parts) + sum(map(_read_length, parts))


def _pairs_and_reads(parts: Sequence[Part]) -> int:
    return min(8 * len(parts) + sum(map(_read_length, parts)), 0xFFFF_FFFF)


def _unpack_reads(parts: Sequence[Part], data: bytes) -> list[Outcome]:
    count = len(parts)
    if len(data) < 4 * count:
        raise DecodeError(f"a sum of {count} reads has at least {4 * count} bytes, got {len(data)}")
    results = struct.unpack_from(f"<{count}I", data)
    lengths = [_read_length(part) for part in parts]
    missing = 4 * count + sum(lengths) - len(data)
    if missing:
        # Some targets leave out the data of failed parts instead of filling it with zeros.
        lengths = [0 if result else n for result, n in zip(results, lengths, strict=True)]
        if 4 * count + sum(lengths) != len(data):
            raise DecodeError(
                f"a sum of {count} reads has {len(data) + missing} bytes, got {len(data)}"
            )
    outcomes = []
    position = 4 * count
    for result, length in zip(results, lengths, strict=True):
        outcomes.append(Outcome(result, b"" if result else data[position : position + length]))
        position += length
    return outcomes


def _unpack_results(parts: Sequence[Part], data: bytes) -> list[Outcome]:
    if len(data) != 4 * len(parts):
        raise DecodeError(f"{len(parts)} results have {4 * len(parts)} bytes, got {len(data)}")
    return [Outcome(result, b"") for (result,) in _RESULT.iter_unpack(data)]


def _unpack_read_writes(parts: Sequence[Part], data: bytes) -> list[Outcome]:
    count = len(parts)
    if len(data) < 8 * count:
        raise DecodeError(f"a sum of {count} parts has at least {8 * count} bytes, got {len(data)}")
    outcomes = []
    position = 8 * count
    for result, length in _PAIR.iter_unpack(data[:position]):
        outcomes.append(Outcome(result, data[position : position + length]))
        position += length
    if position != len(data):
        raise DecodeError(f"a sum of {count} parts announces {position} bytes, got {len(data)}")
    return outcomes


def _unpack_handles(parts: Sequence[Part], data: bytes) -> list[Outcome]:
    if len(data) != 8 * len(parts):
        raise DecodeError(f"{len(parts)} handles have {8 * len(parts)} bytes, got {len(data)}")
    return [Outcome(result, _RESULT.pack(handle)) for result, handle in _PAIR.iter_unpack(data)]


_SUMS: dict[type[Part], _Sum] = {
    ReadRequest: _Sum(
        ReservedGroup.SUM_READ, Command.READ, _pack_reads, _results_and_reads, _unpack_reads
    ),
    WriteRequest: _Sum(
        ReservedGroup.SUM_WRITE, Command.WRITE, _pack_writes, _results_and_reads, _unpack_results
    ),
    ReadWriteRequest: _Sum(
        ReservedGroup.SUM_READ_WRITE,
        Command.READ_WRITE,
        _pack_read_writes,
        _pairs_and_reads,
        _unpack_read_writes,
    ),
    AddNotificationRequest: _Sum(
        ReservedGroup.SUM_ADD_NOTIFICATION,
        Command.ADD_NOTIFICATION,
        _pack_reads,
        _pairs_and_reads,
        _unpack_handles,
    ),
    DeleteNotificationRequest: _Sum(
        ReservedGroup.SUM_DELETE_NOTIFICATION,
        Command.DELETE_NOTIFICATION,
        _pack_reads,
        _results_and_reads,
        _unpack_results,
    ),
}


def command_of(part: Part) -> Command:
    """Return the ADS command that carries `part` alone."""
    return _SUMS[type(part)].command


def sum_of(parts: Sequence[Part]) -> ReadWriteRequest:
    """One Read Write that carries `parts`, at least one, all of one kind."""
    kind = _SUMS[type(parts[0])]
    return ReadWriteRequest(kind.group, len(parts), kind.answer_size(parts), kind.pack(parts))


def unpack(parts: Sequence[Part], data: bytes) -> list[Outcome]:
    """Return the outcome of each part in the answer `data` to `sum_of(parts)`.

    Raises `DecodeError` if the answer does not fit the parts.
    """
    return _SUMS[type(parts[0])].unpack(parts, data)


def outcome(frame: Frame) -> Outcome:
    """Return the outcome in the response `frame` to a part sent alone.

    Some old targets answer an error with the result only, whatever the command.
    """
    if len(frame.data) == 4 and any(frame.data):
        return Outcome(_RESULT.unpack(frame.data)[0], b"")
    response = decode_response(frame)
    match response:
        case DataResponse(result, data):
            return Outcome(result, data)
        case AddNotificationResponse(result, handle):
            return Outcome(result, _RESULT.pack(handle))
        case _:
            return Outcome(response.result, b"")


def batches(parts: Sequence[P], most: int = MAX_BYTES) -> Iterator[Sequence[P]]:
    """`parts` in order, cut so that each piece keeps to `MAX_PARTS` and `most` bytes.

    Where less than MAX_BYTES can go, a Read Write goes alone: the length of its answer is unknown.
    """
    start = size = 0
    for index, part in enumerate(parts):
        match part:
            case ReadRequest(length=length):
                weight = 12 + length
            case WriteRequest(data=data) | ReadWriteRequest(data=data):
                weight = 16 + len(data)  # a Read Write asks for far more than it gets
                if most < MAX_BYTES and isinstance(part, ReadWriteRequest):
                    weight = most
            case _:
                weight = 40
        if index > start and (index - start == MAX_PARTS or size + weight > most):
            yield parts[start:index]
            start, size = index, 0
        size += weight
    if start < len(parts):
        yield parts[start:]
