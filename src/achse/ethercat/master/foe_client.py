"""Files of a slave by mailbox (FoE): read and written whole, in packets that are acknowledged.

Source: ETG.1000.6 §5.8.
"""

import struct
from dataclasses import dataclass

from achse.codes import FoeError
from achse.ethercat.foe import FoeOperation
from achse.ethercat.mailbox import MailboxProtocol
from achse.ethercat.master.errors import BusError, WrongAnswer
from achse.ethercat.master.mailbox_client import MailboxClient
from achse.ethercat.master.steps import Pause, Steps

MAX_FILE = 16 << 20
"""Bytes of the longest file that is taken from a slave or given to it."""

_O = FoeOperation
_HEAD = struct.Struct("<BxI")
_MAILBOX_HEADER = 6
_BUSY_NS = 10_000_000
_MOST_BUSY = 6_000
"""Most consecutive busy answers of a slave to one packet."""


@dataclass
class FoeProgress:
    """Progress of a file transfer: `done` bytes of `whole` (0: not known), and for a device that is
    busy its own `busy_done` of `busy_whole` (0: not reported) and text."""

    done: int = 0
    whole: int = 0
    busy_done: int = 0
    busy_whole: int = 0
    text: str = ""


class FoeRefusal(BusError):
    """The slave refused a file; `number` is its code, `text` its own words."""

    def __init__(self, station: int, name: str, number: int, text: str) -> None:
        known = {int(each): each.name.replace("_", " ").lower() for each in FoeError}
        why = known.get(number, "unknown code")
        super().__init__(f"station {station}: {name}: 0x{number:04X} {why} {text}".rstrip())
        self.number = number
        self.text = text


class FoeClient:
    """Files of the slave behind a mailbox. All are `Steps`; they raise `BusError`."""

    def __init__(self, mailbox: MailboxClient) -> None:
        self._mailbox = mailbox

    def read(
        self,
        name: str,
        password: int = 0,
        *,
        response_ns: int = 0,
        progress: FoeProgress | None = None,
    ) -> Steps[bytes]:
        """Return the whole file; `progress` is kept up to date."""
        progress = progress or FoeProgress()
        mailbox = self._mailbox
        room = mailbox.incoming.length - _MAILBOX_HEADER - _HEAD.size
        yield from mailbox.acquire()
        try:
            value = bytearray()
            request = _HEAD.pack(_O.READ, password) + name.encode()
            number, busy = 1, 0
            while True:
                operation, acknowledged, data = yield from self._exchange(
                    name, request, response_ns
                )
                if operation == _O.BUSY:
                    busy = yield from self._wait(name, busy, acknowledged, data, progress)
                elif operation != _O.DATA or acknowledged != number:
                    raise WrongAnswer(
                        f"{name}: packet {number} expected, got {operation}:{acknowledged}"
                    )
                else:
                    value += data
                    _note(progress, len(value))
                    if len(value) > MAX_FILE:
                        raise WrongAnswer(f"{name}: longer than {MAX_FILE} bytes")
                    request, busy = _HEAD.pack(_O.ACKNOWLEDGE, number), 0
                    number += 1
                    if len(data) < room:
                        yield from mailbox.send(MailboxProtocol.FOE, request)
                        return bytes(value)
        finally:
            mailbox.release()

    def write(
        self,
        name: str,
        data: bytes,
        password: int = 0,
        *,
        response_ns: int = 0,
        progress: FoeProgress | None = None,
    ) -> Steps[None]:
        """Write the whole file; `progress` is kept up to date."""
        progress = progress or FoeProgress()
        progress.whole = len(data)
        if len(data) > MAX_FILE:
            raise WrongAnswer(f"{name}: {MAX_FILE} bytes at most, got {len(data)}")
        mailbox = self._mailbox
        room = mailbox.capacity - _HEAD.size
        yield from mailbox.acquire()
        try:
            request = _HEAD.pack(_O.WRITE, password) + name.encode()
            number, busy, at, last = 0, 0, 0, False
            while True:
                operation, acknowledged, words = yield from self._exchange(
                    name, request, response_ns
                )
                if operation == _O.BUSY:
                    busy = yield from self._wait(name, busy, acknowledged, words, progress)
                    continue
                if operation != _O.ACKNOWLEDGE or acknowledged != number:
                    raise WrongAnswer(
                        f"{name}: expected {number} acknowledged, got {operation}:{acknowledged}"
                    )
                _note(progress, at)
                if last:
                    return
                part = data[at : at + room]
                at += len(part)
                last = len(part) < room
                number, busy = number + 1, 0
                request = _HEAD.pack(_O.DATA, number) + part
        finally:
            mailbox.release()

    def _wait(
        self, name: str, busy: int, part: int, words: bytes, progress: FoeProgress
    ) -> Steps[int]:
        """The slave is busy: `part` has its done and whole. How often it was."""
        progress.busy_done, progress.busy_whole = part & 0xFFFF, part >> 16
        progress.text = words.partition(b"\0")[0].decode("latin-1")
        if busy >= _MOST_BUSY:
            raise WrongAnswer(f"{name}: busy for ever")
        yield Pause(_BUSY_NS)
        return busy + 1

    def _exchange(
        self, name: str, request: bytes, response_ns: int
    ) -> Steps[tuple[int, int, bytes]]:
        """Send a packet; operation, number and data of the answer."""
        mailbox = self._mailbox
        yield from mailbox.send(MailboxProtocol.FOE, request)
        answer = yield from mailbox.receive(
            MailboxProtocol.FOE, lambda data: len(data) >= _HEAD.size, response_ns
        )
        operation, number = _HEAD.unpack_from(answer)
        data = answer[_HEAD.size :]
        if operation == _O.ERROR:
            reason = data.partition(b"\0")[0].decode("latin-1")
            raise FoeRefusal(mailbox.station, name, number, reason)
        return operation, number, data


def _note(progress: FoeProgress, done: int) -> None:
    progress.done = done
    progress.busy_done = progress.busy_whole = 0
    progress.text = ""
