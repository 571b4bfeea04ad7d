"""Frames and mailbox messages of a hostile master, for slaves whose mailboxes speak everything."""

import struct
from collections.abc import Iterator, Sequence
from random import Random

from tests.ethercat.virtual import esi_text

HEAD = b"\xff" * 6 + b"\x02\0\0\0\0\0" + b"\x88\xa4"
MAILBOX_SIZE = 128
MAILBOX_OUT, MAILBOX_IN = 0x1000, 0x1080
FIRST_STATION = 1001
_AOE, _EOE, _COE, _FOE, _SOE, _VOE = 1, 2, 3, 4, 5, 15
_OBJECTS = (0, 0x1000, 0x1008, 0x1018, 0x1600, 0x1601, 0x1A00, 0x1C00, 0x1C12, 0x1C13, 0x6000,
            0x7000, 0xF030, 0xFFFF)  # fmt: skip
_SDO = (0x00, 0x01, 0x0F, 0x10, 0x11, 0x21, 0x22, 0x23, 0x2F, 0x31, 0x33, 0x40, 0x50, 0x60, 0x70,
        0x80)  # fmt: skip
_SIZES = (0, 1, 2, 4, 7, 100, 5000, 1 << 31, 0xFFFF_FFFF)
_LASTING = ((0x0040, 0x0043), (0x0100, 0x0104), (0x0500, 0x0510))
"""What only a power cycle, or who programs EEPROMs, undoes."""

SPEAKER = esi_text.device(
    esi_text.MAILBOX
    + esi_text.OUTPUTS
    + esi_text.INPUTS
    + esi_text.pdo("RxPdo", 0x1600, [(0x7000, 1, 16, "Valve", "INT"), (0, 0, 7, "", "")], Sm=2)
    + esi_text.pdo("RxPdo", 0x1601, [(0x7010, 1, 32, "Level", "REAL")])
    + esi_text.pdo("TxPdo", 0x1A00, [(0x6000, 1, 16, "Status", "UINT")], Sm=3)
    + '<Mailbox DataLinkLayer="1"><AoE/><EoE IP="1" MAC="1"/><CoE SdoInfo="1" PdoAssign="1"'
    ' PdoConfig="1" CompleteAccess="1" SegmentedSdo="1"/><FoE/><SoE ChannelCount="2"><InitCmd>'
    "<Transition>PS</Transition><IDN>32</IDN><Data>0b00</Data></InitCmd></SoE><VoE/></Mailbox>"
    "<Dc><OpMode><Name>DC</Name><AssignActivate>#x0300</AssignActivate>"
    '<CycleTimeSync0 Factor="1">0</CycleTimeSync0></OpMode></Dc>'
    "<Eeprom><ByteSize>2048</ByteSize><ConfigData>050603446400</ConfigData>"
    "<BootStrap>0010800080108000</BootStrap></Eeprom>",
    name="Speaker",
    product=0x9001,
)
"""A device with all protocols, a clock, and PDOs that may be changed."""


class Attacker:
    """Draws what is sent; equal seeds send the same."""

    def __init__(self, seed: int, slaves: int) -> None:
        self._dice = Random(seed)
        self._slaves = slaves

    def message(self) -> bytes:
        """A mailbox message of any protocol: most are nearly right."""
        dice = self._dice
        pick, number = dice.choice, dice.randrange
        kind = pick((0, _AOE, _EOE, _COE, _COE, _COE, _FOE, _FOE, _SOE, _VOE, number(16)))
        body = {_AOE: self._ads, _EOE: self._ethernet, _COE: self._coe, _FOE: self._file,
                _SOE: self._idn}.get(kind, lambda: dice.randbytes(number(60)))()  # fmt: skip
        if number(6) == 0:
            body = body[: number(len(body) + 1)]
        length = pick((len(body),) * 6 + (0, 1, 5, 122, 123, 200, 0xFFFF))
        head = struct.pack("<HHBB", length, 0, 0, kind | number(16) << 4)
        return (head + body).ljust(MAILBOX_SIZE, b"\0")[:MAILBOX_SIZE]

    def _coe(self) -> bytes:
        dice = self._dice
        pick, number = dice.choice, dice.randrange
        service = pick((2, 2, 2, 8, 8, number(16))) << 12
        index = pick(_OBJECTS)
        if service == 8 << 12:
            head = struct.pack("<HBBH", service, pick((1, 3, 5, number(256))), number(2), 0)
            list_type = struct.pack("<H", number(7))
            return head + pick((list_type, struct.pack("<HBB", index, number(4), number(256))))
        head = struct.pack("<HBHB", service, pick((*_SDO, number(256))), index, number(5))
        return head + pick(
            (struct.pack("<I", pick(_SIZES)), dice.randbytes(4), dice.randbytes(number(110)))
        )

    def _file(self) -> bytes:
        dice = self._dice
        head = struct.pack(
            "<BBI", dice.choice((1, 2, 3, 3, 4, 5, 6, 0, 255)), 0, dice.choice((0, 1, 2, 1 << 31))
        )
        return head + dice.choice((b"", b"name", dice.randbytes(112), dice.randbytes(40)))

    def _ethernet(self) -> bytes:
        dice = self._dice
        head = struct.pack("<HH", dice.randrange(1 << 16), dice.randrange(1 << 16))
        if dice.randrange(2):
            head = struct.pack("<HH", dice.randrange(16) | 0x100, dice.randrange(3))
        return head + dice.randbytes(dice.randrange(110))

    def _idn(self) -> bytes:
        dice = self._dice
        flags = dice.randrange(256)
        head = struct.pack("<BBH", flags, 1 << dice.randrange(8), dice.choice((32, 15, 16, flags)))
        return head + dice.randbytes(dice.choice((0, 1, 2, 4, 100)))

    def _ads(self) -> bytes:
        dice = self._dice
        pick, number = dice.choice, dice.randrange
        heads = struct.pack(
            "<6sH6sHHHIII", dice.randbytes(6), 1000, bytes(6), number(65536),
            pick((1, 2, 3, 4, 6, 9, 100)), 4, pick((0, 12, 16, 0xFFFF_FFFF)), 0, number(1 << 32),
        )  # fmt: skip
        place = struct.pack("<III", pick((0xF302, 1)), number(1 << 32), pick(_SIZES))
        return heads + place + dice.randbytes(number(40))

    def frame(self, spares: Sequence[tuple[int, int]] = ()) -> bytes:
        """A frame: up to four datagrams to any memory but `spares`; one in eight is damaged."""
        dice = self._dice
        number = dice.randrange
        parts = []
        for left in range(number(4), -1, -1):
            command, place, data = self._datagram()
            if any(place < end and place + len(data) > first for first, end in spares):
                data = b""
            station = FIRST_STATION + number(self._slaves) if number(8) else number(1 << 16)
            address = number(64) if command in (10, 11, 12) else station | place << 16
            flags = 0x8000 * (left > 0) | 0x4000 * (number(20) == 0)
            head = struct.pack("<BBIHH", command, number(256), address, len(data) | flags, 0)
            parts.append(head + data + b"\0\0")
        body = b"".join(parts)
        packet = HEAD + struct.pack("<H", len(body) & 0x7FF | 0x1000) + body
        if number(8) or spares:
            return packet
        damaged = bytearray(packet)
        for _ in range(number(1, 4)):
            damaged[number(12, len(damaged))] = number(256)
        return bytes(damaged[: number(len(damaged)) + 1])

    def _datagram(self) -> tuple[int, int, bytes]:
        """Command, offset, data."""
        dice = self._dice
        pick, number = dice.choice, dice.randrange
        match number(10):
            case 0 | 1 | 2:
                data = self.message()
                return 5, MAILBOX_OUT, data if number(8) else data[: number(1, MAILBOX_SIZE)]
            case 3:
                return 4, MAILBOX_IN, bytes(MAILBOX_SIZE)
            case 4:
                state = number(64) if number(3) else number(1 << 16)
                return pick((5, 8, 2)), 0x0120, struct.pack("<H", state)
            case 5:
                return number(16), 0x0800 + number(128), dice.randbytes(pick((1, 5, 6, 8, 16)))
            case 6:
                return number(16), 0x0600 + number(256), dice.randbytes(pick((1, 4, 16, 48)))
            case 7:
                return number(16), 0x0900 + number(256), dice.randbytes(pick((1, 2, 4, 8, 16)))
            case 8:
                return pick((4, 5, 8)), 0x0500 + number(16), dice.randbytes(pick((1, 2, 6, 14)))
        place = pick((number(0x1000), number(1 << 16)))
        return number(256), place, dice.randbytes(pick((0, 1, 2, 4, 8, 64, 300)))

    def frames(self, count: int, *, lasting: bool = True) -> Iterator[bytes]:
        """So many frames; without what lasts until a power cycle unless `lasting`."""
        for _ in range(count):
            yield self.frame(() if lasting else _LASTING)
