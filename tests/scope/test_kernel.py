"""Sampling: machine code and plain Python take the same words and fire at the same samples."""

from array import array
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.native.backend import compiler_installed
from achse.native.declare import plain_record
from achse.scope.kernel import KERNEL, SAMPLED, WATCHED, take_sample
from achse.scope.trigger import TRIGGER_KINDS, ScopeTrigger
from achse.scope.types import SCOPE_TYPES

TYPES = sorted(SCOPE_TYPES)
WORDS = st.integers(-(1 << 63), (1 << 63) - 1) | st.integers(-2, 2)


@st.composite
def channels(draw: st.DrawFn) -> list[tuple[str, int]]:
    """Types, and bytes at which they are."""
    return draw(
        st.lists(st.tuples(st.sampled_from(TYPES), st.integers(0, 24)), min_size=1, max_size=6)
    )


@settings(max_examples=60, deadline=None)
@given(channels(), st.lists(st.lists(WORDS, min_size=4, max_size=4), max_size=4), st.data())
def test_both_take_the_same(
    placed: list[tuple[str, int]], moments: list[list[int]], data: st.DataObject
) -> None:
    if not compiler_installed():
        pytest.skip("no compiler")
    table, watched = array("q"), array("q")
    plain_channels, plain_triggers = [], []
    for name, offset in placed:
        type = SCOPE_TYPES[name]
        record: Any = plain_record(SAMPLED)()
        spills = offset % 8 + type.size > 8
        record.place, record.shift = offset // 8, 8 * (offset % 8)
        record.spills, record.mask = int(spills), type.mask
        plain_channels.append(record)
        table.extend((record.place, record.shift, record.spills, record.mask))
    for _ in range(data.draw(st.integers(0, 3))):
        number = data.draw(st.integers(0, len(placed) - 1))
        type = SCOPE_TYPES[placed[number][0]]
        kind = data.draw(st.sampled_from(sorted(TRIGGER_KINDS)))
        bounds = sorted(data.draw(st.floats(-1e6, 1e6)) for _ in range(TRIGGER_KINDS[kind].bounds))
        band = ScopeTrigger("a", kind, tuple(bounds)).band(type)
        form = (number, type.sign, type.flip, type.turn, *type.keys)
        values = (*form, band.low, band.high, band.inverted, band.event, -1)
        trigger: Any = plain_record(WATCHED)()
        for field, value in zip(WATCHED.fields, values, strict=True):
            setattr(trigger, field, value)
        plain_triggers.append(trigger)
        watched.extend(map(int, values))
    n = len(placed)
    plain_ring, machine_ring = array("q", bytes(16 * n)), array("q", bytes(16 * n))
    for moment, words in enumerate(moments):
        memory = array("q", [*words, 0])
        row = moment % 2
        fired = take_sample(memory, plain_channels, plain_ring, plain_triggers, row)
        also = KERNEL.function(
            *memory.buffer_info(),
            *(table.buffer_info()[0], n),
            *machine_ring.buffer_info(),
            *(watched.buffer_info()[0], len(plain_triggers)),
            row,
        )
        assert (fired, plain_ring) == (also, machine_ring)
        content = memory.tobytes()
        for (name, offset), word in zip(placed, plain_ring[row * n : row * n + n], strict=True):
            size = SCOPE_TYPES[name].size
            expected = int.from_bytes(content[offset : offset + size], "little")
            assert word & (1 << 64) - 1 == expected & (1 if name == "BIT" else -1)
