"""Samplers: columns of float64, triggers in the exact row, notifications joined to rows."""

import asyncio
import struct
from collections.abc import AsyncIterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.client import connect
from achse.scope.channel import ScopeChannel
from achse.scope.trigger import TRIGGER_KINDS, ScopeTrigger
from achse.scope.types import SCOPE_TYPES, ScopeType
from achse.station import Station
from achse.web.sampling import (
    KEPT_BYTES,
    SampleRows,
    SharedSampling,
    TriggerWatch,
    columns_of,
    from_notifications,
)

REAL = SCOPE_TYPES["REAL64"]


@st.composite
def tables(draw: st.DrawFn) -> tuple[list[ScopeType], list[list[float]]]:
    """Types, and rows of values that they have."""
    types = draw(st.lists(st.sampled_from(list(SCOPE_TYPES.values())), min_size=1, max_size=4))

    def value(type: ScopeType) -> st.SearchStrategy[float]:
        if type.real:
            return st.floats(allow_nan=False, width=32)
        return st.integers(*type.range)

    return types, draw(st.lists(st.tuples(*map(value, types)).map(list), max_size=6))


@given(tables(), st.integers(0, 2**40), st.integers(1, 10**9), st.integers(0, 2**40))
def test_columns_have_all_values_and_times(
    table: tuple[list[ScopeType], list[list[float]]], begin: int, step: int, zero: int
) -> None:
    types, rows = table
    words = b"".join(
        type.word(value).to_bytes(8, "little", signed=True)
        for row in rows
        for type, value in zip(types, row, strict=True)
    )
    payload = columns_of(SampleRows(begin, len(rows), words, False), step, zero, types)
    numbers = struct.unpack(f"<{(len(types) + 1) * len(rows)}d", payload)
    columns = [numbers[n * len(rows) : (n + 1) * len(rows)] for n in range(len(types) + 1)]
    assert list(columns[0]) == [(begin - zero + n * step) / 1e9 for n in range(len(rows))]
    for number, column in enumerate(columns[1:]):
        assert list(column) == [float(row[number]) for row in rows]


@given(
    kind=st.sampled_from(list(TRIGGER_KINDS)),
    values=st.lists(st.floats(-3, 3), max_size=12),
    low=st.floats(-2, 2),
    wide=st.floats(0, 2),
    cut=st.integers(0, 12),
)
def test_a_trigger_fires_in_its_row_wherever_blocks_end(
    kind: str, values: list[float], low: float, wide: float, cut: int
) -> None:
    bounds = (low,) if TRIGGER_KINDS[kind].bounds == 1 else (low, low + wide)
    watch = TriggerWatch(ScopeTrigger("c", kind, bounds), 0, REAL)
    fired = []
    for start, part in ((0, values[:cut]), (cut, values[cut:])):
        rows = SampleRows(0, len(part), struct.pack(f"<{len(part)}d", *part), False)
        row = watch.first(rows, 1)
        fired += [] if row is None else [start + row]

    def inside(value: float) -> bool:
        high = bounds[-1]
        return {
            "rising": value >= low, "falling": value <= low, "edge": value >= low,
            "above": value > low, "below": value < low,
            "enters": low <= value <= high, "inside": low <= value <= high,
            "leaves": not low <= value <= high, "outside": not low <= value <= high,
        }[kind]  # fmt: skip

    expected = []
    for row, value in enumerate(values):
        before = inside(values[row - 1]) if row else None
        if kind in ("above", "below", "inside", "outside"):
            fires = inside(value)
        elif kind == "edge":
            fires = before is not None and inside(value) != before
        else:
            fires = before is False and inside(value)
        expected += [row] * fires
    first = [row for row in expected if row < cut][:1] + [row for row in expected if row >= cut][:1]
    assert fired == first


class Taken:
    """Keeps what it gets."""

    def __init__(self) -> None:
        self.rows: list[SampleRows] = []
        self.enough: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self.ended: asyncio.Future[Exception | None] = asyncio.get_running_loop().create_future()

    def take(self, sampler: SharedSampling, rows: SampleRows) -> None:
        self.rows.append(rows)
        if sum(each.size for each in self.rows) > 20 and not self.enough.done():
            self.enough.set_result(None)

    def end(self, failure: Exception | None) -> None:
        self.ended.set_result(failure)


async def test_what_is_kept_is_bounded_and_without_gaps() -> None:
    big = bytes(KEPT_BYTES // 4)

    async def source(sampler: SharedSampling) -> AsyncIterator[SampleRows]:
        sampler.known([REAL], 1000, 0)
        for number in range(8):
            yield SampleRows(number * len(big) // 8 * 1000, len(big) // 8, big, number == 2)

    sampler = SharedSampling([ScopeChannel("c", symbol="c")], 1e-6, zero_ns=lambda time: 0)
    taken = Taken()
    sampler.takers[taken] = None
    await sampler.open(source)
    assert await taken.ended is None
    assert len(taken.rows) == 8
    [block] = sampler.data("x").blocks
    assert KEPT_BYTES // 2 < len(block.rows) <= KEPT_BYTES
    assert sampler.over
    await sampler.close()


async def test_a_target_without_scopes_is_sampled_by_notifications() -> None:
    station = Station.demo()
    channels = [
        ScopeChannel("MAIN.nCounter", symbol="MAIN.nCounter", port=851),
        ScopeChannel("500:Axes.X.ActPos", symbol="Axes.X.ActPos", port=500),
    ]
    async with connect(station.router, port=851, keep_alive=None) as client:
        sampler = SharedSampling(channels, 0.01, zero_ns=lambda time: 0)
        sampler.poll = 0.0
        taken = Taken()
        sampler.takers[taken] = None

        async def pass_time() -> None:
            while True:
                station.advance(0.01)
                await asyncio.sleep(0)

        time = asyncio.create_task(pass_time())
        try:
            await sampler.open(from_notifications(client))
            await taken.enough
        finally:
            time.cancel()
            await sampler.close()
        counts = [row[0] for each in taken.rows for row in struct.iter_unpack("<2d", each.rows)]
        assert counts == sorted(set(counts))
        begins = [each.begin_ns for each in taken.rows]
        assert begins == sorted(begins)
        text = ScopeChannel("t", symbol="GVL.sString", port=851)
        wrong = SharedSampling([text], 0.01, zero_ns=lambda time: 0)
        with pytest.raises(ValueError, match="expected a number"):
            await wrong.open(from_notifications(client))
