"""Index groups of a bus master as rows: what each shows of its bus, and what a Write does.

Groups and offsets are those of the manual of the vendor's system; numbers that it does not print
are said to be ours.
"""

import struct
from collections.abc import Callable, Sequence
from typing import NamedTuple

from achse.ams import DeviceError
from achse.codes import AlState, ReturnCode
from achse.devices.io.groups import MasterGroup
from achse.devices.io.served import ServedBus

MANUAL = "TwinCAT System Service, EtherCAT master"
"""Source of the groups."""

_STATE_OFFSET = 0x0100
_ACKNOWLEDGE = 0x10
_STATE = 0x0F
_U32 = 0xFFFF_FFFF
_CLEAR, _ACTIVATE, _DEACTIVATE = range(3)
_LAST_ADDRESS = 0xFFFF


class MasterRow(NamedTuple):
    """An index group of the master, its offsets 0 … `last_offset`.

    `read(bus, offset)` returns the answer, `write(bus, offset, data)` carries a Write out. Both
    raise DeviceError for offsets and data that the group does not have.
    """

    group: MasterGroup
    name: str
    description: str
    last_offset: int
    read: Callable[[ServedBus, int], bytes]
    write: Callable[[ServedBus, int, bytes], None] | None = None


def _read_master_state(bus: ServedBus, offset: int) -> bytes:
    if offset != _STATE_OFFSET:
        raise DeviceError(ReturnCode.INVALID_OFFSET, f"0x100 is readable, got 0x{offset:X}")
    return (bus.master.state or AlState.INIT).to_bytes(2, "little")


def _write_master_state(bus: ServedBus, offset: int, data: bytes) -> None:
    bus.master.request(_state(offset))


def _read_states(bus: ServedBus, offset: int) -> bytes:
    if offset:
        return bus.state_bytes(bus.slave(offset))
    return b"".join(bus.state_bytes(slave) for slave in bus.master.slaves)


def _write_state(bus: ServedBus, offset: int, data: bytes) -> None:
    slave = bus.slave(offset)
    if len(data) != 2:
        raise DeviceError(ReturnCode.INVALID_SIZE, f"2 bytes, got {len(data)}")
    number = int.from_bytes(data, "little")
    if number & ~(_ACKNOWLEDGE | _STATE):
        raise DeviceError(ReturnCode.INVALID_DATA, f"state 0x{number:X}")
    if number & _STATE != AlState.BOOT:
        bus.master.request(_state(number & _STATE), slave)
    elif slave.configuration.boot_out is None:
        raise DeviceError(ReturnCode.SERVICE_NOT_SUPPORTED, f"{slave.name} has no Bootstrap")
    else:
        bus.master.request(AlState.BOOT, slave)


def _read_frames(bus: ServedBus, offset: int) -> bytes:
    master = bus.master
    return _longs(
        [
            master.now_ns // 1_000_000,
            master.cyclic.counters.sent,
            master.cyclic.counters.lost,
            master.traffic.sent_frames,
            master.traffic.lost_frames,
        ]
    )


def _read_trips(bus: ServedBus, offset: int) -> bytes:
    way = bus.way
    if way is None:
        return bytes(48)
    trips = way.round_trips
    return struct.pack(
        "<6Q",
        *(trips.count, trips.missing, trips.last_ns, round(trips.mean_ns)),
        *(trips.within_ns(0.99), trips.largest_ns),
    )


def _reset_trips(bus: ServedBus, offset: int, data: bytes) -> None:
    if bus.way is not None:
        bus.way.round_trips.reset()


def _read_way(bus: ServedBus, offset: int) -> bytes:
    way = bus.way
    if not 0 <= offset <= 3:
        raise DeviceError(ReturnCode.INVALID_OFFSET, f"0 to 3, got {offset}")
    connection = ("",) * 3 if way is None else (way.interface, way.trouble, way.second_interface)
    texts = (*connection, bus.master.supervision.opening)
    return texts[offset].encode() + b"\0"


def _read_errors(bus: ServedBus, offset: int) -> bytes:
    if offset:
        return _longs(bus.slave(offset).counters.errors)
    return _longs([sum(slave.counters.errors) for slave in bus.master.slaves])


def _read_deviation(bus: ServedBus, offset: int) -> bytes:
    histogram = bus.master.supervision.deviation
    if not histogram.active:
        raise DeviceError(ReturnCode.INVALID_STATE, "switch the histogram on: write offset 1")
    return _longs(histogram.figures())


def _write_deviation(bus: ServedBus, offset: int, data: bytes) -> None:
    histogram = bus.master.supervision.deviation
    if offset == _CLEAR:
        histogram.clear()
    elif offset in (_ACTIVATE, _DEACTIVATE):
        histogram.active = offset == _ACTIVATE
    else:
        raise DeviceError(ReturnCode.INVALID_OFFSET, f"0, 1 or 2, got {offset}")


def _state(number: int) -> AlState:
    if number not in (AlState.INIT, AlState.PREOP, AlState.SAFEOP, AlState.OP):
        raise DeviceError(ReturnCode.INVALID_DATA, f"state {number}: expected 1, 2, 4 or 8")
    return AlState(number)


def _words(values: Sequence[int]) -> bytes:
    return struct.pack(f"<{len(values)}H", *values)


def _longs(values: Sequence[int]) -> bytes:
    return struct.pack(f"<{len(values)}I", *(each & _U32 for each in values))


MASTER_ROWS = (
    MasterRow(
        MasterGroup.MASTER_STATE,
        "state of the master",
        "Read 0x100: UINT16, 1 Init, 2 PreOp, 4 SafeOp, 8 Op. Write without data: the"
        " offset is the requested state",
        _STATE_OFFSET,
        _read_master_state,
        _write_master_state,
    ),
    MasterRow(
        MasterGroup.SLAVE_COUNT,
        "configured slaves",
        "UINT16 or UINT32",
        0,
        lambda bus, _: len(bus.master.slaves).to_bytes(4, "little"),
    ),
    MasterRow(
        MasterGroup.SLAVE_ADDRESSES,
        "station addresses",
        "UINT16 each",
        0,
        lambda bus, _: _words([slave.station for slave in bus.master.slaves]),
    ),
    MasterRow(
        MasterGroup.SLAVE_STATES,
        "states of slaves",
        "Offset 0: all; a station address: one. State byte and link byte each. Write"
        " UINT16: requested state (3 Bootstrap), + 0x10 acknowledges an error",
        _LAST_ADDRESS,
        _read_states,
        _write_state,
    ),
    MasterRow(
        MasterGroup.FRAME_STATISTICS,
        "frame statistics",
        "UINT32: ms, cyclic frames sent, lost, acyclic sent, lost. Write: reset",
        0,
        _read_frames,
        lambda bus, _, data: bus.master.reset_frames(),
    ),
    MasterRow(
        MasterGroup.IDENTITY,
        "identity",
        "Offset: station address. UINT32: vendor, product, revision, serial number",
        _LAST_ADDRESS,
        lambda bus, address: _longs(bus.slave(address).facts.identity),
    ),
    MasterRow(
        MasterGroup.CRC_ERRORS,
        "CRC errors",
        "Offset 0: sum of each slave; an address: each of its ports. Write: reset",
        _LAST_ADDRESS,
        _read_errors,
        lambda bus, _, data: bus.master.reset_counters(),
    ),
    MasterRow(
        MasterGroup.ABNORMAL_CHANGES,
        "abnormal state changes",
        "UINT32 each: how often a slave left its state by itself",
        0,
        lambda bus, _: _longs([slave.abnormal_changes for slave in bus.master.slaves]),
    ),
    MasterRow(
        MasterGroup.LOSSES,
        "lost slaves",
        "UINT32 each: how often a slave stopped answering; number ours",
        0,
        lambda bus, _: _longs([slave.losses for slave in bus.master.slaves]),
    ),
    MasterRow(
        MasterGroup.TOPOLOGY,
        "topology",
        "64 bytes each: addresses, neighbours by port, delay, status",
        0,
        lambda bus, _: bus.topology(),
    ),
    MasterRow(
        MasterGroup.CLOCK_DEVIATION,
        "deviation of the clocks",
        "UINT32: count, positive, negative, largest, 10 + 10 classes from 1 µs on."
        " Write without data: 0 clear, 1 on, 2 off",
        _DEACTIVATE,
        _read_deviation,
        _write_deviation,
    ),
    MasterRow(
        MasterGroup.DEV_STATE,
        "state of the bus",
        "UINT16 of bits, 0: all is well",
        0,
        lambda bus, _: bus.dev_state.to_bytes(2, "little"),
    ),
    MasterRow(
        MasterGroup.FRAME_COUNT,
        "cyclic frames",
        "UINT32",
        0,
        lambda bus, _: _longs([len(bus.master.cyclic.frame_states)]),
    ),
    MasterRow(
        MasterGroup.ROUND_TRIPS,
        "round trips on the interface",
        "UINT64: cyclic frames that came back, cycles without them; ns: last, mean, 99 %,"
        " largest. 0 where the slaves are in this process. Write: reset. Number ours",
        0,
        _read_trips,
        _reset_trips,
    ),
    MasterRow(
        MasterGroup.WAY,
        "interface",
        "Text. Offset 0: the network interface, 1: why the bus does not work as"
        " configured, 2: the second interface of a redundant bus; empty in this process."
        " 3: where the ring of a redundant bus is open. Number ours",
        3,
        _read_way,
    ),
    MasterRow(
        MasterGroup.CLOCKS,
        "clocks",
        "INT32 each: ns from the reference clock as last read, above 0 ahead; number ours",
        0,
        lambda bus, _: _longs([slave.clock_difference_ns for slave in bus.master.slaves]),
    ),
    MasterRow(
        MasterGroup.TROUBLE,
        "trouble of a slave",
        "Offset: station address. Text: why it did not reach its state; number ours",
        _LAST_ADDRESS,
        lambda bus, address: bus.slave(address).last_trouble.encode() + b"\0",
    ),
)
