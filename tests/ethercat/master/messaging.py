"""A slave whose mailbox speaks more than CoE, for tests of the master's end."""

import struct
from collections import deque
from collections.abc import Callable, Iterable

from achse.ethercat import Loopback
from achse.ethercat.eoe import EoeResult, EoeType, FrameAssembly, fragments, request, split

AOE, EOE, VOE = 1, 2, 15
ROOM = 250
"""Bytes of a message of ours behind its header."""


class Messenger(Loopback):
    """A network port that keeps its settings and the frames that come, an ADS port with one
    variable, a vendor's echo; `outbox` is what it sends by itself."""

    def __init__(self, *arguments: object, **options: object) -> None:
        super().__init__(*arguments, **options)  # type: ignore[arg-type]
        self.services: dict[int, Callable[[bytes], Iterable[bytes] | int]] = {
            AOE: self.ads,
            EOE: self.ethernet,
            VOE: self.vendor,
        }
        self.outbox: deque[tuple[int, bytes]] = deque()
        self.frames: list[bytes] = []
        self.settings = {EoeType.SET_IP: b"", EoeType.SET_FILTER: b""}
        self.result = EoeResult.SUCCESS
        self.messages: list[bytes] = []
        self.value = b"1234"
        self._assembly = FrameAssembly()

    def take_message(self) -> tuple[int, bytes] | None:
        return self.outbox.popleft() if self.outbox else None

    def send_frame(self, frame: bytes) -> None:
        """Let the master have an Ethernet frame."""
        self.outbox.extend((EOE, part) for part in fragments(frame, 1, ROOM))

    def ethernet(self, data: bytes) -> Iterable[bytes] | int:
        try:
            number, _, _, body = split(data)
            kind = EoeType(number)
        except ValueError:
            return 1
        if kind is EoeType.FRAGMENT:
            frame = self._assembly.take(data)
            if frame is not None:
                self.frames.append(frame)
            return ()
        if kind in self.settings:
            if self.result is EoeResult.SUCCESS:
                self.settings[kind] = body
            return (request(EoeType(kind + 1), b"", 0, self.result),)
        answer = self.settings.get(EoeType(kind - 4), b"")
        return (request(EoeType(kind + 1), answer, 0, self.result),)

    def ads(self, data: bytes) -> Iterable[bytes] | int:
        """Read and write of one variable; others are 0x703."""
        target, source, command, flags, _, _, invoke = struct.unpack_from("<8s8sHHIII", data)
        body = data[32:]
        if flags & 1:
            self.messages.append(data)
            return ()
        if command == 2:
            group, offset, length = struct.unpack_from("<III", body)
            value = self.value[:length]
            known = (group, offset) == (0xF302, 0x2000_0000)
            answer = struct.pack("<II", 0, len(value)) + value
            answer = answer if known else struct.pack("<II", 0x703, 0)
        else:
            self.value = body[12:]
            answer = bytes(4)
        head = struct.pack("<8s8sHHIII", source, target, command, flags | 1, len(answer), 0, invoke)
        return (head + answer,)

    def vendor(self, data: bytes) -> Iterable[bytes] | int:
        self.messages.append(data)
        if data[4:6] == b"\x07\0":
            return (data[:4] + b"\x08\0" + data[6:][::-1],)
        return ()
