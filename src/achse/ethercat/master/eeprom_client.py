"""A slave's EEPROM through its registers: words are read and written, images are whole.

Source: ETG.1000.4 §6.4; ETG.2010 for the end of an image.
"""

from achse.ethercat.eeprom import COMMAND
from achse.ethercat.frame import Datagram, DatagramCommand
from achse.ethercat.master.errors import EepromTrouble, NoAnswer
from achse.ethercat.master.steps import Pause, Steps, Trip, write
from achse.ethercat.registers import Register

_READ, _WRITE, _RELOAD = 1 << 8, 2 << 8 | 1, 4 << 8
"""Commands; a write enables itself in the same access."""

_EIGHT_BYTES = 0x0040
_LOADING, _COMMAND_ERROR, _WRITE_ERROR, _BUSY = 0x1000, 0x2000, 0x4000, 0x8000
_CONTROL = int(Register.EEPROM)
_CLAIM, _HAND_OVER = b"\x00", b"\x01"
_FORCE = b"\x02"

_BUSY_NS = 20_000_000
_POLL_NS = 1_000_000
_TRIES = 3
_CATEGORIES = 0x40
"""First word of the categories."""
_END = 0xFFFF
_STATION = 1001
_SIZE_WORD = 0x3E
_MAX_WORDS = 0x1_0000
_WORDS_PER_KIBIT = 64

assert COMMAND == _CONTROL + 1


class EepromClient:
    """The EEPROM of the slave at `station`. All are `Steps`; they raise `BusError`."""

    def __init__(self, station: int) -> None:
        self.station = station

    def claim(self) -> Steps[None]:
        """Take it from the device: the master reads and writes."""
        yield from write(self.station, Register.EEPROM_CONFIGURATION, _FORCE)
        yield from write(self.station, Register.EEPROM_CONFIGURATION, _CLAIM)

    def hand_over(self) -> Steps[None]:
        """Leave it to the device, which loads its configuration from it."""
        yield from write(self.station, Register.EEPROM_CONFIGURATION, _HAND_OVER)

    def _command(self, command: int, word: int, data: bytes = b"") -> Steps[bytes]:
        """Run a command and return the 8 data bytes behind it, of which 4 or 8 count."""
        if not 0 <= word < _MAX_WORDS:
            raise EepromTrouble(f"an EEPROM has words 0 to {_MAX_WORDS - 1}, got {word}")
        written = command.to_bytes(2, "little") + word.to_bytes(4, "little") + data
        back = Datagram.at(DatagramCommand.FPRD, self.station, _CONTROL, bytes(14))
        status = 0
        for _ in range(_TRIES):
            request = Datagram.at(DatagramCommand.FPWR, self.station, _CONTROL, written)
            came = yield Trip((request, back))
            start = time_ns = came.now_ns
            while True:
                if came.datagrams[0].counter != 1 or came.datagrams[-1].counter != 1:
                    raise NoAnswer(self.station, _CONTROL, 0)
                answer = came.datagrams[-1].data
                status = int.from_bytes(answer[:2], "little")
                if not status & (_BUSY | _LOADING):
                    break
                if time_ns - start > _BUSY_NS:
                    raise EepromTrouble(f"station {self.station}: EEPROM stays busy")
                time_ns = (yield Pause(_POLL_NS)).now_ns
                came = yield Trip((back,))
            if not status & (_COMMAND_ERROR | _WRITE_ERROR):
                return answer[6 : 14 if status & _EIGHT_BYTES else 10]
            clear = Datagram.at(DatagramCommand.FPWR, self.station, _CONTROL, bytes(2))
            yield Trip((clear,))
        raise EepromTrouble(
            f"station {self.station}: EEPROM word 0x{word:X}: status 0x{status:04X} after"
            f" {_TRIES} tries"
        )

    def read(self, word: int, count: int) -> Steps[bytes]:
        """`count` words from `word` on."""
        data = bytearray()
        while len(data) < 2 * count:
            data += yield from self._command(_READ, word + len(data) // 2)
        return bytes(data[: 2 * count])

    def write(self, word: int, data: bytes) -> Steps[None]:
        """Write words from `word` on; `data` has an even number of bytes."""
        if len(data) & 1:
            raise EepromTrouble(f"an EEPROM holds words of 2 bytes, got {len(data)} bytes")
        for first in range(0, len(data), 2):
            yield from self._command(_WRITE, word + first // 2, data[first : first + 2])

    def reload(self) -> Steps[None]:
        """Let the controller take the configuration area over."""
        yield from self._command(_RELOAD, 0)

    def content(self) -> Steps[bytes]:
        """Return all words of the memory, as many as word 0x3E says, 131,072 bytes at most."""
        data = yield from self.read(0, _SIZE_WORD + 1)
        return data + (yield from self.read(_SIZE_WORD + 1, _words(data) - _SIZE_WORD - 1))

    def image(self) -> Steps[bytes]:
        """Return all up to the end of the categories, at most what the size in the image allows."""
        data = bytearray((yield from self.read(0, _CATEGORIES + 2)))
        words = _words(data)
        at = _CATEGORIES
        while int.from_bytes(data[2 * at : 2 * at + 2], "little") != _END:
            at += 2 + int.from_bytes(data[2 * at + 2 : 2 * at + 4], "little")
            if at + 2 > words:
                break
            known = len(data) // 2
            if at + 2 > known:
                data += yield from self.read(known, at + 2 - known)
        return bytes(data)


def _words(data: bytes | bytearray) -> int:
    """Words of the memory, by its size in KiBit less 1."""
    size = int.from_bytes(data[2 * _SIZE_WORD : 2 * _SIZE_WORD + 2], "little") + 1
    return min(size * _WORDS_PER_KIBIT, _MAX_WORDS)


def whole_image(position: int, new: bytes = b"") -> Steps[bytes]:
    """Return the whole EEPROM of the slave at a position, after `new` was written to it, if any.

    Its word 0x3E has its size.

    The bus goes to Init. Raises `BusError`, also if the image reads back otherwise.
    """
    from achse.ethercat.master.inspection import count_slaves, reset_bus, set_station

    count = yield from count_slaves()
    if position >= count:
        raise EepromTrouble(f"there are {count} slaves, the first is 0; got {position}")
    yield from reset_bus()
    station = _STATION + position
    yield from set_station(position, station)
    eeprom = EepromClient(station)
    yield from eeprom.claim()
    if new:
        yield from eeprom.write(0, new)
        back = yield from eeprom.read(0, len(new) // 2)
        if back != new:
            raise EepromTrouble(f"position {position}: the image reads back otherwise")
    return (yield from eeprom.content())
