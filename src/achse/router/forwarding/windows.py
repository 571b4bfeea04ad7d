"""Windows: how much of one client is at the targets, so that others need not wait behind it.

A connection carries requests one after the other, and a target answers them so. A client that sends
thousands at once has a window of them under way; the others wait here, in the order of the client,
until answers come. So a request of another client has at most one window of each client before it.
A host with many connections has smaller windows (`shares`). A target that leaves requests
unanswered gets another window each second: it may answer others.
"""

from collections.abc import Callable, Iterator

from achse.ams import Command
from achse.ams.frame import AMS_HEADER, TCP_HEADER
from achse.router.forwarding.forwarded_client import ClientLoad

_HEADERS = TCP_HEADER.size + AMS_HEADER.size
_COMMAND = TCP_HEADER.size + 16

_READS = (int(Command.READ), int(Command.READ_WRITE))


def _weight(packet: bytes) -> int:
    """Return the bytes of a request and of the answer that it asks for."""
    size = len(packet) - _HEADERS
    if int.from_bytes(packet[_COMMAND : _COMMAND + 2], "little") not in _READS:
        return size
    return size + int.from_bytes(packet[_HEADERS + 8 : _HEADERS + 12], "little")


def _frames(data: bytes) -> Iterator[bytes]:
    """Yield the frames of which `data` consists."""
    position = 0
    while position < len(data):
        stop = position + TCP_HEADER.size + TCP_HEADER.unpack_from(data, position)[1]
        yield data[position:stop]
        position = stop


class Windows:
    """The requests of one connection that wait.

    `write` sends packets to the targets; `later` calls back after a second.
    """

    def __init__(
        self,
        write: Callable[[list[bytes]], object],
        later: Callable[[Callable[[], object]], object],
    ) -> None:
        self._write = write
        self._later = later
        self._waiting: dict[ClientLoad, int] = {}
        """Loads with requests that wait, with what had gone a second ago."""
        self._due = False

    def __len__(self) -> int:
        """Requests that wait."""
        return sum(len(load.waiting) for load in self._waiting)

    def is_open(self, load: ClientLoad) -> bool:
        """True if all requests of a client, as they are entered now, may be at the targets."""
        if load.waiting:
            return False
        share, count = load.share, load.count
        return count <= 1 or (count <= share.window and load.size <= share.window_bytes)

    def _fits(self, load: ClientLoad, sent: int, size: int) -> bool:
        """True if a further request may go beside so many, of `size` bytes with it."""
        share = load.share
        return sent <= 0 or (sent < share.window and size <= share.window_bytes)

    def admit(self, load: ClientLoad, data: bytes, count: int, size: int) -> list[bytes]:
        """Return the requests in `data` that may go now; the others wait.

        They were entered before: `count` requests of `size` bytes with their answers.
        """
        packets: list[bytes] = []
        sent, sent_size = load.count - count, load.size - size
        for packet in _frames(data):
            weight = _weight(packet) if count else 0
            if load.waiting or not self._fits(load, sent, sent_size + weight):
                self._keep(load, packet, weight)
            else:
                packets.append(packet)
                sent += 1
                sent_size += weight
        return packets

    def _keep(self, load: ClientLoad, packet: bytes, weight: int) -> None:
        load.waiting.append((packet, weight))
        load.waiting_size += weight
        if load not in self._waiting:
            self._waiting[load] = load.released
            self._look_later()

    def go_on(self, load: ClientLoad, most: int = 0) -> None:
        """Send what fits now, after an answer; `most` requests whether they fit or not."""
        packets: list[bytes] = []
        while load.waiting:
            packet, weight = load.waiting[0]
            sent, sent_size = load.count - len(load.waiting), load.size - load.waiting_size
            if len(packets) >= most and not self._fits(load, sent, sent_size + weight):
                break
            load.waiting.popleft()
            load.waiting_size -= weight
            load.released += 1
            packets.append(packet)
        if not load.waiting:
            self._waiting.pop(load, None)
        if packets:
            self._write(packets)

    def _look_later(self) -> None:
        if not self._due:
            self._due = True
            self._later(self._look)

    def _look(self) -> None:
        """Send another window of those from which nothing has gone for a second."""
        self._due = False
        for load, before in list(self._waiting.items()):
            if load.released == before:
                self.go_on(load, load.share.window)
            if load in self._waiting:
                self._waiting[load] = load.released
        if self._waiting:
            self._look_later()

    def clear(self) -> None:
        """Forget all: the connection has ended."""
        for load in self._waiting:
            load.waiting.clear()
            load.waiting_size = 0
        self._waiting.clear()
