"""Frames that come alone: written at once, and left for a look whenever something has changed."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import Command, Frame
from achse.ams.commands import WriteRequest
from achse.router.rights import Right
from tests.transport.connections.known.test_frames import DEVICES, SOURCES, World
from tests.transport.connections.known.test_requests import read


def polled() -> World:
    """A client that has polled three times."""
    made = World(known=True, source_nat=True)
    made.come()
    for number in range(3):
        poll(made, number)
    return made


def poll(made: World, number: int) -> None:
    made.take(made.clients[0][0], read(number), ())
    [request] = made.requests()
    made.requests().clear()
    assert made.far is not None
    made.take(made.far, request.reply(bytes(12)).encode_tcp(), ())


def test_request_and_answer_leave_without_a_turn_of_the_loop() -> None:
    made = polled()
    [(peer, end, _)] = made.clients
    calls = made.loop._number
    peer.receive(read(9))
    assert made.loop._number == calls + 1  # the wire of the test carries the bytes
    made.loop.run()
    [request] = made.requests()
    before = len(end.written)
    assert made.far is not None
    made.far.receive(request.reply(bytes(12)).encode_tcp())
    assert made.loop._number == calls + 2
    made.loop.run()
    assert len(end.written) == before + 38 + 12


@given(st.lists(st.integers(4, 500), min_size=1, max_size=30, unique=True))
def test_many_under_way_are_gathered_for_a_turn(numbers: list[int]) -> None:
    made = polled()
    [(peer, _, _)] = made.clients
    assert made.far is not None
    for number in numbers:
        peer.receive(read(number))
    assert (made.far.backlog == 0) is (len(numbers) <= 4)
    made.loop.run()
    assert [each.invoke_id for each in made.requests()] == numbers


def write(number: int, data: bytes) -> bytes:
    body = WriteRequest(0x4020, 0, data).encode()
    return Frame(DEVICES[0], SOURCES[0], Command.WRITE, 4, 0, number, body).encode_tcp()


@given(st.integers(0, 3000), st.integers(0, 40))
@settings(max_examples=10)
def test_bytes_of_a_frame_that_look_like_another_stay_its_own(before: int, after: int) -> None:
    made = polled()
    [(peer, end, _)] = made.clients
    within = read(9)
    data = write(50, bytes(before) + within + bytes(after))
    end_of_it = len(data) - after
    made.take(peer, data, (end_of_it - len(within), end_of_it))
    [request] = made.requests()
    assert (request.invoke_id, request.data[12 + before :][: len(within)]) == (50, within)
    made.requests().clear()
    for number in (20, 21):
        made.take(peer, read(number), ())
    first, second = made.requests()
    within = second.reply(bytes(12)).encode_tcp()
    data = first.reply(bytes(before) + within + bytes(after)).encode_tcp()
    end_of_it, had = len(data) - after, len(end.written)
    assert made.far is not None
    made.take(made.far, data, (end_of_it - len(within), end_of_it))
    assert len(end.written) == had + len(data)


@given(st.lists(st.integers(1, 5000), min_size=1, max_size=8))
@settings(max_examples=10)
def test_a_single_request_does_not_overtake_those_that_wait(sizes: list[int]) -> None:
    made = polled()
    [(peer, _, _)] = made.clients
    peer.receive(b"".join(write(100 + n, bytes(size)) for n, size in enumerate(sizes)))
    peer.receive(read(9))
    made.loop.run()
    assert [each.invoke_id for each in made.requests()][-1] == 9


@pytest.mark.parametrize("change", ["rights", "gate", "route", "far", "source", "length", "unread"])
def test_single_request_is_looked_at_after_a_change(change: str) -> None:
    made = polled()
    [(peer, _, _)] = made.clients
    [single] = peer._singles.values()
    data = read(9)
    assert made.far is not None
    match change:
        case "rights":
            peer.rights.assign(SOURCES[0], Right.READ)
        case "gate":
            made.host.router.put_watcher(made.watched.append)
        case "route":
            made.host.router.remove_route(DEVICES[0].net_id)
        case "far":
            made.far.abort()
        case "source":
            head = (DEVICES[0], SOURCES[1], Command.READ_STATE, 4, 0, 1)
            made.take(peer, Frame(*head, b"").encode_tcp(), ())
        case "unread":
            assert made.line is not None
            made.line.stall(True)
            assert single(data)
            data = read(10)
        case "length":
            data += b"\0"
    assert not single(data)
