"""The scope in the browser: blocks, triggers, recordings, exports."""

import asyncio
import itertools
import struct
from collections.abc import Callable
from contextlib import AsyncExitStack
from dataclasses import replace
from typing import Any

import pytest

from achse.scope.channel import ScopeChannel
from achse.web.sampling import SampleRows, columns_of
from achse.web.send_queue import BLOCK_HEADER, BlockFlag
from tests.web.conftest import OpenPage

Shows = Callable[..., Any]

POSITION, COUNTER = "500:Axes.X.ActPos", "MAIN.nCounter"


class Block:
    """A binary message, decoded."""

    def __init__(self, data: bytes) -> None:
        _, self.flags, self.scope, columns, rows, self.dropped = BLOCK_HEADER.unpack_from(data)
        numbers = struct.unpack_from(f"<{columns * rows}d", data, BLOCK_HEADER.size)
        self.columns = [numbers[n * rows : (n + 1) * rows] for n in range(columns)]
        self.rows = rows


async def read_blocks(page: Any, scope: int, count: int) -> list[Block]:
    """Blocks until there are so many rows, or the end."""
    blocks: list[Block] = []
    while sum(each.rows for each in blocks) < count:
        block = Block(await page.until(lambda each: isinstance(each, bytes)))
        if block.scope == scope:
            blocks.append(block)
            if block.flags & BlockFlag.END:
                break
    return blocks


async def test_rows_come_in_every_cycle(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        started = await page.done("scope.start", channels=[POSITION, COUNTER], cycle=0.002)
        assert started["cycle"] == 0.002
        assert started["channels"] == [
            {"name": POSITION, "unit": "mm", "type": "REAL64"},
            {"name": COUNTER, "unit": "", "type": "UINT32"},
        ]
        blocks = await read_blocks(page, started["scope"], 500)
        times = [time for each in blocks for time in each.columns[0]]
        counts = [count for each in blocks for count in each.columns[2]]
        assert [round((b - a) * 1000) for a, b in itertools.pairwise(times)] == [2] * (
            len(times) - 1
        )
        assert {b - a for a, b in itertools.pairwise(counts)} <= {0.0, 1.0}
        await page.done("scope.stop", scope=started["scope"])
        assert it.server.handlers.scopes.samplers == 0
        assert "no scope" in (await page.refused("scope.stop", scope=started["scope"]))["text"]


async def test_pages_with_the_same_wish_share_a_sampler(shown: Shows) -> None:
    async with shown() as it, it.page() as first:
        one = await first.done("scope.start", channels=[COUNTER], cycle=0.001)
        assert one["cycle"] == 0.002, "whole ticks of the station"
        async with it.page() as second:
            other = await second.done("scope.start", channels=[COUNTER], cycle=0.002)
            assert it.server.handlers.scopes.samplers == 1
            assert other["time_zero"] == one["time_zero"] > 0
            await read_blocks(second, other["scope"], 10)
            await first.done("scope.start", channels=[COUNTER, POSITION], cycle=0.002)
            assert it.server.handlers.scopes.samplers == 2
        await read_blocks(first, one["scope"], 10)
    assert it.server.handlers.scopes.samplers == 0


async def test_pages_that_begin_at_once_share_a_sampler_and_its_encoding(
    shown: Shows, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As after a restart of the station, when all pages come back together."""
    encoded: list[SampleRows] = []

    def counted(rows: SampleRows, *arguments: Any) -> bytes:
        encoded.append(rows)
        return columns_of(rows, *arguments)

    monkeypatch.setattr("achse.web.sampling.columns_of", counted)
    async with shown() as it, AsyncExitStack() as stack:
        pages = [await stack.enter_async_context(it.page()) for _ in range(10)]
        started = await asyncio.gather(
            *(page.done("scope.start", channels=[COUNTER], cycle=0.002) for page in pages)
        )
        assert it.server.handlers.scopes.samplers == 1
        blocks = [
            await read_blocks(page, one["scope"], 100)
            for page, one in zip(pages, started, strict=True)
        ]
        for each in blocks:
            counts = [count for block in each for count in block.columns[1]]
            assert {b - a for a, b in itertools.pairwise(counts)} <= {0.0, 1.0}
        assert len(encoded) == len({id(rows) for rows in encoded})
    assert it.server.handlers.scopes.samplers == 0


async def test_blocks_go_to_one_page_in_each_turn_of_the_loop(shown: Shows) -> None:
    """A station's cycle waits for the block of one page at most, not for those of all."""
    turn = 0
    sent: list[int] = []
    enough = asyncio.Event()

    async def count() -> None:
        nonlocal turn
        while True:
            turn += 1
            await asyncio.sleep(0)

    class Counting(OpenPage):
        async def send(self, message: str | bytes) -> None:
            if isinstance(message, bytes):
                sent.append(turn)
                if len(sent) >= 200:
                    enough.set()
            await super().send(message)

    async with shown() as it, AsyncExitStack() as stack:
        counting = asyncio.create_task(count())
        pages = [await stack.enter_async_context(it.page(Counting())) for _ in range(10)]
        for page in pages:
            await page.done("scope.start", channels=[COUNTER], cycle=0.002)
        sent.clear()
        enough.clear()
        await enough.wait()
        seen = list(sent)
        counting.cancel()
    assert len(set(seen)) == len(seen)


async def test_the_row_of_the_trigger_begins_a_block(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        trigger = {"channel": COUNTER, "kind": "rising", "level": 200, "pretrigger": 0.5}
        started = await page.done("scope.start", channels=[COUNTER], cycle=0.002, trigger=trigger)
        before = 0.0
        while True:
            [*_, block] = await read_blocks(page, started["scope"], 1)
            if block.flags & BlockFlag.TRIGGER:
                assert before < 200 <= block.columns[1][0]
                break
            before = block.columns[1][-1]


async def test_a_slow_page_gets_gaps_and_holds_nothing_up(shown: Shows) -> None:
    async with shown() as it, it.page() as slow, it.page() as good:
        started = await slow.done("scope.start", channels=[COUNTER], cycle=0.002)
        [viewer] = [each for each in it.server.open_pages if each.scopes]
        slow.reads.clear()
        payload = bytes(1 << 20)
        for _ in range(20):
            viewer.send_queue.put_block(started["scope"], payload, 2, 1 << 16)
        assert viewer.send_queue.buffered_bytes <= 5 << 20
        assert await good.done("hello")
        slow.reads.set()
        dropped: list[Block] = []
        while not dropped or not dropped[-1].dropped:
            dropped += await read_blocks(slow, started["scope"], 1)
        assert any(each.flags & BlockFlag.GAP for each in dropped)


async def test_a_recording_is_kept_loaded_and_exported(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        started = await page.done("scope.start", channels=[COUNTER], cycle=0.002, record=True)
        await read_blocks(page, started["scope"], 300)
        path = await page.done("scope.export", scope=started["scope"], format="csv")
        name, data = it.server.handlers.scopes.download(path.rpartition("/")[2])
        assert name == "scope.csv"
        assert data.decode().count("\n") > 300
        await page.done("scope.stop", scope=started["scope"])
        [recording] = await page.done("scope.recordings")
        assert recording == {"name": "recording 1", "channels": [COUNTER], "state": "done"}
        loaded = await page.done("scope.load", name="recording 1")
        blocks = await read_blocks(page, loaded["scope"], 10**9)
        assert blocks[-1].flags & BlockFlag.END
        assert sum(each.rows for each in blocks) >= 300
        path = await page.done("scope.export", name="recording 1")
        assert it.server.handlers.scopes.download(path.rpartition("/")[2])[0] == "recording-1.csv"
        assert it.server.handlers.scopes.download("else") is None


async def test_scopes_of_the_station_are_recordings(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        client = it.server.watched.client
        async with client.scope([COUNTER], length=0.5, name="mine") as scope:
            for _ in range(100):
                await asyncio.sleep(0)
            rows = await page.done("scope.recordings")
            name = f"scope {scope.number}: mine"
            assert {"name": name, "channels": None, "state": "recording"} in rows
            loaded = await page.done("scope.load", name=name)
            assert (await read_blocks(page, loaded["scope"], 10**9))[-1].flags & BlockFlag.END


async def test_channels_with_other_sample_times_are_loaded_too(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        slow = ScopeChannel(COUNTER, COUNTER.partition(":")[2] or COUNTER, 851, 10_000_000)
        fast = replace(slow, name="fast", sample_time_ns=2_000_000)
        async with it.server.watched.client.scope([slow, fast], length=0.5, name="two") as scope:
            for _ in range(100):
                await asyncio.sleep(0)
            loaded = await page.done("scope.load", name=f"scope {scope.number}: two")
            assert {each["cycle"] for each in loaded["channels"]} == {0.002, 0.01}
            assert loaded["cycle"] == 0.002
            blocks = await read_blocks(page, loaded["scope"], 10**9)
    assert blocks[-1].flags & BlockFlag.END
    assert {len(each.columns) for each in blocks[:-1]} == {3}


@pytest.mark.parametrize(
    "name", ["../../etc/passwd", "scope ../1: x", f"scope {2**40}: x", "scope -1"]
)
async def test_only_recordings_are_loaded_and_exported(shown: Shows, name: str) -> None:
    async with shown() as it, it.page() as page:
        for call in ("scope.load", "scope.export"):
            refusal = await page.refused(call, name=name)
            assert "there is not such a recording" in refusal["text"]


async def test_names_of_channels_are_not_formulas_in_an_export(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        evil = ScopeChannel("=cmd|' /C calc'!A0", COUNTER, port=851, comment="@SUM(1)", unit="+A1")
        async with it.server.watched.client.scope([evil], length=0.5, name="-evil") as scope:
            for _ in range(100):
                await asyncio.sleep(0)
            path = await page.done("scope.export", name=f"scope {scope.number}: x")
            _, data = it.server.handlers.scopes.download(path.rpartition("/")[2])
    heads = data.decode().partition("\n\n\n")[2].splitlines()[:20]
    cells = [cell for line in heads for cell in line.split("\t")[1:]]
    assert "'=cmd|' /C calc'!A0" in cells
    assert not [cell for cell in cells if cell.startswith(("=", "@", "+"))]
    assert "Name\t'-evil" in data.decode()


async def test_all_pages_together_have_so_many_samplers(
    shown: Shows, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("achse.web.scopes.MOST_SAMPLERS", 1)
    async with shown() as it, it.page() as page, it.page() as other:
        await page.done("scope.start", channels=[COUNTER], cycle=0.002)
        await other.done("scope.start", channels=[COUNTER], cycle=0.002)
        refusal = await other.refused("scope.start", channels=[COUNTER], cycle=0.01)
        assert "up to 1 different scopes" in refusal["text"]


async def test_what_can_be_recorded_is_found_with_its_unit(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        rows = await page.done("scope.search", text="axes.x", limit=100)
        units = {each["name"].removeprefix("500:Axes.X."): each["unit"] for each in rows}
        assert (units["ActPos"], units["SetVelo"], units["SetAcc"]) == ("mm", "mm/s", "mm/s²")
        assert all(each["kind"] == "axis" and each["type"] for each in rows)
        assert not await page.done("scope.search", text="GVL.sString")


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"channels": []}, "channels: expected one at least"),
        ({"channels": "x"}, "channels: expected a list"),
        ({"channels": ["GVL.nope"]}, "GVL.nope"),
        ({"channels": ["GVL.sString"]}, "GVL.sString"),
        ({"channels": ["1:2:3:4:5"]}, "1:2:3:4:5"),
        ({"channels": [COUNTER], "cycle": 0}, "cycle: expected a number"),
        ({"channels": [COUNTER], "trigger": 5}, "trigger: expected an object"),
        ({"channels": [COUNTER], "trigger": {"channel": "x", "kind": "rising"}}, "one of the"),
        ({"channels": [COUNTER], "trigger": {"channel": COUNTER, "kind": "x"}}, "trigger.kind"),
    ],
)
async def test_what_cannot_be_recorded(shown: Shows, fields: dict[str, Any], message: str) -> None:
    async with shown() as it, it.page() as page:
        assert message in (await page.refused("scope.start", **fields))["text"]
        assert it.server.handlers.scopes.samplers == 0
        assert "recording" in (await page.refused("scope.load", name="x"))["text"]
        assert "no scope" in (await page.refused("scope.export", scope=3))["text"]
