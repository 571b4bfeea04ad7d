"""Frames of calls, and the memory of `__NEW`."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.plc.code.faults import PlcFault
from achse.plc.code.frames import HEAP_SIZE, STACK_SIZE, Frames, Heap
from achse.plc.code.views import Views
from achse.plc.memory import Area, Memory


def test_frames_are_one_above_the_other_and_begin_as_their_image() -> None:
    memory = Memory()
    frames = Frames(memory, Views(memory))
    first = frames.enter(5, b"abcde")
    second = frames.enter(3, b"xyz")
    assert (first, second) == (0, 8)
    assert memory[Area.STACK].read(8, 3) == b"xyz"
    frames.leave(second)
    assert frames.enter(1, b"!") == 8


def test_frames_without_room_are_a_stack_overflow() -> None:
    memory = Memory()
    frames = Frames(memory, Views(memory))
    frames.enter(STACK_SIZE, bytes(STACK_SIZE))
    with pytest.raises(PlcFault, match="STACK_OVERFLOW"):
        frames.enter(1, b"\0")
    frames.clear()
    assert frames.enter(1, b"\0") == 0


@given(st.lists(st.tuples(st.booleans(), st.integers(1, HEAP_SIZE // 3)), max_size=40))
def test_blocks_never_overlap_and_all_room_comes_back(steps: list[tuple[bool, int]]) -> None:
    """Random order of making and freeing, of any size."""
    memory = Memory()
    heap = Heap(memory)
    base = memory.address(Area.HEAP, 0)
    live: dict[int, int] = {}
    for makes, number in steps:
        if makes:
            address = heap.allocate(number)
            if address:
                assert base <= address
                assert address + number <= base + HEAP_SIZE
                for other, size in live.items():
                    assert address + number <= other or other + size <= address
                live[address] = number
        elif live:
            address = sorted(live)[number % len(live)]
            del live[address]
            heap.free(address)
    for address in live:
        heap.free(address)
    assert heap.used == 0
    assert heap.allocate(HEAP_SIZE) == base


def test_freeing_what_was_not_made_is_an_access_violation() -> None:
    heap = Heap(Memory())
    with pytest.raises(PlcFault, match="ACCESS_VIOLATION"):
        heap.free(4711)
