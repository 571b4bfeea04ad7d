"""Parts of a request: one part, or the parts of a sum command with the outcome of each."""

import struct
from collections.abc import Sequence

from achse.ams import Command, DecodeError, Frame
from achse.ams.commands import (
    AddNotificationRequest,
    DeleteNotificationRequest,
    ReadRequest,
    ReadWriteRequest,
    WriteRequest,
    decode_request,
)
from achse.client.session.sums import Outcome, Part, outcome, unpack
from achse.codes import ReservedGroup
from achse.codes.groups import SUMS

_READ = struct.Struct("<III")
_READ_WRITE = struct.Struct("<IIII")
_PLACED = (
    ReadRequest,
    WriteRequest,
    ReadWriteRequest,
    AddNotificationRequest,
    DeleteNotificationRequest,
)


def parts_of(request: Frame) -> list[Part]:
    """Return the parts of a request with a place, those of a sum one by one; raises DecodeError.

    Other commands, such as Read State, have none.
    """
    decoded = decode_request(request)
    if not isinstance(decoded, _PLACED):
        return []
    if isinstance(decoded, ReadWriteRequest) and decoded.index_group in SUMS:
        try:
            return _split(decoded)
        except struct.error as failure:
            raise DecodeError(f"a sum ends inside a part: {failure}") from None
    return [decoded]


def _split(request: ReadWriteRequest) -> list[Part]:
    group, count, _, data = request
    if group in (
        ReservedGroup.SUM_READ,
        ReservedGroup.SUM_READ_WITH_LENGTHS,
        ReservedGroup.SUM_READ_SHORT,
    ):
        return [ReadRequest(*_READ.unpack_from(data, 12 * i)) for i in range(count)]
    if group in (ReservedGroup.SUM_WRITE, ReservedGroup.SUM_READ_WRITE):
        layout = _READ if group == ReservedGroup.SUM_WRITE else _READ_WRITE
        position = layout.size * count
        parts: list[Part] = []
        for i in range(count):
            group_of_part, offset, *read_length, length = layout.unpack_from(data, layout.size * i)
            content = data[position : position + length]
            position += length
            if read_length:
                parts.append(ReadWriteRequest(group_of_part, offset, read_length[0], content))
            else:
                parts.append(WriteRequest(group_of_part, offset, content))
        return parts
    if group == ReservedGroup.SUM_ADD_NOTIFICATION:
        return [AddNotificationRequest.decode(data[40 * i : 40 * i + 40]) for i in range(count)]
    return [DeleteNotificationRequest.decode(data[4 * i : 4 * i + 4]) for i in range(count)]


def outcomes_of(request: Frame, parts: Sequence[Part], response: Frame) -> list[Outcome]:
    """Return the outcome of each part; an error of the whole request is that of each."""
    if response.error:
        return [Outcome(response.error, b"")] * len(parts)
    whole = outcome(response)
    if whole.result:
        return [Outcome(whole.result, b"")] * len(parts)
    group = int.from_bytes(request.data[:4], "little")
    if request.command != Command.READ_WRITE or group not in SUMS:
        return [whole] * len(parts)
    if not parts:
        return []
    if group in (ReservedGroup.SUM_READ_WITH_LENGTHS, ReservedGroup.SUM_READ_SHORT):
        return _results_with_lengths(len(parts), whole.data)
    return unpack(parts, whole.data)


def _results_with_lengths(count: int, data: bytes) -> list[Outcome]:
    """Answers of the extended sum reads: all pairs of result and length, then the data."""
    outcomes, position = [], 8 * count
    if len(data) < position:
        raise DecodeError(f"a sum of {count} parts has {position} bytes or more, got {len(data)}")
    for result, length in struct.iter_unpack("<II", data[:position]):
        outcomes.append(Outcome(result, data[position : position + length]))
        position += length
    return outcomes
