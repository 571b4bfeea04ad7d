"""A Modbus device that has memory."""

import struct

__all__ = ["Memory"]


class Memory:
    """Coils and registers of a device; what it was asked last."""

    def __init__(self) -> None:
        self.bits = [index % 3 == 0 for index in range(64)]
        self.registers = [0x1100 + index for index in range(64)]
        self.unit = 0

    def answer(self, unit: int, pdu: bytes) -> bytes:
        self.unit = unit
        function = pdu[0]
        if function == 8:
            return pdu
        address, value = struct.unpack(">HH", pdu[1:5])
        if address + (value if function not in (5, 6) else 1) > 64:
            return bytes((function | 0x80, 2))
        if function in (1, 2):
            return bytes((function, (value + 7) // 8)) + self._bits(address, value)
        if function in (3, 4):
            return bytes((function, 2 * value)) + self._words(address, value)
        if function == 5:
            self.bits[address] = value == 0xFF00
        elif function == 6:
            self.registers[address] = value
        elif function == 15:
            for index in range(value):
                self.bits[address + index] = bool(pdu[6 + index // 8] >> index % 8 & 1)
        elif function == 16:
            self._write(address, pdu[6:])
        elif function == 23:
            self._write(struct.unpack(">H", pdu[5:7])[0], pdu[10:])
            return bytes((function, 2 * value)) + self._words(address, value)
        return pdu[:5]

    def _bits(self, address: int, count: int) -> bytes:
        number = sum(bit << index for index, bit in enumerate(self.bits[address : address + count]))
        return number.to_bytes((count + 7) // 8, "little")

    def _words(self, address: int, count: int) -> bytes:
        return struct.pack(f">{count}H", *self.registers[address : address + count])

    def _write(self, address: int, data: bytes) -> None:
        for index, value in enumerate(struct.unpack(f">{len(data) // 2}H", data)):
            self.registers[address + index] = value
