"""Sum commands: each part for itself, layouts as real clients parse them."""

import struct
from collections.abc import Callable
from typing import Any

import pytest

MEMORY = 0x4020
PLENTY = 1 << 20


def parts(*each: tuple[int, ...]) -> bytes:
    return b"".join(struct.pack(f"<{len(part)}I", *part) for part in each)


def words(*values: int) -> bytes:
    return struct.pack(f"<{len(values)}I", *values)


MIXED = ((MEMORY, 0, 2), (0x4711, 0, 3), (MEMORY, 10, 0), (0x1000, 99, 4), (0xF100, 0, 8))
"""Good, unknown group, nothing asked, unknown offset, more asked than there is."""


@pytest.mark.parametrize("length", [4 * 5 + 17, PLENTY, 0xFFFF_FFFF])
def test_sum_read_keeps_the_requested_lengths(bench: Any, length: int) -> None:
    answer = bench.exchange(0xF080, 5, length, parts(*MIXED))
    data = b"\0\1" + bytes(3) + bytes(4) + b"\5\0\0\0\0\0\0\0"
    assert answer == (0, words(0, 0x702, 0, 0x703, 0) + data)


def test_sum_read_with_offset_zero_answers_data_only(bench: Any) -> None:
    answer = bench.exchange(0xF080, 0, PLENTY, parts(*MIXED))
    assert answer == (0, b"\0\1" + bytes(3) + bytes(4) + b"\5\0\0\0\0\0\0\0")


def test_sum_read_ex_pads_and_says_how_much_came(bench: Any) -> None:
    answer = bench.exchange(0xF083, 5, PLENTY, parts(*MIXED))
    heads = words(0, 2, 0x702, 0, 0, 0, 0x703, 0, 0, 4)
    assert answer == (0, heads + b"\0\1" + bytes(3) + bytes(4) + b"\5\0\0\0\0\0\0\0")


def test_sum_read_ex_2_answers_what_came(bench: Any) -> None:
    answer = bench.exchange(0xF084, 5, PLENTY, parts(*MIXED))
    assert answer == (0, words(0, 2, 0x702, 0, 0, 0, 0x703, 0, 0, 4) + b"\0\1" + b"\5\0\0\0")


def test_sum_write_writes_each_part(bench: Any) -> None:
    request = parts((MEMORY, 0, 2), (0xF100, 0, 1), (MEMORY, 63, 2), (MEMORY, 4, 0), (MEMORY, 5, 1))
    answer = bench.exchange(0xF081, 5, 20, request + b"ab" + b"c" + b"de" + b"" + b"f")
    assert answer == (0, words(0, 0x704, 0x705, 0, 0))
    assert bench.memory[:6] == b"ab\2\3\4f"


def test_sum_read_write_answers_the_returned_lengths(bench: Any) -> None:
    bench.source.symbols["main.ncounter"].number = 5
    names = (b"MAIN.nCounter", b"MAIN.nothing", b"MAIN.text\0")
    request = parts(
        (0xF004, 0, 0xFFFF, len(names[0])),
        (0xF003, 0, 4, len(names[1])),
        (0xF007, 0, 12, len(names[2])),
        (MEMORY, 0, 4, 0),
    )
    answer = bench.exchange(0xF082, 4, PLENTY, request + b"".join(names))
    heads = words(0, 4, 0x710, 0, 0, 12, 0x704, 0)
    assert answer == (0, heads + b"\5\0\0\0" + words(0x4040, 32, 81))


def test_many_handles_at_once(bench: Any) -> None:
    request = parts(*((0xF003, 0, 4, 13) for _ in range(500))) + b"MAIN.nCounter" * 500
    result, answer = bench.exchange(0xF082, 500, 500 * 12, request)
    assert result == 0
    assert answer[:4000] == words(*(0, 4) * 500)
    handles = struct.unpack("<500I", answer[4000:])
    assert len(set(handles)) == 500
    read = parts(*((0xF005, handle, 4) for handle in handles))
    assert bench.exchange(0xF080, 500, 500 * 8, read) == (0, bytes(4000))


def test_sum_add_and_delete_notifications(bench: Any) -> None:
    def body(group: int, offset: int, mode: int = 3) -> bytes:
        return words(group, offset, 2, mode, 0, 0) + b"\xcc" * 16

    request = body(MEMORY, 0) + body(0x4711, 0) + body(MEMORY, 4) + body(MEMORY, 0, mode=99)
    answer = bench.exchange(0xF085, 4, 32, request)
    assert answer == (0, words(0, 1, 0x702, 0, 0, 2, 0x713, 0))
    assert bench.samples() == [(0, 1, b"\0\1"), (0, 2, b"\4\5")]
    assert bench.exchange(0xF086, 3, 12, words(1, 9, 2)) == (0, words(0, 0x714, 0))
    bench.tick(100)
    assert bench.samples() == []


def test_an_unknown_group_is_0x701_where_parts_are_written(bench: Any) -> None:
    request = parts((0x4711, 0, 1), (MEMORY, 0, 1)) + b"xy"
    assert bench.exchange(0xF081, 2, 8, request) == (0, words(0x701, 0))
    assert bench.memory[:1] == b"y"


@pytest.mark.parametrize("group", range(0xF080, 0xF087))
def test_a_sum_of_nothing_answers_nothing(bench: Any, group: int) -> None:
    assert bench.exchange(group, 0, 100, b"") == (0, b"")


SIZES = {0xF080: 12, 0xF081: 12, 0xF082: 16, 0xF083: 12, 0xF084: 12, 0xF085: 40, 0xF086: 4}
RESULTS = {0xF080: 4, 0xF081: 4, 0xF082: 8, 0xF083: 8, 0xF084: 8, 0xF085: 8, 0xF086: 4}


@pytest.mark.parametrize("group", SIZES)
def test_five_hundred_parts_are_served_and_one_more_is_refused(bench: Any, group: int) -> None:
    result, answer = bench.exchange(group, 500, PLENTY, bytes(SIZES[group] * 500))
    assert result == 0
    assert len(answer) == RESULTS[group] * 500
    for count in (501, 0xFFFF_FFFF):
        assert bench.exchange(group, count, PLENTY, bytes(SIZES[group] * 501)) == (0x705, b"")


def test_five_hundred_and_one_parts_without_count_are_refused(bench: Any) -> None:
    assert bench.exchange(0xF080, 0, PLENTY, bytes(12 * 501)) == (0x705, b"")


@pytest.mark.parametrize("group", SIZES)
@pytest.mark.parametrize("excess", [-1, 1])
def test_data_that_do_not_fit_the_count_are_refused(bench: Any, group: int, excess: int) -> None:
    data = bytes(SIZES[group] * 3 + excess)
    assert bench.exchange(group, 3, PLENTY, data) == (0x705, b"")


def test_write_data_that_do_not_fit_are_refused_before_anything_is_written(bench: Any) -> None:
    request = parts((MEMORY, 0, 2), (MEMORY, 2, 2))
    for data in (b"abc", b"abcde"):
        assert bench.exchange(0xF081, 2, 8, request + data) == (0x705, b"")
    huge = parts((MEMORY, 0, 0xFFFF_FFFF))
    assert bench.exchange(0xF081, 1, 4, huge) == (0x705, b"")
    assert bench.memory[:4] == b"\0\1\2\3"


@pytest.mark.parametrize("group", SIZES)
def test_an_answer_without_room_for_its_results_is_refused(bench: Any, group: int) -> None:
    data = bytes(SIZES[group] * 3)
    assert bench.exchange(group, 3, RESULTS[group] * 3 - 1, data) == (0x705, b"")
    assert bench.exchange(group, 3, RESULTS[group] * 3, data)[0] == 0


def test_less_room_than_data_cuts_the_answer(bench: Any) -> None:
    request = parts((MEMORY, 0, 4), (MEMORY, 4, 4))
    assert bench.exchange(0xF080, 2, 8 + 6, request) == (0, words(0, 0) + b"\0\1\2\3\4\5")
    answer = bench.exchange(0xF084, 2, 16 + 6, request)
    assert answer == (0, words(0, 4, 0, 2) + b"\0\1\2\3\4\5")


def test_a_part_cannot_make_the_answer_huge(bench: Any) -> None:
    endless = parts((MEMORY, 0, 0xFFFF_FFFF))
    for group in (0xF080, 0xF083):
        assert bench.exchange(group, 1, 0xFFFF_FFFF, endless) == (0x705, b"")
    result, answer = bench.exchange(0xF084, 1, 0xFFFF_FFFF, endless)
    assert (result, answer[:8]) == (0, words(0, 64))


@pytest.mark.parametrize("group", [0xF080, 0xF083])
def test_answer_of_fixed_length_has_16_mebibytes_at_most(bench: Any, group: int) -> None:
    for excess, code in ((0, 0), (1, 0x705)):
        request = parts((MEMORY, 0, 1 << 23), (MEMORY, 0, (1 << 23) + excess))
        result, answer = bench.exchange(group, 2, 0xFFFF_FFFF, request)
        assert (result, len(answer)) == (code, 0 if code else RESULTS[group] * 2 + (1 << 24))


def test_sum_inside_a_sum_of_notifications_refuses_the_part(bench: Any) -> None:
    request = words(0xF080, 1, 4, 3, 0, 0) + bytes(16)
    assert bench.exchange(0xF085, 1, 8, request) == (0, words(0x701, 0))


@pytest.mark.parametrize("nested", SIZES)
def test_a_sum_inside_a_sum_refuses_the_part(bench: Any, nested: int) -> None:
    request = parts((nested, 1, 4, 0), (0xF007, 0, 12, 13)) + b"MAIN.nCounter"
    result, answer = bench.exchange(0xF082, 2, PLENTY, request)
    assert (result, answer[:16]) == (0, words(0x701, 0, 0, 12))
    request = parts((nested, 1, 4), (MEMORY, 0, 1))
    assert bench.exchange(0xF084, 2, PLENTY, request) == (0, words(0x701, 0, 0, 1) + b"\0")
    assert bench.exchange(0xF080, 1, 8, parts((nested, 1, 4))) == (0, words(0x701, 0))


def test_a_fault_in_a_part_stays_in_the_part(bench: Any, caplog: pytest.LogCaptureFixture) -> None:
    request = parts((0x1000, 3, 2), (MEMORY, 1, 1))
    assert bench.exchange(0xF080, 2, 11, request) == (0, words(1, 0) + b"\0\0\1")
    assert "ZeroDivisionError" in caplog.text


def test_all_parts_may_fail(make_bench: Callable[..., Any]) -> None:
    bench = make_bench()
    answer = bench.exchange(0xF080, 2, 16, parts((1, 0, 4), (2, 0, 4)))
    assert answer == (0, words(0x702, 0x702) + bytes(8))
    assert bench.read(0xF080, 1, 4) == (0x704, b"")
    assert bench.write(0xF081, 1, b"") == 0x704
