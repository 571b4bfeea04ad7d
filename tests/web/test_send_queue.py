"""What waits for a page is bounded, and nothing is lost without being told."""

import asyncio
import json

from hypothesis import given
from hypothesis import strategies as st

from achse.web.send_queue import (
    BLOCK_HEADER,
    MOST_ANSWERS,
    MOST_BLOCK_BYTES,
    MOST_LINES,
    BlockFlag,
    PageSendQueue,
)


async def everything(send_queue: PageSendQueue) -> list[str | bytes]:
    """All messages that wait."""
    messages: list[str | bytes] = []
    while True:
        taking = asyncio.ensure_future(send_queue.take())
        await asyncio.sleep(0)
        if not taking.done():
            taking.cancel()
            return messages
        messages.append(taking.result())


async def test_of_a_state_the_newest_is_sent_and_the_others_are_counted() -> None:
    send_queue = PageSendQueue()
    for number in range(5):
        send_queue.put_state(3, f'"value":{number}')
    send_queue.put_state(4, '"value":"b"')
    report = [json.loads(each) for each in await everything(send_queue)]
    assert report == [
        {"event": "data", "watch": 3, "lost": 4, "value": 4},
        {"event": "data", "watch": 4, "lost": 0, "value": "b"},
    ]


async def test_an_answer_goes_before_values() -> None:
    send_queue = PageSendQueue()
    send_queue.put_state(1, '"value":0')
    send_queue.put('{"id":1}')
    assert (await everything(send_queue))[0] == '{"id":1}'


@given(st.lists(st.integers(1, 900), min_size=1, max_size=8))
def test_lines_come_in_order_or_are_counted(batches: list[int]) -> None:
    async def play() -> None:
        send_queue = PageSendQueue()
        count = 0
        for size in batches:
            send_queue.put_lines(7, [str(count + number) for number in range(size)])
            count += size
        lost = expected = 0
        lines: list[int] = []
        for message in await everything(send_queue):
            fields = json.loads(message)
            lost += fields["lost"]
            lines += fields["value"]
        expected = min(count, MOST_LINES)
        assert lines == list(range(count - expected, count))
        assert lost == count - expected

    asyncio.run(play())


@given(st.lists(st.tuples(st.integers(1, 3), st.sampled_from([1000, 700_000])), max_size=30))
def test_blocks_are_bounded_and_gaps_are_marked(blocks: list[tuple[int, int]]) -> None:
    async def play() -> None:
        send_queue = PageSendQueue()
        sent: dict[int, list[bytes]] = {}
        for number, (scope, size) in enumerate(blocks):
            payload = number.to_bytes(8, "little") + bytes(size)
            sent.setdefault(scope, []).append(payload)
            send_queue.put_block(scope, payload, 1, 1)
            assert send_queue.buffered_bytes <= MOST_BLOCK_BYTES + size + 8
        for message in await everything(send_queue):
            assert isinstance(message, bytes)
            kind, flags, scope, _, _, dropped = BLOCK_HEADER.unpack_from(message)
            payload = message[BLOCK_HEADER.size :]
            place = sent[scope].index(payload)
            assert kind == 1
            assert bool(flags & BlockFlag.GAP) == (place > 0)
            sent[scope] = sent[scope][place + 1 :]
            assert dropped or not place
        assert not any(sent.values()), "the newest block of each scope is always sent"
        assert send_queue.buffered_bytes == 0

    asyncio.run(play())


async def test_the_end_is_reported_even_if_its_block_is_dropped() -> None:
    send_queue = PageSendQueue()
    send_queue.put_block(1, bytes(8), 1, 1, BlockFlag.TRIGGER)
    for _ in range(3):
        send_queue.put_block(1, bytes(MOST_BLOCK_BYTES // 2), 1, 1)
    first = (await everything(send_queue))[0]
    assert isinstance(first, bytes)
    assert first[1] == BlockFlag.TRIGGER | BlockFlag.GAP


async def test_there_is_room_again_when_answers_are_read() -> None:
    send_queue = PageSendQueue()
    for _ in range(MOST_ANSWERS):
        send_queue.put("{}")
    waiting = asyncio.ensure_future(send_queue.room())
    await asyncio.sleep(0)
    assert not waiting.done()
    await send_queue.take()
    await waiting


async def test_what_is_forgotten_is_not_sent() -> None:
    send_queue = PageSendQueue()
    send_queue.put_state(1, '"value":0')
    send_queue.put_lines(2, ["1"])
    send_queue.put_block(3, bytes(8), 1, 1)
    send_queue.forget_watch(1)
    send_queue.forget_watch(2)
    send_queue.forget_scope(3)
    assert await everything(send_queue) == []
    assert send_queue.buffered_bytes == 0
