"""What requests and their answers change in the resources of a client."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AmsAddress, Command, Frame
from achse.ams.commands import ADD_NOTIFICATION_BODY
from achse.router.forwarding.ledger import (
    Resource,
    ResourceKind,
    end_hints,
)
from achse.router.forwarding.resource_requests import change_of

PLC = AmsAddress("5.0.0.9.1.1:851")
CLIENT = AmsAddress("192.168.0.9.1.1:30000")
SUBSCRIPTION, HANDLE = ResourceKind.SUBSCRIPTION, ResourceKind.SYMBOL_HANDLE


def request(command: int, data: bytes) -> Frame:
    return Frame(PLC, CLIENT, command, data=data)


def read_write(group: int, offset: int, data: bytes) -> Frame:
    head = struct.pack("<IIII", group, offset, 4096, len(data))
    return request(Command.READ_WRITE, head + data)


def outcomes(frame: Frame, answer: bytes) -> list[tuple[bool, ResourceKind, int]]:
    """True for what is fetched, False for what is released."""
    change = change_of(frame)
    outcomes_ = () if change is None else change.outcomes(answer)
    return [(action.handle is None, each.kind, each.handle) for action, each in outcomes_]


def test_single_requests_fetch_and_release() -> None:
    body = ADD_NOTIFICATION_BODY.pack(0xF005, 1, 4, 4, 0, 0)
    add = request(Command.ADD_NOTIFICATION, body)
    assert outcomes(add, struct.pack("<II", 0, 7)) == [(True, SUBSCRIPTION, 7)]
    assert outcomes(add, struct.pack("<II", 0x716, 0)) == []
    delete = Resource(SUBSCRIPTION, PLC, 7).release(CLIENT, 1)
    assert outcomes(delete, bytes(4)) == [(False, SUBSCRIPTION, 7)]
    assert outcomes(delete, struct.pack("<I", 0x714)) == [(False, SUBSCRIPTION, 7)]
    assert outcomes(delete, struct.pack("<I", 0x723)) == []
    fetch = read_write(0xF003, 0, b"MAIN.x")
    assert outcomes(fetch, struct.pack("<III", 0, 4, 9)) == [(True, HANDLE, 9)]
    release = Resource(HANDLE, PLC, 9).release(CLIENT, 1)
    assert outcomes(release, bytes(4)) == [(False, HANDLE, 9)]


def test_parts_of_sum_commands_stand_alone() -> None:
    body = ADD_NOTIFICATION_BODY.pack(0xF005, 1, 4, 4, 0, 0)
    adds = struct.pack("<6I", 0, 16, 0, 7, 0x716, 0)
    assert outcomes(read_write(0xF085, 2, body * 2), adds) == [(True, SUBSCRIPTION, 7)]
    deletes = struct.pack("<4I", 0, 8, 0x723, 0)
    assert outcomes(read_write(0xF086, 2, struct.pack("<II", 7, 8)), deletes) == [
        (False, SUBSCRIPTION, 8)
    ]
    parts = struct.pack("<8I", 0xF004, 0, 2, 1, 0xF003, 0, 4, 1) + b"ab"
    values = struct.pack("<6I", 0, 22, 0, 2, 0, 4) + b"xx" + struct.pack("<I", 9)
    assert outcomes(read_write(0xF082, 2, parts), values) == [(True, HANDLE, 9)]
    writes = struct.pack("<6I", 0x4020, 0, 2, 0xF006, 0, 4) + b"xx" + struct.pack("<I", 9)
    results = struct.pack("<4I", 0, 8, 0x705, 0)
    assert outcomes(read_write(0xF081, 2, writes), results) == [(False, HANDLE, 9)]


SYSTEM = AmsAddress("5.0.0.9.1.1:10000")
FILE = ResourceKind.FILE


@given(
    st.sampled_from((100, 101, 102, 120)), st.integers(1, 0xFFFF_FFFF), st.sampled_from((0, 0x704))
)
def test_files_are_opened_and_closed(group: int, handle: int, result: int) -> None:
    opened = read_write(group, 1, b"a.txt")
    opened.target = SYSTEM
    answer = struct.pack("<I", result) + (bytes(4) if result else struct.pack("<II", 4, handle))
    fetched = result == 0 and handle != 0xFFFF_FFFF
    assert outcomes(opened, answer) == ([(True, FILE, handle)] if fetched else [])
    closed = Resource(FILE, SYSTEM, handle).release(CLIENT, 1)
    assert outcomes(closed, bytes(8)) == [(False, FILE, handle)]
    older = request(Command.WRITE, struct.pack("<IIII", 111, 0, 4, handle))
    older.target = SYSTEM
    assert outcomes(older, bytes(4)) == [(False, FILE, handle)]
    opened.target = PLC
    assert change_of(opened) is None


@pytest.mark.parametrize("offset", [1, 0xF601])
def test_a_search_is_open_until_nothing_more_is_found(offset: int) -> None:
    find = read_write(133, offset, b"*")
    find.target = SYSTEM
    answer = struct.pack("<III", 0, 324, 0xF601) + bytes(320)
    assert outcomes(find, answer) == [(True, FILE, 0xF601)]
    assert outcomes(find, struct.pack("<II", 0x70C, 0)) == [(False, FILE, offset)]


OPENED = st.tuples(st.sampled_from((100, 101, 102, 120)), st.just(1), st.just(4))
CLOSED = st.tuples(st.just(121), st.sampled_from((0xF601, 0xF602)), st.just(0))
SEARCHED = st.tuples(st.just(133), st.sampled_from((1, 0xF603)), st.just(324))
OTHER = st.tuples(st.sampled_from((0xF003, 0xF004)), st.just(0), st.just(4))


@given(
    st.lists(
        st.tuples(st.one_of(OPENED, CLOSED, SEARCHED, OTHER), st.binary(max_size=9), st.booleans()),
        max_size=6,
    ),
    st.booleans(),
)
def test_parts_of_a_sum_open_and_close_files_as_requests_alone(
    parts: list[tuple[tuple[int, int, int], bytes, bool]], system: bool
) -> None:
    target = SYSTEM if system else PLC
    heads = written = pairs = values = b""
    expected: list[tuple[bool, ResourceKind, int]] = []
    for number, ((group, offset, length), name, success) in enumerate(parts):
        result = 0 if success else 0x70C
        value = struct.pack("<I", 0xF610 + number).ljust(length, b"\0")[:length]
        value = value if success else b""
        single = read_write(group, offset, name)
        single.target = target
        answer = struct.pack("<II", result, len(value)) + value
        expected += outcomes(single, answer)
        heads += struct.pack("<4I", group, offset, length, len(name))
        written += name
        pairs += struct.pack("<II", result, len(value))
        values += value
    frame = read_write(0xF082, len(parts), heads + written)
    frame.target = target
    content = pairs + values
    assert outcomes(frame, struct.pack("<II", 0, len(content)) + content) == expected
    assert system or not any(kind is FILE for _, kind, _ in expected)


def test_writes_of_a_sum_close_files_at_the_system_service_alone() -> None:
    writes = struct.pack("<4I", 111, 0, 4, 0xF601)
    frame, answer = read_write(0xF081, 1, writes), struct.pack("<3I", 0, 4, 0)
    assert outcomes(frame, answer) == []
    frame.target = SYSTEM
    assert outcomes(frame, answer) == [(False, FILE, 0xF601)]


def test_end_hints_are_samples_without_data() -> None:
    samples = [
        Resource(SUBSCRIPTION, PLC, 3),
        Resource(HANDLE, PLC, 4),
        Resource(SUBSCRIPTION, PLC, 5),
    ]
    [hint] = end_hints(samples, CLIENT, 0)
    assert (hint.target, hint.source, hint.command) == (CLIENT, PLC, Command.NOTIFICATION)
    assert hint.data == struct.pack("<IIQIIIII", 32, 1, 0, 2, 3, 0, 5, 0)


@given(
    st.sampled_from((2, 3, 6, 7, 9)),
    st.sampled_from((0xF003, 0xF006, 0xF081, 0xF082, 0xF085, 0xF086)),
    st.one_of(st.integers(0, 9), st.integers(0, 0xFFFF_FFFF)),
    st.binary(max_size=120),
    st.binary(max_size=120),
)
def test_any_request_and_answer_raise_nothing(
    command: int, group: int, parts: int, data: bytes, answer: bytes
) -> None:
    frame = request(command, struct.pack("<II", group, parts) + data)
    change = change_of(frame)
    if change is not None:
        assert len(list(change.outcomes(answer))) <= len(change.actions) <= 64
