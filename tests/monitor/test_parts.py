"""Requests and sums come apart into what each part asked for and got."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AdsError, Command, DecodeError, Frame
from achse.ams.commands import (
    AddNotificationRequest,
    DeleteNotificationRequest,
    ReadRequest,
    ReadWriteRequest,
    WriteRequest,
)
from achse.client.session.sums import Outcome, sum_of
from achse.monitor.parts import outcomes_of, parts_of

A, B = bytes(8), bytes(range(8))


def request(command: Command, data: bytes) -> Frame:
    return Frame(A, B, command, 4, 0, 1, data)


@pytest.mark.parametrize(
    "parts",
    [
        [ReadRequest(1, 2, 4), ReadRequest(3, 4, 8)],
        [WriteRequest(1, 2, b"ab"), WriteRequest(3, 4, b"")],
        [ReadWriteRequest(1, 2, 4, b"ab"), ReadWriteRequest(3, 4, 0, b"xyz")],
        [AddNotificationRequest(1, 2, 4, 3, 0, 100), AddNotificationRequest(1, 3, 4, 4, 5, 6)],
        [DeleteNotificationRequest(1), DeleteNotificationRequest(2)],
    ],
)
def test_a_sum_comes_apart_as_it_was_made(parts: list[object]) -> None:
    frame = request(Command.READ_WRITE, sum_of(parts).encode())  # type: ignore[arg-type]
    assert parts_of(frame) == parts


def test_a_request_without_a_place_has_no_parts() -> None:
    assert parts_of(request(Command.READ_STATE, b"")) == []


def test_outcomes_of_a_sum_of_extended_reads() -> None:
    parts = [ReadRequest(1, 2, 4), ReadRequest(3, 4, 8)]
    request_data = ReadWriteRequest(0xF083, 2, 100, b"".join(part.encode() for part in parts))
    frame = request(Command.READ_WRITE, request_data.encode())
    assert parts_of(frame) == parts
    data = struct.pack("<4I", 0, 4, 0x710, 0) + b"abcd"
    answer = frame.reply(struct.pack("<II", 0, len(data)) + data)
    assert outcomes_of(frame, parts, answer) == [Outcome(0, b"abcd"), Outcome(0x710, b"")]


@pytest.mark.parametrize(
    ("error", "data"), [(7, b""), (0, struct.pack("<II", 7, 0)), (0, struct.pack("<I", 7))]
)
def test_an_error_of_the_whole_is_that_of_each_part(error: int, data: bytes) -> None:
    parts = [ReadRequest(1, 2, 4), ReadRequest(3, 4, 8)]
    frame = request(Command.READ_WRITE, sum_of(parts).encode())
    assert [each.result for each in outcomes_of(frame, parts, frame.reply(data, error))] == [7, 7]


def test_a_sum_that_ends_inside_a_part_is_an_error() -> None:
    cut = ReadWriteRequest(0xF080, 5, 100, bytes(12))
    with pytest.raises(DecodeError, match="ends inside a part"):
        parts_of(request(Command.READ_WRITE, cut.encode()))


@given(st.integers(1, 9), st.integers(0xF07F, 0xF087), st.integers(0, 9), st.binary(max_size=80))
def test_whatever_comes_only_ads_errors_leave(
    command: int, group: int, count: int, data: bytes
) -> None:
    request_data = ReadWriteRequest(group, count, 10, data).encode() if command == 9 else data
    frame = Frame(A, B, command, 4, 0, 1, request_data)
    try:
        parts = parts_of(frame)
        outcomes_of(frame, parts, frame.reply(data))
    except AdsError:
        pass
