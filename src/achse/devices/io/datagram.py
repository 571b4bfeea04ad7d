"""A datagram by ADS: what clients send with groups 0x2C and 0x500 goes round the bus."""

import struct

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.ethercat import Datagram
from achse.ethercat.frame import MAX_FRAME
from achse.ethercat.master.steps import Steps, Trip

_HEAD = struct.Struct("<BBIHH")
_COUNTER = 2
_LENGTH = 0x07FF
_OVERHEAD = _HEAD.size + _COUNTER
_LAST_COMMAND = 14
_LONGEST = MAX_FRAME - 16


def decode_datagram(data: bytes, read_length: int) -> Datagram:
    """Return the datagram in a request; both lengths are 12 + n. Raises DeviceError 0x705,
    0x706."""
    if len(data) < _OVERHEAD or read_length < len(data) or len(data) > _LONGEST:
        raise DeviceError(
            ReturnCode.INVALID_SIZE,
            f"12 to {_LONGEST} bytes both ways, got {len(data)} and {read_length}",
        )
    command, index, address, length, _ = _HEAD.unpack_from(data)
    size = len(data) - _OVERHEAD
    if length & _LENGTH != size:
        expected = f"expected {length & _LENGTH} bytes of data, got {size}"
        raise DeviceError(ReturnCode.INVALID_SIZE, expected)
    if command > _LAST_COMMAND:
        raise DeviceError(ReturnCode.INVALID_DATA, f"command {command}")
    return Datagram(command, address, data[_HEAD.size : -_COUNTER], index)


def encode_datagram(datagram: Datagram, index: int) -> bytes:
    """Return the datagram as it came back, with the index that the client gave it."""
    head = _HEAD.pack(datagram.command, index, datagram.address, len(datagram.data), datagram.irq)
    return head + datagram.data + (datagram.counter & 0xFFFF).to_bytes(_COUNTER, "little")


def send_datagram(datagram: Datagram) -> Steps[bytes]:
    """Send it once; the bytes of the answer."""
    index = datagram.index
    back = yield Trip((datagram,), tries=1)
    return encode_datagram(back.datagrams[0], index)
