"""ADS packets by mailbox (AoE): a message is an AMS packet, 32 bytes of header and its data.

The packets are taken as they are: only invoke id and the flag of responses are looked at, to find
the answer to a request.

Source: ETG.1020 §3 (AoE); manuals of modules with AoE for the header.
"""

from collections.abc import Callable

from achse.ethercat.mailbox import MailboxProtocol
from achse.ethercat.master.errors import WrongAnswer
from achse.ethercat.master.mailbox_client import MailboxClient
from achse.ethercat.master.steps import Steps

_HEADER = 32
_COMMAND, _FLAGS, _LENGTH, _INVOKE_ID = slice(16, 18), 18, slice(20, 24), slice(28, 32)
_RESPONSE = 0x01


def is_packet(data: bytes) -> bool:
    """Return True if the bytes are one whole AMS packet."""
    return len(data) >= _HEADER and int.from_bytes(data[_LENGTH], "little") == len(data) - _HEADER


class AoeClient:
    """ADS of the slave behind a mailbox. All are `Steps`; they raise `BusError`.

    What the slave sends by itself goes to `take`, packet by packet.
    """

    def __init__(self, mailbox: MailboxClient) -> None:
        self._mailbox = mailbox
        self.take: Callable[[bytes], None] | None = None
        mailbox.listen(MailboxProtocol.AOE, self._take)

    def _take(self, data: bytes) -> None:
        if self.take is not None and is_packet(data):
            self.take(data)

    @property
    def room(self) -> int:
        """Bytes of the longest packet."""
        return min(self._mailbox.capacity, self._mailbox.incoming.length - 6)

    def request(self, packet: bytes, *, response_ns: int = 0) -> Steps[bytes]:
        """Return the response to a request: the packet with its invoke id and command."""
        self._check(packet)

        def wanted(data: bytes) -> bool:
            return (
                is_packet(data)
                and bool(data[_FLAGS] & _RESPONSE)
                and data[_INVOKE_ID] == packet[_INVOKE_ID]
                and data[_COMMAND] == packet[_COMMAND]
            )

        return (yield from self._mailbox.converse(MailboxProtocol.AOE, packet, wanted, response_ns))

    def send(self, packet: bytes) -> Steps[None]:
        """Send a packet that has no answer: a response, a notification."""
        self._check(packet)
        mailbox = self._mailbox
        yield from mailbox.acquire()
        try:
            yield from mailbox.send(MailboxProtocol.AOE, packet)
        finally:
            mailbox.release()

    def _check(self, packet: bytes) -> None:
        if not is_packet(packet):
            raise WrongAnswer(f"{len(packet)} bytes are not an AMS packet")
