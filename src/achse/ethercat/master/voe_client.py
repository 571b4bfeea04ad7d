"""Messages of a vendor's own form by mailbox (VoE): vendor id, vendor type, anything.

Source: ETG.1000.6 §5.10.
"""

import struct
from typing import NamedTuple

from achse.ethercat.mailbox import MailboxProtocol
from achse.ethercat.master.errors import WrongAnswer
from achse.ethercat.master.mailbox_client import MailboxClient
from achse.ethercat.master.steps import Steps

_HEAD = struct.Struct("<IH")


class VendorMessage(NamedTuple):
    """One message: whose form it has (a vendor id), which of its types, and the rest."""

    vendor: int
    type: int
    data: bytes = b""

    def encode(self) -> bytes:
        """As it travels."""
        return _HEAD.pack(self.vendor, self.type) + self.data

    @classmethod
    def decode(cls, message: bytes) -> "VendorMessage":
        """WrongAnswer for a message that is too short."""
        if len(message) < _HEAD.size:
            raise WrongAnswer(f"a vendor's message has 6 bytes or more, got {len(message)}")
        vendor, kind = _HEAD.unpack_from(message)
        return cls(vendor, kind, message[_HEAD.size :])


class VoeClient:
    """Messages to the slave behind a mailbox, as `Steps` that raise `BusError`, and from it.

    `last` is the last unsolicited one, `count` the number of them.
    """

    def __init__(self, mailbox: MailboxClient) -> None:
        self._mailbox = mailbox
        self.last: VendorMessage | None = None
        self.count = 0
        mailbox.listen(MailboxProtocol.VOE, self._take)

    def _take(self, data: bytes) -> None:
        if len(data) >= _HEAD.size:
            self.last = VendorMessage.decode(data)
            self.count += 1

    def send(self, message: VendorMessage) -> Steps[None]:
        """Send a message that has no answer."""
        mailbox = self._mailbox
        yield from mailbox.acquire()
        try:
            yield from mailbox.send(MailboxProtocol.VOE, message.encode())
        finally:
            mailbox.release()

    def request(self, message: VendorMessage, *, response_ns: int = 0) -> Steps[VendorMessage]:
        """Send a message; the next of the same vendor is the answer."""
        head = message.vendor.to_bytes(4, "little")
        answer = yield from self._mailbox.converse(
            MailboxProtocol.VOE,
            message.encode(),
            lambda data: len(data) >= _HEAD.size and data[:4] == head,
            response_ns,
        )
        return VendorMessage.decode(answer)
