"""Threads with a stack of a chosen size."""

import threading
from collections.abc import Callable
from typing import TypeVar

from achse.native.backend.thread_stack import start_with_stack

T = TypeVar("T")


def in_thread(size: int, work: Callable[[], T]) -> T:
    """Return the result of `work` in a thread with a stack of so many bytes.

    The C library may give it the stack of a thread that ended, which may be four times as large.
    """
    results: list[T] = []
    thread = threading.Thread(target=lambda: results.append(work()))
    start_with_stack(thread, size)
    thread.join()
    return results[0]
