"""Both interfaces of a redundant bus: one that is away is opened again, the other does the work."""

from collections.abc import Callable
from typing import Protocol

from achse.ethercat.master.redundancy import Redundancy
from achse.station.buses.frame_link import FrameLink
from achse.station.buses.redundant_link import RedundantLink
from achse.transport.ethernet import LinkError

_AGAIN_NS = 5_000_000
"""Until an interface that is not there is tried again: with its link the ring is closed, and what
comes back there is lost while no master listens."""


class BusSocket(FrameLink, Protocol):
    """An open interface."""

    @property
    def gone(self) -> bool:
        """True if the interface was removed."""

    def close(self) -> None: ...


class InterfacePair(RedundantLink):
    """The interfaces at both ends of a line, opened by `open_link`; it is a `BusSocket`.

    Raises LinkError if neither can be opened.
    """

    def __init__(self, interfaces: tuple[str, str], open_link: Callable[[str], BusSocket]) -> None:
        super().__init__(None, None, Redundancy())
        self.interfaces = interfaces
        self._open_link = open_link
        self._sockets: list[BusSocket | None] = [None, None]
        self._troubles = ["", ""]
        """Reason why each interface is not open, empty if it is."""
        self._again_ns = 0
        self._open()
        if self.gone:
            raise LinkError(self.trouble)

    @property
    def trouble(self) -> str:
        """Reason why an interface is not open; empty if both are."""
        return "; ".join(filter(None, self._troubles))

    @property
    def gone(self) -> bool:
        """True if neither interface is present."""
        self._leave_gone()
        return self._sockets == [None, None]

    def send(self, frame: bytes) -> bool:
        """Send both copies; False if no interface takes one."""
        if None in self._sockets and self.clock() >= self._again_ns:
            self._again_ns = self.clock() + _AGAIN_NS
            self._open()
        return super().send(frame)

    def _open(self) -> None:
        """Open what is not open."""
        for number, interface in enumerate(self.interfaces):
            if self._sockets[number] is not None:
                continue
            try:
                self._sockets[number] = self._open_link(interface)
                self._troubles[number] = ""
            except (LinkError, OSError) as failure:
                if self._troubles[number] != _gone(interface):
                    self._troubles[number] = _why(interface, failure)
        self.links = list(self._sockets)

    def _leave_gone(self) -> None:
        for number, socket in enumerate(self._sockets):
            if socket is not None and socket.gone:
                socket.close()
                self._sockets[number] = self.links[number] = None
                self._troubles[number] = _gone(self.interfaces[number])

    def close(self) -> None:
        """Let go of both."""
        for socket in self._sockets:
            if socket is not None:
                socket.close()
        self._sockets = [None, None]
        self.links = [None, None]


def _why(interface: str, failure: LinkError | OSError) -> str:
    """Return the reason why an interface cannot be opened; a LinkError names the interface."""
    return f"{interface}: {failure.strerror}" if isinstance(failure, OSError) else str(failure)


def _gone(interface: str) -> str:
    return f"{interface} is gone"
