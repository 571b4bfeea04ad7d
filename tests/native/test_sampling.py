"""Changed values: plain and machine code find the same, and a sampler sends just these."""

import struct
from array import array
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.native.declare import Slot, lay_out, plain_record
from achse.native.memory import Rows, RowView
from achse.native.sampling import LAYOUT, SampledValue, Sampler, is_fixed, write_changed

WORDS = st.integers(-(1 << 63), (1 << 63) - 1) | st.integers(-2, 2)
SIZES = st.lists(st.integers(0, 20), min_size=1, max_size=8)


def table(sizes: list[int]) -> list[Any]:
    """Values of these sizes, one behind the other in whole words, as plain records."""
    record, values, place = plain_record(LAYOUT), [], 0
    for number, size in enumerate(sizes):
        value = record()
        value.place, value.size, value.header = place, size, number | size << 32
        value.mask = (1 << 8 * (size % 8)) - 1 or -1
        values.append(value)
        place += size + 7 >> 3
    return values


@given(SIZES, st.data())
def test_what_changed_is_written_with_its_header(sizes: list[int], data: st.DataObject) -> None:
    values = table(sizes)
    count = sum(size + 7 >> 3 for size in sizes)
    changes = data.draw(
        st.lists(st.sampled_from([0, 1, 1 << 20, (1 << 63) - 1]), min_size=count, max_size=count)
    )
    before = data.draw(st.lists(WORDS, min_size=count, max_size=count))
    after = [word ^ change for word, change in zip(before, changes, strict=True)]
    last, stream = [0] * count, bytearray(8 * len(sizes) + 8 * count)
    write_changed(before, values, last, stream)
    taken = write_changed(after, values, last, stream)
    sent = []
    for value in values:
        first = 8 * value.place
        old, new = (
            struct.pack(f"={count}q", *words)[first : first + value.size]
            for words in (before, after)
        )
        if old != new:
            sent.append(struct.pack("=q", value.header) + new)
    assert divmod(taken, 1 << 32) == (len(sent), len(b"".join(sent)))
    assert stream.startswith(b"".join(sent))
    assert write_changed(after, values, last, stream) == 0


@given(SIZES, st.data())
def test_machine_code_does_the_same(
    compiled: Callable[..., Any], sizes: list[int], data: st.DataObject
) -> None:
    values = table(sizes)
    count = sum(size + 7 >> 3 for size in sizes)
    words = st.lists(WORDS, min_size=count, max_size=count)
    memory, last = data.draw(words), data.draw(words)
    packed = array("q")
    for value in values:
        packed.extend((value.place, value.size, value.mask, value.header))
    machine_memory, machine_last = array("q", memory), array("q", last)
    stream = bytearray(8 * len(sizes) + 8 * count)
    machine_stream = array("q", bytes(stream))
    function = compiled(write_changed, {SampledValue: LAYOUT})
    taken = function(
        *machine_memory.buffer_info(),
        *(packed.buffer_info()[0], len(values)),
        *machine_last.buffer_info(),
        *(machine_stream.buffer_info()[0], len(stream)),
    )
    assert taken == write_changed(memory, values, last, stream)
    assert machine_last.tolist() == last
    assert machine_stream.tobytes() == stream


class Record:
    first: float = 0.0
    second: int = 0
    third: int = 0


FIELDS = lay_out("Record", [Record], Slot)


def test_a_sampler_gives_what_changed_of_places_and_of_readers_that_it_calls() -> None:
    pytest.importorskip("llvmlite")
    view = RowView(Rows(FIELDS, 2), 1)
    called: list[bytes | None] = [b"abc"]
    both = view.place(FIELDS.fields["first"], 16)
    low = view.place(FIELDS.fields["third"], 2)
    readers: list[Any] = [both, lambda: called[0], low]
    assert [is_fixed(read) for read in readers] == [True, False, True]
    sampler = Sampler(
        readers, [b"header_1", b"header_2", b"header_3"], [bytes(16), b"abc", b"\0\0"]
    )
    assert sampler.sample() == (0, b"")
    view.ints[1] = 5
    view.ints[2] = 1 << 16  # beyond what is asked for
    assert sampler.sample() == (1, b"header_1" + bytes(8) + struct.pack("<q", 5))
    called[0] = b"abd"
    view.ints[2] = -1
    assert sampler.sample() == (2, b"header_2abdheader_3\xff\xff")
    assert sampler.last == (struct.pack("<qq", 0, 5), b"abd", b"\xff\xff")
    called[0] = None
    assert sampler.sample() is None
