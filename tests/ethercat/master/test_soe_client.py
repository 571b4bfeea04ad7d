"""SoE: elements of any length, fragments, refusals."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from achse.codes import AlState
from achse.ethercat.mailbox import MailboxProtocol
from achse.ethercat.master.errors import MailboxRefusal, WrongAnswer
from achse.ethercat.master.soe_client import SoeClient, SoeElement, SoeRefusal


class Sercos:
    """Elements of IDNs; answers are cut into `room` bytes, requests are joined."""

    def __init__(self, room: int = 200) -> None:
        self.values: dict[tuple[int, int, int], bytes] = {}
        self.room = room
        self._pending = b""

    def answer(self, data: bytes) -> list[bytes]:
        operation, drive = data[0] & 7, data[0] >> 5
        if operation == 3:
            self._pending += data[4:]
            if data[0] & 8:
                return []
        idn = int.from_bytes(data[2:4], "little")
        key = drive, data[1], idn
        if operation == 3:
            self.values[key], self._pending = self._pending, b""
            return [bytes((4 | drive << 5, data[1])) + data[2:4]]
        if key not in self.values:
            return [bytes((0x12 | drive << 5, data[1])) + data[2:4] + b"\x01\x10"]
        value = self.values[key]
        parts = [value[at : at + self.room] for at in range(0, len(value), self.room)] or [b""]
        answers = []
        for left, part in zip(range(len(parts) - 1, -1, -1), parts, strict=True):
            head = bytes((2 | drive << 5 | (8 if left else 0), data[1]))
            answers.append(head + (left or idn).to_bytes(2, "little") + part)
        return answers


def client(ours: Any, sercos: Sercos) -> SoeClient:
    ours.segment.slaves[0]._mailbox._services[MailboxProtocol.SOE] = sercos.answer
    return SoeClient(ours.master.slaves[0].mailbox)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=15)
@given(
    idn=st.integers(1, 0xFFFF),
    element=st.sampled_from(SoeElement),
    drive=st.integers(0, 7),
    data=st.binary(max_size=700),
    room=st.integers(1, 240),
)
def test_what_is_written_is_read(
    bus: Callable[..., Any], idn: int, element: SoeElement, drive: int, data: bytes, room: int
) -> None:
    ours = bus().up(AlState.PREOP)
    sercos = Sercos(max(room, len(data) // 20 + 1))
    soe = client(ours, sercos)
    ours.do(soe.write(idn, data, element, drive))
    assert sercos.values == {(drive, element, idn): data}
    assert ours.do(soe.read(idn, element, drive)) == data


def test_refusals_name_the_idn(bus: Callable[..., Any]) -> None:
    ours = bus().up(AlState.PREOP)
    with pytest.raises(MailboxRefusal, match="UNSUPPORTED_PROTOCOL"):
        ours.do(SoeClient(ours.master.slaves[0].mailbox).read(32))
    soe = client(ours, Sercos())
    with pytest.raises(SoeRefusal, match="S-0-0032: SERCOS error 0x1001"):
        ours.do(soe.read(32))
    with pytest.raises(SoeRefusal, match="P-0-0005"):
        ours.do(soe.read(0x8005))
    assert ours.master.slaves[0].mailbox.idle


def test_an_answer_without_end_is_cut(bus: Callable[..., Any]) -> None:
    ours = bus().up(AlState.PREOP)
    soe = client(ours, Sercos())
    endless = bytes((2 | 8, 0x40)) + b"\1\0" + bytes(240)
    ours.segment.slaves[0]._mailbox._services[MailboxProtocol.SOE] = lambda data: [endless] * 300
    with pytest.raises(WrongAnswer, match="longer than 65536"):
        ours.do(soe.read(32))
