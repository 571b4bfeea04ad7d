"""EoE on the wire: what is taken apart is put together again, and nothing else is."""

from ipaddress import IPv4Address

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ethercat.eoe import (
    EoeType,
    FrameAssembly,
    IpSettings,
    MacFilter,
    fragments,
    request,
    split,
)

MACS = st.binary(min_size=6, max_size=6)
ADDRESSES = st.none() | st.integers(0, 2**32 - 1).map(IPv4Address)
FRAMES = st.binary(min_size=14, max_size=1518)


@given(st.lists(st.tuples(FRAMES, st.integers(36, 1486), st.integers(0, 15)), max_size=5))
def test_frames_come_out_of_their_fragments(sent: list[tuple[bytes, int, int]]) -> None:
    assembly = FrameAssembly()
    for frame, room, number in sent:
        parts = list(fragments(frame, number, room))
        assert all(len(part) <= room for part in parts)
        whole = [assembly.take(part) for part in parts]
        assert whole == [None] * (len(parts) - 1) + [frame]
    assert assembly.dropped == 0


@given(FRAMES, st.integers(36, 400), st.data())
def test_a_frame_with_a_wrong_fragment_is_dropped_and_the_next_one_comes(
    frame: bytes, room: int, data: st.DataObject
) -> None:
    assembly = FrameAssembly()
    parts = list(fragments(frame, 3, room))
    hit = data.draw(st.integers(0, len(parts) - 1), "fragment")
    kind = data.draw(st.sampled_from(["lost", "twice"]), "what happens")
    parts[hit : hit + 1] = [] if kind == "lost" else [parts[hit]] * 2
    whole = [each for each in map(assembly.take, parts) if each is not None]
    assert whole in ([], [frame]) or (len(parts) == 2 and whole == [frame, frame])
    assert [assembly.take(part) for part in fragments(frame, 4, room)][-1] == frame


@given(st.lists(st.binary(max_size=80), max_size=20))
def test_any_bytes_are_taken(messages: list[bytes]) -> None:
    assembly = FrameAssembly()
    for message in messages:
        frame = assembly.take(message)
        assert frame is None or 14 <= len(frame) <= 1518


def test_the_time_behind_a_frame_is_no_part_of_it() -> None:
    (part,) = fragments(bytes(range(60)), 0, 200)
    timed = bytes((part[0], part[1] | 0x02)) + part[2:] + bytes(4)
    assert FrameAssembly().take(timed) == bytes(range(60))


@pytest.mark.parametrize(("size", "room"), [(13, 200), (1519, 200), (60, 35)])
def test_what_is_no_frame_is_refused(size: int, room: int) -> None:
    with pytest.raises(ValueError, match=r"14 to 1518 bytes|needs 36 bytes"):
        list(fragments(bytes(size), 0, room))


NONE = IPv4Address("0.0.0.0")


@given(
    *(st.none() | MACS, ADDRESSES, ADDRESSES, ADDRESSES, ADDRESSES),
    st.none() | st.text("abc-.1", max_size=32),
)
def test_settings_travel(
    mac: bytes | None,
    address: IPv4Address | None,
    mask: IPv4Address | None,
    gateway: IPv4Address | None,
    dns: IPv4Address | None,
    name: str | None,
) -> None:
    settings = IpSettings(mac, address, mask, gateway, dns, name)
    assert IpSettings.decode(settings.encode()) == settings
    whole = bytearray(IpSettings(bytes(6), NONE, NONE, NONE, NONE, "").encode())
    at = 4
    for bit, field in enumerate((mac, address, mask, gateway, dns, name)):
        size = (6, 4, 4, 4, 4, 32)[bit]
        if field is None:
            whole[0] &= ~(1 << bit)
        else:
            name_of = ("mac", "address", "mask", "gateway", "dns", "name")[bit]
            alone = IpSettings(**{name_of: field})  # type: ignore[arg-type]
            whole[at : at + size] = alone.encode()[4:]
        at += size
    assert IpSettings.decode(bytes(whole)) == settings, "each at its place"


def test_addresses_are_little_endian_and_packed_as_open_masters_send_them() -> None:
    data = IpSettings(address=IPv4Address("192.168.9.200")).encode()
    assert data == b"\x02\0\0\0" + bytes((200, 9, 168, 192))
    assert IpSettings.decode(b"\x20\0\0\0box").name == "box", "a name may be short"


@given(st.lists(MACS, max_size=15), st.lists(MACS, max_size=3), st.booleans())
def test_filters_travel(addresses: list[bytes], masks: list[bytes], broadcasts: bool) -> None:
    wanted = MacFilter(tuple(addresses), tuple(masks), broadcasts)
    assert MacFilter.decode(wanted.encode()) == wanted


def test_too_much_for_a_setting_is_refused() -> None:
    with pytest.raises(ValueError, match="15 addresses and 3 masks"):
        MacFilter((bytes(6),) * 16).encode()
    with pytest.raises(ValueError, match="MAC address has 6 bytes"):
        MacFilter((bytes(5),)).encode()
    with pytest.raises(ValueError, match="a name 32 at most"):
        IpSettings(name="x" * 33).encode()
    with pytest.raises(ValueError, match="4 bytes or more, got 3"):
        IpSettings.decode(bytes(3))
    with pytest.raises(ValueError, match="cut off after 7 bytes"):
        IpSettings.decode(b"\x02\0\0\0" + bytes(3))
    with pytest.raises(ValueError, match="122 bytes, got 3"):
        MacFilter.decode(bytes(3))


def test_requests_have_four_bytes_of_head() -> None:
    assert request(EoeType.SET_IP, b"abc") == b"\x02\x01\0\0abc"
    assert split(b"\x23\x01\x01\x02rest") == (3, 2, 0x0201, b"rest")
    with pytest.raises(ValueError, match="4 bytes or more, got 3"):
        split(b"abc")
