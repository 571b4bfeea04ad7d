"""A switch between the network ports of slaves (EoE) and of the host, without a network interface.

It learns which address is behind which port and sends frames for others to all but the sender.
What a port does not take is dropped there, as a switch does it.

Source: ETG.1000.6 §5.7.1 (a master with EoE is a switch).
"""

from collections import OrderedDict, deque
from collections.abc import Callable
from dataclasses import dataclass, field

from achse.ethercat.eoe import LONGEST_FRAME, SHORTEST_FRAME

_MOST_ADDRESSES = 1024
_MOST_WAITING = 64
"""Frames that wait at a port; more are dropped."""
_GROUP = 0x01
"""Bit of the first byte of an address: for many."""


@dataclass(eq=False)
class SwitchPort:
    """One port. `take` gets each frame for it, or without it `waiting` keeps them."""

    name: str
    take: Callable[[bytes], None] | None = None
    waiting: deque[bytes] = field(default_factory=lambda: deque(maxlen=_MOST_WAITING))
    sent: int = 0
    """Frames that came in here."""
    received: int = 0
    """Frames that went out here."""
    dropped: int = 0


class EthernetSwitch:
    """Hands Ethernet frames (destination, source, type, data; without check sum) on."""

    def __init__(self) -> None:
        self.ports: list[SwitchPort] = []
        self._behind: OrderedDict[bytes, SwitchPort] = OrderedDict()

    def attach(self, name: str, take: Callable[[bytes], None] | None = None) -> SwitchPort:
        """Another port."""
        port = SwitchPort(name, take)
        self.ports.append(port)
        return port

    def detach(self, port: SwitchPort) -> None:
        """Take a port away. Unknown is not an error."""
        if port in self.ports:
            self.ports.remove(port)
        for address in [each for each, behind in self._behind.items() if behind is port]:
            del self._behind[address]

    def send(self, port: SwitchPort, frame: bytes) -> None:
        """Accept a frame at a port. Raises ValueError for a frame of a wrong length."""
        if not SHORTEST_FRAME <= len(frame) <= LONGEST_FRAME:
            raise ValueError(
                f"an Ethernet frame has {SHORTEST_FRAME} to {LONGEST_FRAME} bytes, got {len(frame)}"
            )
        if port not in self.ports:
            raise ValueError(f"{port.name} is not at this switch")
        port.sent += 1
        target, source = frame[:6], frame[6:12]
        if not source[0] & _GROUP:
            self._behind[source] = port
            self._behind.move_to_end(source)
            if len(self._behind) > _MOST_ADDRESSES:
                self._behind.popitem(last=False)
        known = None if target[0] & _GROUP else self._behind.get(target)
        for each in tuple(self.ports) if known is None else (known,):
            if each is not port:
                _hand(each, frame)


def _hand(port: SwitchPort, frame: bytes) -> None:
    port.received += 1
    if port.take is not None:
        port.take(frame)
        return
    port.dropped += len(port.waiting) == port.waiting.maxlen
    port.waiting.append(frame)
