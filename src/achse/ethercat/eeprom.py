"""The EEPROM behind the EEPROM registers: the master reads and writes the SII image.

Source: ETG.1000.4 §6.4.
"""

from achse.ethercat.registers import Register

_CONTROL, COMMAND, _ADDRESS, _DATA = (Register.EEPROM + offset for offset in (0, 1, 2, 6))
"""Parts of the register: control and status, the command in it, word address, data."""

_WRITE_ENABLE = 0x0001
_READS_EIGHT_BYTES = 0x0040
_TWO_BYTE_ADDRESS = 0x0080
_CHECKSUM_ERROR = 0x0800
_COMMAND_ERROR = 0x2000
_WRITE_ENABLE_ERROR = 0x4000


def checksum(words: bytes | bytearray) -> int:
    """CRC-8 of the configuration area, bytes 0..13: x^8+x^2+x+1, start value 0xFF."""
    crc = 0xFF
    for byte in words[:14]:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1 ^ 0x07 if crc & 0x80 else crc << 1) & 0xFF
    return crc


class Eeprom:
    """An SII image with the register interface of the slave controller.

    Commands complete at once. `image` is what lasts; the controller takes its configuration area
    (words 0..7) over at power-up and on reload.
    """

    def __init__(self, image: bytes, memory: bytearray) -> None:
        self.image = bytearray(image)
        self._memory = memory
        self._errors = 0
        self._set_status()

    @property
    def valid(self) -> bool:
        """True if the checksum of the configuration area is right."""
        return len(self.image) > 14 and self.image[14] == checksum(self.image)

    def command(self, first: int, end: int) -> None:
        """Do what control requests: registers `first` to `end` - 1 have been written."""
        if first >= _ADDRESS or end <= COMMAND:
            self._set_status()
            return
        memory = self._memory
        control = memory[_CONTROL] | memory[_CONTROL + 1] << 8
        address = 2 * int.from_bytes(memory[_ADDRESS:_DATA], "little")
        self._errors = 0
        match control >> 8 & 0x07:
            case 0:
                pass
            case 1:
                data = bytes(self.image[address : address + 8])
                memory[_DATA : _DATA + 8] = data.ljust(8, b"\xff")
            case 2 if not control & _WRITE_ENABLE:
                self._errors = _WRITE_ENABLE_ERROR
            case 2 if address + 2 <= len(self.image):
                self.image[address : address + 2] = memory[_DATA : _DATA + 2]
            case 4:
                pass
            case _:
                self._errors = _COMMAND_ERROR
        self._set_status()

    def _set_status(self) -> None:
        status = _READS_EIGHT_BYTES | _TWO_BYTE_ADDRESS | self._errors
        if not self.valid:
            status |= _CHECKSUM_ERROR
        self._memory[_CONTROL : _CONTROL + 2] = status.to_bytes(2, "little")
