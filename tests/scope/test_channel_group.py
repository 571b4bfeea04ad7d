"""Channel groups: rings of rows, values from any memory, channels without values."""

import mmap
import threading
from collections.abc import Callable

import pytest

from achse.native.backend import compiler_installed
from achse.native.memory import MemoryCell
from achse.scope.channel import ScopeChannel
from achse.scope.channel_group import ChannelGroup, GroupChannel, ScopeSource, address_of
from achse.scope.trigger import trigger_of
from achse.scope.types import SCOPE_TYPES

MS = 1_000_000


def group_of(
    *reads: tuple[str, Callable[[], bytes]], compiled: bool, capacity: int = 4, trigger: str = ""
) -> ChannelGroup:
    channels = [
        GroupChannel(ScopeChannel(f"c{n}"), ScopeSource(read, SCOPE_TYPES[type], MS))
        for n, (type, read) in enumerate(reads)
    ]
    triggers = [trigger_of(trigger)] if trigger else []
    group = ChannelGroup(channels, MS, capacity, triggers, compiled=compiled)
    group.start(MS)
    return group


def words(rows: bytes) -> list[int]:
    return memoryview(rows).cast("q").tolist()


def test_rows_have_the_values_of_their_moment(compiled: bool, memory: bytearray) -> None:
    group = group_of(
        ("UINT8", MemoryCell(memory, 3, 1)),
        ("INT16", lambda: b"\xff\xff"),
        ("INT64", MemoryCell(memory, 5, 8)),
        compiled=compiled,
    )
    for moment in (1, 2, 3):
        memory[3] = moment
        memory[5:13] = (-moment).to_bytes(8, "little", signed=True)
        assert group.sample() == 0
    assert words(group.rows(0, 9)[1]) == [1, 0xFFFF, -1, 2, 0xFFFF, -2, 3, 0xFFFF, -3]
    assert group.due_ns == 4 * MS


def test_the_oldest_rows_go_and_are_counted(compiled: bool, memory: bytearray) -> None:
    group = group_of(("UINT8", MemoryCell(memory, 0, 1)), compiled=compiled)
    for moment in range(11):
        memory[0] = moment
        group.sample()
    assert group.oldest == 7
    assert group.rows(0, 100)[0] == 7
    assert words(group.rows(0, 100)[1]) == [7, 8, 9, 10]
    first, rows = group.rows(8, 2)
    assert (first, words(rows)) == (8, [8, 9])
    assert group.rows(20, 5) == (11, b"")
    assert group.rows(9, 0) == (9, b"")
    assert group.rows(9, -5) == (9, b"")


def test_memory_that_grows_is_found_again(compiled: bool, memory: bytearray) -> None:
    group = group_of(("UINT32", MemoryCell(memory, 100, 4)), compiled=compiled)
    group.sample()
    memory.extend(bytes(1 << 22))  # it is elsewhere now
    memory[100] = 7
    group.sample()
    assert words(group.rows(0, 9)[1]) == [0, 7]


def test_a_channel_that_cannot_be_read_ends(compiled: bool, memory: bytearray) -> None:
    values = iter((b"\1", b"\2"))

    def read() -> bytes:
        try:
            return next(values)
        except StopIteration:
            raise LookupError("axis 3 is gone") from None

    group = group_of(
        ("UINT8", read),
        ("UINT8", lambda: b"\5"),
        ("UINT8", MemoryCell(memory, 0, 1)),
        compiled=compiled,
    )
    for _ in range(4):
        memory[0] += 1
        group.sample()
    gone, *others = group.channels
    assert (gone.failure, gone.length) == ("axis 3 is gone", 2)
    assert not any(each.failure for each in others)
    assert words(group.rows(0, 9)[1]) == [1, 5, 1, 2, 5, 2, 0, 5, 3, 0, 5, 4]
    group.lose(0, "again")
    assert gone.failure == "axis 3 is gone"


def test_triggers_fire_at_their_row(compiled: bool, memory: bytearray) -> None:
    group = group_of(("UINT8", MemoryCell(memory, 0, 1)), compiled=compiled, trigger="c0 rising 2")
    fired = []
    for value in (3, 1, 2, 2, 0, 5):
        memory[0] = value
        fired.append(group.sample())
    assert fired == [0, 0, 1, 0, 0, 1]


def test_an_address_is_that_of_the_value(memory: bytearray) -> None:
    if not compiler_installed():
        pytest.skip("no compiler")
    pages = mmap.mmap(-1, 4096)
    group = group_of(("UINT16", MemoryCell(pages, 9, 2)), compiled=True)  # type: ignore[arg-type]
    pages[9:11] = b"\1\2"
    group.sample()
    assert words(group.rows(0, 1)[1]) == [0x0201]
    assert address_of(MemoryCell(memory, 5, 1)) - address_of(MemoryCell(memory, 0, 1)) == 5
    memory.extend(b"free to grow")
    pages.close()


def test_a_copy_beside_sampling_has_whole_rows_in_order(memory: bytearray) -> None:
    """Another thread copies; rows that go meanwhile are left out, none is of two moments."""
    group = group_of(
        *[("INT64", MemoryCell(memory, 8 * n, 8)) for n in range(16)],
        compiled=compiler_installed(),
        capacity=20_000,
    )

    def sample(count: int) -> None:
        for _ in range(count):
            memory[:] = group.count.to_bytes(8, "little") * 16
            group.sample()

    sample(25_000)
    copies: list[tuple[int, bytearray]] = []

    def copy() -> None:
        copies.extend(group.copy(group.oldest, group.count) for _ in range(10))

    thread = threading.Thread(target=copy)
    thread.start()
    while thread.is_alive():
        sample(100)
    for first, rows in copies:
        numbers = words(bytes(rows))
        assert numbers[::16] == list(range(first, first + len(numbers) // 16))
        assert numbers[15::16] == numbers[::16]


def test_a_copy_while_a_row_is_written_has_neither_it_nor_the_one_that_it_replaces(
    memory: bytearray,
) -> None:
    group = group_of(("INT64", MemoryCell(memory, 0, 8)), compiled=False, capacity=4)
    take, copies = group._take, []

    def take_slowly(row: int) -> int:
        copies.append(group.copy(0, group.count + 1))
        fired = take(row)
        copies.append(group.copy(0, group.count + 1))
        return fired

    group._take = take_slowly
    for number in range(9):
        memory[0] = number
        group.sample()
        (before, rows), (after, again) = copies
        assert before == after == max(number - 3, 0)
        assert words(bytes(rows)) == words(bytes(again)) == list(range(before, number))
        copies.clear()


def test_a_copy_leaves_out_what_went_meanwhile(memory: bytearray) -> None:
    group = group_of(("INT64", MemoryCell(memory, 0, 8)), compiled=False, capacity=4)
    for _ in range(6):
        memory[0] = group.count
        group.sample()
    assert group.copy(0, 6) == (
        2,
        bytearray(bytes([2, *bytes(7), 3, *bytes(7), 4, *bytes(7), 5, *bytes(7)])),
    )
    for _ in range(10):
        group.sample()
    assert group.copy(2, 6) == (6, bytearray())
