"""A bus master, port 65535 at the NetId of its bus: its rows, its dictionary, datagrams."""

from collections.abc import Callable, Iterator, Mapping
from typing import ClassVar

from achse.ams import AdsState, DeviceError
from achse.codes import ReturnCode
from achse.devices.io.datagram import decode_datagram, send_datagram
from achse.devices.io.groups import MasterGroup, SlaveGroup
from achse.devices.io.later import answer_later
from achse.devices.io.master_objects import MasterObjects
from achse.devices.io.master_rows import MANUAL, MASTER_ROWS, MasterRow
from achse.devices.io.served import ServedBus
from achse.server import Device, IndexGroup, RawGroup

_COMPLETE = 0x0100
_LAST_OBJECT = 0xFFFF_FFFF


class BusMasterDevice(Device):
    """Answers for the master of one bus."""

    accepted_states: ClassVar[Mapping[int, AdsState]] = {AdsState.RUN: AdsState.RUN}

    def __init__(self, bus: ServedBus, *, clock: Callable[[], int]) -> None:
        self.bus = bus
        self.objects = MasterObjects(bus)
        super().__init__("EtherCAT Master", (3, 1, 0), self._own_groups(), clock=clock)

    def _own_groups(self) -> Iterator[IndexGroup]:
        for row in MASTER_ROWS:
            yield self._group(row)
        yield RawGroup(
            SlaveGroup.SDO,
            "objects of the master",
            read=self._read_object,
            write=self._write_object,
            last_offset=_LAST_OBJECT,
            response="BYTE[n]",
            description="ETG.1510; offset = index << 16 | complete access << 8 | subindex",
            source=MANUAL,
        )
        for group, name in (
            (MasterGroup.FIRST_LINE, "datagram, first line"),
            (MasterGroup.DATAGRAM, "datagram"),
        ):
            yield RawGroup(
                group,
                name,
                read_write=self._send,
                request="UINT8 command; UINT8 index; UINT32 address; UINT16 length; UINT16 IRQ;"
                " BYTE[n] data; UINT16 counter",
                response="the same, as it came back",
                description="Sends a datagram; APRD of register 0 counts the slaves",
                source="achse",
            )

    def _group(self, row: MasterRow) -> RawGroup:
        """Return the index group of a row, over the bus of this master."""
        bus, read, write = self.bus, row.read, row.write

        def carry_out(offset: int, data: bytes, client: bytes) -> None:
            assert write is not None
            write(bus, offset, data)

        return RawGroup(
            row.group,
            row.name,
            read=lambda offset, length, client: read(bus, offset),
            write=None if write is None else carry_out,
            last_offset=row.last_offset,
            response="BYTE[n]",
            description=row.description,
            source=MANUAL,
        )

    def _send(self, offset: int, read_length: int, data: bytes, client: bytes) -> bytes:
        datagram = decode_datagram(data, read_length)
        master = self.bus.master
        if not master.supervision.link:
            raise DeviceError(ReturnCode.DEVICE_TIMEOUT, "no slave answers")
        raise answer_later(master, send_datagram(datagram), lambda answer: answer)

    def _read_object(self, offset: int, length: int, client: bytes) -> bytes:
        return self.objects.read(offset >> 16, offset & 0xFF, bool(offset & _COMPLETE))

    def _write_object(self, offset: int, data: bytes, client: bytes) -> None:
        self.objects.write(offset >> 16, offset & 0xFF, data)
