"""Recordings whose channels have different sample times, as rows on one time column."""

from array import array
from collections.abc import Iterator, Sequence
from heapq import merge
from typing import NamedTuple

from achse.scope.channel import ScopeChannel
from achse.scope.data import ScopeBlock
from achse.scope.types import WORD, ScopeType

_NAN = float("nan")


class MixedRows(NamedTuple):
    """Rows that follow each other: the time column, then each channel, as float64."""

    size: int
    columns: bytes


def channels_of(blocks: Sequence[ScopeBlock]) -> list[tuple[ScopeChannel, ScopeType, int]]:
    """Return the channels of all blocks with type and sample time in ns, in the order of their
    columns."""
    return [
        (channel, type, block.step_ns)
        for block in blocks
        for channel, type in zip(block.channels, block.types, strict=True)
    ]


def rows_of(blocks: Sequence[ScopeBlock], zero_ns: int, most: int) -> Iterator[MixedRows]:
    """Rows at every time at which a block has one, up to `most` at once; NaN where it has none.

    Times count in seconds from `zero_ns`.
    """
    next_rows = [0] * len(blocks)
    times: list[int] = []
    for time in merge(*(_times(block) for block in blocks)):
        if times and time == times[-1]:
            continue
        if len(times) == most:
            yield _rows(blocks, next_rows, times, zero_ns)
            times = []
        times.append(time)
    if times:
        yield _rows(blocks, next_rows, times, zero_ns)


def _times(block: ScopeBlock) -> range:
    return range(
        block.begin_ns, block.begin_ns + block.count * block.step_ns, max(block.step_ns, 1)
    )


def _rows(
    blocks: Sequence[ScopeBlock], next_rows: list[int], times: list[int], zero_ns: int
) -> MixedRows:
    """Return the columns at these times; `next_rows` are those with which the blocks go on."""
    places = {time: place for place, time in enumerate(times)}
    parts = [array("d", [(time - zero_ns) / 1e9 for time in times]).tobytes()]
    for number, block in enumerate(blocks):
        first = next_rows[number]
        covered = (times[-1] - block.begin_ns) // block.step_ns + 1
        last = next_rows[number] = max(min(block.count, covered), first)
        at = [places[block.begin_ns + row * block.step_ns] for row in range(first, last)]
        width = len(block.channels)
        words = block.words[first * width : last * width]
        for channel, type in enumerate(block.types):
            column = array("d", [_NAN]) * len(times)
            values = memoryview(words[channel::width].tobytes()).cast(type.code)  # type: ignore[call-overload]
            count = max(min(block.lengths[channel] - first, last - first), 0)
            for place, value in zip(at[:count], values[:: WORD // type.size], strict=False):
                column[place] = value
            parts.append(column.tobytes())
    return MixedRows(len(times), b"".join(parts))
