"""Parameters of a SERCOS drive by mailbox (SoE): elements of an IDN, read and written.

Source: ETG.1000.6 §5.9; IEC 61800-7-204 for elements.
"""

import struct
from enum import IntFlag

from achse.ethercat.mailbox import MailboxProtocol
from achse.ethercat.master.errors import BusError, WrongAnswer
from achse.ethercat.master.mailbox_client import MailboxClient
from achse.ethercat.master.steps import Steps

_READ, _READ_ANSWER, _WRITE, _WRITE_ANSWER = 1, 2, 3, 4
_OPERATION, _INCOMPLETE, _ERROR = 0x07, 0x08, 0x10
_HEAD = struct.Struct("<BBH")
_LONGEST = 1 << 16


class SoeElement(IntFlag):
    """Elements of an IDN; several are read one behind the other."""

    STATUS = 0x01
    NAME = 0x02
    ATTRIBUTE = 0x04
    UNIT = 0x08
    MINIMUM = 0x10
    MAXIMUM = 0x20
    VALUE = 0x40
    DEFAULT = 0x80


class SoeRefusal(BusError):
    """The drive refused access to an IDN; `number` is its SERCOS error code."""

    def __init__(self, station: int, idn: int, number: int) -> None:
        kind, parameter = ("P", idn & 0x0FFF) if idn & 0x8000 else ("S", idn & 0x0FFF)
        name = f"{kind}-{idn >> 12 & 7}-{parameter:04d}"
        super().__init__(f"station {station}: {name}: SERCOS error 0x{number:04X}")
        self.number = number
        self.idn = idn


class SoeClient:
    """IDNs of the drives behind a mailbox. All are `Steps`; they raise `BusError`."""

    def __init__(self, mailbox: MailboxClient) -> None:
        self._mailbox = mailbox

    def read(
        self,
        idn: int,
        element: int = SoeElement.VALUE,
        drive: int = 0,
        *,
        response_ns: int = 0,
    ) -> Steps[bytes]:
        """Return the bytes of an element; `drive` is 0 to 7."""
        mailbox = self._mailbox
        yield from mailbox.acquire()
        try:
            head = _HEAD.pack(_READ | drive << 5, element, idn)
            yield from mailbox.send(MailboxProtocol.SOE, head)
            value = bytearray()
            while True:
                flags, part = yield from self._answer(_READ_ANSWER, idn, drive, response_ns)
                value += part
                if len(value) > _LONGEST:
                    raise WrongAnswer(f"IDN 0x{idn:04X}: longer than {_LONGEST} bytes")
                if not flags & _INCOMPLETE:
                    return bytes(value)
        finally:
            mailbox.release()

    def write(
        self,
        idn: int,
        data: bytes,
        element: int = SoeElement.VALUE,
        drive: int = 0,
        *,
        response_ns: int = 0,
    ) -> Steps[None]:
        """Write an element; what does not fit into a message goes in fragments."""
        mailbox = self._mailbox
        room = mailbox.capacity - _HEAD.size
        yield from mailbox.acquire()
        try:
            parts = [data[at : at + room] for at in range(0, len(data), room)] or [b""]
            for left, part in zip(range(len(parts) - 1, -1, -1), parts, strict=True):
                flags = _WRITE | drive << 5 | (_INCOMPLETE if left else 0)
                head = _HEAD.pack(flags, element, left or idn)
                yield from mailbox.send(MailboxProtocol.SOE, head + part)
            yield from self._answer(_WRITE_ANSWER, idn, drive, response_ns)
        finally:
            mailbox.release()

    def _answer(
        self, operation: int, idn: int, drive: int, response_ns: int
    ) -> Steps[tuple[int, bytes]]:
        """Flags and data of the answer."""

        def wanted(data: bytes) -> bool:
            return (
                len(data) >= _HEAD.size
                and data[0] & _OPERATION == operation
                and data[0] >> 5 == drive
                and (bool(data[0] & _INCOMPLETE) or int.from_bytes(data[2:4], "little") == idn)
            )

        mailbox = self._mailbox
        answer = yield from mailbox.receive(MailboxProtocol.SOE, wanted, response_ns)
        if answer[0] & _ERROR:
            number = int.from_bytes(answer[-2:], "little")
            raise SoeRefusal(mailbox.station, idn, number)
        return answer[0], answer[_HEAD.size :]
