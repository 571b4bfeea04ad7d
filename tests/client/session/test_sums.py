"""Sum commands: layouts, splitting, and targets that deviate."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import Command, DecodeError, Frame
from achse.ams.commands import (
    AddNotificationRequest,
    DeleteNotificationRequest,
    ReadRequest,
    ReadWriteRequest,
    WriteRequest,
)
from achse.client.session.sums import (
    MAX_BYTES,
    Outcome,
    Part,
    batches,
    command_of,
    outcome,
    sum_of,
    unpack,
)

READS = [ReadRequest(0xF005, 0x11, 4), ReadRequest(0x4020, 2, 2)]


def test_a_sum_of_reads_lists_group_offset_length() -> None:
    request = sum_of(READS)
    assert request == ReadWriteRequest(
        0xF080, 2, 4 + 4 + 4 + 2, struct.pack("<6I", 0xF005, 0x11, 4, 0x4020, 2, 2)
    )


def test_a_failed_read_keeps_its_place_in_the_data() -> None:
    answer = struct.pack("<II", 0x710, 0) + bytes(4) + b"ok"
    assert unpack(READS, answer) == [Outcome(0x710, b""), Outcome(0, b"ok")]


def test_a_target_may_leave_out_the_data_of_failed_reads() -> None:
    assert unpack(READS, struct.pack("<II", 0x710, 0) + b"ok") == [
        Outcome(0x710, b""),
        Outcome(0, b"ok"),
    ]


def test_a_sum_of_writes_has_all_heads_before_all_data() -> None:
    parts = [WriteRequest(1, 2, b"abc"), WriteRequest(3, 4, b"d")]
    request = sum_of(parts)
    assert request == ReadWriteRequest(0xF081, 2, 8, struct.pack("<6I", 1, 2, 3, 3, 4, 1) + b"abcd")
    assert unpack(parts, struct.pack("<II", 0, 0x705)) == [Outcome(0, b""), Outcome(0x705, b"")]


def test_a_sum_of_read_writes_answers_returned_lengths() -> None:
    parts = [ReadWriteRequest(0xF003, 0, 4, b"a\0"), ReadWriteRequest(0xF009, 0, 0xFFFF, b"bc\0")]
    request = sum_of(parts)
    heads = struct.pack("<8I", 0xF003, 0, 4, 2, 0xF009, 0, 0xFFFF, 3)
    assert request == ReadWriteRequest(0xF082, 2, 16 + 4 + 0xFFFF, heads + b"a\0bc\0")
    answer = struct.pack("<4I", 0x710, 0, 0, 3) + b"xyz"
    assert unpack(parts, answer) == [Outcome(0x710, b""), Outcome(0, b"xyz")]


def test_a_sum_of_subscriptions_has_bodies_of_40_bytes_and_answers_handles() -> None:
    parts = [AddNotificationRequest(0xF005, 7, 4, 4, 0, 10_000)] * 2
    request = sum_of(parts)
    assert (request.index_group, request.index_offset, request.read_length) == (0xF085, 2, 16)
    assert len(request.data) == 80
    answer = struct.pack("<4I", 0, 3, 0x701, 0)
    assert unpack(parts, answer) == [Outcome(0, b"\3\0\0\0"), Outcome(0x701, bytes(4))]


def test_a_sum_of_deletes_lists_handles() -> None:
    parts = [DeleteNotificationRequest(5), DeleteNotificationRequest(6)]
    assert sum_of(parts) == ReadWriteRequest(0xF086, 2, 8, struct.pack("<II", 5, 6))
    assert unpack(parts, struct.pack("<II", 0, 0x714)) == [Outcome(0, b""), Outcome(0x714, b"")]


@pytest.mark.parametrize(
    "parts",
    [
        READS,
        [WriteRequest(1, 2, b"")] * 2,
        [ReadWriteRequest(1, 2, 3, b"")] * 2,
        [AddNotificationRequest(1, 2, 3, 4, 5, 6)] * 2,
        [DeleteNotificationRequest(1)] * 2,
    ],
)
@given(answer=st.binary(max_size=64))
def test_any_answer_is_read_or_a_decode_error(parts: list[Part], answer: bytes) -> None:
    try:
        outcomes = unpack(parts, answer)
    except DecodeError:
        return
    assert len(outcomes) == len(parts)


@pytest.mark.parametrize(("count", "pieces"), [(0, []), (1, [1]), (500, [500]), (501, [500, 1])])
def test_sums_are_split_at_500_parts(count: int, pieces: list[int]) -> None:
    parts = [ReadRequest(1, index, 4) for index in range(count)]
    cut = list(batches(parts))
    assert [len(piece) for piece in cut] == pieces
    assert [part for piece in cut for part in piece] == parts


def test_sums_are_split_before_their_data_grows_too_large() -> None:
    parts = [ReadRequest(1, index, MAX_BYTES // 3) for index in range(7)]
    assert [len(piece) for piece in batches(parts)] == [2, 2, 2, 1]
    assert [len(piece) for piece in batches([WriteRequest(1, 2, bytes(MAX_BYTES))] * 2)] == [1, 1]


@pytest.mark.parametrize(
    ("part", "answer", "expected"),
    [
        (READS[0], b"\0\0\0\0\2\0\0\0ab", Outcome(0, b"ab")),
        (READS[0], b"\2\7\0\0\0\0\0\0", Outcome(0x702, b"")),
        (READS[0], b"\2\7\0\0", Outcome(0x702, b"")),
        (WriteRequest(1, 2, b""), b"\0\0\0\0", Outcome(0, b"")),
        (AddNotificationRequest(1, 2, 3, 4, 5, 6), b"\0\0\0\0\7\0\0\0", Outcome(0, b"\7\0\0\0")),
        (DeleteNotificationRequest(1), b"\x14\7\0\0", Outcome(0x714, b"")),
    ],
)
def test_the_answer_to_a_part_sent_alone_gives_the_same_outcome(
    part: Part, answer: bytes, expected: Outcome
) -> None:
    assert outcome(Frame(bytes(8), bytes(8), command_of(part), 5, data=answer)) == expected


def test_the_command_of_a_part_is_its_own() -> None:
    assert command_of(READS[0]) is Command.READ


def test_where_little_goes_at_once_sums_are_short_and_read_writes_go_alone() -> None:
    reads = [ReadRequest(0x4040, n, 8) for n in range(30)]
    assert [len(batch) for batch in batches(reads, 199)] == [9, 9, 9, 3]
    both = [ReadWriteRequest(0xF003, 0, 4, b"a") for _ in range(3)]
    assert [len(batch) for batch in batches(both, 199)] == [1, 1, 1]
