"""AMS frames: layout, reply, marks that never travel."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AmsAddress, Command, DecodeError, Flags, Frame, TcpCommand, TcpMessage
from achse.ams.commands import DataResponse, ReadRequest

u16 = st.integers(0, 0xFFFF)
u32 = st.integers(0, 0xFFFFFFFF)
addresses = st.binary(min_size=8, max_size=8)
frames = st.builds(Frame, addresses, addresses, u16, u16, u32, u32, st.binary(max_size=64))

PLC = AmsAddress("192.168.100.174.1.1:801")
TERMINAL = AmsAddress("192.168.100.156.1.1:32769")
REQUEST = bytes.fromhex(
    "c0a864ae0101 2103 c0a8649c0101 0180 0200 0400 0c000000 00000000 07000000"
    "05f00000 0400009d 02000000"
)
RESPONSE = bytes.fromhex(
    "c0a8649c0101 0180 c0a864ae0101 2103 0200 0500 0a000000 00000000 0700000000000000 02000000 af27"
)
"""The worked example of 000 §4.3."""


def test_the_worked_request_decodes() -> None:
    frame = Frame.decode(REQUEST)
    assert (frame.target, frame.source) == (PLC, TERMINAL)
    assert (frame.command, frame.flags) == (Command.READ, Flags.ADS_COMMAND)
    assert (frame.error, frame.invoke_id) == (0, 7)
    assert ReadRequest.decode(frame.data) == ReadRequest(0xF005, 0x9D000004, 2)


def test_the_worked_request_encodes() -> None:
    read = ReadRequest(0xF005, 0x9D000004, 2)
    assert Frame(PLC, TERMINAL, Command.READ, invoke_id=7, data=read.encode()).encode() == REQUEST


def test_the_worked_response_is_the_reply_to_the_worked_request() -> None:
    reply = Frame.decode(REQUEST).reply(DataResponse(0, b"\xaf\x27").encode())
    assert reply.encode() == RESPONSE
    assert reply.is_response


def test_a_router_error_stands_in_the_header_with_empty_data() -> None:
    reply = Frame.decode(REQUEST).reply(error=0x40)
    assert reply.encode() == RESPONSE[:20] + bytes.fromhex("00000000 40000000 07000000")


def test_a_reply_leaves_by_the_way_the_request_came() -> None:
    class Way:
        def deliver(self, frame: Frame) -> bool:
            return True

    request = Frame.decode(REQUEST)
    assert request.reply().via is None
    request.origin = Way()
    assert request.reply().via is request.origin
    assert request.reply().origin is None


@given(frames)
def test_bytes_and_back(frame: Frame) -> None:
    twin = Frame.decode(frame.encode())
    assert twin == frame
    for name in ("target", "source", "command", "flags", "error", "invoke_id", "data"):
        assert getattr(twin, name) == getattr(frame, name)


@given(frames)
def test_over_tcp_the_length_of_the_packet_goes_before(frame: Frame) -> None:
    packet = frame.encode()
    assert frame.encode_tcp() == b"\0\0" + len(packet).to_bytes(4, "little") + packet


@given(frames, st.integers(0, 31))
def test_a_cut_header_is_an_error(frame: Frame, size: int) -> None:
    with pytest.raises(DecodeError, match=f"at least 32 bytes, got {size}"):
        Frame.decode(frame.encode()[:size])


@given(frames, st.binary(min_size=1, max_size=8))
def test_data_beyond_the_announced_length_are_an_error(frame: Frame, more: bytes) -> None:
    with pytest.raises(DecodeError, match="announces"):
        Frame.decode(frame.encode() + more)


def test_marks_do_not_count_in_comparison() -> None:
    frame, twin = Frame.decode(REQUEST), Frame.decode(REQUEST)
    twin.origin = twin.via = object()  # type: ignore[assignment]
    assert frame == twin
    assert frame != Frame.decode(RESPONSE)
    assert frame != REQUEST


def test_a_frame_is_readable() -> None:
    assert repr(Frame.decode(RESPONSE)) == (
        "Frame(192.168.100.174.1.1:801 → 192.168.100.156.1.1:32769, command=2, flags=0x0005,"
        " error=0x0, invoke_id=7, data=00 00 00 00 02 00 00 00 af 27)"
    )


@pytest.mark.parametrize(
    ("message", "packet"),
    [
        (TcpMessage(TcpCommand.PORT_CONNECT, bytes(2)), "0010 02000000 0000"),
        (TcpMessage(TcpCommand.PORT_CONNECT, bytes(PLC)), "0010 08000000 c0a864ae0101 2103"),
        (TcpMessage(TcpCommand.PORT_CLOSE, b"\x01\x80"), "0100 02000000 0180"),
        (TcpMessage(TcpCommand.GET_LOCAL_NET_ID, b""), "0210 00000000"),
        (TcpMessage(TcpCommand.ROUTER_NOTE, bytes(4)), "0110 04000000 00000000"),
    ],
)
def test_port_service_packets(message: TcpMessage, packet: str) -> None:
    assert message.encode_tcp() == bytes.fromhex(packet)


def test_flags_are_the_bits_of_the_header() -> None:
    assert Flags.RESPONSE | Flags.ADS_COMMAND == 0x0005
    assert [flag.value for flag in Flags] == [1, 2, 4, 8, 0x10, 0x20, 0x40, 0x80, 0x8000]
