"""A bus master, port 65535 at the NetId of its bus: states, addresses, counters, its dictionary.

Groups and offsets are those of the manual of the vendor's system; numbers that it does not print
are said to be ours.
"""

import struct
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import ClassVar

from achse.ams import AdsState, DeviceError
from achse.codes import AlState, ReturnCode
from achse.devices.io.datagram import decode_datagram, send_datagram
from achse.devices.io.groups import MasterGroup, SlaveGroup
from achse.devices.io.later import answer_later
from achse.devices.io.master_objects import MasterObjects
from achse.devices.io.served import ServedBus
from achse.server import Device, IndexGroup, RawGroup

__all__ = ["BusMasterDevice"]

_STATE_OFFSET = 0x0100
_COMPLETE = 0x0100
_ACKNOWLEDGE = 0x10
_STATE = 0x0F
_U32 = 0xFFFF_FFFF
_CLEAR, _ACTIVATE, _DEACTIVATE = range(3)
_MANUAL = "TwinCAT System Service, EtherCAT master"
_LAST_ADDRESS = 0xFFFF


class BusMasterDevice(Device):
    """Answers for the master of one bus."""

    accepted_states: ClassVar[Mapping[int, AdsState]] = {AdsState.RUN: AdsState.RUN}

    def __init__(self, bus: ServedBus, *, clock: Callable[[], int]) -> None:
        self.bus = bus
        self.objects = MasterObjects(bus)
        super().__init__("EtherCAT Master", (3, 1, 0), self._own_groups(), clock=clock)

    def _own_groups(self) -> Iterator[IndexGroup]:
        bus = self.bus
        for group, name, read, write, last, description in (
            (
                MasterGroup.MASTER_STATE,
                "state of the master",
                self._read_master_state,
                self._write_master_state,
                _STATE_OFFSET,
                "Read 0x100: UINT16, 1 Init, 2 PreOp, 4 SafeOp, 8 Op. Write without data: the"
                " offset is the state asked for",
            ),
            (
                MasterGroup.SLAVE_COUNT,
                "configured slaves",
                self._read_count,
                None,
                0,
                "UINT16 or UINT32",
            ),
            (
                MasterGroup.SLAVE_ADDRESSES,
                "station addresses",
                lambda offset, length, client: _words(
                    [slave.station for slave in bus.master.slaves]
                ),
                None,
                0,
                "UINT16 each",
            ),
            (
                MasterGroup.SLAVE_STATES,
                "states of slaves",
                self._read_states,
                self._write_state,
                _LAST_ADDRESS,
                "Offset 0: all; a station address: one. State byte and link byte each. Write"
                " UINT16: state asked for (3 Bootstrap), + 0x10 acknowledges an error",
            ),
            (
                MasterGroup.FRAME_STATISTICS,
                "frame statistics",
                self._read_frames,
                lambda offset, data, client: bus.master.reset_frames(),
                0,
                "UINT32: ms, cyclic frames sent, lost, acyclic sent, lost. Write: reset",
            ),
            (
                MasterGroup.IDENTITY,
                "identity",
                self._read_identity,
                None,
                _LAST_ADDRESS,
                "Offset: station address. UINT32: vendor, product, revision, serial number",
            ),
            (
                MasterGroup.CRC_ERRORS,
                "CRC errors",
                self._read_errors,
                lambda offset, data, client: bus.master.reset_counters(),
                _LAST_ADDRESS,
                "Offset 0: sum of each slave; an address: each of its ports. Write: reset",
            ),
            (
                MasterGroup.ABNORMAL_CHANGES,
                "abnormal state changes",
                lambda offset, length, client: _longs(
                    [slave.abnormal_changes for slave in bus.master.slaves]
                ),
                None,
                0,
                "UINT32 each: how often a slave left its state by itself",
            ),
            (
                MasterGroup.LOSSES,
                "lost slaves",
                lambda offset, length, client: _longs(
                    [slave.losses for slave in bus.master.slaves]
                ),
                None,
                0,
                "UINT32 each: how often a slave stopped answering; number ours",
            ),
            (
                MasterGroup.TOPOLOGY,
                "topology",
                lambda offset, length, client: bus.topology(),
                None,
                0,
                "64 bytes each: addresses, neighbours by port, delay, status",
            ),
            (
                MasterGroup.CLOCK_DEVIATION,
                "deviation of the clocks",
                self._read_deviation,
                self._write_deviation,
                _DEACTIVATE,
                "UINT32: count, positive, negative, largest, 10 + 10 classes from 1 µs on."
                " Write without data: 0 clear, 1 on, 2 off",
            ),
            (
                MasterGroup.DEV_STATE,
                "state of the bus",
                lambda offset, length, client: bus.dev_state.to_bytes(2, "little"),
                None,
                0,
                "UINT16 of bits, 0: all is well",
            ),
            (
                MasterGroup.FRAME_COUNT,
                "cyclic frames",
                lambda offset, length, client: _longs([len(bus.master.cyclic.frame_states)]),
                None,
                0,
                "UINT32",
            ),
            (
                MasterGroup.ROUND_TRIPS,
                "round trips on the interface",
                self._read_trips,
                self._reset_trips,
                0,
                "UINT64: cyclic frames that came back, cycles without them; ns: last, mean, 99 %,"
                " largest. 0 where the slaves are in this process. Write: reset. Number ours",
            ),
            (
                MasterGroup.WAY,
                "interface",
                self._read_way,
                None,
                3,
                "Text. Offset 0: the network interface, 1: why the bus does not work as"
                " configured, 2: the second interface of a redundant bus; empty in this process."
                " 3: where the ring of a redundant bus is open. Number ours",
            ),
            (
                MasterGroup.CLOCKS,
                "clocks",
                lambda offset, length, client: _longs(
                    [slave.clock_difference_ns for slave in bus.master.slaves]
                ),
                None,
                0,
                "INT32 each: ns from the reference clock as last read, above 0 ahead; number ours",
            ),
            (
                MasterGroup.TROUBLE,
                "trouble of a slave",
                lambda offset, length, client: bus.slave(offset).last_trouble.encode() + b"\0",
                None,
                _LAST_ADDRESS,
                "Offset: station address. Text: why it did not reach its state; number ours",
            ),
            (
                SlaveGroup.SDO,
                "objects of the master",
                self._read_object,
                self._write_object,
                _U32,
                "ETG.1510; offset = index << 16 | complete access << 8 | subindex",
            ),
        ):
            yield RawGroup(
                group,
                name,
                read=read,
                write=write,
                last_offset=last,
                response="BYTE[n]",
                description=description,
                source=_MANUAL,
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

    # states

    def _read_master_state(self, offset: int, length: int, client: bytes) -> bytes:
        if offset != _STATE_OFFSET:
            raise DeviceError(ReturnCode.INVALID_OFFSET, f"0x100 is readable, got 0x{offset:X}")
        return (self.bus.master.state or AlState.INIT).to_bytes(2, "little")

    def _write_master_state(self, offset: int, data: bytes, client: bytes) -> None:
        self.bus.master.request(_state(offset))

    def _read_count(self, offset: int, length: int, client: bytes) -> bytes:
        return len(self.bus.master.slaves).to_bytes(4, "little")

    def _read_states(self, offset: int, length: int, client: bytes) -> bytes:
        bus = self.bus
        if offset:
            return bus.state_bytes(bus.slave(offset))
        return b"".join(bus.state_bytes(slave) for slave in bus.master.slaves)

    def _write_state(self, offset: int, data: bytes, client: bytes) -> None:
        slave = self.bus.slave(offset)
        if len(data) != 2:
            raise DeviceError(ReturnCode.INVALID_SIZE, f"2 bytes, got {len(data)}")
        number = int.from_bytes(data, "little")
        if number & ~(_ACKNOWLEDGE | _STATE):
            raise DeviceError(ReturnCode.INVALID_DATA, f"state 0x{number:X}")
        if number & _STATE != AlState.BOOT:
            self.bus.master.request(_state(number & _STATE), slave)
        elif slave.configuration.boot_out is None:
            raise DeviceError(ReturnCode.SERVICE_NOT_SUPPORTED, f"{slave.name} has no Bootstrap")
        else:
            self.bus.master.request(AlState.BOOT, slave)

    # counters

    def _read_frames(self, offset: int, length: int, client: bytes) -> bytes:
        master = self.bus.master
        return _longs(
            [
                master.now_ns // 1_000_000,
                master.cyclic.counters.sent,
                master.cyclic.counters.lost,
                master.traffic.sent,
                master.traffic.lost,
            ]
        )

    def _read_trips(self, offset: int, length: int, client: bytes) -> bytes:
        way = self.bus.way
        if way is None:
            return bytes(48)
        trips = way.round_trips
        return struct.pack(
            "<6Q",
            *(trips.count, trips.missing, trips.last_ns, round(trips.mean_ns)),
            *(trips.within_ns(0.99), trips.largest_ns),
        )

    def _reset_trips(self, offset: int, data: bytes, client: bytes) -> None:
        if self.bus.way is not None:
            self.bus.way.round_trips.reset()

    def _read_way(self, offset: int, length: int, client: bytes) -> bytes:
        way = self.bus.way
        if not 0 <= offset <= 3:
            raise DeviceError(ReturnCode.INVALID_OFFSET, f"0 to 3, got {offset}")
        told = ("",) * 3 if way is None else (way.interface, way.trouble, way.second_interface)
        texts = (*told, self.bus.master.supervision.opening)
        return texts[offset].encode() + b"\0"

    def _read_identity(self, offset: int, length: int, client: bytes) -> bytes:
        slave = self.bus.slave(offset)
        return _longs(slave.facts.identity)

    def _read_errors(self, offset: int, length: int, client: bytes) -> bytes:
        if offset:
            return _longs(self.bus.slave(offset).counters.errors)
        return _longs([sum(slave.counters.errors) for slave in self.bus.master.slaves])

    def _read_deviation(self, offset: int, length: int, client: bytes) -> bytes:
        histogram = self.bus.master.supervision.deviation
        if not histogram.active:
            raise DeviceError(ReturnCode.INVALID_STATE, "switch the histogram on: write offset 1")
        return _longs(histogram.figures())

    def _write_deviation(self, offset: int, data: bytes, client: bytes) -> None:
        histogram = self.bus.master.supervision.deviation
        if offset == _CLEAR:
            histogram.clear()
        elif offset in (_ACTIVATE, _DEACTIVATE):
            histogram.active = offset == _ACTIVATE
        else:
            raise DeviceError(ReturnCode.INVALID_OFFSET, f"0, 1 or 2, got {offset}")

    # datagrams and objects

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


def _state(number: int) -> AlState:
    if number not in (AlState.INIT, AlState.PREOP, AlState.SAFEOP, AlState.OP):
        raise DeviceError(ReturnCode.INVALID_DATA, f"state {number}: expected 1, 2, 4 or 8")
    return AlState(number)


def _words(values: Sequence[int]) -> bytes:
    return struct.pack(f"<{len(values)}H", *values)


def _longs(values: Sequence[int]) -> bytes:
    return struct.pack(f"<{len(values)}I", *(each & _U32 for each in values))
