"""Inspection of the bus: count, addresses, identity and features of its slaves.

Source: ETG.1000.4 §6.1; ETG.2010 words 8 to 15.
"""

import struct
from collections.abc import Sequence

from achse.codes import AlState
from achse.ethercat.frame import Datagram, DatagramCommand
from achse.ethercat.master.bus_slave import SlaveFacts
from achse.ethercat.master.configuration import SlaveConfiguration
from achse.ethercat.master.eeprom_client import EepromClient
from achse.ethercat.master.errors import StateTimeout
from achse.ethercat.master.steps import (
    Pause,
    Round,
    Steps,
    Trip,
    broadcast_read,
    broadcast_write,
    now,
    read,
    read_number,
    write_position,
)
from achse.ethercat.registers import FMMU_BASE, SM_BASE, Register

MAX_SLAVES = 2048
"""Slaves that are addressed; more than any frame reaches in its time."""

_IDENTITY_WORD = 8
_STATE = 0x0F
_INIT_ACKNOWLEDGED = 0x11
_INIT_NS = 5_000_000_000
_POLL_NS = 5_000_000
_FACTS = struct.Struct("<BxHBBBBH")
_MASTER_FORCED, _MASTER = b"\x02", b"\x00"
_PER_TRIP = 40


def count_slaves() -> Steps[int]:
    """Return the number of slaves that frames pass: two counts have to agree."""
    before = -1
    while True:
        _, count = yield from broadcast_read(Register.AL_STATUS, 2)
        if count == before:
            return min(count, MAX_SLAVES)
        before = count


def reset_bus() -> Steps[None]:
    """Return all slaves to Init with empty FMMUs and SyncManagers, clocks at rest, EEPROM ours."""
    _, count = yield from broadcast_read(Register.AL_STATUS, 2)
    for address, data in (
        (Register.DL_CONTROL + 1, b"\0"),  # loops open and close by themselves
        (Register.DL_CONTROL + 3, b"\0"),  # no alias
        (Register.AL_CONTROL, _INIT_ACKNOWLEDGED.to_bytes(2, "little")),
    ):
        yield from broadcast_write(address, data)
    start = yield from now()
    while True:
        # the states come by OR; Init is the lowest bit alone
        time_ns = yield from now()
        state, answered = yield from broadcast_read(Register.AL_STATUS, 2)
        if state[0] & _STATE == AlState.INIT and answered == count:
            break
        if time_ns - start > _INIT_NS:
            raise StateTimeout(f"not all slaves reach Init: by OR they show 0x{state[0]:02X}")
        init = _INIT_ACKNOWLEDGED.to_bytes(2, "little")
        yield from broadcast_write(Register.AL_CONTROL, init)
        yield Pause(_POLL_NS)
    for address, data in (
        (Register.RX_ERRORS, bytes(8)),
        (FMMU_BASE, bytes(256)),
        (SM_BASE, bytes(128)),
        (Register.CYCLIC_UNIT_CONTROL, bytes(2)),
        (Register.SPEED_COUNTER_START, Register.SPEED_COUNTER_START.default.to_bytes(2, "little")),
        (Register.FILTER_DEPTHS, Register.FILTER_DEPTHS.default.to_bytes(2, "little")),
        (Register.EEPROM_CONFIGURATION, _MASTER_FORCED),
        (Register.EEPROM_CONFIGURATION, _MASTER),
    ):
        yield from broadcast_write(address, data)


def set_station(position: int, station: int) -> Steps[None]:
    """Give the slave at a position its station address."""
    yield from write_position(position, Register.STATION_ADDRESS, station.to_bytes(2, "little"))


def inspect(station: int) -> Steps[SlaveFacts]:
    """Features, links and identity of a slave."""
    kind, _, fmmus, managers, _, ports, features = _FACTS.unpack(
        (yield from read(station, Register.TYPE, _FACTS.size))
    )
    facts = SlaveFacts(kind, fmmus, managers, ports, features)
    facts.dl_status = yield from read_number(station, Register.DL_STATUS)
    facts.identity = yield from identify(station)
    return facts


def identify(station: int) -> Steps[tuple[int, int, int, int]]:
    """Vendor, product, revision and serial number from the EEPROM."""
    eeprom = EepromClient(station)
    yield from eeprom.claim()
    data = yield from eeprom.read(_IDENTITY_WORD, 8)
    vendor, product, revision, serial = struct.unpack("<4I", data)
    return vendor, product, revision, serial


def same_device(
    slave: SlaveConfiguration, identity: tuple[int, int, int, int], revision: bool = False
) -> bool:
    """Return True if a slave is the configured one; configured numbers that are 0 are not
    compared."""
    wanted = (slave.vendor_id, slave.product_code, slave.revision_number, slave.serial_number)
    compared = (True, True, revision, True)
    return all(
        not check or not number or number == actual
        for check, number, actual in zip(compared, wanted, identity, strict=True)
    )


def match(
    slaves: Sequence[SlaveConfiguration],
    identities: Sequence[tuple[int, int, int, int]],
    revision: bool = False,
) -> list[int | None]:
    """Return the index of the configured slave for each identity, None: another; optional ones may
    be missing.

    Where no configured slave fits, the next one that is not optional is expected at that place.
    """
    indices: list[int | None] = []
    at = 0
    for identity in identities:
        ahead = at
        while (
            ahead < len(slaves)
            and not same_device(slaves[ahead], identity, revision)
            and slaves[ahead].optional
        ):
            ahead += 1
        if ahead < len(slaves) and same_device(slaves[ahead], identity, revision):
            indices.append(ahead)
            at = ahead + 1
        else:
            indices.append(None)
            at = min(ahead + 1, len(slaves))
    return indices


def scattered_reads(
    stations: Sequence[int], address: int, length: int, command: DatagramCommand
) -> Steps[list[bytes | None]]:
    """Return the same memory of many slaves, by station or position; None of those that do not
    answer."""
    answers: list[bytes | None] = []
    for first in range(0, len(stations), _PER_TRIP):
        back: Round = yield Trip(
            tuple(
                Datagram.at(command, station, address, bytes(length))
                for station in stations[first : first + _PER_TRIP]
            )
        )
        answers += [each.data if each.counter == 1 else None for each in back.datagrams]
    return answers
