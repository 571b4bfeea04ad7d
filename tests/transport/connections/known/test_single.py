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
    world = World(known=True, source_nat=True)
    world.come()
    for number in range(3):
        poll(world, number)
    return world


def poll(world: World, number: int) -> None:
    world.take(world.clients[0][0], read(number), ())
    [request] = world.requests()
    world.requests().clear()
    assert world.far is not None
    world.take(world.far, request.reply(bytes(12)).encode_tcp(), ())


def test_request_and_answer_leave_without_a_turn_of_the_loop() -> None:
    world = polled()
    [(peer, end, _)] = world.clients
    calls = world.loop._number
    peer.receive(read(9))
    assert world.loop._number == calls + 1  # the wire of the test carries the bytes
    world.loop.run()
    [request] = world.requests()
    before = len(end.written)
    assert world.far is not None
    world.far.receive(request.reply(bytes(12)).encode_tcp())
    assert world.loop._number == calls + 2
    world.loop.run()
    assert len(end.written) == before + 38 + 12


@given(st.lists(st.integers(4, 500), min_size=1, max_size=30, unique=True))
def test_many_under_way_are_gathered_for_a_turn(numbers: list[int]) -> None:
    world = polled()
    [(peer, _, _)] = world.clients
    assert world.far is not None
    for number in numbers:
        peer.receive(read(number))
    assert (world.far.backlog == 0) is (len(numbers) <= 4)
    world.loop.run()
    assert [each.invoke_id for each in world.requests()] == numbers


def write(number: int, data: bytes) -> bytes:
    body = WriteRequest(0x4020, 0, data).encode()
    return Frame(DEVICES[0], SOURCES[0], Command.WRITE, 4, 0, number, body).encode_tcp()


@given(st.integers(0, 3000), st.integers(0, 40))
@settings(max_examples=10)
def test_bytes_of_a_frame_that_look_like_another_stay_its_own(before: int, after: int) -> None:
    world = polled()
    [(peer, end, _)] = world.clients
    within = read(9)
    data = write(50, bytes(before) + within + bytes(after))
    end_of_it = len(data) - after
    world.take(peer, data, (end_of_it - len(within), end_of_it))
    [request] = world.requests()
    assert (request.invoke_id, request.data[12 + before :][: len(within)]) == (50, within)
    world.requests().clear()
    for number in (20, 21):
        world.take(peer, read(number), ())
    first, second = world.requests()
    within = second.reply(bytes(12)).encode_tcp()
    data = first.reply(bytes(before) + within + bytes(after)).encode_tcp()
    end_of_it, had = len(data) - after, len(end.written)
    assert world.far is not None
    world.take(world.far, data, (end_of_it - len(within), end_of_it))
    assert len(end.written) == had + len(data)


@given(st.lists(st.integers(1, 5000), min_size=1, max_size=8))
@settings(max_examples=10)
def test_a_single_request_does_not_overtake_those_that_wait(sizes: list[int]) -> None:
    world = polled()
    [(peer, _, _)] = world.clients
    peer.receive(b"".join(write(100 + n, bytes(size)) for n, size in enumerate(sizes)))
    peer.receive(read(9))
    world.loop.run()
    assert [each.invoke_id for each in world.requests()][-1] == 9


@pytest.mark.parametrize("change", ["rights", "gate", "route", "far", "source", "length", "unread"])
def test_single_request_is_looked_at_after_a_change(change: str) -> None:
    world = polled()
    [(peer, _, _)] = world.clients
    [single] = peer._singles.values()
    data = read(9)
    assert world.far is not None
    match change:
        case "rights":
            peer.rights.assign(SOURCES[0], Right.READ)
        case "gate":
            world.host.router.put_watcher(world.watched.append)
        case "route":
            world.host.router.remove_route(DEVICES[0].net_id)
        case "far":
            world.far.abort()
        case "source":
            head = (DEVICES[0], SOURCES[1], Command.READ_STATE, 4, 0, 1)
            world.take(peer, Frame(*head, b"").encode_tcp(), ())
        case "unread":
            assert world.line is not None
            world.line.stall(True)
            assert single(data)
            data = read(10)
        case "length":
            data += b"\0"
    assert not single(data)
