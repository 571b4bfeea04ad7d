"""Answers and notifications that are passed on without decoding: which ones."""

import struct

from hypothesis import given
from hypothesis import strategies as st

from achse.ams import Command, Frame
from tests.transport.connections.known.test_frames import World
from tests.transport.connections.known.test_requests import read

KINDS = st.sampled_from(("answer", "answer", "failed", "error", "unknown", "sample"))


def passed(world: World, data: bytes) -> int:
    """Bytes that go without decoding."""
    assert world.far is not None
    known = world.far._known_frames
    assert known is not None
    return known.pass_on(data)


@given(st.lists(KINDS, max_size=30), st.integers(1, 30))
def test_answers_to_requests_go_until_one_has_to_be_decoded(kinds: list[str], size: int) -> None:
    world = World(known=True, source_nat=True)
    world.come()
    world.take(world.clients[0][0], read(10_000), ())
    for number in range(len(kinds)):
        world.take(world.clients[0][0], read(number), ())
    requests = {each.invoke_id: each for each in world.requests()}
    data, whole = b"", 0
    for number, kind in enumerate(kinds):
        answer = requests[number].reply(struct.pack("<II", 0, size) + bytes(size))
        match kind:
            case "failed":
                answer.data = struct.pack("<II", 0x703, 0)
            case "error":
                answer.error = 7
            case "unknown":
                answer.invoke_id = 5_000
            case "sample":
                head = (answer.target, answer.source, Command.NOTIFICATION, 4, 0, 0)
                answer = Frame(*head, bytes(size))
        data += answer.encode_tcp()
        if whole == len(data) - len(answer.encode_tcp()) and kind not in ("error", "unknown"):
            whole = len(data)
    before = world.clients[0][1].written
    assert passed(world, data) == whole
    world.loop.run()
    came = world.clients[0][1].written[len(before) :]
    assert len(came) == whole
    assert world.host.router.client_figures[read(0)[14:22]].errors == kinds[
        : next((n for n, kind in enumerate(kinds) if kind in ("error", "unknown")), None)
    ].count("failed")


def test_answer_to_a_client_that_left_is_not_passed_on() -> None:
    world = World(known=True, source_nat=True)
    world.come()
    world.take(world.clients[0][0], read(1), ())
    [request] = world.requests()
    world.clients[0][0].abort()
    assert passed(world, request.reply(bytes(8)).encode_tcp()) == 0
