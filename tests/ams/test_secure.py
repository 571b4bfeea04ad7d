"""The connect block of Secure ADS byte for byte, and frames without TCP header however cut."""

import hashlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AmsAddress, Command, DecodeError, Frame, NetId
from achse.ams.secure import (
    BLOCK_SIZE,
    ConnectBlock,
    ConnectFlags,
    SecureFrames,
    SecureRefusal,
    TcpFrames,
    fingerprint_of,
    parse_fingerprint,
    pre_shared_key,
)

FIRST = ConnectBlock(
    net_id=NetId("192.168.4.7.1.1"),
    host="panel",
    flags=ConnectFlags.SELF_SIGNED | ConnectFlags.ADD_REMOTE,
    user="Administrator",
    password="1",
)


def test_first_contact_byte_for_byte() -> None:
    expected = bytes.fromhex(
        "4e00 9000 01 00 c0a804070101 0d 01" + "00" * 18 + "70616e656c" + "00" * 27
    )
    assert FIRST.encode() == expected + b"Administrator" + b"1"
    assert ConnectBlock.decode(FIRST.encode()) == FIRST


def test_answer_byte_for_byte() -> None:
    answer = ConnectBlock(
        net_id=NetId("5.6.7.8.1.1"),
        flags=ConnectFlags.RESPONSE,
        refusal=SecureRefusal.UNKNOWN_USER,
    )
    assert answer.encode() == bytes.fromhex("4000 0100 01 04 050607080101 00 00") + bytes(50)


@given(
    st.binary(min_size=6, max_size=6),
    st.text("abcäöü-", max_size=32),
    st.integers(0, 0xFFFF),
    st.integers(0, 255),
    st.text("xyz€", max_size=200),
    st.text("xyz€", max_size=200),
    st.integers(0, 255),
)
def test_what_is_encoded_is_decoded(
    net_id: bytes, host: str, flags: int, refusal: int, user: str, password: str, version: int
) -> None:
    block = ConnectBlock(
        net_id=NetId(net_id),
        host=host,
        flags=ConnectFlags(flags),
        refusal=refusal,
        user=user,
        password=password,
        version=version,
    )
    stream = bytearray(block.encode() + b"more")
    assert ConnectBlock.take(stream) == block
    assert stream == b"more"


def test_too_long_names_are_refused() -> None:
    with pytest.raises(ValueError, match="255 bytes at most"):
        ConnectBlock(net_id=FIRST.net_id, user="u" * 256).encode()
    with pytest.raises(ValueError, match="448 together"):
        ConnectBlock(net_id=FIRST.net_id, user="u" * 250, password="p" * 250).encode()


def test_a_block_comes_in_pieces() -> None:
    stream = bytearray()
    for byte in FIRST.encode()[:-1]:
        stream.append(byte)
        assert ConnectBlock.take(stream) is None
    stream += FIRST.encode()[-1:]
    assert ConnectBlock.take(stream) == FIRST


@pytest.mark.parametrize("length", [0, BLOCK_SIZE - 1, 513, 0xFFFF])
def test_impossible_lengths_are_refused_at_once(length: int) -> None:
    with pytest.raises(DecodeError, match=r"64\.\.512"):
        ConnectBlock.take(bytearray(length.to_bytes(2, "little")))


@given(st.binary(max_size=600))
def test_any_bytes_are_a_block_none_or_an_error(data: bytes) -> None:
    try:
        ConnectBlock.take(bytearray(data))
        ConnectBlock.decode(data)
    except DecodeError:
        pass


def _frame(data: bytes) -> Frame:
    target, source = AmsAddress("5.6.7.8.1.1:851"), AmsAddress("192.0.2.7.1.1:30000")
    return Frame(bytes(target), bytes(source), Command.READ, 4, 0, 7, data)


@given(st.lists(st.binary(max_size=300), max_size=8), st.lists(st.integers(1, 64), min_size=1))
def test_frames_lose_and_get_their_header_however_cut(datas: list[bytes], cuts: list[int]) -> None:
    packets = b"".join(_frame(data).encode_tcp() for data in datas)
    there, back = TcpFrames(), SecureFrames()
    plain, again = b"", b""
    position = turn = 0
    while position < len(packets):
        step = cuts[turn % len(cuts)]
        plain += b"".join(there.receive(packets[position : position + step]))
        position, turn = position + step, turn + 1
    assert len(plain) == len(packets) - 6 * len(datas)
    for start in range(0, len(plain), cuts[0]):
        again += back.receive(plain[start : start + cuts[0]])
    assert again == packets
    assert back.pending == 0


def test_the_port_service_does_not_go() -> None:
    connect = bytes.fromhex("0010 02000000 0000")
    assert list(TcpFrames().receive(connect + _frame(b"x").encode_tcp())) == [
        _frame(b"x").encode_tcp()[6:]
    ]


def test_a_frame_that_announces_too_much_is_refused() -> None:
    frames = SecureFrames(max_length=100)
    with pytest.raises(DecodeError, match="the limit is 100"):
        frames.receive(_frame(bytes(69)).encode_tcp()[6:])


def test_of_an_unfinished_frame_no_more_than_a_header_is_kept() -> None:
    """What is unfinished counts where the frames go: in the limit of all connections together."""
    packet = _frame(bytes(1_000_000)).encode_tcp()
    frames = SecureFrames()
    came = b""
    for start in range(6, 900_000, 997):
        came += frames.receive(packet[start : start + 997])
        assert frames.pending < 32
    assert packet.startswith(came)
    assert len(came) > 899_000


def test_a_frame_with_its_tcp_header_is_refused() -> None:
    with pytest.raises(DecodeError, match="have no TCP header"):
        SecureFrames().receive(_frame(b"abc").encode_tcp())


def test_fingerprints() -> None:
    digits = hashlib.sha256(b"certificate").hexdigest()
    assert fingerprint_of(b"certificate") == digits
    spaced = ":".join(digits[i : i + 2] for i in range(0, 64, 2)).upper()
    assert parse_fingerprint(spaced) == digits
    with pytest.raises(ValueError, match="64 hex digits"):
        parse_fingerprint("abc")


def test_keys() -> None:
    assert pre_shared_key("x", "ab" * 32) == b"\xab" * 32
    assert pre_shared_key("me", "secret") == hashlib.sha256(b"MEsecret").digest()
    sensitive = pre_shared_key("me", "secret", case_sensitive=True)
    assert sensitive == hashlib.sha256(b"mesecret").digest()
