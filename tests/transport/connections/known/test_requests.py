"""Requests that are forwarded without decoding: which ones, and when no longer."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AmsAddress, Command, Frame, NetId
from achse.ams.commands import ReadRequest, ReadWriteRequest, WriteRequest
from achse.router.rights import Right
from achse.router.routes import Route
from tests.transport.connections.known.test_frames import DEVICES, SOURCES, World


def known_world() -> World:
    """A client that has asked once, so that its way is known."""
    world = World(known=True, source_nat=True)
    world.come()
    for number in (0, 1):
        world.take(world.clients[0][0], read(number), ())
    world.requests()
    return world


def read(number: int, length: int = 4, device: AmsAddress = DEVICES[0]) -> bytes:
    data = ReadRequest(0x4020, 0, length).encode()
    return Frame(device, SOURCES[0], Command.READ, 4, 0, number, data).encode_tcp()


def forwarded(world: World, data: bytes) -> int:
    """Bytes that go without decoding."""
    known = world.clients[0][0]._known_frames
    assert known is not None
    return known.pass_on(data)


@given(
    st.lists(st.tuples(st.integers(0, 2), st.integers(0, 64)), min_size=1, max_size=40),
    st.integers(0, 80),
)
def test_whole_requests_of_a_known_client_go_under_its_alias(
    requests: list[tuple[int, int]], missing: int
) -> None:
    world = known_world()
    packets = []
    for number, (kind, size) in enumerate(requests, 10):
        data = WriteRequest(0x4020, 0, bytes(size)).encode()
        head = (DEVICES[0], SOURCES[0], Command.WRITE, 4, 0, number)
        packets.append(read(number, size) if kind else Frame(*head, data).encode_tcp())
    stream = b"".join(packets)
    data = stream[: len(stream) - missing]
    done = forwarded(world, data)
    world.loop.run()
    ends = [sum(map(len, packets[:n])) for n in range(len(packets) + 1)]
    assert done == max(end for end in ends if end <= len(data))
    sent = world.requests()[-ends.index(done) :] if done else []
    alias = world.requests()[0].source
    assert [each.encode()[16:] for each in sent] == [
        each[22:] for each in packets[: ends.index(done)]
    ]
    assert {each.source for each in sent} <= {alias}


@pytest.mark.parametrize("command", [Command.READ, Command.WRITE, Command.READ_WRITE])
def test_of_the_system_service_reads_alone_are_known(command: Command) -> None:
    """Other requests may open and close files."""
    world, system = known_world(), DEVICES[1]
    world.take(world.clients[0][0], read(2, device=system), ())
    data = {
        Command.READ: ReadRequest(1, 0, 4).encode(),
        Command.WRITE: WriteRequest(1, 0, b"").encode(),
        Command.READ_WRITE: ReadWriteRequest(0xF082, 1, 4, bytes(16)).encode(),
    }[command]
    packet = Frame(system, SOURCES[0], command, 4, 0, 9, data).encode_tcp()
    assert forwarded(world, packet) == (len(packet) if command == Command.READ else 0)


def test_requests_with_a_repeated_invoke_id_are_left() -> None:
    world = known_world()
    assert forwarded(world, read(0)) == 0
    stream = b"".join(map(read, (5, 6, 7, 8, 9, 5)))
    assert forwarded(world, stream) == len(stream) - len(read(5))


def test_requests_of_a_limited_sender_are_left() -> None:
    world = known_world()
    peer = world.clients[0][0]
    peer.rights.assign(SOURCES[0], Right.READ)
    assert forwarded(world, read(9)) == 0


@pytest.mark.parametrize("change", ["gate", "route", "connection", "client"])
def test_requests_are_left_after_a_change_of_the_way(change: str) -> None:
    world = known_world()
    router = world.host.router
    assert forwarded(world, read(8)) == len(read(8))
    match change:
        case "gate":
            router.set_frame_filter(lambda frame, hand_on: hand_on(frame))
        case "route":
            router.remove_route(DEVICES[0].net_id)
        case "connection":
            assert world.far is not None
            world.far.abort()
            world.loop.run()
        case "client":
            world.clients[0][0].abort()
    assert forwarded(world, read(9)) == 0


def test_request_of_a_source_that_is_the_port_of_another_is_left() -> None:
    world = World(known=True, source_nat=False)
    world.come()
    own = AmsAddress.of(world.host.router.net_id, 40_000)
    data = ReadRequest(0x4020, 0, 4).encode()
    packet = Frame(DEVICES[0], own, Command.READ, 4, 0, 1, data).encode_tcp()
    for _ in range(2):
        world.take(world.clients[0][0], packet, ())
    world.come()
    world.host.router.register(40_000, world.clients[1][0])
    other = packet[:34] + b"\x09" + packet[35:]
    assert world.clients[0][0]._known_frames is not None
    world.take(world.clients[0][0], other, ())
    aliases = {each.source for each in world.requests()}
    assert len(aliases) == 1


def test_long_packet_is_not_sent_by_a_route_with_a_limit() -> None:
    world = known_world()
    route = Route(name="press", net_id=NetId(DEVICES[0].net_id), host="192.0.2.2", max_fragment=40)
    world.uplink.route = route
    assert forwarded(world, read(9)) == 0
