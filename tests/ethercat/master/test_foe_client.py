"""FoE: files of any length, busy slaves, refusals."""

import struct
from collections.abc import Callable
from typing import Any

import pytest

from achse.codes import AlState
from achse.ethercat import Disturbance
from achse.ethercat.mailbox import MailboxProtocol
from achse.ethercat.master.errors import MailboxRefusal, WrongAnswer
from achse.ethercat.master.foe_client import FoeClient, FoeRefusal

ROOM = 256 - 6 - 6
"""Bytes of a packet in a mailbox of 256."""


class Files:
    """A slave's files; before each answer it is `busy` so many times."""

    def __init__(self, busy: int = 0) -> None:
        self.files: dict[str, bytes] = {"there": b"content"}
        self.busy = busy
        self.last = b""
        self._left = busy
        self._name = ""
        self._number = 0

    def answer(self, data: bytes) -> list[bytes]:
        if self._left:
            self._left -= 1
            return [struct.pack("<BxHH", 6, 0, 0)]
        self._left = self.busy
        operation, number = data[0], int.from_bytes(data[2:6], "little")
        if operation == 1:
            self._name, self._number = data[6:].decode(), 0
            if self._name not in self.files:
                return [struct.pack("<BxI", 5, 0x8001) + b"not here"]
        elif operation == 2:
            if number != 7:
                return [struct.pack("<BxI", 5, 0x8002)]
            self._name = data[6:].decode()
            self.files[self._name] = b""
            return [struct.pack("<BxI", 4, 0)]
        elif operation == 3:
            self.files[self._name] += data[6:]
            return [struct.pack("<BxI", 4, number)]
        elif operation == 4 and self._number * ROOM > len(self.files[self._name]):
            return []  # the last packet is acknowledged
        part = self.files[self._name][self._number * ROOM : (self._number + 1) * ROOM]
        self._number += 1
        return [struct.pack("<BxI", 3, self._number) + part]


def client(ours: Any, files: Files) -> FoeClient:
    ours.segment.slaves[0]._mailbox._services[MailboxProtocol.FOE] = files.answer
    return FoeClient(ours.master.slaves[0].mailbox)


@pytest.mark.parametrize("busy", [0, 2])
@pytest.mark.parametrize("size", [0, 1, ROOM - 1, ROOM, ROOM + 1, 5 * ROOM])
def test_what_is_written_is_read(bus: Callable[..., Any], size: int, busy: int) -> None:
    ours = bus().up(AlState.PREOP)
    files = Files(busy)
    foe = client(ours, files)
    data = bytes(range(256)) * 5
    ours.do(foe.write("firmware.efw", data[:size], 7))
    assert files.files["firmware.efw"] == data[:size]
    assert ours.do(foe.read("firmware.efw")) == data[:size]
    assert ours.master.slaves[0].mailbox.idle


def test_a_lost_frame_costs_no_packet(bus: Callable[..., Any]) -> None:
    ours = bus().up(AlState.PREOP)
    files = Files()
    files.files["long"] = bytes(range(200)) * 20
    foe = client(ours, files)
    ours.segment.disturbance = Disturbance()
    job = ours.master.run(foe.read("long"))
    while not job.is_done:
        ours.run(3)
        ours.segment.disturbance.lose = 1
        ours.run(1)
    assert job.result() == files.files["long"]


def test_refusals_have_their_code(bus: Callable[..., Any]) -> None:
    ours = bus().up(AlState.PREOP)
    with pytest.raises(MailboxRefusal, match="UNSUPPORTED_PROTOCOL"):
        ours.do(FoeClient(ours.master.slaves[0].mailbox).read("there"))
    foe = client(ours, Files())
    with pytest.raises(FoeRefusal, match="nothing: 0x8001 not found not here") as refusal:
        ours.do(foe.read("nothing"))
    assert (refusal.value.number, refusal.value.text) == (0x8001, "not here")
    with pytest.raises(FoeRefusal, match="0x8002 access denied"):
        ours.do(foe.write("there", b"", 6))
    with pytest.raises(WrongAnswer, match="bytes at most"):
        ours.do(foe.write("there", bytes((16 << 20) + 1)))


def test_answers_out_of_turn_end_it(bus: Callable[..., Any]) -> None:
    ours = bus().up(AlState.PREOP)
    foe = client(ours, Files())
    services = ours.segment.slaves[0]._mailbox._services
    services[MailboxProtocol.FOE] = lambda data: [struct.pack("<BxI", 3, 9)]
    with pytest.raises(WrongAnswer, match="packet 1 expected, got 3:9"):
        ours.do(foe.read("there"))
    with pytest.raises(WrongAnswer, match="expected 0 acknowledged"):
        ours.do(foe.write("there", b"", 7))
