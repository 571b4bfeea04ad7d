"""Frames by machine code are those that a channel makes of the same samples."""

import struct
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams.filetime import from_unix_ns
from achse.native.declare import Slot, lay_out, plain_record
from achse.native.memory import MemoryCell, Rows, RowView
from achse.native.sampling import LAYOUT, Sampler
from achse.server.frame_stream import (
    HEAD_SIZE,
    STATE,
    FrameStream,
    write_frame,
)
from achse.server.subscriptions import Batch, Channel

CLIENT, SERVER = bytes(range(8)), bytes(range(8, 16))


class Words:
    first: int = 0
    second: int = 0
    third: int = 0


WORDS = lay_out("Words", [Words], Slot)
CHANGES = st.lists(
    st.lists(st.sampled_from([0, 0, 1, -(1 << 62)]), min_size=3, max_size=3), max_size=12
)
SIZES = st.tuples(*[st.integers(1, 8)] * 3)
TIMES = st.tuples(st.integers(0, 1 << 61), st.integers(1, 1 << 40))


def expected(
    sizes: tuple[int, ...], changes: list[list[int]], begin_ns: int, cycle_ns: int
) -> list[bytes]:
    """Return the frame of each moment with changes, as a channel makes it."""
    channel = Channel(CLIENT, SERVER, None)
    batch, now, frames = Batch(channel, 0), [bytes(8)] * 3, []
    words = [0, 0, 0]
    for n, change in enumerate(changes):
        words = [word ^ bits for word, bits in zip(words, change, strict=True)]
        before, now = now, [struct.pack("<q", word) for word in words]
        for handle, (size, old, new) in enumerate(zip(sizes, before, now, strict=True)):
            if old[:size] != new[:size]:
                batch.take(struct.pack("<II", handle, size), new[:size])
        if batch.count:
            batch.close_stamp(from_unix_ns(begin_ns + n * cycle_ns), 1 << 18)
            batch.release()
            frame = channel.frame(1 << 18)
            assert frame is not None
            frames.append(frame.encode_tcp())
    return frames


def sampled(sizes: tuple[int, ...]) -> tuple[RowView, Sampler]:
    """Return three words of memory and their sampler."""
    view = RowView(Rows(WORDS, 1), 0)
    cells = [
        view.place(slot, size) for slot, size in zip(WORDS.fields.values(), sizes, strict=True)
    ]
    headers = [struct.pack("<II", handle, size) for handle, size in enumerate(sizes)]
    assert all(isinstance(cell, MemoryCell) for cell in cells)
    readers: list[Any] = cells
    return view, Sampler(readers, headers, [bytes(size) for size in sizes])


@given(SIZES, CHANGES, TIMES, st.integers(1, 5))
def test_frames_are_those_of_a_channel(
    sizes: tuple[int, ...], changes: list[list[int]], times: tuple[int, int], frames: int
) -> None:
    pytest.importorskip("llvmlite")
    view, sampler = sampled(sizes)
    stream = FrameStream(sampler, CLIENT, SERVER)
    assert stream.largest == HEAD_SIZE + sum(8 + size + -size % 8 for size in sizes)
    room = frames * stream.largest
    began_ns, cycle_ns = times
    stream.begin(began_ns, cycle_ns, room)
    packets = []
    for n, change in enumerate(changes, 1):
        for word, bits in enumerate(change):
            view.ints[word] ^= bits
        is_full = stream.write()
        assert is_full == (len(stream.take()) + stream.largest > room)
        if is_full:
            packets.append(stream.take())
            stream.begin(began_ns + n * cycle_ns, cycle_ns, room)
    packets.append(stream.take())
    assert b"".join(packets) == b"".join(expected(sizes, changes, began_ns, cycle_ns))


@given(CHANGES, TIMES)
def test_plain_and_machine_code_write_the_same(
    changes: list[list[int]], times: tuple[int, int]
) -> None:
    pytest.importorskip("llvmlite")
    sizes = (8, 2, 5)
    value, state = plain_record(LAYOUT), plain_record(STATE)()
    values = []
    for n, size in enumerate(sizes):
        values.append(value())
        values[n].place, values[n].size, values[n].header = n, size, n | size << 32
        values[n].mask = (1 << 8 * (size % 8)) - 1 or -1
    state.largest, (state.unix_ns, state.cycle_ns) = 100, times
    state.limit = 1 << 14
    view, sampler = sampled(sizes)
    stream = FrameStream(sampler, CLIENT, SERVER)
    stream.begin(*times, 1 << 14)
    head = list(stream._head)
    last, content = [0, 0, 0], bytearray(1 << 14)
    for change in changes:
        for word, bits in enumerate(change):
            view.ints[word] ^= bits
        write_frame(list(view.ints), values, last, content, head, [state])
        stream.write()
    assert bytes(content[: state.end]) == stream.take()
