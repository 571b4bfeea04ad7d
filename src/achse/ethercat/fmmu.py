"""FMMUs: bits of the logical address space that are bits of a slave's memory.

Source: ETG.1000.4 §6.6, table 57.
"""

import struct
from typing import NamedTuple

_REGISTERS = struct.Struct("<IHBBHBBB3x")

_READ = 0x01
_WRITE = 0x02


class Transfer(NamedTuple):
    """The part of an FMMU that a datagram covers, in bits of the datagram's data and of memory."""

    datagram_bit: int
    memory_bit: int
    bits: int

    @property
    def in_bytes(self) -> bool:
        """True if no bit shifting is needed."""
        return not (self.datagram_bit | self.memory_bit | self.bits) & 7


class Fmmu(NamedTuple):
    """One FMMU entry, 16 bytes of registers at 0x0600 + 16·number.

    Logical bits from `start_bit` of the byte at `logical` to `stop_bit` of the last of `length`
    bytes are the bits from `physical_bit` of the byte at `physical` on.
    """

    logical: int
    length: int
    start_bit: int
    stop_bit: int
    physical: int
    physical_bit: int
    direction: int
    active: int

    @classmethod
    def decode(cls, registers: bytes | bytearray) -> "Fmmu":
        """Return the entry in its 16 registers."""
        logical, length, start, stop, physical, bit, direction, active = _REGISTERS.unpack(
            registers
        )
        return cls(logical, length, start & 7, stop & 7, physical, bit & 7, direction, active)

    def encode(self) -> bytes:
        """Return the 16 registers."""
        return _REGISTERS.pack(*self)

    @property
    def reads(self) -> bool:
        """True if memory is copied into the datagram."""
        return bool(self.active & 1 and self.direction & _READ)

    @property
    def writes(self) -> bool:
        """True if the datagram is copied into memory."""
        return bool(self.active & 1 and self.direction & _WRITE)

    def transfer(self, address: int, length: int) -> Transfer | None:
        """Return the overlap with a datagram of `length` bytes at the logical `address`, None
        without overlap."""
        first = self.logical * 8 + self.start_bit
        last = (self.logical + self.length - 1) * 8 + self.stop_bit + 1
        begin = max(first, address * 8)
        bits = min(last, (address + length) * 8) - begin
        if bits <= 0:
            return None
        memory = self.physical * 8 + self.physical_bit + begin - first
        return Transfer(begin - address * 8, memory, bits)
