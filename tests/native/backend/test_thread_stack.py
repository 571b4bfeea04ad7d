"""Bounds of stacks: of the main thread, of threads of many sizes, and of unknown systems."""

import gc
import threading
from array import array
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.native.backend import U64, Effort, MachineCode, ModuleBuilder, compile_module
from achse.native.backend import thread_stack as room
from achse.native.backend.thread_stack import (
    StackLimit,
    bounds_of_this_thread,
    reserve_of,
)
from tests.native.backend.stacks import in_thread

T = TypeVar("T")
KB = 1 << 10
SIZES = [64 * KB, 128 * KB, 1024 * KB, 8192 * KB, 64 * KB * KB]


@cache
def pointer() -> Callable[[], int]:
    """A function that gives the stack pointer of the running thread."""
    module = ModuleBuilder()
    body = module.function("here", [], [U64], exported=True)
    body.return_(body.stack_pointer())
    content = compile_module(module, Effort.FAST)
    result: Callable[[], int] = MachineCode(content, module.interface).function("here")
    return result


def test_bounds_hold_the_stack_pointer_of_the_main_thread() -> None:
    here = pointer()()
    low, high = bounds_of_this_thread(here)
    assert low < here < high
    assert low + 128 * KB < here, "there is room for calls"


@pytest.mark.parametrize("size", SIZES)
def test_bounds_of_a_thread_have_its_size(size: int) -> None:
    def work() -> tuple[int, Any]:
        here = pointer()()
        return here, bounds_of_this_thread(here)

    here, (low, high) = in_thread(size, work)
    assert low < here < high
    assert size <= high - low <= 4 * size + 64 * KB, "C libraries use stacks of ended threads again"


@given(st.sampled_from([None, "wrong", OSError, AttributeError]), st.integers(0, 1 << 47))
def test_unknown_bounds_are_guessed_around_the_stack_pointer(answer: Any, here: int) -> None:
    def bounds(_: int) -> Any:
        if isinstance(answer, type):
            raise answer
        return answer and room.StackBounds(here + 1, here + 2)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(room, "_bounds_by_system", bounds)
        low, high = bounds_of_this_thread(here)
    assert low == max(here - 128 * KB, 0)
    assert low <= here < high


@given(st.integers(1, 1 << 40))
def test_reserve_is_a_quarter_between_its_ends(size: int) -> None:
    assert reserve_of(size) == min(max(size // 4, 64 * KB), 1024 * KB)


def test_main_stack_ends_above_the_mapping_below(monkeypatch: pytest.MonkeyPatch) -> None:
    """RLIMIT_STACK may say more than the kernel gives: 256 pages above the next mapping."""
    import resource

    page = resource.getpagesize()
    maps = "1000-300000 rw-p 0 0:0 0 x\n{:x}-{:x} rw-p 0 0:0 0 [stack]\n"
    high = 0x300000 + 4096 * page
    with monkeypatch.context() as patch:  # whoever measures the test reads files behind it
        patch.setattr(Path, "read_text", lambda *_, **__: maps.format(high - page, high))
        for limit, low in (
            (resource.RLIM_INFINITY, 0x300000 + 256 * page),
            (1 << 40, 0x300000 + 256 * page),
            (100 * page, high - 100 * page),
            (0, high - page),
        ):
            patch.setattr(resource, "getrlimit", lambda _, limit=limit: (limit, limit))
            assert room._bounds_of_main_thread(high - 1) == (low, high)
        assert room._bounds_of_main_thread(0x100) is None


def test_limits_end_with_their_thread() -> None:
    words = array("q", [0, 0, 0])
    limit = StackLimit(words)

    def work() -> tuple[int, list[int]]:
        here = pointer()()
        limit.adopt(here)
        return here, list(words)

    here, (lowest, low, size) = in_thread(256 * KB, work)
    assert low < lowest < here < low + size
    assert lowest - low == reserve_of(size)
    gc.collect()
    assert list(words) == [lowest, low, 0], "no other thread is taken for the one that ended"


def test_borrowed_limits_are_given_back() -> None:
    words = array("q", [0, 0, 0])
    limit = StackLimit(words)
    limit.adopt(pointer()())
    ours = list(words)

    def work() -> list[int]:
        with limit.borrowed(pointer()()):
            return list(words)

    assert in_thread(256 * KB, work) != ours
    gc.collect()
    assert list(words) == ours


def test_limits_borrowed_from_a_thread_that_ended_are_of_no_stack() -> None:
    words = array("q", [0, 0, 0])
    limit = StackLimit(words)
    adopted = threading.Event()
    ours: list[int] = []

    def work() -> None:
        limit.adopt(pointer()())
        ours.extend(words)
        adopted.set()

    thread = threading.Thread(target=work)
    thread.start()
    adopted.wait()
    with limit.borrowed(pointer()()):
        thread.join()
        gc.collect()
    assert list(words) == [*ours[:2], 0]


def test_guessed_bounds_move_up_but_not_down(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(room, "_bounds_by_system", lambda _: None)
    words = array("q", [0, 0, 0])
    limit = StackLimit(words)

    def work() -> list[int]:
        lows = []
        for here in (1 << 30, (1 << 30) - 4096 * KB, (1 << 30) + 128 * KB):
            limit.adopt(here)
            lows.append(words[1])
        return lows

    low = (1 << 30) - 128 * KB
    assert in_thread(256 * KB, work) == [low, low, low + 256 * KB - 128 * KB]
