"""Requests under way: found by their answers, bounded, and forgotten when they are old."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import AmsAddress, Command, Frame
from achse.codes import ReturnCode
from achse.router.forwarding import pending
from achse.router.forwarding.forwarded_client import ForwardedClient
from achse.router.forwarding.pending import PendingRequest, PendingRequests

TARGETS = [AmsAddress(f"5.0.0.9.1.1:{port}") for port in (851, 852)]
SECOND = 1_000_000_000


class Client:
    def deliver(self, frame: Frame) -> bool:
        return True


def session(number: int) -> ForwardedClient:
    alias = bytes(AmsAddress(f"5.0.0.1.1.1:{32768 + number}"))
    return ForwardedClient(Client(), alias, alias, registered=False)


def without_window(number: int) -> ForwardedClient:
    client = session(number)
    client.load.share.window = 0
    return client


STEP = st.tuples(
    st.sampled_from(("ask", "ask", "answer", "wait")),
    st.integers(0, 2),
    st.integers(0, 1),
    st.integers(0, 4),
)


@settings(max_examples=100)
@given(st.lists(STEP, max_size=60), st.integers(3, 8), st.booleans())
def test_answers_find_the_oldest_request_and_old_ones_are_forgotten(
    steps: list[tuple[str, int, int, int]], most: int, circles: bool
) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pending, "_PENDING", most)
        forgotten: list[ForwardedClient] = []
        table = PendingRequests(forgotten.append)
        sessions = [without_window(number) for number in range(3)]
        waiting_ids: dict[tuple[int, int, int], list[int]] = {}
        now = 0
        for what, who, target, number in steps:
            key = (who, target, number)
            if what == "wait":
                now += number * SECOND // 3
            elif what == "ask":
                now += 1
                head = (TARGETS[target], sessions[who].alias, Command.READ, 4, 0, number)
                request = PendingRequest(sessions[who], Command.READ, 4, None, now, 10)
                waiting = waiting_ids.get(key, [])
                refusal = table.add(sessions[who], Frame(*head, b""), request, circles)
                if circles and sum(now - each < SECOND for each in waiting) >= 2:
                    assert refusal is ReturnCode.TARGET_MACHINE_NOT_FOUND
                    continue
                if not waiting and len(waiting_ids) >= most:
                    oldest = min(waiting_ids, key=lambda each: waiting_ids[each][0])
                    if circles and now - waiting_ids[oldest][0] < SECOND:
                        assert refusal is ReturnCode.ROUTER_MAILBOX_FULL
                        continue
                    del waiting_ids[oldest]
                    assert forgotten.pop() is sessions[oldest[0]]
                assert refusal is None
                waiting_ids.setdefault(key, []).append(now)
                if len(waiting_ids[key]) > most:
                    waiting_ids[key].pop(0)
            else:
                exchange = table.exchange(sessions[who], TARGETS[target])
                came = table.pop(exchange, number)
                times = waiting_ids.get(key, [])
                assert (None if came is None else came.time) == (times.pop(0) if times else None)
                if not times:
                    waiting_ids.pop(key, None)
            total = sum(map(len, waiting_ids.values()))
            assert len(table) == total
            assert [each.pending for each in sessions] == [
                any(key[0] == who for key in waiting_ids) for who in range(3)
            ]
            assert table.size == 10 * total
    assert len(table.end(ReturnCode.HOST_UNREACHABLE)) == total_of(waiting_ids)
    assert (len(table), table.size) == (0, 0)


def total_of(pending: dict[tuple[int, int, int], list[int]]) -> int:
    return sum(map(len, pending.values()))


@given(st.integers(1, 40), st.integers(1, 20))
def test_table_that_one_client_fills_has_room_for_the_window_of_another(
    most: int, window: int
) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pending, "_PENDING", most)
        table = PendingRequests(lambda session: None)
        full, other = without_window(0), session(1)
        other.load.share.window = window

        def refusals(client: ForwardedClient, count: int) -> list[ReturnCode | None]:
            reports = []
            for number in range(count):
                request = PendingRequest(client, Command.READ, 4, None, 1, 10)
                frame = Frame(TARGETS[0], client.alias, Command.READ, 4, 0, number, b"")
                reports.append(table.add(client, frame, request, True))
            return reports

        assert refusals(full, most + 1) == [None] * most + [ReturnCode.ROUTER_MAILBOX_FULL]
        last = [ReturnCode.ROUTER_MAILBOX_FULL]
        assert refusals(other, window + 1) == [None] * window + last


def test_exchanges_of_a_client_are_bounded() -> None:
    table = PendingRequests(lambda session: None)
    client = session(0)
    first = table.exchange(client, TARGETS[0])
    for port in range(1, 3000):
        table.exchange(client, AmsAddress(f"5.0.0.9.1.1:{port}"))
    assert len(table.exchanges) == len(client.exchanges) <= 256
    assert not first.live
    table.drop(client)
    assert (table.exchanges, client.exchanges) == ({}, {})


def test_room_is_that_of_the_client_and_of_all() -> None:
    table = PendingRequests(lambda session: None)
    one, other = session(0), session(1)
    assert table.room(one, 0, 1) == 1 << 22
    table.sent(one, 1, 1 << 21, 0)
    assert table.room(one, 0, 1) == 1 << 21
    assert table.room(one, 0, 1 << 12) == 0
    assert table.room(other, 0, 1) == 1 << 22
    assert table.room(one, 10 * SECOND, 1) == 1 << 22
