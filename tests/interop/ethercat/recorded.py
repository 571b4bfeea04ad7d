"""Recorded EtherCAT traffic, read: frames, what slaves had in their EEPROM, what they answered.

`recorded_slave` is one of ours that has the EEPROM of a slave in a capture, and answers CoE with
the messages that slave sent.
"""

import struct
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from achse.ethercat import Loopback, Slave
from achse.ethercat.description import SyncManagerArea, SyncManagerLayout
from achse.ethercat.eeprom import checksum
from achse.ethercat.frame import Datagram, DatagramCommand, EthercatFrame, payload_offset
from achse.ethercat.mailbox import MailboxProtocol, MailboxServer
from achse.ethercat.master.sii_reader import read_sii

_SECTION, _PACKET = 0x0A0D0D0A, 6
_BACK = 0x02
"""Of the first byte of the source: a slave has marked the frame."""
_READS = (DatagramCommand.APRD, DatagramCommand.FPRD)
_WRITES = (DatagramCommand.APWR, DatagramCommand.FPWR, DatagramCommand.BWR)
_EEPROM_CONTROL, _EEPROM_DATA = 0x0502, 0x0508
_RAM = 0x1000
_EEPROM_SIZE = 0x1000
_MAILBOX = struct.Struct("<HHBB")
_ABORT = struct.Struct("<HBHBI")
_NOT_THERE = 0x0602_0000


def ethercat_frames(capture: Path) -> Iterator[bytes]:
    """The EtherCAT frames of a pcapng file, in order."""
    data = capture.read_bytes()
    order, at = "<", 0
    while at + 12 <= len(data):
        (kind,) = struct.unpack_from("<I", data, at)
        if kind == _SECTION:
            order = "<" if data[at + 8 : at + 12] == b"\x4d\x3c\x2b\x1a" else ">"
        kind, size = struct.unpack_from(f"{order}II", data, at)
        if kind == _PACKET:
            (length,) = struct.unpack_from(f"{order}I", data, at + 20)
            packet = data[at + 28 : at + 28 + length]
            if payload_offset(packet) is not None:
                yield packet
        at += max(size, 12)


@dataclass
class Recorded:
    """One slave of a capture."""

    eeprom: dict[int, bytes] = field(default_factory=dict)
    """Words by address, as they were read."""
    answers: dict[bytes, list[bytes]] = field(default_factory=dict)
    """To each CoE message, the messages that came."""
    address: int = 0
    """Which words were asked for last."""
    request: bytes = b""
    """The CoE message that waits for its answer."""

    @property
    def image(self) -> bytes:
        """What was read of the EEPROM, 0 between that; the checksum and the size are right."""
        image = bytearray(_EEPROM_SIZE)
        last = 0
        for address, words in self.eeprom.items():
            image[2 * address : 2 * address + len(words)] = words
            last = max(last, 2 * address + len(words))
        image[124:126] = (_EEPROM_SIZE // 128 - 1).to_bytes(2, "little")
        image[14] = checksum(bytes(image))
        return bytes(image[:last]).ljust(_EEPROM_SIZE, b"\xff")


def recorded(frames: Iterable[bytes]) -> list[Recorded]:
    """The slaves whose EEPROM was read, by position or station address."""
    slaves: dict[int, Recorded] = {}
    address = 0
    for frame in frames:
        if not frame[6] & _BACK:
            continue
        for each in EthercatFrame.decode(frame).datagrams:
            if each.command == DatagramCommand.BWR and each.ado == _EEPROM_CONTROL:
                address = int.from_bytes(each.data[2:6], "little")
                for slave in slaves.values():
                    slave.address = address
            elif each.counter == 1 and each.command in (*_READS, *_WRITES):
                slave = slaves.setdefault(each.adp, Recorded(address=address))
                _note(slave, each)
    return [each for each in slaves.values() if 8 in each.eeprom]


def _note(slave: Recorded, datagram: Datagram) -> None:
    data = datagram.data
    if datagram.command in _WRITES:
        if datagram.ado == _EEPROM_CONTROL and len(data) >= 6:
            slave.address = int.from_bytes(data[2:6], "little")
        elif datagram.ado >= _RAM and len(data) > _MAILBOX.size:
            slave.request = _coe(data)
    elif datagram.ado == _EEPROM_DATA and len(data) >= 4:
        slave.eeprom[slave.address] = data
    elif datagram.ado >= _RAM and slave.request and (came := _coe(data)):
        slave.answers.setdefault(slave.request, []).append(came)


def _coe(message: bytes) -> bytes:
    """The CoE message in a mailbox, empty for anything else."""
    length, _, _, kind = _MAILBOX.unpack_from(message)
    return message[6 : 6 + length] if kind & 0x0F == MailboxProtocol.COE else b""


def recorded_slave(entry: Recorded) -> Slave:
    """A slave with that EEPROM; what nobody asked it before is not in its dictionary."""
    image = entry.image
    content = read_sii(image)
    areas = [each.area for each in content.sync_managers]
    none = SyncManagerArea(0, 0, 0)
    areas += [none] * (4 - len(areas))
    layout = SyncManagerLayout(
        content.mailbox_out or areas[0], content.mailbox_in or areas[1], areas[2], areas[3]
    )
    slave = Slave(Loopback(), sii=image, layout=layout)

    def answer(data: bytes) -> list[bytes]:
        _, _, index, subindex, _ = _ABORT.unpack(data[:10])
        refusal = struct.pack("<HBHBI", 0x2000, 0x80, index, subindex, _NOT_THERE)
        return entry.answers.get(data, [refusal])[:1]

    slave._mailbox = MailboxServer({MailboxProtocol.COE: answer})
    return slave
