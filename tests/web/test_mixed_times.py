"""Recordings with several sample times on one time column."""

import math
import struct

from hypothesis import given
from hypothesis import strategies as st

from achse.scope.channel import channel_of
from achse.scope.data import ScopeBlock
from achse.scope.types import SCOPE_TYPES
from achse.web.mixed_times import channels_of, rows_of

REAL, WHOLE = SCOPE_TYPES["REAL64"], SCOPE_TYPES["INT16"]


def block(begin: int, step: int, values: list[float], whole: bool) -> ScopeBlock:
    words = [
        struct.pack("<hxxxxxx", int(each)) if whole else struct.pack("<d", each) for each in values
    ]
    channel = channel_of("MAIN.a", "channels")
    type = WHOLE if whole else REAL
    return ScopeBlock(begin, step, (channel,), (type,), (len(values),), b"".join(words))


BLOCKS = st.lists(
    st.builds(
        block,
        st.integers(0, 50),
        st.integers(1, 20),
        st.lists(st.integers(-1000, 1000).map(float), max_size=30),
        st.booleans(),
    ),
    min_size=1,
    max_size=4,
)


@given(BLOCKS, st.integers(0, 10), st.integers(1, 40))
def test_every_sample_is_there_once_at_its_time(
    blocks: list[ScopeBlock], zero: int, most: int
) -> None:
    assert len(channels_of(blocks)) == len(blocks)
    times: list[float] = []
    columns: list[list[float]] = [[] for _ in blocks]
    for part in rows_of(blocks, zero, most):
        assert 0 < part.size <= most
        values = memoryview(part.columns).cast("d").tolist()
        assert len(values) == part.size * (len(blocks) + 1)
        times += values[: part.size]
        for number, column in enumerate(columns, 1):
            column += values[number * part.size : (number + 1) * part.size]
    assert times == sorted(set(times))
    for each, column in zip(blocks, columns, strict=True):
        shown = [(time, value) for time, value in zip(times, column, strict=True) if value == value]
        assert shown == [
            ((each.begin_ns + row * each.step_ns - zero) / 1e9, value)
            for row, value in enumerate(wanted(each))
        ]


def wanted(each: ScopeBlock) -> list[float]:
    form = "<h" if each.types[0] is WHOLE else "<d"
    return [float(struct.unpack_from(form, each.rows, 8 * row)[0]) for row in range(each.count)]


def test_a_channel_that_ended_before_has_nothing_there() -> None:
    whole = block(0, 1, [1.0, 2.0, 3.0], False)
    short = ScopeBlock(0, 1, whole.channels, whole.types, (2,), whole.rows)
    [part] = rows_of([short], 0, 10)
    values = memoryview(part.columns).cast("d").tolist()
    assert values[3:5] == [1.0, 2.0]
    assert math.isnan(values[5])
