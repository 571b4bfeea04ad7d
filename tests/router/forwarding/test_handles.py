"""Handles with other numbers at the target: places in requests, and both ways."""

import struct

from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AmsAddress, Command, Frame
from achse.ams.commands import ADD_NOTIFICATION_BODY
from achse.ams.notification import NotificationStream, encode_stream
from achse.router.forwarding.handles import HandleMap
from achse.router.forwarding.ledger import Resource, ResourceKind
from achse.router.forwarding.resource_requests import change_of, handle_places

PLC, OTHER = AmsAddress("5.0.0.9.1.1:851"), AmsAddress("5.0.0.9.1.1:852")
CLIENT = AmsAddress("192.168.0.9.1.1:30000")
SUBSCRIPTION, SYMBOL = ResourceKind.SUBSCRIPTION, ResourceKind.SYMBOL_HANDLE
WORD = st.integers(1, 9)
HANDLES = st.lists(WORD, min_size=1, max_size=5)


def word(number: int) -> bytes:
    return number.to_bytes(4, "little")


def request(command: int, data: bytes) -> Frame:
    return Frame(PLC, CLIENT, command, data=data)


def read_write(group: int, parts: int, data: bytes) -> Frame:
    return request(Command.READ_WRITE, struct.pack("<IIII", group, parts, 99, len(data)) + data)


@st.composite
def requests_with_handles(draw: st.DrawFn) -> tuple[Frame, ResourceKind, list[int]]:
    """A request, the kind of its handles, and the handles in their order."""
    handles = draw(HANDLES)
    count, first = len(handles), handles[0]
    group = draw(st.sampled_from((0xF005, 0xF010)))
    match draw(st.integers(0, 8)):
        case 0:
            return request(Command.DELETE_NOTIFICATION, word(first)), SUBSCRIPTION, [first]
        case 1:
            data = b"".join(map(word, handles))
            return read_write(0xF086, count, data), SUBSCRIPTION, handles
        case 2:
            command = draw(st.sampled_from((Command.READ, Command.WRITE)))
            data = struct.pack("<III", group, first, 4) + bytes(4)
            return request(command, data), SYMBOL, [first]
        case 3:
            data = struct.pack("<III", 0xF006, 0, 4) + word(first)
            return request(Command.WRITE, data), SYMBOL, [first]
        case 4:
            body = ADD_NOTIFICATION_BODY.pack(group, first, 4, 4, 0, 0)
            return request(Command.ADD_NOTIFICATION, body), SYMBOL, [first]
        case 5:
            parts = b"".join(struct.pack("<III", group, each, 4) for each in handles)
            kind = draw(st.sampled_from((0xF080, 0xF083, 0xF084)))
            return read_write(kind, count, parts), SYMBOL, handles
        case 6:
            parts = struct.pack("<III", 0xF006, 0, 4) * count
            return read_write(0xF081, count, parts + b"".join(map(word, handles))), SYMBOL, handles
        case 7:
            parts = b"".join(struct.pack("<IIII", group, each, 4, 0) for each in handles)
            return read_write(0xF082, count, parts), SYMBOL, handles
        case _:
            bodies = b"".join(
                ADD_NOTIFICATION_BODY.pack(group, each, 4, 4, 0, 0) for each in handles
            )
            return read_write(0xF085, count, bodies), SYMBOL, handles


@given(requests_with_handles(), st.dictionaries(WORD, st.integers(100, 109)))
def test_handles_of_requests_are_replaced_and_nothing_else(
    drawn: tuple[Frame, ResourceKind, list[int]], numbers: dict[int, int]
) -> None:
    frame, kind, handles = drawn
    handle_map = HandleMap()
    for known, handle in numbers.items():
        handle_map.enter(Resource(kind, PLC, known), handle)
    places = list(handle_places(frame))
    assert [place for place, _ in places] == [kind] * len(handles)
    data = handle_map.request(frame)
    for (_, position), known in zip(places, handles, strict=True):
        assert data[position : position + 4] == word(numbers.get(known, known))
        data = data[:position] + word(known) + data[position + 4 :]
    assert data == frame.data
    other = Frame(OTHER, CLIENT, frame.command, data=frame.data)
    assert handle_map.request(other) == frame.data


@given(st.dictionaries(WORD, st.integers(1, 20)), HANDLES)
def test_handles_that_are_given_out_meet_none_that_the_client_knows(
    numbers: dict[int, int], given_out: list[int]
) -> None:
    handle_map = HandleMap()
    at_target: dict[int, int] = {}
    for known, handle in numbers.items():
        if handle not in at_target.values():
            at_target[known] = handle
            handle_map.enter(Resource(SUBSCRIPTION, PLC, known), handle)
    body = ADD_NOTIFICATION_BODY.pack(0x4020, 0, 4, 4, 0, 0)
    for handle in set(given_out) - set(at_target.values()):
        change = change_of(request(Command.ADD_NOTIFICATION, body))
        assert change is not None
        answer = handle_map.answer(change, struct.pack("<II", 0, handle))
        known = int.from_bytes(answer[4:], "little")
        assert known not in at_target
        at_target[known] = handle
    stream = encode_stream([(5, [(handle, b"ab") for handle in at_target.values()])])
    [stamp] = NotificationStream.decode(handle_map.samples(PLC, stream)).stamps
    assert [sample.handle for sample in stamp.samples] == list(at_target)
    for known, handle in at_target.items():
        delete = request(Command.DELETE_NOTIFICATION, word(known))
        assert handle_map.request(delete) == word(handle)
        handle_map.forget(Resource(SUBSCRIPTION, PLC, handle))
    assert len(handle_map) == 0


@given(
    st.sampled_from((2, 3, 6, 7, 9)),
    st.sampled_from((0xF005, 0xF006, *range(0xF080, 0xF087))),
    st.one_of(st.integers(0, 9), st.integers(0, 0xFFFF_FFFF)),
    st.binary(max_size=120),
)
def test_any_request_and_stream_raise_nothing(
    command: int, group: int, parts: int, data: bytes
) -> None:
    handle_map = HandleMap()
    for known in range(9):
        handle_map.enter(Resource(SYMBOL, PLC, known), known + 1)
    frame = request(command, struct.pack("<II", group, parts) + data)
    assert len(handle_map.request(frame)) == len(frame.data)
    assert len(handle_map.samples(PLC, data)) == len(data)
