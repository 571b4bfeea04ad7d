"""The surroundings of a peer: a line that carries bytes, calls at a time, and its owner.

An asyncio transport is a `Line`, and its loop is `Turns`; tests and other roads have their own.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

from achse.router import Router
from achse.transport.connections.fair_queue import FairQueue
from achse.transport.connections.send_budget import SendBudget

if TYPE_CHECKING:
    from achse.transport.connections.peer import Peer


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


class PeerOwner(Protocol):
    """Owner of connections that it accepted or dialled, with their limits."""

    router: Router
    max_length: int
    max_backlog: int
    routes_required: bool
    send_budget: SendBudget
    fair_queue: FairQueue

    @property
    def loop(self) -> Turns: ...

    def serves_ports(self, host: str) -> bool:
        """Return True if a peer at `host` may register ports here."""
        ...

    def opened(self, peer: "Peer") -> None:
        """Its line is there."""

    def closed(self, peer: "Peer") -> None:
        """Its line is gone."""
