"""SDO transfers and object information, the master's end.

Source: 001 §2.6, §2.7; command bytes as masters and slaves were seen to send them.
"""

import struct
from collections.abc import Callable
from dataclasses import dataclass

from achse.ethercat.coe import CoeService
from achse.ethercat.mailbox import MailboxProtocol
from achse.ethercat.master.errors import SdoRefusal, WrongAnswer
from achse.ethercat.master.mailbox_client import MailboxClient
from achse.ethercat.master.steps import Steps

MAX_UPLOAD = 1 << 24
"""Bytes of the longest value that is taken from a slave."""

_HEAD = struct.Struct("<BHB")
_WITH_NUMBER = struct.Struct("<BHBI")
_COE = struct.Struct("<H")

_DOWNLOAD, _UPLOAD, _UPLOAD_SEGMENT, _ABORT = 0x20, 0x40, 0x60, 0x80
_DOWNLOADED, _DOWNLOADED_SEGMENT, _UPLOADED = 0x60, 0x20, 0x40
_SPECIFIER = 0xE0
_COMPLETE, _TOGGLE = 0x10, 0x10
_EXPEDITED, _SIZE_INDICATED, _LAST = 0x02, 0x01, 0x01

_LIST, _OBJECT, _ENTRY = (1, 2), (3, 4), (5, 6)
"""Operations of SDO information: request and answer."""
_INFORMATION_ERROR = 7
_INCOMPLETE = 0x80
_MAX_FRAGMENTS = 4096

_TOGGLE_FAULT, _COMMAND_FAULT = 0x0503_0000, 0x0504_0001
"""Abort codes this end sends."""


@dataclass(frozen=True, slots=True)
class ObjectInformation:
    """An object as the slave describes it; `code` is an `ObjectCode` number."""

    index: int
    data_type: int
    max_subindex: int
    code: int
    name: str


@dataclass(frozen=True, slots=True)
class EntryInformation:
    """An entry as the slave describes it; `values` are the bytes that follow by `info`."""

    index: int
    subindex: int
    info: int
    data_type: int
    bits: int
    access: int
    rest: bytes


class SdoClient:
    """Objects of the slave behind a mailbox. All are `Steps`; they raise `BusError`."""

    def __init__(self, mailbox: MailboxClient) -> None:
        self._mailbox = mailbox

    def upload(
        self, index: int, subindex: int = 0, *, complete: bool = False, response_ns: int = 0
    ) -> Steps[bytes]:
        """Return the value of an entry, or with `complete` of an object from `subindex` 0 or 1
        on."""
        yield from self._mailbox.acquire()
        try:
            command = _UPLOAD | _COMPLETE * complete
            request = _HEAD.pack(command, index, subindex) + bytes(4)
            reply = yield from self._exchange(request, index, subindex, response_ns)
            if reply[0] & _SPECIFIER != _UPLOADED:
                raise WrongAnswer(f"{index:04X}: command 0x{reply[0]:02X} answers an upload")
            if reply[0] & _EXPEDITED:
                size = 4 - (reply[0] >> 2 & 3) if reply[0] & _SIZE_INDICATED else 4
                return reply[4 : 4 + size]
            size = int.from_bytes(reply[4:8], "little")
            if size > MAX_UPLOAD:
                raise WrongAnswer(f"{index:04X}: {size} bytes announced, {MAX_UPLOAD} are taken")
            value = bytearray(reply[8:])
            yield from self._upload_segments(value, size, index, subindex, response_ns)
            return bytes(value[:size])
        finally:
            self._mailbox.release()

    def _upload_segments(
        self, value: bytearray, size: int, index: int, subindex: int, response_ns: int
    ) -> Steps[None]:
        toggle = 0
        last = len(value) >= size
        while not last:
            request = bytes((_UPLOAD_SEGMENT | toggle,)) + bytes(7)
            reply = yield from self._exchange(request, index, subindex, response_ns)
            if reply[0] & _SPECIFIER:
                raise WrongAnswer(f"{index:04X}: command 0x{reply[0]:02X} answers a segment")
            if reply[0] & _TOGGLE != toggle:
                yield from self._abort(index, subindex, _TOGGLE_FAULT)
                raise SdoRefusal(self._mailbox.station, index, subindex, _TOGGLE_FAULT)
            part = reply[1:]
            if len(part) == 7:
                part = part[: 7 - (reply[0] >> 1 & 7)]
            value += part
            last = bool(reply[0] & _LAST)
            if not last and (not part or len(value) > size):
                yield from self._abort(index, subindex, _COMMAND_FAULT)
                raise WrongAnswer(f"{index:04X}: {len(value)} bytes came, {size} are announced")
            toggle ^= _TOGGLE
        if len(value) < size:
            raise WrongAnswer(f"{index:04X}: {len(value)} bytes came, {size} are announced")

    def download(
        self,
        index: int,
        subindex: int,
        data: bytes,
        *,
        complete: bool = False,
        response_ns: int = 0,
    ) -> Steps[None]:
        """Write an entry, or with `complete` an object."""
        yield from self._mailbox.acquire()
        try:
            size = len(data)
            command = _DOWNLOAD | _COMPLETE * complete
            room = self._mailbox.capacity - _COE.size - _WITH_NUMBER.size
            if size <= 4 and not complete:
                if size:
                    command |= _SIZE_INDICATED | 4 - size << 2
                first = _HEAD.pack(command | _EXPEDITED, index, subindex) + data.ljust(4, b"\0")
            else:
                head = _WITH_NUMBER.pack(command | _SIZE_INDICATED, index, subindex, size)
                first = head + data[:room]
            reply = yield from self._exchange(first, index, subindex, response_ns)
            self._check(reply, _DOWNLOADED, index)
            if size > max(room, 4):
                yield from self._download_segments(data[room:], index, subindex, response_ns)
        finally:
            self._mailbox.release()

    def _download_segments(
        self, data: bytes, index: int, subindex: int, response_ns: int
    ) -> Steps[None]:
        room = self._mailbox.capacity - _COE.size - 1
        toggle = 0
        while data:
            part, data = data[:room], data[room:]
            command = toggle | (0 if data else _LAST)
            if len(part) < 7:
                command |= 7 - len(part) << 1
            request = bytes((command,)) + part.ljust(7, b"\0")
            reply = yield from self._exchange(request, index, subindex, response_ns)
            self._check(reply, _DOWNLOADED_SEGMENT, index)
            if reply[0] & _TOGGLE != toggle:
                yield from self._abort(index, subindex, _TOGGLE_FAULT)
                raise SdoRefusal(self._mailbox.station, index, subindex, _TOGGLE_FAULT)
            toggle ^= _TOGGLE

    def _check(self, reply: bytes, specifier: int, index: int) -> None:
        if reply[0] & _SPECIFIER != specifier:
            raise WrongAnswer(f"{index:04X}: command 0x{reply[0]:02X} answers a download")

    def _exchange(
        self, request: bytes, index: int, subindex: int, response_ns: int
    ) -> Steps[bytes]:
        """Send an SDO request; the answer's bytes behind the CoE header, at least 8."""
        segment = request[0] & _SPECIFIER not in (_DOWNLOAD, _UPLOAD)

        def wanted(data: bytes) -> bool:
            if len(data) < _COE.size + 8:
                return False
            service = data[1] >> 4
            if service not in (CoeService.SDO_REQUEST, CoeService.SDO_RESPONSE):
                return False
            if segment and data[2] & _SPECIFIER != _ABORT:
                return True
            return int.from_bytes(data[3:5], "little") == index

        yield from self._mailbox.send(
            MailboxProtocol.COE, _COE.pack(CoeService.SDO_REQUEST << 12) + request
        )
        data = yield from self._mailbox.receive(MailboxProtocol.COE, wanted, response_ns)
        reply = data[_COE.size :]
        if reply[0] & _SPECIFIER == _ABORT:
            number = int.from_bytes(reply[4:8], "little")
            raise SdoRefusal(self._mailbox.station, index, subindex, number)
        return reply

    def _abort(self, index: int, subindex: int, number: int) -> Steps[None]:
        yield from self._mailbox.send(
            MailboxProtocol.COE,
            _COE.pack(CoeService.SDO_REQUEST << 12)
            + _WITH_NUMBER.pack(_ABORT, index, subindex, number),
        )

    # information

    def object_list(self, kind: int = 1) -> Steps[list[int]]:
        """Indices of the objects: 1 all, 2 RxPDO, 3 TxPDO, 4 backup, 5 settings; 0 five counts."""
        data = yield from self._inform(_LIST, kind.to_bytes(2, "little"))
        numbers = data[2 : len(data) & ~1]
        return [each for (each,) in struct.iter_unpack("<H", numbers)]

    def object_information(self, index: int) -> Steps[ObjectInformation]:
        """Read the description of an object from the slave."""
        data = yield from self._inform(_OBJECT, index.to_bytes(2, "little"))
        if len(data) < 6:
            raise WrongAnswer(f"{index:04X}: a description has 6 bytes at least, got {len(data)}")
        object_index, kind, last, code = struct.unpack_from("<HHBB", data)
        return ObjectInformation(object_index, kind, last, code & 0x0F, data[6:].decode("latin-1"))

    def entry_information(
        self, index: int, subindex: int, info: int = 7
    ) -> Steps[EntryInformation]:
        """Read the description of an entry from the slave; `info` selects additional values by
        bit."""
        request = struct.pack("<HBB", index, subindex, info)
        data = yield from self._inform(_ENTRY, request)
        if len(data) < 10:
            raise WrongAnswer(f"{index:04X}: a description has 10 bytes at least, got {len(data)}")
        object_index, sub, present_info, kind, bits, access = struct.unpack_from("<HBBHHH", data)
        return EntryInformation(object_index, sub, present_info, kind, bits, access, data[10:])

    def inform(self, operation: int, request: bytes) -> Steps[bytes]:
        """Return the bytes behind the information header: 1 list, 3 object, 5 entry, fragments
        joined."""
        return (yield from self._inform((operation, operation + 1), request))

    def _inform(self, operation: tuple[int, int], request: bytes) -> Steps[bytes]:
        request_code, answered = operation
        mailbox = self._mailbox
        yield from mailbox.acquire()
        try:
            head = _COE.pack(CoeService.SDO_INFORMATION << 12)
            yield from mailbox.send(
                MailboxProtocol.COE, head + struct.pack("<BxH", request_code, 0) + request
            )
            value = bytearray()
            for _ in range(_MAX_FRAGMENTS):
                data = yield from mailbox.receive(MailboxProtocol.COE, _information(answered))
                if data[2] & ~_INCOMPLETE == _INFORMATION_ERROR:
                    number = int.from_bytes(data[6:10].ljust(4, b"\0"), "little")
                    index = int.from_bytes(request[:2], "little")
                    raise SdoRefusal(mailbox.station, index, 0, number)
                value += data[6:]
                if not data[2] & _INCOMPLETE:
                    return bytes(value)
            raise WrongAnswer(f"a description has more than {_MAX_FRAGMENTS} fragments")
        finally:
            mailbox.release()


def _information(operation: int) -> Callable[[bytes], bool]:
    def wanted(data: bytes) -> bool:
        return (
            len(data) >= 6
            and data[1] >> 4 == CoeService.SDO_INFORMATION
            and data[2] & ~_INCOMPLETE in (operation, _INFORMATION_ERROR)
        )

    return wanted
