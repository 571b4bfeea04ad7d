"""NetIds and AMS addresses: text, bytes, limits."""

import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AmsAddress, NetId

net_ids = st.binary(min_size=6, max_size=6).map(NetId)
ports = st.integers(0, 0xFFFF)


def test_a_net_id_is_its_wire_bytes() -> None:
    assert NetId("192.168.100.174.1.1") == bytes.fromhex("c0a864ae0101")


def test_an_address_is_its_wire_bytes() -> None:
    address = AmsAddress("192.168.100.174.1.1:801")
    assert address == bytes.fromhex("c0a864ae0101 2103")
    assert address.net_id == NetId("192.168.100.174.1.1")
    assert isinstance(address.net_id, NetId)
    assert address.port == 801


@given(net_ids, ports)
def test_text_and_back(net_id: NetId, port: int) -> None:
    address = AmsAddress.of(net_id, port)
    assert NetId(str(net_id)) == net_id
    assert AmsAddress(str(address)) == address
    assert (address.net_id, address.port) == (net_id, port)


@given(net_ids, ports)
def test_a_slice_of_a_frame_finds_the_same_dictionary_entry(net_id: NetId, port: int) -> None:
    address = AmsAddress.of(net_id, port)
    assert dict[bytes, str]({address: "device"})[bytes(address)] == "device"


@pytest.mark.parametrize(
    "text",
    [
        "",
        "1.2.3.4.5",
        "1.2.3.4.5.6.7",
        "1.2.3.4.5.256",
        "1.2.3.4.5.-1",
        "1.2.3.4.5.x",
        "1.2.3.4.5.1_0",
        "1.2.3.4.5.+1",
        "1.2.3.4.5.٣",
        "1..3.4.5.6",
        "1.2.3.4.5." + "9" * 5000,
    ],
)
def test_bad_net_id_texts_say_what_was_expected(text: str) -> None:
    with pytest.raises(ValueError, match=r"six numbers 0\.\.255 with dots, got"):
        NetId(text)


@pytest.mark.parametrize("text", ["1.2.3.4.5.6", "1.2.3.4.5.6:", "1.2.3.4.5.6:x", ":851", "851"])
@pytest.mark.parametrize("suffix", ["", "²", "٣", "-1", "9" * 5000])
def test_bad_address_texts_say_what_was_expected(text: str, suffix: str) -> None:
    with pytest.raises(ValueError, match=r"an AMS address is NETID:PORT|a NetId is six numbers"):
        AmsAddress(text + suffix)


@pytest.mark.parametrize("port", [-1, 0x1_0000])
def test_ports_have_16_bits(port: int) -> None:
    with pytest.raises(ValueError, match=r"0\.\.65535"):
        AmsAddress.of(bytes(6), port)


def test_a_port_in_text_has_16_bits() -> None:
    with pytest.raises(ValueError, match=r"0\.\.65535, got 65536"):
        AmsAddress("1.2.3.4.5.6:65536")


@pytest.mark.parametrize("size", [0, 5, 7])
def test_wrong_sizes(size: int) -> None:
    with pytest.raises(ValueError, match="6 bytes"):
        NetId(bytes(size))
    with pytest.raises(ValueError, match="8 bytes"):
        AmsAddress.of(bytes(size), 851)
    with pytest.raises(ValueError, match="8 bytes"):
        AmsAddress(bytes(size))


def test_representations_are_readable() -> None:
    address = AmsAddress("5.1.2.3.1.1:851")
    assert repr(address) == "AmsAddress('5.1.2.3.1.1:851')"
    assert repr(address.net_id) == "NetId('5.1.2.3.1.1')"
    assert f"{address}" == "5.1.2.3.1.1:851"


def test_addresses_survive_pickling() -> None:
    address = AmsAddress("5.1.2.3.1.1:851")
    assert pickle.loads(pickle.dumps(address)) == address
