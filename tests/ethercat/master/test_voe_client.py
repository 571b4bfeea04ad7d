"""VoE: messages of a vendor's own form, asked for and sent by the slave."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import AlState
from achse.ethercat.master.errors import MailboxRefusal, MailboxTimeout, WrongAnswer
from achse.ethercat.master.voe_client import VendorMessage
from tests.ethercat.master.conftest import Bus
from tests.ethercat.master.messaging import VOE, Messenger


@settings(max_examples=15, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.binary(max_size=244),
    st.lists(st.binary(max_size=100), max_size=3),
)
def test_a_question_has_the_next_message_of_its_vendor(
    vendor: int, data: bytes, before: list[bytes]
) -> None:
    ours = Bus(1, {}, {}, Messenger).up(AlState.PREOP)
    slave = ours.master.slaves[0]
    other = (vendor ^ 1).to_bytes(4, "little")
    ours.line[0].outbox.extend((VOE, other + each) for each in before)  # type: ignore[attr-defined]
    assert slave.voe is not None
    answer = ours.do(slave.voe.request(VendorMessage(vendor, 7, data)))
    assert answer == VendorMessage(vendor, 8, data[::-1])
    counted = [each for each in before if len(each) >= 2]
    assert slave.voe.count == len(counted)
    if counted:
        assert slave.voe.last == VendorMessage.decode(other + counted[-1])


def test_messages_without_an_answer(bus: Callable[..., Any]) -> None:
    ours = bus(kind=Messenger).up(AlState.PREOP)
    voe = ours.master.slaves[0].voe
    ours.do(voe.send(VendorMessage(5, 1, b"x")))
    assert ours.line[0].messages == [b"\x05\0\0\0\x01\0x"]
    ours.line[0].outbox.append((VOE, b"\x09\0\0\0\x02\0news"))
    ours.until(lambda: voe.count == 1)
    assert voe.last == VendorMessage(9, 2, b"news")
    with pytest.raises(MailboxTimeout):
        ours.do(voe.request(VendorMessage(5, 1), response_ns=20_000_000))
    with pytest.raises(WrongAnswer, match="250 bytes at most"):
        ours.do(voe.send(VendorMessage(5, 1, bytes(245))))
    with pytest.raises(WrongAnswer, match="6 bytes or more"):
        VendorMessage.decode(b"short")


def test_a_slave_without_it_says_so(bus: Callable[..., Any]) -> None:
    ours = bus().up(AlState.PREOP)
    with pytest.raises(MailboxRefusal, match="UNSUPPORTED_PROTOCOL"):
        ours.do(ours.master.slaves[0].voe.request(VendorMessage(5, 1)))
