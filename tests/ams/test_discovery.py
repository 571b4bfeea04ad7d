"""Discovery datagrams: byte layout as recorded, both directions, nothing but DecodeError."""

import struct
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AmsAddress, DecodeError, NetId
from achse.ams.discovery import (
    DiscoveryPacket,
    DiscoveryService,
    OsVersion,
    RouteRequest,
    RouterInfo,
    Tag,
    answer_with,
    info_request,
    status_of,
)

OURS = NetId("5.1.2.3.1.1")
PYADS_ADD_ROUTE = bytes.fromhex(
    "03661471 00000000 06000000 0a0000070101 1027 05000000"
    "0c00 0500 7072657300"  # route name "pres"
    "0700 0600 0a0000070101"
    "0d00 0600 61646d696e00"  # user "admin"
    "0200 0200 3100"  # password "1"
    "0500 0900 31302e302e302e3700".replace(" ", "")
)


def test_a_search_has_the_recorded_24_bytes() -> None:
    data = info_request(NetId("1.1.1.1.1.1")).encode()
    assert data.hex() == "036614710000000001000000" + "010101010101" + "1027" + "00000000"


def test_an_add_route_of_a_python_client_is_understood() -> None:
    datagram = DiscoveryPacket.decode(PYADS_ADD_ROUTE)
    assert datagram.service == DiscoveryService.ADD_ROUTE
    assert not datagram.answer
    assert datagram.source == AmsAddress("10.0.0.7.1.1:10000")
    assert RouteRequest.decode(datagram) == RouteRequest(
        "pres", NetId("10.0.0.7.1.1"), "10.0.0.7", "admin", "1"
    )


def test_an_add_route_is_written_as_it_was_recorded() -> None:
    request = RouteRequest("pres", NetId("10.0.0.7.1.1"), "10.0.0.7", "admin", "1")
    assert request.encode(NetId("10.0.0.7.1.1")).encode() == PYADS_ADD_ROUTE


@pytest.mark.parametrize("status", [0, 0x704, 0x706])
def test_the_answer_to_an_add_route_has_exactly_32_bytes(status: int) -> None:
    request = DiscoveryPacket.decode(PYADS_ADD_ROUTE)._replace(invoke_id=77)
    data = answer_with(request, OURS, status).encode()
    assert len(data) == 32
    assert data[26:28] == b"\4\0"
    assert struct.unpack_from("<III", data) == (0x71146603, 77, 0x80000006)
    assert status_of(DiscoveryPacket.decode(data)) == status


def test_an_info_answer_has_its_tags_in_the_recorded_order_and_size() -> None:
    info = RouterInfo(OURS, "CX-1234", (3, 1, 4024), OsVersion(10, 0, 19045, 2, "x"), "ab" * 32)
    datagram = info.encode(info_request(OURS))
    assert [number for number, _ in datagram.tags] == [5, 4, 3, 18]
    assert [len(data) for _, data in datagram.tags] == [8, 276, 4, 65]
    data = datagram.encode()
    assert data[8:12] == b"\1\0\0\x80"
    assert data[12:18] == OURS
    assert RouterInfo.decode(DiscoveryPacket.decode(data)) == info


def test_an_answer_without_tags_still_names_its_sender() -> None:
    answer = DiscoveryPacket(1, AmsAddress.of(OURS, 10_000), (), True)
    assert RouterInfo.decode(answer) == RouterInfo(OURS, "")
    with pytest.raises(DecodeError, match="status"):
        status_of(answer)


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "24 bytes"),
        (bytes(24), "0x71146603"),
        (PYADS_ADD_ROUTE[:30], "cut short"),
        (PYADS_ADD_ROUTE[:26], "5 tags are announced, 0 came"),
        (PYADS_ADD_ROUTE[:20] + b"\xff\xff\xff\xff", "at most 64 tags"),
    ],
)
def test_what_is_no_datagram_says_so(data: bytes, reason: str) -> None:
    with pytest.raises(DecodeError, match=reason):
        DiscoveryPacket.decode(data)


def test_a_tag_beyond_its_length_field_is_refused() -> None:
    with pytest.raises(ValueError, match="65535"):
        DiscoveryPacket(1, AmsAddress.of(OURS, 1), [(5, bytes(0x1_0000))]).encode()


def test_tags_of_a_wrong_size_are_as_if_absent() -> None:
    tags = [(Tag.NET_ID, b"12345"), (Tag.OPTIONS, b"1"), (Tag.VERSION, b""), (Tag.OS_VERSION, b"1")]
    datagram = DiscoveryPacket(6, AmsAddress.of(OURS, 10_000), tags)
    assert RouteRequest.decode(datagram) == RouteRequest("", None)
    assert RouterInfo.decode(datagram) == RouterInfo(OURS, "")


texts = st.text(st.characters(codec="cp1252", exclude_characters="\0"), max_size=40)
net_ids = st.binary(min_size=6, max_size=6).map(NetId)
datagrams = st.builds(
    DiscoveryPacket,
    st.integers(0, 0x7FFF_FFFF),
    st.binary(min_size=8, max_size=8).map(AmsAddress),
    st.lists(st.tuples(st.integers(0, 0xFFFF), st.binary(max_size=60)), max_size=20),
    st.booleans(),
    st.integers(0, 0xFFFF_FFFF),
)


@given(datagrams, st.binary(max_size=5))
def test_a_datagram_survives_the_wire(datagram: DiscoveryPacket, tail: bytes) -> None:
    assert DiscoveryPacket.decode(datagram.encode() + tail) == datagram


@given(st.binary(max_size=100), st.booleans())
def test_any_bytes_decode_or_raise_decode_error(data: bytes, begins_well: bool) -> None:
    if begins_well:
        data = info_request(OURS).encode()[:20] + data
    try:
        datagram = DiscoveryPacket.decode(data)
    except DecodeError:
        return
    RouteRequest.decode(datagram)
    RouterInfo.decode(datagram)


@given(st.builds(RouteRequest, texts, net_ids, texts, texts, texts, st.booleans()), net_ids)
def test_a_route_request_survives_the_wire(request: RouteRequest, source: NetId) -> None:
    assert RouteRequest.decode(DiscoveryPacket.decode(request.encode(source).encode())) == request


versions = st.builds(
    OsVersion,
    *[st.integers(0, 0xFFFF_FFFF)] * 4,
    st.text(st.characters(max_codepoint=0xFFFF, exclude_categories=["Cs"], exclude_characters="\0"),
            max_size=127),
)  # fmt: skip


@given(st.builds(RouterInfo, net_ids, texts,
                 st.tuples(st.integers(0, 255), st.integers(0, 255), st.integers(0, 65535)),
                 versions, st.text("0123456789abcdef", max_size=64)))  # fmt: skip
def test_system_info_survives_the_wire(info: RouterInfo) -> None:
    data = info.encode(info_request(OURS)).encode()
    assert RouterInfo.decode(DiscoveryPacket.decode(data)) == info


@pytest.mark.skipif(sys.platform == "win32", reason="its processes have no limit of descriptors")
def test_answer_needs_no_descriptor() -> None:
    """Python loads the module of a text encoding when it is first used, from a file."""
    code = """
import os, resource
from achse.ams import NetId
from achse.ams.discovery import RouterInfo, info_request
resource.setrlimit(resource.RLIMIT_NOFILE, (3, 3))
RouterInfo(NetId("5.1.2.3.1.1"), "press").encode(info_request(NetId("5.1.2.4.1.1")))
"""
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (result.stderr, result.returncode) == ("", 0)
