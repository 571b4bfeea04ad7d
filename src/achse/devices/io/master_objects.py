"""The dictionary of a master (ETG.1510): slaves configured, found, their diagnosis; frames."""

import struct
from collections.abc import Callable
from typing import NamedTuple

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.devices.io.served import ServedBus
from achse.ethercat.master import BusSlave

_CONFIGURED, _FOUND, _DIAGNOSIS = 0x8000, 0x9000, 0xA000
_SLAVES = 0x1000
"""Objects of each kind."""
_ADDRESSES, _FOUND_ADDRESSES, _ADDRESS_LISTS = 0xF020, 0xF040, 0x10
_PER_LIST = 255
_SCAN = 0xF002
_STATISTICS, _RESET = 0xF120, 0xF200
_RESET_DIAGNOSIS = 16
_RECORD_SIZE = 80
"""Complete access to a configured slave, as clients read it."""
_DONE_WITH_ANSWER = 1
_CONFIGURED_SUBINDICES = (1, 2, 3, 4, 5, 6, 7, 8, 33, 34, 35, 36)
"""Of address, type, name, device type, identity, mailbox sizes, link status and preset."""


class MasterValue(NamedTuple):
    """One entry: its subindex and bytes."""

    subindex: int
    data: bytes


class MasterObjects:
    """Reads and writes the objects of a master."""

    def __init__(self, bus: ServedBus) -> None:
        self._bus = bus
        self._scanned = False

    def read(self, index: int, subindex: int, complete: bool) -> bytes:
        """Return an entry, or from `subindex` 0 or 1 on all; raises DeviceError 0x703."""
        entries = self._entries(index)
        if complete:
            body = b"".join(each.data for each in entries)
            if _CONFIGURED <= index < _CONFIGURED + _SLAVES and subindex == 0:
                return (self._count(entries) + self._record(index))[:_RECORD_SIZE]
            return self._count(entries) + body if subindex == 0 else body
        if subindex == 0 and index not in self._variables():
            return self._count(entries)[:1] if not self._is_list(index) else self._count(entries)
        for each in entries:
            if each.subindex == subindex:
                return each.data
        raise DeviceError(ReturnCode.INVALID_OFFSET, f"{index:04X} has no entry {subindex}")

    def write(self, index: int, subindex: int, data: bytes) -> None:
        """Scan (F002:01) or reset the diagnosis (F200:10h); raises DeviceError."""
        self._entries(index)
        if index == _SCAN and subindex == 1:
            self._scanned = True
            self._bus.master.supervision.look_soon()
        elif index == _RESET and subindex == _RESET_DIAGNOSIS:
            self._bus.master.reset_counters()
        else:
            raise DeviceError(ReturnCode.INVALID_ACCESS, f"{index:04X}:{subindex:02X} is read-only")

    @staticmethod
    def _count(entries: list[MasterValue]) -> bytes:
        return max((each.subindex for each in entries), default=0).to_bytes(2, "little")

    @staticmethod
    def _is_list(index: int) -> bool:
        return any(
            first <= index < first + _ADDRESS_LISTS for first in (_ADDRESSES, _FOUND_ADDRESSES)
        )

    @staticmethod
    def _variables() -> tuple[int, ...]:
        return (0x1000, 0x1008, 0x1009, 0x100A)

    def _entries(self, index: int) -> list[MasterValue]:
        bus, master = self._bus, self._bus.master
        slaves = master.slaves
        for base, build in (
            (_CONFIGURED, self._configured),
            (_FOUND, self._scanned_slave),
            (_DIAGNOSIS, self._diagnosis),
        ):
            if base <= index < base + _SLAVES and index - base < len(slaves):
                values = build(slaves[index - base])
                if base == _CONFIGURED:
                    return list(map(MasterValue, _CONFIGURED_SUBINDICES, values))
                return _numbered(values)
        for base, stations in (
            (_ADDRESSES, [each.station for each in slaves]),
            (_FOUND_ADDRESSES, [each.station for each in slaves if each.present]),
        ):
            if base <= index < base + _ADDRESS_LISTS:
                first = (index - base) * _PER_LIST
                part = stations[first : first + _PER_LIST]
                return _numbered([each.to_bytes(2, "little") for each in part])
        single: dict[int, Callable[[], list[MasterValue]]] = {
            0x1000: lambda: [MasterValue(0, bytes(4))],
            0x1008: lambda: [MasterValue(0, bus.name.encode("cp1252", "replace"))],
            0x1009: lambda: [MasterValue(0, b"achse")],
            0x100A: lambda: [MasterValue(0, b"1")],
            0x1018: lambda: _numbered([bytes(4)] * 4),
            _SCAN: self._scan,
            _STATISTICS: self._statistics,
            _RESET: lambda: [MasterValue(_RESET_DIAGNOSIS, bytes(2))],
        }
        if index not in single:
            raise DeviceError(ReturnCode.INVALID_OFFSET, f"the master has no object {index:04X}")
        return single[index]()

    def _configured(self, slave: BusSlave) -> list[bytes]:
        configuration = slave.configuration
        sizes = [
            area.length if area else 0
            for area in (configuration.mailbox_out, configuration.mailbox_in)
        ]
        return [
            slave.station.to_bytes(2, "little"),
            _fixed(configuration.type_name, 16),
            _fixed(slave.name, 32),
            bytes(4),
            *(
                each.to_bytes(4, "little")
                for each in (
                    configuration.vendor_id,
                    configuration.product_code,
                    configuration.revision_number,
                    configuration.serial_number,
                )
            ),
            *(each.to_bytes(2, "little") for each in sizes),
            self._bus.state_bytes(slave)[1:],
            b"\0",
        ]

    def _record(self, index: int) -> bytes:
        slave = self._bus.master.slaves[index - _CONFIGURED]
        return b"".join(self._configured(slave)).ljust(_RECORD_SIZE - 2, b"\0")

    def _scanned_slave(self, slave: BusSlave) -> list[bytes]:
        facts = slave.facts
        return [
            (slave.station if slave.present else 0).to_bytes(2, "little"),
            *(each.to_bytes(4, "little") for each in facts.identity),
            facts.dl_status.to_bytes(2, "little"),
        ]

    def _diagnosis(self, slave: BusSlave) -> list[bytes]:
        return [
            (slave.state | 0x10 * slave.error).to_bytes(2, "little"),
            int(slave.requested_state).to_bytes(2, "little"),
            slave.al_code.to_bytes(2, "little"),
            self._bus.state_bytes(slave)[1:],
            *((each & 0xFFFF_FFFF).to_bytes(4, "little") for each in slave.counters.errors),
            *(
                each.to_bytes(4, "little")
                for each in (slave.wrong_cycles, slave.losses, slave.abnormal_changes)
            ),
            b"\0",
        ]

    def _scan(self) -> list[MasterValue]:
        status = _DONE_WITH_ANSWER * self._scanned
        count = self._bus.master.supervision.slave_count
        return [
            MasterValue(1, bytes(2)),
            MasterValue(2, bytes((status,))),
            MasterValue(3, struct.pack("<BxHxx", status, count)),
        ]

    def _statistics(self) -> list[MasterValue]:
        master = self._bus.master
        seconds = max(master.now_ns - master.counters_since_ns, 1) / 1e9
        values = [
            master.cyclic.counters.lost,
            master.traffic.lost_frames,
            round(master.cyclic.counters.sent / seconds),
            round(master.traffic.sent_frames / seconds),
        ]
        entries = _numbered([(each & 0xFFFF_FFFF).to_bytes(4, "little") for each in values])
        return [*entries, MasterValue(16, master.state.to_bytes(2, "little"))]


def _numbered(values: list[bytes]) -> list[MasterValue]:
    return [MasterValue(number, data) for number, data in enumerate(values, 1)]


def _fixed(text: str, size: int) -> bytes:
    return text.encode("cp1252", "replace")[: size - 1].ljust(size, b"\0")
