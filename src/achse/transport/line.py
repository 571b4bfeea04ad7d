"""The surroundings of a peer: a line that carries bytes, and calls at a time.

An asyncio transport is a `Line`, and its loop is `Turns`; tests and other roads have their own.
"""

from collections.abc import Callable
from typing import Protocol

__all__ = ["Line", "Timer", "Turns"]


class Line(Protocol):
    """Carrier of bytes to a peer, in order."""

    def write(self, data: bytes, /) -> None:
        """Send `data`, or keep it until the peer takes it."""
        ...

    def get_write_buffer_size(self) -> int:
        """Bytes that the peer has not taken yet."""
        ...

    def close(self) -> None:
        """End once the peer has taken everything."""
        ...

    def abort(self) -> None:
        """End at once."""
        ...

    def pause_reading(self) -> None:
        """Bring nothing for the present, or little."""
        ...

    def resume_reading(self) -> None:
        """Bring on what comes."""
        ...


class Timer(Protocol):
    """A call to come."""

    def cancel(self) -> None: ...


class Turns(Protocol):
    """Source of calls: at the end of this turn, or at a time in seconds."""

    def time(self) -> float: ...

    def call_soon(self, callback: Callable[[], object], /) -> object: ...

    def call_at(self, when: float, callback: Callable[[], object], /) -> Timer: ...
