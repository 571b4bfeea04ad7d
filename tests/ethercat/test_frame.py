"""Frames and datagrams, both directions."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ethercat.frame import (
    Addressing,
    Datagram,
    DatagramCommand,
    EthercatFrame,
    FrameError,
    datagram_offsets,
    payload_offset,
)

COMMANDS = "NOP APRD APWR APRW FPRD FPWR FPRW BRD BWR BRW LRD LWR LRW ARMW FRMW"
"""001 table 2.3.1.1, by number."""

datagrams = st.builds(
    Datagram,
    command=st.integers(0, 255),
    address=st.integers(0, 0xFFFF_FFFF),
    data=st.binary(max_size=200),
    index=st.integers(0, 255),
    counter=st.integers(0, 0xFFFF),
    irq=st.integers(0, 0xFFFF),
    circulating=st.booleans(),
)
frames = st.builds(
    EthercatFrame,
    st.lists(datagrams, min_size=1, max_size=7),
    source=st.binary(min_size=6, max_size=6),
    destination=st.binary(min_size=6, max_size=6),
)


def test_the_commands_are_the_manuals() -> None:
    assert " ".join(command.name for command in DatagramCommand) == COMMANDS
    assert [int(command) for command in DatagramCommand] == list(range(15))


@pytest.mark.parametrize("command", DatagramCommand)
def test_a_commands_name_says_what_it_does(command: DatagramCommand) -> None:
    way = {
        "A": Addressing.POSITION,
        "F": Addressing.STATION,
        "B": Addressing.BROADCAST,
        "L": Addressing.LOGICAL,
    }
    assert command.addressing is way.get(command.name[0], Addressing.NONE)
    does = command.name[-2:]
    assert command.reads == (does in ("RD", "RW", "MW"))
    assert command.writes == (does in ("WR", "RW", "MW"))
    assert command.multiple == (does == "MW")


@given(frames)
def test_decoding_undoes_encoding(frame: EthercatFrame) -> None:
    assert EthercatFrame.decode(frame.encode()) == frame
    payload = EthercatFrame.decode_payload(frame.encode_payload())
    assert payload.datagrams == frame.datagrams


def test_the_wire() -> None:
    frame = EthercatFrame([Datagram.at(DatagramCommand.BRD, 0, 0x0130, bytes(2), index=7)])
    assert frame.encode() == bytes.fromhex(
        "ffffffffffff 020000000000 88a4 0e10 07 07 0000 3001 0200 0000 0000 0000"
    )


def test_padding_of_the_network_card_is_no_datagram() -> None:
    frame = EthercatFrame([Datagram(DatagramCommand.NOP, 0, b"tag")])
    padded = frame.encode().ljust(60, b"\0")
    assert EthercatFrame.decode(padded) == frame


def test_a_vlan_tag_moves_the_header() -> None:
    packet = EthercatFrame([Datagram(DatagramCommand.NOP, 0, b"")]).encode()
    tagged = packet[:12] + b"\x81\x00\x20\x01" + packet[12:]
    assert payload_offset(packet) == 14
    assert payload_offset(tagged) == 18
    assert EthercatFrame.decode(tagged).datagrams == EthercatFrame.decode(packet).datagrams


@pytest.mark.parametrize("packet", [b"", bytes(14), b"\xff" * 12 + b"\x08\x00" + bytes(40)])
def test_other_protocols_are_not_ethercat(packet: bytes) -> None:
    assert payload_offset(packet) is None
    with pytest.raises(FrameError, match="EtherType"):
        EthercatFrame.decode(packet)


@pytest.mark.parametrize("kind", [0, 4, 5, 15])
def test_frames_of_other_types_have_no_datagrams(kind: int) -> None:
    assert datagram_offsets(struct.pack("<H", kind << 12 | 20) + bytes(20), 0) == []


@pytest.mark.parametrize(
    ("payload", "complaint"),
    [
        ("", "2 bytes"),
        ("0c", "2 bytes"),
        ("0c10", "at least 12"),
        ("0010", "at least 12"),
        ("0b10" + 11 * "00", "at least 12"),
        ("0c10" + "000000000000" + "0100" + 4 * "00", "ends 1 bytes after the frame"),
        ("0c10" + "000000000000" + "0080" + 4 * "00", "at least 12"),
    ],
)
def test_broken_structure_is_reported(payload: str, complaint: str) -> None:
    with pytest.raises(FrameError, match=complaint):
        datagram_offsets(bytes.fromhex(payload), 0)


@pytest.mark.parametrize("length", [0x000, 0x00D, 0x00E, 0x01C, 0x7FF])
def test_the_length_in_the_header_is_not_looked_at(length: int) -> None:
    """It may count a byte too much, or be that of a longer frame: masters send that."""
    datagram = Datagram.at(DatagramCommand.BWR, 0, 0x0101, b"\0", index=0x40)
    packet = bytearray(EthercatFrame([datagram]).encode().ljust(60, b"\0"))
    struct.pack_into("<H", packet, 14, 0x1000 | length)
    assert EthercatFrame.decode(bytes(packet)).datagrams == [datagram]


def test_a_frame_has_limits() -> None:
    with pytest.raises(FrameError, match="at least one"):
        EthercatFrame([]).encode()
    EthercatFrame([Datagram(DatagramCommand.NOP, 0, bytes(1486))]).encode()
    with pytest.raises(FrameError, match="1498"):
        EthercatFrame([Datagram(DatagramCommand.NOP, 0, bytes(1487))]).encode()


def test_adp_and_ado() -> None:
    datagram = Datagram.at(DatagramCommand.APRD, -3, 0x0130, b"")
    assert (datagram.adp, datagram.ado) == (0xFFFD, 0x0130)
