"""EoE of a slave: addresses, filter, frames both ways, ARP and ping."""

import struct
from ipaddress import IPv4Address

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from achse.ethercat.eoe import EoeType, IpSettings, MacFilter, fragments, request
from achse.ethercat.mailbox import MailboxError
from achse.ethercat.virtual import SlaveBehaviour, VirtualDevice
from achse.ethercat.virtual.network_port import NetworkPort
from tests.ethercat.virtual.conftest import Served

MACS = st.binary(min_size=6, max_size=6).filter(lambda mac: not mac[0] & 1)
ADDRESSES = st.integers(1, (1 << 32) - 2).map(IPv4Address)
ALL = b"\xff" * 6


class Kept(SlaveBehaviour):
    """Keeps the frames that come."""

    def __init__(self) -> None:
        self.frames: list[bytes] = []

    def frame(self, device: VirtualDevice, frame: bytes) -> None:
        self.frames.append(frame)


def arp(asker: bytes, asker_address: IPv4Address, target: IPv4Address) -> bytes:
    question = struct.pack(">HHBBH", 1, 0x0800, 6, 4, 1)
    body = question + asker + asker_address.packed + bytes(6) + target.packed
    return ALL + asker + b"\x08\x06" + body.ljust(46, b"\0")


def checksum(data: bytes) -> int:
    data += b"\0" * (len(data) & 1)
    total: int = sum(struct.unpack(f">{len(data) // 2}H", data))
    while total >> 16:
        total = (total & 0xFFFF) + (total >> 16)
    return ~total & 0xFFFF


def ping(mac: bytes, asker: bytes, source: IPv4Address, target: IPv4Address, data: bytes) -> bytes:
    head = struct.pack(
        ">BBHHHBBH4s4s",
        *(0x45, 0, 28 + len(data), 7, 0, 64, 1, 0, source.packed, target.packed),
    )
    head = head[:10] + checksum(head).to_bytes(2, "big") + head[12:]
    message = struct.pack(">BBHHH", 8, 0, 0, 1, 2) + data
    message = message[:2] + checksum(message).to_bytes(2, "big") + message[4:]
    return mac + asker + b"\x08\x00" + head + message


@settings(max_examples=10, deadline=None)
@given(
    mac=MACS, asker=MACS, address=ADDRESSES, other=ADDRESSES, data=st.binary(max_size=1400),
    own=st.binary(min_size=14, max_size=1500),
)  # fmt: skip
def test_port_answers_arp_and_ping_and_exchanges_frames(
    mac: bytes, asker: bytes, address: IPv4Address, other: IPv4Address, data: bytes, own: bytes
) -> None:
    behaviour = Kept()
    ours = Served("<EoE/>", behaviour)
    eoe = ours.seen.eoe
    came: list[bytes] = []
    eoe.take = came.append
    echo = ping(mac, asker, other, address, data)
    ours.do(eoe.send(echo))
    ours.do(eoe.set_ip(IpSettings(mac, address)))
    ours.do(eoe.set_ip(IpSettings(name="speaker")))
    assert ours.do(eoe.get_ip()) == IpSettings(mac, address, name="speaker")
    ours.do(eoe.send(arp(asker, other, address)))
    ours.do(eoe.send(echo))
    ours.until(lambda: len(came) == 2)
    reply, answer = came
    assert reply[:14] == answer[:12] + b"\x08\x06" == asker + mac + b"\x08\x06"
    assert reply[20:42] == b"\0\2" + mac + address.packed + asker + other.packed
    assert answer[12:14] == b"\x08\x00"
    assert answer[26:34] == address.packed + other.packed
    assert (checksum(answer[14:34]), checksum(answer[34:])) == (0, 0)
    assert answer[34:36] + answer[38:] == b"\0\0" + echo[38:]
    ours.device.send_frame(own)
    ours.until(lambda: len(came) == 3)
    assert came[2] == own
    assert behaviour.frames == [echo, arp(asker, other, address), echo]


@given(MACS, st.lists(MACS, max_size=3), MACS, st.booleans())
def test_filter_lets_its_addresses_in(
    mac: bytes, listed: list[bytes], other: bytes, broadcasts: bool
) -> None:
    came: list[bytes] = []
    port = NetworkPort(200, came.append)
    port.answer(request(EoeType.SET_IP, IpSettings(mac).encode()))
    wanted = MacFilter(tuple(listed), (), broadcasts)
    (message,) = port.answer(request(EoeType.SET_FILTER, wanted.encode()))  # type: ignore[misc]
    assert message[0] & 0x0F == EoeType.SET_FILTER_ANSWER
    for target in (mac, *listed, other, ALL):
        for part in fragments(target + bytes(60), 1, 200):
            port.answer(part)
    allowed = [mac, *listed, *[other] * (other in (mac, *listed)), *[ALL] * broadcasts]
    assert [frame[:6] for frame in came] == allowed


@given(st.binary(max_size=200))
def test_any_message_has_an_answer_or_an_error(data: bytes) -> None:
    port = NetworkPort(200, lambda frame: None)
    port.answer(request(EoeType.SET_IP, IpSettings(bytes(6), IPv4Address("10.0.0.1")).encode()))
    hostile = request(EoeType.SET_IP, b"\x20\0\0\0" + data)
    assert len(list(port.answer(hostile))) == 1  # type: ignore[arg-type]
    assert len(list(port.answer(request(EoeType.GET_IP)))) == 1  # type: ignore[arg-type]
    outcome = port.answer(data)
    assert outcome in list(MailboxError) or all(len(each) <= 200 for each in outcome)  # type: ignore[union-attr]
    frame = ALL + b"\2" * 6 + b"\x08" + data.ljust(50, b"\0")
    for part in fragments(frame[:1500], 1, 200):
        assert port.answer(part) == ()


@settings(max_examples=5, deadline=None)
@given(asker=MACS, mac=MACS, first=ADDRESSES, second=ADDRESSES)
def test_master_switches_between_slaves(
    asker: bytes, mac: bytes, first: IPv4Address, second: IPv4Address
) -> None:
    """One slave asks for the address of another, and has the answer."""
    assume(asker != mac)
    stored = Kept()
    ours = Served("<EoE/>", stored, count=2)
    ours.do(ours.master.slaves[1].eoe.set_ip(IpSettings(mac, second)))  # type: ignore[union-attr]
    ours.device.send_frame(arp(asker, first, second))
    ours.until(lambda: bool(stored.frames))
    (answer,) = stored.frames
    assert answer[:14] == asker + mac + b"\x08\x06"


def test_queue_to_the_master_is_bounded() -> None:
    port = NetworkPort(42, lambda frame: None)
    for _ in range(9):
        port.send(bytes(320))
    assert (len(port.waiting), port.dropped) == (60, 3)
    with pytest.raises(ValueError, match="14 to 1518 bytes"):
        port.send(b"short")


def test_device_without_a_port_sends_no_frame() -> None:
    with pytest.raises(ValueError, match="Speaker has no EoE"):
        Served("<FoE/>").device.send_frame(bytes(60))
