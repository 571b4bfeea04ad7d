"""Modbus requests and answers: PDUs of the function codes that PLC blocks use.

Registers are in the memory of a PLC with the low byte first, on the wire with the high byte first;
bits are in both eight to a byte, the first one lowest. Source: MODBUS Application Protocol
V1.1b3, section 6.
"""

import struct
from typing import NamedTuple

_WORDS = struct.Struct(">BHH")
_WRITE = struct.Struct(">BHHB")
_READ_WRITE = struct.Struct(">BHHHHB")

ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, ILLEGAL_VALUE, DEVICE_FAILURE = 1, 2, 3, 4

_MOST_READ = {1: 2000, 2: 2000, 3: 125, 4: 125, 23: 125}
"""Most bits or registers that one request may read, by function code."""
_MOST_WRITTEN = {15: 1968, 16: 123, 23: 121}
_BITS = (1, 2, 15)


class ModbusRefusal(Exception):
    """A request that cannot go, or that was refused, with the exception code of Modbus."""

    def __init__(self, code: int, text: str) -> None:
        super().__init__(text)
        self.code = code


class Query(NamedTuple):
    """A request as a block gives it."""

    function: int
    address: int = 0
    """First bit or register; sub-function of function 8."""
    quantity: int = 0
    """Bits or registers to be read, or written by 15 and 16; the value of 5, 6 and 8."""
    write_address: int = 0
    write_quantity: int = 0
    """Both of function 23."""
    data: bytes = b""
    """Data to be written, in the byte order of the PLC's memory."""

    @property
    def size(self) -> int:
        """Bytes that the answer has for the PLC."""
        if self.function == 8:
            return 2
        return _size(self.function, self.quantity) if self.function in _MOST_READ else 0


def _size(function: int, quantity: int) -> int:
    return (quantity + 7) // 8 if function in _BITS else 2 * quantity


def swapped(registers: bytes) -> bytes:
    """Registers with their bytes the other way round."""
    turned = bytearray(registers)
    turned[::2], turned[1::2] = registers[1::2], registers[::2]
    return bytes(turned)


def request_pdu(query: Query) -> bytes:
    """Return the PDU of a request. Raises ModbusRefusal: 1 for an unknown function, 2 for too
    little data or addresses beyond 65535, 3 for a quantity that no request can have."""
    function = query.function
    if function in (5, 6, 8):
        return _WORDS.pack(function, query.address, query.quantity)
    if function not in _MOST_READ and function not in _MOST_WRITTEN:
        raise ModbusRefusal(ILLEGAL_FUNCTION, f"function {function}")
    if function in _MOST_READ:
        _check(query.address, query.quantity, _MOST_READ[function])
        if function != 23:
            return _WORDS.pack(function, query.address, query.quantity)
        address, quantity = query.write_address, query.write_quantity
    else:
        address, quantity = query.address, query.quantity
    _check(address, quantity, _MOST_WRITTEN[function])
    size = _size(function, quantity)
    if len(query.data) < size:
        raise ModbusRefusal(
            ILLEGAL_ADDRESS, f"{size} bytes are to be written, got {len(query.data)}"
        )
    data = query.data[:size]
    if function == 15:
        return _WRITE.pack(function, address, quantity, size) + _masked(data, quantity)
    if function == 16:
        return _WRITE.pack(function, address, quantity, size) + swapped(data)
    return _READ_WRITE.pack(
        function, query.address, query.quantity, address, quantity, size
    ) + swapped(data)


def _check(address: int, quantity: int, most: int) -> None:
    if not 1 <= quantity <= most:
        raise ModbusRefusal(ILLEGAL_VALUE, f"expected 1..{most} at a time, got {quantity}")
    if address + quantity > 0x1_0000:
        raise ModbusRefusal(ILLEGAL_ADDRESS, f"{quantity} from {address} on end beyond 65535")


def _masked(bits: bytes, quantity: int) -> bytes:
    """Bits without those of the last byte that were not requested."""
    rest = quantity % 8
    return bits if not rest else bits[:-1] + bytes((bits[-1] & (1 << rest) - 1,))


def answer_data(query: Query, pdu: bytes) -> bytes:
    """Return the data of an answer, in the byte order of the PLC's memory.

    Raises ModbusRefusal with the exception code of the answer, 4 for one that does not fit.
    """
    function = query.function
    if len(pdu) == 2 and pdu[0] == function | 0x80:
        raise ModbusRefusal(pdu[1], f"the device answers exception {pdu[1]}")
    if not pdu or pdu[0] != function:
        raise _misfit(pdu)
    if function in _MOST_READ:
        size = query.size
        if len(pdu) != 2 + size or pdu[1] != size:
            raise _misfit(pdu)
        data = pdu[2:]
        return _masked(data, query.quantity) if function in _BITS else swapped(data)
    if len(pdu) != _WORDS.size:
        raise _misfit(pdu)
    _, address, value = _WORDS.unpack(pdu)
    if address != query.address or (function != 8 and value != query.quantity):
        raise _misfit(pdu)
    return struct.pack("<H", value) if function == 8 else b""


def _misfit(pdu: bytes) -> ModbusRefusal:
    return ModbusRefusal(DEVICE_FAILURE, f"the answer {pdu[:16].hex(' ')} does not fit")
