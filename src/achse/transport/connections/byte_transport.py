"""Interfaces that a peer needs: a transport of bytes, a scheduler of calls, and its owner.

An asyncio transport is a `ByteTransport`, and its loop is a `Scheduler`; tests and other transports
have their own.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

from achse.router import Router
from achse.transport.connections.fair_queue import FairQueue
from achse.transport.connections.send_budget import SendBudget

if TYPE_CHECKING:
    from achse.transport.connections.peer import Peer


class ByteTransport(Protocol):
    """Carrier of bytes to a peer, in order."""

    def write(self, data: bytes, /) -> None:
        """Send `data`, or buffer it until the peer reads it."""
        ...

    def get_write_buffer_size(self) -> int:
        """Return the number of buffered bytes."""
        ...

    def close(self) -> None:
        """Close once the buffer is empty."""
        ...

    def abort(self) -> None:
        """Close at once."""
        ...

    def pause_reading(self) -> None:
        """Deliver no more bytes, or few, until `resume_reading`."""
        ...

    def resume_reading(self) -> None:
        """Deliver received bytes again."""
        ...


class Timer(Protocol):
    """A scheduled call."""

    def cancel(self) -> None: ...


class Scheduler(Protocol):
    """Scheduler of calls: at the end of this turn, or at a time in seconds."""

    def time(self) -> float: ...

    def call_soon(self, callback: Callable[[], object], /) -> object: ...

    def call_at(self, when: float, callback: Callable[[], object], /) -> Timer: ...


class PeerOwner(Protocol):
    """Owner of connections that it accepted or dialled, with their limits."""

    router: Router
    max_length: int
    max_backlog: int
    routes_required: bool
    send_budget: SendBudget
    fair_queue: FairQueue

    @property
    def loop(self) -> Scheduler: ...

    def serves_ports(self, host: str) -> bool:
        """Return True if a peer at `host` may register ports here."""
        ...

    def opened(self, peer: "Peer") -> None:
        """Note that the transport of `peer` is connected."""

    def closed(self, peer: "Peer") -> None:
        """Note that the transport of `peer` is closed."""
