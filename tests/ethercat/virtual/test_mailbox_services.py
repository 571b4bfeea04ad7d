"""Protocols of a slave are those of its file; others are refused; VoE goes to the behaviour."""

from collections.abc import Iterable
from ipaddress import IPv4Address

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ethercat.eoe import EoeType, IpSettings, fragments, request
from achse.ethercat.mailbox import MailboxError, MailboxProtocol
from achse.ethercat.master.errors import MailboxRefusal, MailboxTimeout
from achse.ethercat.master.esi_reader import read_esi
from achse.ethercat.master.foe_client import FoeClient
from achse.ethercat.master.voe_client import VendorMessage
from achse.ethercat.virtual import SlaveBehaviour, VirtualDevice
from tests.ethercat.virtual.conftest import Served
from tests.ethercat.virtual.esi_text import MAILBOX, device, esi

NAMES = ("AoE", "EoE", "CoE", "FoE", "SoE", "VoE")
REQUESTS = {
    "AoE": bytes(16) + b"\1\0\4\0" + bytes(12),
    "EoE": b"\6\1\0\0",
    "CoE": b"\0\x20\x40\x00\x10\0\0\0\0\0",
    "FoE": b"\1\0\0\0\0\0x",
    "SoE": b"\1\x40\1\0",
    "VoE": b"\1\0\0\0\2\0data",
}


class Turned(SlaveBehaviour):
    """Sends each message of a vendor back the other way round."""

    def vendor_message(self, device: VirtualDevice, data: bytes) -> Iterable[bytes]:
        return (data[:6] + data[:5:-1],)


@settings(max_examples=20, deadline=None)
@given(st.sets(st.sampled_from(NAMES), min_size=1))
def test_only_protocols_of_the_file_are_spoken(spoken: set[str]) -> None:
    ours = Served("".join(f"<{each}/>" for each in sorted(spoken)), Turned())
    for name in NAMES:
        protocol = MailboxProtocol[name.upper()]
        steps = ours.seen.mailbox.converse(protocol, REQUESTS[name], lambda data: True)
        if name in spoken:
            assert ours.do(steps)
        else:
            with pytest.raises(MailboxRefusal, match="UNSUPPORTED_PROTOCOL"):
                ours.do(steps)


def test_vendor_s_messages_wait_or_are_answered() -> None:
    quiet, turned = Served("<VoE/>"), Served("<VoE/>", Turned())
    message = VendorMessage(5, 6, b"abc")
    assert turned.do(turned.seen.voe.request(message)) == VendorMessage(5, 6, b"cba")
    with pytest.raises(MailboxTimeout):
        quiet.do(quiet.seen.voe.request(message, response_ns=20_000_000))
    assert list(quiet.device.messages.vendor_messages) == [message.encode()]


def test_protocols_do_not_disturb_each_other() -> None:
    ours = Served("".join(f"<{each}/>" for each in NAMES), Turned())
    foe = FoeClient(ours.seen.mailbox)
    wanted = IpSettings(b"\2" * 6, IPv4Address("10.0.0.9"))
    jobs = [
        ours.master.run(steps)
        for steps in (
            foe.write("a", bytes(1000)), ours.seen.eoe.set_ip(wanted),
            ours.seen.sdo.upload(0x1008, 0), ours.seen.eoe.get_ip(), foe.read("a"),
        )
    ]  # fmt: skip
    ours.until(lambda: all(job.is_done for job in jobs))
    assert [job.result() for job in jobs] == [None, None, b"Speaker", wanted, bytes(1000)]


@settings(max_examples=30)
@given(
    st.integers(-6, 122),
    st.lists(st.tuples(st.sampled_from(NAMES), st.binary(max_size=100)), max_size=20),
)
def test_replies_fit_into_the_mailbox_that_the_master_made(
    room: int, messages: list[tuple[str, bytes]]
) -> None:
    """Whatever comes, and however small the mailbox is."""
    (box,) = read_esi(esi(device(MAILBOX + "<Mailbox><AoE/><EoE/><SoE/><VoE/></Mailbox>")))
    result = VirtualDevice(box, behaviour=Turned())
    result.messages.open(room)
    address = IpSettings(b"\2" * 6, IPv4Address("10.0.0.9"))
    question = b"\xff" * 6 + b"\4" * 6 + b"\x08\x06" + bytes((0, 1, 8, 0, 6, 4, 0, 1))
    question += b"\4" * 6 + bytes((10, 0, 0, 1)) + bytes(6) + address.address.packed  # type: ignore[union-attr]
    ours = [
        ("EoE", request(EoeType.SET_IP, address.encode())), ("EoE", request(EoeType.GET_IP)),
        ("EoE", next(fragments(question, 1, 200))), ("SoE", b"\1\x40\x10\0"),
        ("AoE", REQUESTS["AoE"]),
    ]  # fmt: skip
    for name, data in (*ours, *messages):
        handler = result.services.get(MailboxProtocol[name.upper()])
        replies = () if handler is None else handler(data)
        if not isinstance(replies, int):
            assert all(len(each) <= room for each in replies)
    while (message := result.take_message()) is not None:
        assert len(message[1]) <= room


def test_mailbox_of_the_master_limits_the_parts_of_an_answer() -> None:
    ours = Served("<SoE/><EoE/>")
    slave = ours.ring.segment.slaves[0]
    manager = slave.esc.sync_managers[1]
    manager.length = 40
    slave.reset_services()
    reply = ours.device.services[MailboxProtocol.EOE](request(EoeType.GET_FILTER))
    assert reply == MailboxError.NO_MEMORY
