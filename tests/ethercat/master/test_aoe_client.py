"""AoE: ADS packets to a slave and from it, answers found by invoke id and command."""

import struct
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import AlState
from achse.ethercat.master.aoe_client import is_packet
from achse.ethercat.master.errors import MailboxRefusal, MailboxTimeout, WrongAnswer
from tests.ethercat.master.conftest import Bus
from tests.ethercat.master.messaging import AOE, Messenger

US, SLAVE = bytes(range(8)), bytes(range(8, 16))


def packet(command: int, body: bytes, invoke: int = 7, flags: int = 4) -> bytes:
    return struct.pack("<8s8sHHIII", SLAVE, US, command, flags, len(body), 0, invoke) + body


def reading(group: int = 0xF302, offset: int = 0x2000_0000, invoke: int = 7) -> bytes:
    return packet(2, struct.pack("<III", group, offset, 100), invoke)


def request(body: bytes) -> bytes:
    return packet(2, body)


@settings(max_examples=15, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.binary(max_size=100),
    st.lists(
        st.binary(max_size=60) | st.binary(max_size=9).map(lambda b: packet(2, b)), max_size=3
    ),
)
def test_the_answer_is_that_of_the_request(invoke: int, value: bytes, unasked: list[bytes]) -> None:
    ours = Bus(1, {}, {}, Messenger).up(AlState.PREOP)
    slave, device = ours.master.slaves[0], ours.line[0]
    assert slave.aoe is not None
    came: list[bytes] = []
    slave.aoe.take = came.append
    device.outbox.extend((AOE, each) for each in unasked)  # type: ignore[attr-defined]
    body = struct.pack("<III", 0xF302, 0x2000_0000, len(value)) + value
    written = ours.do(slave.aoe.request(packet(3, body, invoke)))
    assert written == struct.pack("<8s8sHHIII", US, SLAVE, 3, 5, 4, 0, invoke) + bytes(4)
    answer = ours.do(slave.aoe.request(reading(invoke=invoke)))
    assert answer[32:] == struct.pack("<II", 0, len(value)) + value
    assert came == [each for each in unasked if is_packet(each)]


def test_what_is_no_packet_is_refused(bus: Callable[..., Any]) -> None:
    ours = bus(kind=Messenger).up(AlState.PREOP)
    aoe = ours.master.slaves[0].aoe
    with pytest.raises(WrongAnswer, match="not an AMS packet"):
        ours.do(aoe.request(bytes(20)))
    with pytest.raises(WrongAnswer, match="250 bytes at most"):
        ours.do(aoe.request(packet(3, bytes(aoe.room - 31))))
    ours.segment.slaves[0]._mailbox._services[AOE] = lambda data: [data]  # a request comes back
    with pytest.raises(MailboxTimeout):
        ours.do(aoe.request(reading(), response_ns=20_000_000))


def test_a_response_is_sent_without_waiting(bus: Callable[..., Any]) -> None:
    ours = bus(kind=Messenger).up(AlState.PREOP)
    response = packet(2, bytes(8), flags=5)
    ours.do(ours.master.slaves[0].aoe.send(response))
    assert ours.line[0].messages == [response]


def test_a_slave_without_it_says_so(bus: Callable[..., Any]) -> None:
    ours = bus().up(AlState.PREOP)
    with pytest.raises(MailboxRefusal, match="UNSUPPORTED_PROTOCOL"):
        ours.do(ours.master.slaves[0].aoe.request(reading()))
