"""The stack of a thread: its bounds by system, and the limits that machine code keeps within them.

Linux gives the bounds of a thread by `pthread_getattr_np`; the stack of the main thread grows up to
RLIMIT_STACK. macOS has `pthread_get_stackaddr_np`, Windows `GetCurrentThreadStackLimits`. Elsewhere
the bounds are a guess that is on the safe side: 128 kB below the first call of the thread.
"""

import ctypes
import os
import sys
import threading
import weakref
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

_SMALLEST_RESERVE = 64 << 10
_LARGEST_RESERVE = 1 << 20

_LARGEST_MAIN_STACK = 64 << 20
"""Bytes that Linux keeps free below the main stack at least, whatever RLIMIT_STACK is (128 MB)."""

_GUARD_PAGES = 256
"""Pages that Linux keeps free between a stack that grows and the mapping below it."""

_GUESSED = 128 << 10
"""Bytes of a stack below and above the address where a thread was first seen."""

_ATTRIBUTES_SIZE = 256
"""Bytes for a pthread_attr_t, which has 64 at most."""


class StackBounds(NamedTuple):
    """Addresses of a stack: its lowest byte, and the end above its highest. It grows downwards."""

    low: int
    high: int


_starting = threading.Lock()


def start_with_stack(thread: threading.Thread, size: int) -> None:
    """Start a thread with a stack of `size` bytes. RuntimeError or ValueError if it cannot be."""
    with _starting:  # the size is one for the whole process
        before = threading.stack_size(size)
        try:
            thread.start()
        finally:
            threading.stack_size(before)


def reserve_of(size: int) -> int:
    """Return the bytes at the end of a stack of `size` bytes that calls in one another leave free.

    Python and C functions that machine code calls use them, and calls whose frame is so small that
    it is checked only once it is there.
    """
    return max(_SMALLEST_RESERVE, min(size // 4, _LARGEST_RESERVE))


def bounds_of_this_thread(here: int) -> StackBounds:
    """Return the bounds of the stack of the running thread; `here` is an address within it."""
    bounds = None
    with suppress(OSError, AttributeError, ValueError):  # not this system, or an unusual one
        bounds = _bounds_by_system(here)
    if bounds is None or not bounds.low <= here < bounds.high:
        return StackBounds(max(here - _GUESSED, 0), here + _GUESSED)
    return bounds


def _bounds_by_system(here: int) -> StackBounds | None:
    if sys.platform == "win32":
        low, high = ctypes.c_size_t(), ctypes.c_size_t()
        ctypes.WinDLL("kernel32").GetCurrentThreadStackLimits(ctypes.byref(low), ctypes.byref(high))
        return StackBounds(low.value, high.value)
    if sys.platform == "darwin":
        return _bounds_of_mac()
    if sys.platform == "linux":
        if threading.get_native_id() == os.getpid():
            return _bounds_of_main_thread(here)
        return _bounds_of_pthread()
    return None


@cache
def _library() -> Any:
    library = ctypes.CDLL(None)
    library.pthread_self.restype = ctypes.c_void_p
    return library


def _bounds_of_mac() -> StackBounds:
    library = _library()
    library.pthread_get_stackaddr_np.restype = ctypes.c_void_p
    library.pthread_get_stacksize_np.restype = ctypes.c_size_t
    this = ctypes.c_void_p(library.pthread_self())
    high = library.pthread_get_stackaddr_np(this)
    return StackBounds(high - library.pthread_get_stacksize_np(this), high)


def _bounds_of_pthread() -> StackBounds | None:
    library = _library()
    attributes = ctypes.create_string_buffer(_ATTRIBUTES_SIZE)
    this = ctypes.c_void_p(library.pthread_self())
    if library.pthread_getattr_np(this, attributes):
        return None
    low, size = ctypes.c_void_p(), ctypes.c_size_t()
    library.pthread_attr_getstack(attributes, ctypes.byref(low), ctypes.byref(size))
    library.pthread_attr_destroy(attributes)
    start = low.value or 0
    return StackBounds(start, start + size.value)


def _bounds_of_main_thread(here: int) -> StackBounds | None:
    """Return how far the kernel lets the main stack grow: C libraries differ in what they say."""
    import resource

    limit, _ = resource.getrlimit(resource.RLIMIT_STACK)
    if limit == resource.RLIM_INFINITY or limit > _LARGEST_MAIN_STACK:
        limit = _LARGEST_MAIN_STACK
    below = 0
    for line in Path("/proc/self/maps").read_text(errors="replace").splitlines():
        start, end = (int(each, 16) for each in line.split(" ", 1)[0].split("-"))
        if start <= here < end:
            lowest = below + _GUARD_PAGES * resource.getpagesize()
            return StackBounds(min(max(end - limit, lowest), start), end)
        below = end
    return None


class _ThreadStack:
    """Bounds of the stack of a thread; gone when the thread is."""

    def __init__(self, bounds: StackBounds) -> None:
        self.bounds = bounds


_threads = threading.local()


def _this_thread(here: int) -> _ThreadStack:
    stack: _ThreadStack | None = getattr(_threads, "stack", None)
    if stack is None or here >= stack.bounds.high:  # they were guessed deep in other calls
        stack = _threads.stack = _ThreadStack(bounds_of_this_thread(here))
    return stack


class StackLimit:
    """Three words of a module: lowest stack pointer of its calls, begin and size of the stack.

    They are of the thread that its code runs on. With the thread they end: another one may have
    its stack in the same place.
    """

    def __init__(self, words: Any) -> None:
        self._words = words
        self._thread: weakref.ref[_ThreadStack] | None = None

    def adopt(self, here: int) -> None:
        """Set the limits for the running thread; `here` is an address in its stack."""
        stack, words = _this_thread(here), self._words
        low, high = stack.bounds
        words[0] = low + reserve_of(high - low)
        words[1] = low
        words[2] = high - low

        def end(_: object) -> None:
            words[2] = 0

        self._thread = weakref.ref(stack, end)

    @contextmanager
    def borrowed(self, here: int) -> Iterator[None]:
        """Set the limits for the running thread while code of another thread waits in a call."""
        words, thread = list(self._words), self._thread
        self.adopt(here)
        try:
            yield
        finally:
            if thread is not None and thread() is None:
                words[2] = 0
            self._words[0], self._words[1], self._words[2] = words
            self._thread = thread
