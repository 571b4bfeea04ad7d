"""Datagrams by ADS: lengths, and what comes back."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import DeviceError
from achse.devices.io.datagram import decode_datagram, encode_datagram


@given(
    command=st.integers(0, 14),
    index=st.integers(0, 255),
    address=st.integers(0, 0xFFFF_FFFF),
    data=st.binary(max_size=100),
)
def test_there_and_back(command: int, index: int, address: int, data: bytes) -> None:
    request = (
        bytes((command, index))
        + address.to_bytes(4, "little")
        + len(data).to_bytes(2, "little")
        + bytes(2)
        + data
        + bytes(2)
    )
    datagram = decode_datagram(request, len(request))
    assert encode_datagram(datagram, index) == request


@given(st.binary(max_size=40), st.integers(0, 100))
def test_anything_is_decoded_or_refused(data: bytes, length: int) -> None:
    try:
        decode_datagram(data, length)
    except DeviceError:
        return
    assert 12 <= len(data) <= length


def test_lengths_have_to_agree() -> None:
    with pytest.raises(DeviceError):
        decode_datagram(bytes(12), 11)
    with pytest.raises(DeviceError):
        decode_datagram(bytes(13), 13)
