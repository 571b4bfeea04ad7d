"""A timer that wakes an asyncio loop at a moment of the monotonic clock (Linux, timerfd).

A loop's own timers are as coarse as a millisecond; a helper thread costs two more switches. The
timer is a file descriptor that is readable when its moment has come.
"""

import ctypes
import os
import sys

_MONOTONIC, _ABSOLUTE = 1, 1


class _Spec(ctypes.Structure):
    """struct itimerspec: interval, then the first time; seconds and nanoseconds each."""

    _fields_ = (
        ("interval_s", ctypes.c_long),
        ("interval_ns", ctypes.c_long),
        ("first_s", ctypes.c_long),
        ("first_ns", ctypes.c_long),
    )


class WakeTimer:
    """One timer, until `close`."""

    def __init__(self) -> None:
        """OSError where the system has none."""
        if sys.platform != "linux":
            raise OSError("timerfd is Linux's")
        self._library = ctypes.CDLL(None, use_errno=True)
        try:
            create = self._library.timerfd_create
        except AttributeError:
            raise OSError("this C library has no timerfd") from None
        self._descriptor = create(_MONOTONIC, os.O_NONBLOCK | os.O_CLOEXEC)
        if self._descriptor < 0:
            raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
        self._spec = _Spec()
        self._reference = ctypes.byref(self._spec)

    def fileno(self) -> int:
        """Return the descriptor that is readable from the moment on."""
        return int(self._descriptor)

    def wake_at(self, moment_ns: int) -> None:
        """Become readable at this moment of `time.monotonic_ns`; at once if it is over."""
        spec = self._spec
        spec.first_s, spec.first_ns = divmod(max(moment_ns, 1), 1_000_000_000)
        self._library.timerfd_settime(self._descriptor, _ABSOLUTE, self._reference, None)

    def clear(self) -> None:
        """Become unreadable until the next moment."""
        try:
            os.read(self._descriptor, 8)
        except BlockingIOError:  # it was not
            return

    def close(self) -> None:
        """Free the descriptor."""
        os.close(self._descriptor)
