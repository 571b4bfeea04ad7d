"""CANopen over EtherCAT, the slave's end: SDO transfers, object information, emergencies.

Source: 001 §2.6, §2.7; layouts as masters send and expect them.
"""

import struct
from collections.abc import Iterable
from enum import IntEnum

from achse.codes import SdoAbort
from achse.ethercat.application import Application
from achse.ethercat.mailbox import MailboxError
from achse.ethercat.pdo_service import RX_PDO, TX_PDO, PdoService
from achse.ethercat.sdo import SdoServer
from achse.ethercat.sdo_information import SdoInformation

_HEADER = struct.Struct("<H")
_SERVICE_AT, _PDO_NUMBER = 12, (1 << 9) - 1
"""Parts of the CoE header."""


class CoeService(IntEnum):
    """Bits 12..15 of the CoE header."""

    EMERGENCY = 1
    SDO_REQUEST = 2
    SDO_RESPONSE = 3
    TX_PDO = 4
    RX_PDO = 5
    TX_PDO_REQUEST = 6
    RX_PDO_REQUEST = 7
    SDO_INFORMATION = 8


class CoeServer:
    """Answers the CoE messages of a master from an application's dictionary."""

    def __init__(self, application: Application) -> None:
        objects = {each.index: each for each in application.objects()}
        self._sdo = SdoServer(application, objects)
        self._information = SdoInformation(objects)
        self._pdos = PdoService(application, objects)
        self.capacity = 0

    def reset(self, mailbox_length: int) -> None:
        """Begin again with a mailbox to the master of `mailbox_length` bytes."""
        self.capacity = mailbox_length - 8
        self._sdo.reset()

    def answer(self, data: bytes) -> Iterable[bytes] | MailboxError:
        """Return the replies to a CoE message, or why it is refused."""
        if len(data) < 2:
            return MailboxError.SIZE_TOO_SHORT
        body = data[2:]
        head = int.from_bytes(data[:2], "little")
        service = head >> _SERVICE_AT
        match service:
            case CoeService.SDO_REQUEST if len(body) >= 8:
                reply, aborted = self._sdo.answer(body, self.capacity)
                if reply is None:
                    return ()
                # an abort is sent as a request, in both directions
                service = CoeService.SDO_REQUEST if aborted else CoeService.SDO_RESPONSE
                return (_framed(service, reply),)
            case CoeService.SDO_INFORMATION if len(body) >= 6:
                replies = self._information.answer(body, self.capacity)
                return [_framed(CoeService.SDO_INFORMATION, reply) for reply in replies]
            case CoeService.TX_PDO_REQUEST | CoeService.RX_PDO_REQUEST | CoeService.RX_PDO:
                return self._pdo(service, head & _PDO_NUMBER, body)
            case CoeService.SDO_REQUEST | CoeService.SDO_INFORMATION:
                return MailboxError.SIZE_TOO_SHORT
            case _:
                return MailboxError.SERVICE_NOT_SUPPORTED

    def _pdo(self, service: int, number: int, body: bytes) -> Iterable[bytes] | MailboxError:
        """Return a PDO requested, or written: a write has no answer."""
        try:
            if service == CoeService.RX_PDO:
                self._pdos.write(RX_PDO + number, body)
                return ()
            output = service == CoeService.RX_PDO_REQUEST
            data = self._pdos.read((RX_PDO if output else TX_PDO) + number)
        except SdoAbort:
            return () if service == CoeService.RX_PDO else MailboxError.SERVICE_NOT_SUPPORTED
        if len(data) > self.capacity:
            return MailboxError.INVALID_SIZE
        answered = CoeService.RX_PDO if output else CoeService.TX_PDO
        return (_HEADER.pack(answered << _SERVICE_AT | number) + data,)

    @staticmethod
    def emergency(data: bytes) -> bytes:
        """Return the CoE message for the 8 bytes of an emergency."""
        return _framed(CoeService.EMERGENCY, data)


def _framed(service: CoeService, body: bytes) -> bytes:
    return _HEADER.pack(service << _SERVICE_AT) + body
