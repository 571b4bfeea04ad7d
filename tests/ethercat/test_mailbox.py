"""Mailbox messages, counters, error replies, repeats."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import AlState
from achse.ethercat.mailbox import MailboxError, MailboxProtocol, MailboxServer, Message

SDO_READ_VENDOR = bytes.fromhex("0020 40 1810 01 00000000")

messages = st.builds(
    Message,
    protocol=st.integers(0, 15),
    data=st.binary(max_size=50),
    counter=st.integers(0, 7),
    station=st.integers(0, 0xFFFF),
    channel=st.integers(0, 63),
    priority=st.integers(0, 3),
)


@given(messages, st.integers(0, 20))
def test_decoding_undoes_encoding(message: Message, padding: int) -> None:
    assert Message.decode(message.encode() + bytes(padding)) == message


@pytest.mark.parametrize(
    ("buffer", "error"),
    [
        ("", MailboxError.SIZE_TOO_SHORT),
        ("0000000000", MailboxError.SIZE_TOO_SHORT),
        ("010000000003", MailboxError.INVALID_SIZE),
        ("000000000083", MailboxError.INVALID_HEADER),
    ],
)
def test_broken_messages(buffer: str, error: MailboxError) -> None:
    assert Message.decode(bytes.fromhex(buffer)) is error


def server() -> tuple[MailboxServer, list[bytes]]:
    seen: list[bytes] = []

    def echo(data: bytes) -> list[bytes]:
        seen.append(data)
        return [data]

    return MailboxServer({MailboxProtocol.COE: echo}), seen


def test_counters_of_answers_run_from_1_to_7() -> None:
    result, _ = server()
    counters = []
    for n in range(9):
        result.receive(Message(3, b"x", n % 7 + 1).encode())
        answer = Message.decode(result.fetch() or b"")
        assert isinstance(answer, Message)
        counters.append(answer.counter)
    assert counters == [1, 2, 3, 4, 5, 6, 7, 1, 2]


def test_the_same_counter_again_is_a_repeat_and_not_executed() -> None:
    result, seen = server()
    result.receive(Message(3, b"a", 1).encode())
    result.receive(Message(3, b"a", 1).encode())
    result.receive(Message(3, b"b", 0).encode())
    result.receive(Message(3, b"c", 0).encode())
    assert seen == [b"a", b"b", b"c"]


@pytest.mark.parametrize("protocol", [1, 2, 4, 5, 6, 14, 15], ids="AEFS69V")
def test_other_protocols_are_refused(master: Any, protocol: int) -> None:
    """AoE, EoE, FoE, SoE, VoE and unknown ones: error reply, protocol not supported."""
    master.bring(AlState.PREOP)
    master.post(bytes(10), protocol)
    assert master.fetch() == (0, bytes.fromhex("0100 0200"))


@pytest.mark.parametrize(
    ("message", "detail"),
    [
        ("ff01 0000 00 13", 8),  # longer than the mailbox
        ("0a00 0000 00 93", 5),
        ("0000 0000 00 13", 6),  # no CoE header
        ("0800 0000 00 13 0020", 6),  # no whole SDO
        ("0a00 0000 00 13 0040", 4),  # a TxPDO by mailbox, which slaves send
        ("0a00 0000 00 13 0162", 4),  # TxPDO 1: there is one PDO, 0
        ("0400 0000 00 13 0080", 6),  # no whole SDO information
    ],
)
def test_error_replies(master: Any, message: str, detail: int) -> None:
    master.bring(AlState.PREOP)
    assert master.write(0x1000, bytes.fromhex(message).ljust(256, b"\0")) == 1
    assert master.fetch() == (0, bytes((1, 0, detail, 0)))


def test_an_error_message_of_the_master_is_not_answered(master: Any) -> None:
    master.bring(AlState.PREOP)
    master.post(bytes.fromhex("0100 0200"), protocol=0)
    assert master.fetch() is None
    assert master.post(SDO_READ_VENDOR) == 1


def test_a_lost_message_is_repeated_on_request(master: Any) -> None:
    master.bring(AlState.PREOP)
    master.post(SDO_READ_VENDOR)
    first = master.fetch()
    assert first is not None
    assert master.fetch() is None
    for toggle in (3, 1):
        master.write(0x080E, bytes((toggle,)))
        assert master.number(0x080F, 1) == toggle & 2
        assert master.fetch() == first
    assert master.fetch() is None


def test_answers_queue_behind_one_mailbox(master: Any) -> None:
    """Two requests before the first answer is read: both are answered, in order."""
    master.bring(AlState.PREOP)
    assert master.post(SDO_READ_VENDOR) == 1
    assert master.post(bytes.fromhex("0020 40 1810 02 00000000")) == 1
    assert master.post(bytes.fromhex("0020 40 1810 03 00000000")) == 1
    assert master.post(bytes.fromhex("0020 40 1810 04 00000000")) == 0  # full until one is read
    subindices = [(master.fetch() or (0, b""))[1][5] for _ in range(3)]
    assert subindices == [1, 2, 3]


def test_a_slow_application_answers_later(master: Any) -> None:
    master.bring(AlState.PREOP)
    master.segment.slaves[0].mailbox_delay_ns = 20_000_000
    assert master.post(SDO_READ_VENDOR) == 1
    assert master.fetch() is None
    assert master.number(0x0805, 1) & 0x08  # the message is still in the mailbox
    master.advance(19)
    assert master.fetch() is None
    master.advance(2)
    assert master.fetch() is not None


def test_the_mailbox_is_closed_in_init(master: Any) -> None:
    master.bring(AlState.PREOP)
    assert master.post(SDO_READ_VENDOR) == 1
    master.request(AlState.INIT)
    assert master.post(SDO_READ_VENDOR) == 0
    master.request(AlState.PREOP)
    assert master.fetch() is None  # what waited is forgotten


def test_a_waiting_message_is_an_event(master: Any) -> None:
    master.bring(AlState.PREOP)
    master.write(0x0200, b"\x20\x00")
    master.post(SDO_READ_VENDOR)
    from achse.ethercat import Datagram, DatagramCommand

    assert master.send(Datagram(DatagramCommand.NOP, 0, b""))[0].irq == 0x20
    assert master.number(0x0210, 2) & 0x20
    master.fetch()
    assert master.send(Datagram(DatagramCommand.NOP, 0, b""))[0].irq == 0
