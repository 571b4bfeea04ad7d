"""Files by mailbox (FoE), the slave's end: packets, their acknowledgement, a device that is busy.

Source: ETG.1000.6 §5.8.
"""

import struct
from collections.abc import Iterable
from enum import IntEnum

from achse.codes import FileRefusal, FoeError
from achse.ethercat.application import FileApplication
from achse.ethercat.mailbox import MailboxError

_HEAD = struct.Struct("<BxI")
_BUSY = struct.Struct("<BxHH")
_MAILBOX_HEADER = 6


class FoeOperation(IntEnum):
    """Operation code of an FoE message."""

    READ = 1
    WRITE = 2
    DATA = 3
    ACKNOWLEDGE = 4
    ERROR = 5
    BUSY = 6


class FoeServer:
    """Answers the FoE messages of a master from the files of an application, one at a time."""

    def __init__(self, files: FileApplication) -> None:
        self._files = files
        self.reset(0, 0)

    def reset(self, out_length: int, in_length: int) -> None:
        """Begin again with mailboxes of these lengths, from and to the master."""
        self._longest_request = out_length - _MAILBOX_HEADER - _HEAD.size
        self._longest_answer = in_length - _MAILBOX_HEADER - _HEAD.size
        self._leave()

    def _leave(self) -> None:
        """End the transfer: no file is under way."""
        self._reading: bytes | None = None
        self._writing: bytearray | None = None
        self._name = ""
        self._number = 0
        self._finishing = False
        self._last = b""

    def answer(self, data: bytes) -> Iterable[bytes] | int:
        """Return the replies to a message, or the mailbox error for one that is too short."""
        if len(data) < _HEAD.size:
            return MailboxError.SIZE_TOO_SHORT
        operation, number = _HEAD.unpack_from(data)
        try:
            return self._answer(operation, number, data[_HEAD.size :])
        except FileRefusal as refusal:
            self._leave()
            text = refusal.reason.encode("latin-1", "replace")[: self._longest_answer]
            return (_HEAD.pack(FoeOperation.ERROR, refusal.code) + text,)

    def _answer(self, operation: int, number: int, data: bytes) -> Iterable[bytes]:
        match operation:
            case FoeOperation.READ:
                return self._begin_reading(_name(data), number)
            case FoeOperation.WRITE:
                return self._begin_writing(_name(data), number)
            case FoeOperation.DATA:
                return self._take(number, data)
            case FoeOperation.ACKNOWLEDGE:
                return self._acknowledged(number)
            case FoeOperation.BUSY:
                return (self._last,) if self._last else ()
            case FoeOperation.ERROR:
                self._leave()
                return ()
        raise FileRefusal(FoeError.ILLEGAL, f"operation {operation}")

    # to the master

    def _begin_reading(self, name: str, password: int) -> Iterable[bytes]:
        busy = self._files.programming
        if busy is not None:
            return (_busy(busy),)
        self._leave()
        self._reading = self._files.read_file(name, password)
        return self._next()

    def _acknowledged(self, number: int) -> Iterable[bytes]:
        if self._reading is None:
            return ()
        if number != self._number:
            raise FileRefusal(FoeError.PACKET_NUMBER, f"{self._number} expected, got {number}")
        if len(self._last) < _HEAD.size + self._longest_answer:
            self._leave()
            return ()
        return self._next()

    def _next(self) -> Iterable[bytes]:
        assert self._reading is not None
        at = self._number * self._longest_answer
        self._number += 1
        part = self._reading[at : at + self._longest_answer]
        self._last = _HEAD.pack(FoeOperation.DATA, self._number) + part
        return (self._last,)

    # from the master

    def _begin_writing(self, name: str, password: int) -> Iterable[bytes]:
        busy = self._files.programming
        if busy is not None:
            return (_busy(busy),)
        self._leave()
        self._files.begin_file(name, password)
        self._writing, self._name = bytearray(), name
        return (_HEAD.pack(FoeOperation.ACKNOWLEDGE, 0),)

    def _take(self, number: int, data: bytes) -> Iterable[bytes]:
        if self._writing is None:
            raise FileRefusal(FoeError.ILLEGAL, "no file is open")
        if number != self._number + 1:
            raise FileRefusal(FoeError.PACKET_NUMBER, f"{self._number + 1} expected, got {number}")
        if not self._finishing:
            self._writing += data
            if len(self._writing) > self._files.longest_file:
                raise FileRefusal(FoeError.DISK_FULL, f"{self._files.longest_file} bytes at most")
            if len(data) < self._longest_request:
                self._files.write_file(self._name, bytes(self._writing))
                self._finishing = True
        if self._finishing:
            # the packet is sent again until it is acknowledged: the file is in its place then
            busy = self._files.programming
            if busy is not None:
                return (_busy(busy),)
            self._leave()
        else:
            self._number = number
        return (_HEAD.pack(FoeOperation.ACKNOWLEDGE, number),)


def _name(data: bytes) -> str:
    return data.partition(b"\0")[0].decode("latin-1")


def _busy(part: tuple[int, int]) -> bytes:
    """Done, of how much: at most 16 bits each."""
    done, whole = part
    shift = max(whole.bit_length() - 16, 0)
    return _BUSY.pack(FoeOperation.BUSY, done >> shift, whole >> shift) + b"programming"
