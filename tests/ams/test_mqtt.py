"""Topics and info messages of ADS over MQTT; messages that are frames and those that are not."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AmsAddress, Command, DecodeError, Frame, NetId
from achse.ams.mqtt import MqttTopics, RouterNote, as_tcp_packet

PRESS = NetId("5.6.7.8.1.1")

DOCUMENTED = b"""<info>
  <online name="EC2AMAZ-2RRSQS6" osVersion="10.0.20348" osPlatform="2"
    tcVersion="3.1.4026.10">true</online>
</info>"""


def test_topics() -> None:
    topics = MqttTopics("plant/hall1")
    assert topics.info(PRESS) == "plant/hall1/5.6.7.8.1.1/info"
    assert topics.requests(PRESS) == "plant/hall1/5.6.7.8.1.1/ams"
    assert topics.answers(PRESS) == "plant/hall1/5.6.7.8.1.1/ams/res"
    assert topics.ours(PRESS) == "plant/hall1/5.6.7.8.1.1/ams/#"
    assert topics.all_infos == "plant/hall1/+/info"
    assert topics.teller(topics.info(PRESS)) == PRESS
    for other in ("plant/hall1/x/info", "plant/5.6.7.8.1.1/info", topics.requests(PRESS), "info"):
        assert topics.teller(other) is None


@pytest.mark.parametrize("name", ["", "/", "a/", "a//b", "a+", "#", "a\0"])
def test_names_that_cannot_be(name: str) -> None:
    with pytest.raises(ValueError, match="virtual network"):
        MqttTopics(name)


def test_the_documented_info() -> None:
    note = RouterNote.decode(DOCUMENTED)
    assert note == RouterNote(
        online=True,
        name="EC2AMAZ-2RRSQS6",
        os_version="10.0.20348",
        os_platform=2,
        tc_version="3.1.4026.10",
    )
    assert RouterNote.decode(note.encode()) == note
    assert note.encode() == (
        b'<info><online name="EC2AMAZ-2RRSQS6" osVersion="10.0.20348" osPlatform="2"'
        b' tcVersion="3.1.4026.10">true</online></info>'
    )


@pytest.mark.parametrize(
    ("text", "online"),
    [
        (b"", False),
        (b"<info><online>false</online></info>", False),
        (b"<info><online> True </online></info>", True),
        (b"\xef\xbb\xbf<info>\r\n<online osPlatform='x'>1</online></info>", True),
        (b"<online>true</online>", True),
        (b"<info><online/></info>", False),
    ],
)
def test_foreign_infos(text: bytes, online: bool) -> None:
    assert RouterNote.decode(text).online is online


@pytest.mark.parametrize(
    "text", [b"true", b"<info>", b"<info/>", b"<!DOCTYPE x><info/>", b"<info>" + b" " * 5000]
)
def test_infos_that_are_none(text: bytes) -> None:
    with pytest.raises(DecodeError):
        RouterNote.decode(text)


@given(st.booleans(), st.text(max_size=30), st.text(max_size=10), st.integers(0, 9999))
def test_infos_come_back(online: bool, name: str, version: str, platform: int) -> None:
    note = RouterNote(online=online, name=name, tc_version=version, os_platform=platform)
    try:
        assert RouterNote.decode(note.encode()).online is online
    except DecodeError:
        assert not name.isprintable() or not version.isprintable()


def test_messages_are_frames() -> None:
    target, source = AmsAddress("5.6.7.8.1.1:851"), AmsAddress("10.1.2.3.1.1:30000")
    packet = Frame(bytes(target), bytes(source), Command.READ, data=b"abc").encode_tcp()
    assert as_tcp_packet(packet[6:], 100) == packet
    for wrong, message in (
        (packet, "announces"),
        (packet[6:-1], "announces 3 bytes of data, the message has 2"),
        (packet[6:] + bytes(100), "32..100 bytes"),
        (b"", "32..100 bytes, got 0"),
    ):
        with pytest.raises(DecodeError, match=message):
            as_tcp_packet(wrong, 100)
