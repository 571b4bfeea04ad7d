"""The EtherCAT slave controller: 64 KiB of memory with registers that act, seen from both sides.

The master reads and writes by `read` and `write`; both say whether the access counts. The device
side is a `Pdi`: it is called when something happened, and answers by the attributes and methods
below "the application's side"; or it looks by itself, through `pdi_access`.

Source: ETG.1000.4 §6.1 to §6.8.
"""

import struct
from bisect import bisect_right
from collections.abc import Callable, Sequence
from typing import TypeAlias

from achse.codes import AlState, AlStatus
from achse.ethercat.clock import DistributedClock, Instant
from achse.ethercat.eeprom import COMMAND, Eeprom
from achse.ethercat.fmmu import Fmmu
from achse.ethercat.pdi import AlEvent, Pdi, PdiAccess
from achse.ethercat.registers import (
    DIGITAL_OUTPUTS,
    FMMU_BASE,
    RAM_BASE,
    RESOURCES,
    SM_BASE,
    ControllerResources,
    Register,
)
from achse.ethercat.syncmanager import SyncManager

_MEMORY_SIZE = 0x1_0000

_EVENT_LATCH = 0x0001
_EVENT_DL_STATUS = 0x0004
_EVENT_AL_STATUS = 0x0008

_PDI, _PDI_WATCHDOG = 0x03, 0x02
"""DL status: the PDI is operational, its watchdog has not expired; the latter alone."""

_DL_CONTROL, _STATION, _SYSTEM_TIME = (
    int(each) for each in (Register.DL_CONTROL, Register.STATION_ADDRESS, Register.SYSTEM_TIME)
)
"""Registers that each datagram reads; numbers, since looking up a member takes longer than the
rest."""

_LOOP_CONTROL, _ALIAS_USE = _DL_CONTROL + 1, _DL_CONTROL + 3
"""Bytes of DL control: what the ports do, whether the alias is in use."""

_CLOCK = 1 << 2  # of the features

_ERROR, _ID_LOADED = 0x0010, 0x0020

_Action: TypeAlias = "Callable[[Esc, int, int], None]"
_ACTIONS: dict[Register, _Action] = {}
"""Actions after writing a register; arguments are the first and the last byte written."""


def _when_written(*registers: Register) -> Callable[[_Action], _Action]:
    """Binds a method of the controller to the registers whose writing it answers."""

    def bind(action: _Action) -> _Action:
        for register in registers:
            _ACTIONS[register] = action
        return action

    return bind


class Esc:
    """Memory, registers, FMMUs, SyncManagers, EEPROM and clock of one slave.

    It is dead until `power_up`.
    """

    def __init__(
        self,
        pdi: Pdi,
        sii: bytes,
        *,
        resources: ControllerResources = RESOURCES,
        alias: int = 0,
    ) -> None:
        self.pdi = pdi
        self.memory = bytearray(_MEMORY_SIZE)
        self.time = Instant()
        self.remapped: Callable[[], None] = _nothing
        """Called when FMMUs or SyncManagers have changed."""
        self.readdressed: Callable[[], None] = _nothing
        """Called when station address or alias have changed, or whether the alias counts."""
        self.rerouted: Callable[[], None] = _nothing
        """Called when DL control was written: ports may open or close."""
        self.irq_changed: Callable[[], None] = _nothing
        """Called when `irq`, the pending events that the master's mask lets through, changes."""
        self.fmmus = [Fmmu.decode(bytes(16))] * resources.fmmus
        self.watchdog_ns = 0
        """Process data watchdog time, 0 = off."""
        self.pdi_watchdog_ns = 0
        """Longest time without an access of the device, ns; 0 = unlimited."""
        self.pdi_access = PdiAccess(self)
        self._alias = alias
        self._resources = resources
        self.has_clock = bool(resources.features & _CLOCK)
        """Without distributed clocks their registers are 0."""
        self.ram_end = RAM_BASE + 1024 * resources.ram_kib
        self._ram_base = RAM_BASE
        """First byte that SyncManagers guard."""
        self._reset_progress = 0
        self._loop_control = 0
        self.eeprom = Eeprom(sii, self.memory)
        self.clock = DistributedClock(self.memory, self.time, pdi.timing_changed)
        self.sync_managers = [
            self._sync_manager(number) for number in range(resources.sync_managers)
        ]
        self._guarded: list[SyncManager] = []
        self._writers = self._rows()
        self._starts = [first for first, _, _ in self._writers]
        self._refreshers = self._live_blocks()

    def _sync_manager(self, number: int) -> SyncManager:
        return SyncManager(
            number,
            lambda data: self.pdi.written(number, data),
            lambda: self._taken(number),
        )

    def _taken(self, number: int) -> None:
        self.pdi.taken(number)
        self._update_irq()

    def power_up(self) -> None:
        """Set registers to their defaults, and load the configuration area from the EEPROM."""
        memory = self.memory
        memory[:] = bytes(_MEMORY_SIZE)
        for register in Register:
            register.set(memory, register.default)
        self._resources.show(memory)
        self.fmmus = [Fmmu.decode(bytes(16))] * len(self.fmmus)
        for sync_manager in self.sync_managers:
            sync_manager.locked = True
            sync_manager.repeat_acknowledge = False
            sync_manager.configure(bytes(8))
        self._guarded = []
        self._ram_base = RAM_BASE
        self.events = 0
        self.irq = 0
        self.al_events = AlEvent(0)
        self._loop_control = 0
        self._reload()
        self.clock.reset()
        self._watchdog_written(Register.WATCHDOG_DIVIDER, Register.WATCHDOG_DIVIDER.end)
        self.rerouted()

    def _reload(self) -> None:
        """Take words 0 to 4 of the EEPROM over; without the checksum the PDI stays dead."""
        memory = self.memory
        self.eeprom.command(0, 0)
        words = self.eeprom.image
        alias = self._alias.to_bytes(2, "little") if self._alias else words[8:10]
        memory[Register.DL_STATUS] &= ~_PDI
        if self.eeprom.valid:
            memory[Register.PDI_CONTROL : Register.ESC_CONFIGURATION.end] = words[0:2]
            memory[Register.PDI_CONFIGURATION.place] = words[2:4] + words[6:8]
            memory[Register.PULSE_LENGTH.place] = words[4:6]
            memory[Register.STATION_ALIAS.place] = alias
            self.readdressed()
            memory[Register.DL_STATUS] |= _PDI

    # the master's side

    def read(self, address: int, length: int) -> bytes | None:
        """`length` bytes from `address`, or None if the access is refused."""
        end = address + length
        base = self._ram_base
        if address >= base:
            return self._read_ram(address, end)
        if end > base:
            registers, ram = self.read(address, base - address), self._read_ram(base, end)
            return None if registers is None or ram is None else registers + ram
        data = self.look(address, length)
        if self.events:
            self._events_read(address, end)
        return data

    def look(self, address: int, length: int) -> bytes:
        """Registers as they are now; nothing is read by that."""
        end = address + length
        for block in range(address >> 4, end + 15 >> 4):
            if block in self._refreshers:
                self._refreshers[block](address, end)
        return bytes(self.memory[address:end])

    def holds_message(self, number: int) -> bool:
        """Return True if a mailbox is full, as the master reads it in the SyncManager's status."""
        self.pdi.looked_at(number)
        return self.sync_managers[number].full

    def rests(self, address: int, length: int) -> bool:
        """Return True if these registers are read from memory as stored: no register is refreshed
        on reading."""
        blocks = range(address >> 4, address + length + 15 >> 4)
        return address + length <= RAM_BASE and self._refreshers.keys().isdisjoint(blocks)

    def write(self, address: int, data: bytes | bytearray) -> bool:
        """Write `data` at `address`; False if nothing was written."""
        if address == _SYSTEM_TIME:
            if self.has_clock:
                self.clock.feed(data[:8])
            return True
        end = address + len(data)
        base = self._ram_base
        if address >= base:
            return self._write_ram(address, end, data)
        if end > base and not self._may_write_ram(base, end):
            return False
        memory = self.memory
        done = False
        rows = self._writers
        for number in range(max(bisect_right(self._starts, address) - 1, 0), len(rows)):
            first, last, act = rows[number]
            if first >= end:
                break
            if last > address:
                low = max(first, address)
                high = min(last, end)
                memory[low:high] = data[low - address : high - address]
                act(low, high)
                done = True
        if end > base:
            done |= self._write_ram(base, end, data[base - address :])
        return done

    def _ranges(self, address: int, end: int) -> list[tuple[SyncManager | None, int, int]]:
        """Return the parts of an access to process data memory, by their SyncManager."""
        ranges: list[tuple[SyncManager | None, int, int]] = []
        while address < end:
            stop = end
            guard = None
            for each in self._guarded:
                if each.start <= address < each.end:
                    guard = each
                    stop = min(end, each.end)
                    break
                if address < each.start < stop:
                    stop = each.start
            ranges.append((guard, address, stop))
            address = stop
        return ranges

    def _read_ram(self, address: int, end: int) -> bytes | None:
        if end > self.ram_end:
            return None
        ranges = self._ranges(address, end)
        if any(guard and not guard.accepts(write=False) for guard, _, _ in ranges):
            return None
        return b"".join(
            [
                guard.read(low - guard.start, high - low) if guard else bytes(self.memory[low:high])
                for guard, low, high in ranges
            ]
        )

    def _may_write_ram(self, address: int, end: int) -> bool:
        return end <= self.ram_end and all(
            guard is None or guard.accepts(write=True) for guard, _, _ in self._ranges(address, end)
        )

    def _write_ram(self, address: int, end: int, data: bytes | bytearray) -> bool:
        if not self._may_write_ram(address, end):
            return False
        for guard, low, high in self._ranges(address, end):
            part = data[low - address : high - address]
            if guard:
                guard.write(low - guard.start, part)
            else:
                self.memory[low:high] = part
        return True

    def read_bits(self, bit: int, bits: int) -> int | None:
        """Bits of memory as a number, from bit `bit` (8·address + bit of the byte) on."""
        first = bit >> 3
        data = self.read(first, (bit + bits + 7 >> 3) - first)
        if data is None:
            return None
        return int.from_bytes(data, "little") >> (bit & 7) & (1 << bits) - 1

    def write_bits(self, bit: int, bits: int, value: int) -> bool:
        """Write bits of memory; the other bits of the bytes keep what was written last."""
        first = bit >> 3
        end = bit + bits + 7 >> 3
        mask = (1 << bits) - 1 << (bit & 7)
        old = self.memory[first:end]
        for guard in self._guarded:
            if guard.start <= first and end <= guard.end:
                old = guard.peek()[first - guard.start : end - guard.start]
        new = int.from_bytes(old, "little") & ~mask | value << (bit & 7) & mask
        return self.write(first, new.to_bytes(end - first, "little"))

    # registers that act when written

    def _rows(self) -> list[tuple[int, int, Callable[[int, int], None]]]:
        """Return the ranges that the master may write, ascending: first address, end, action after
        writing."""
        rows = [
            (int(row), row.end, _ACTIONS[row].__get__(self) if row in _ACTIONS else _plain)
            for row in Register
            if row.writable
        ]
        rows.append((FMMU_BASE, FMMU_BASE + 16 * len(self.fmmus), self._fmmu_written))
        for number in range(len(self.sync_managers)):
            base = SM_BASE + 8 * number
            rows.append((base, base + 5, self._sync_manager_written))
            rows.append((base + 6, base + 7, self._sync_manager_written))
        return sorted(rows, key=lambda row: row[0])

    @_when_written(
        Register.RX_ERRORS,
        Register.PROCESSING_ERRORS,
        Register.LOST_LINKS,
        Register.WATCHDOG_COUNTERS,
    )
    def _counters_written(self, first: int, end: int) -> None:
        """Clear all counters of the register, whatever is written and where."""
        register = max(each for each in Register if each <= first)
        register.set(self.memory, 0)

    @_when_written(Register.RECEIVE_TIME_PORT_0)
    def _receive_times_written(self, first: int, end: int) -> None:
        self.clock.latch_receive_times()

    @_when_written(Register.SYSTEM_TIME_OFFSET, Register.SYSTEM_TIME_DELAY)
    def _system_time_written(self, first: int, end: int) -> None:
        self.clock.registers_written()

    @_when_written(Register.SPEED_COUNTER_START)
    def _speed_counter_written(self, first: int, end: int) -> None:
        self.clock.restart_loop()

    @_when_written(Register.ACTIVATION)
    def _activation_written(self, first: int, end: int) -> None:
        self.clock.activate()

    @_when_written(Register.STATION_ADDRESS)
    def _mapping_written(self, first: int, end: int) -> None:
        self.readdressed()

    @_when_written(Register.DL_CONTROL)
    def _dl_control_written(self, first: int, end: int) -> None:
        self.readdressed()
        if self.memory[_LOOP_CONTROL] != self._loop_control:
            self._loop_control = self.memory[_LOOP_CONTROL]
            self.rerouted()

    @_when_written(Register.RESET)
    def _reset_written(self, first: int, end: int) -> None:
        """Reset the controller once 'R', 'E' and 'S' came in three writes."""
        letter = self.memory[Register.RESET]
        expected = b"RES"[self._reset_progress]
        self._reset_progress = self._reset_progress + 1 if letter == expected else 0
        if self._reset_progress == 3:
            self._reset_progress = 0
            self.pdi.reset()

    @_when_written(Register.AL_CONTROL)
    def _al_control_written(self, first: int, end: int) -> None:
        if self.operational:
            self.al_events |= AlEvent.AL_CONTROL
            self.pdi.al_control(Register.AL_CONTROL.get(self.memory))

    @_when_written(Register.ECAT_EVENT_MASK)
    def _mask_written(self, first: int, end: int) -> None:
        self._update_irq()

    @_when_written(Register.WATCHDOG_DIVIDER, Register.PDI_WATCHDOG, Register.PROCESS_WATCHDOG)
    def _watchdog_written(self, first: int, end: int) -> None:
        tick = 40 * (Register.WATCHDOG_DIVIDER.get(self.memory) + 2)
        self.pdi_watchdog_ns = tick * Register.PDI_WATCHDOG.get(self.memory)
        self.watchdog_ns = tick * Register.PROCESS_WATCHDOG.get(self.memory)
        self.pdi.timing_changed()

    @_when_written(Register.EEPROM)
    def _eeprom_written(self, first: int, end: int) -> None:
        reload = self.memory[COMMAND] & 0x07 == 4 and first <= COMMAND < end
        self.eeprom.command(first, end)
        if reload:
            self._reload()

    def _fmmu_written(self, first: int, end: int) -> None:
        for number in range((first - FMMU_BASE) >> 4, (end - FMMU_BASE + 15) >> 4):
            base = FMMU_BASE + 16 * number
            self.fmmus[number] = Fmmu.decode(self.memory[base : base + 16])
        self.remapped()

    def _sync_manager_written(self, first: int, end: int) -> None:
        number = (first - SM_BASE) >> 3
        sync_manager = self.sync_managers[number]
        base = SM_BASE + 8 * number
        registers = bytes(self.memory[base : base + 8])
        if first == base + 6 and bool(registers[6] & 1) == sync_manager.enabled:
            sync_manager.repeat_request = bool(registers[6] & 2)
        else:
            sync_manager.configure(registers)
            self._guarded = [each for each in self.sync_managers if each.guards]
            first = min((each.start for each in self._guarded), default=RAM_BASE)
            self._ram_base = DIGITAL_OUTPUTS if DIGITAL_OUTPUTS <= first < RAM_BASE else RAM_BASE
            self.remapped()
            self.al_events |= AlEvent.SYNC_MANAGERS
        self.pdi.sync_manager_changed(number)

    # registers that are made when read

    def _live_blocks(self) -> dict[int, Callable[[int, int], None]]:
        """Blocks of 16 bytes whose content is brought up to date before it is read."""
        blocks: dict[int, Callable[[int, int], None]] = {
            Register.ECAT_EVENT_REQUEST >> 4: self._refresh_events,
            Register.AL_EVENT_REQUEST >> 4: self._refresh_events,
        }
        blocks |= self.clock.live_blocks() if self.has_clock else {}
        for block in range(len(self.sync_managers) + 1 >> 1):
            blocks[(SM_BASE >> 4) + block] = self._refresh_sync_managers
        return blocks

    def _refresh_events(self, first: int, end: int) -> None:
        Register.ECAT_EVENT_REQUEST.set(self.memory, self.event_request)
        Register.AL_EVENT_REQUEST.set(self.memory, self.al_event_request)

    def _refresh_sync_managers(self, first: int, end: int) -> None:
        begin = max(first - SM_BASE >> 3, 0)
        for sync_manager in self.sync_managers[begin : end - SM_BASE + 7 >> 3]:
            base = SM_BASE + 8 * sync_manager.number
            if first <= base + 5 < end:
                self.pdi.looked_at(sync_manager.number)
            self.memory[base + 5] = sync_manager.status
            self.memory[base + 7] = sync_manager.locked | sync_manager.repeat_acknowledge << 1

    # events to the master

    @property
    def event_request(self) -> int:
        """ECAT event request: latch, DL status, AL status, a message in SyncManager n."""
        request = self.events
        for sync_manager in self.sync_managers:
            if sync_manager.full and not sync_manager.to_application:
                request |= 0x10 << sync_manager.number
        return request

    @property
    def al_event_request(self) -> int:
        """AL event request, the events to the device; see `AlEvent`."""
        request = int(self.al_events)
        if self.events & _EVENT_LATCH:
            request |= AlEvent.LATCH
        if self.clock.sync0_pending:
            request |= AlEvent.SYNC0
        if self.clock.sync1_pending:
            request |= AlEvent.SYNC1
        for sync_manager in self.sync_managers:
            if sync_manager.concerns_application:
                request |= AlEvent.SYNC_MANAGER_0 << sync_manager.number
        return request

    def acknowledge(self, event: AlEvent) -> None:
        """Note that the device has seen an event."""
        self.al_events &= ~event

    def _raise_event(self, event: int) -> None:
        self.events |= event
        self._update_irq()

    def _update_irq(self) -> None:
        mask = Register.ECAT_EVENT_MASK.get(self.memory)
        irq = self.event_request & mask if mask else 0
        if irq != self.irq:
            self.irq = irq
            self.irq_changed()

    def _events_read(self, first: int, end: int) -> None:
        """Note that the master read what has changed: the event is over."""
        if first <= Register.AL_STATUS < end:
            self.events &= ~_EVENT_AL_STATUS
        if first <= Register.DL_STATUS < end:
            self.events &= ~_EVENT_DL_STATUS
        if self.events & _EVENT_LATCH:
            self.clock.latch_times_read(first, end)
            if not self.clock.latched:
                self.events &= ~_EVENT_LATCH
        self._update_irq()

    # the application's side

    def set_al_status(self, state: AlState, code: AlStatus, identification: int = 0) -> None:
        """Show state and AL status code; `identification` instead of a code if requested."""
        status = state | _ERROR * (code is not AlStatus.NO_ERROR)
        number = code.number
        if identification and not number:
            status |= _ID_LOADED
            number = identification
        self.show_al_status(Register.AL_STATUS, struct.pack("<HxxH", status, number))

    def show_al_status(self, address: int, data: bytes) -> None:
        """Show what the device's program wrote to AL status or its code."""
        self.memory[address : address + len(data)] = data
        self._raise_event(_EVENT_AL_STATUS)

    def set_links(self, linked: Sequence[bool]) -> list[bool]:
        """Show in DL status which ports have a link; which of them forward frames to it.

        Loop control (DL control bits 8..15, two for each port): 0 and 1 open with the link,
        2 always open, 3 closed.
        """
        status = self.memory[Register.DL_STATUS] & _PDI
        control = self.memory[_LOOP_CONTROL]
        opened = []
        for port, link in enumerate(linked):
            mode = control >> 2 * port & 3
            is_open = mode == 2 or (link and mode != 3)
            opened.append(is_open)
            status |= link << 4 + port | (not is_open) << 8 + 2 * port | link << 9 + 2 * port
        if status != Register.DL_STATUS.get(self.memory):
            Register.DL_STATUS.set(self.memory, status)
            self._raise_event(_EVENT_DL_STATUS)
        return opened

    def open_with_link(self, port: int | None = None) -> None:
        """Let a port (all, if none is given) open with its link again, as after power-up."""
        mask = 0 if port is None else ~(3 << 2 * port)
        self.memory[_LOOP_CONTROL] = self._loop_control = self.memory[_LOOP_CONTROL] & mask

    def count(self, address: int) -> None:
        """Count up an error counter, which stops at 255."""
        if self.memory[address] < 0xFF:
            self.memory[address] += 1

    def lock(self, number: int, locked: bool) -> None:
        """Let a SyncManager work, or refuse the master's accesses to it."""
        sync_manager = self.sync_managers[number]
        if sync_manager.locked != locked:
            sync_manager.locked = locked
            sync_manager.reset()
            self.remapped()

    def put(self, number: int, message: bytes) -> None:
        """Put a message to the master into a mailbox."""
        self.sync_managers[number].put(message)
        self._update_irq()

    def latch(self, unit: int, rising: bool) -> None:
        """Latch an edge at latch input 0 or 1."""
        if self.clock.latch(unit, rising):
            self._raise_event(_EVENT_LATCH)

    @property
    def destroys_foreign(self) -> bool:
        """True if frames of other protocols are not forwarded (DL control bit 0)."""
        return bool(self.memory[_DL_CONTROL] & 1)

    @property
    def operational(self) -> bool:
        """True if the EEPROM was loaded without error, and the PDI answers."""
        return bool(self.memory[Register.DL_STATUS] & 1)

    @property
    def station(self) -> int:
        """Configured station address."""
        return self.memory[_STATION] | self.memory[_STATION + 1] << 8

    @property
    def alias(self) -> int:
        """Configured station alias."""
        return Register.STATION_ALIAS.get(self.memory)

    @property
    def addresses(self) -> set[int]:
        """Configured addresses that mean this slave: its own, and its alias if in use."""
        return {self.station, self.alias} if self.memory[_ALIAS_USE] & 1 else {self.station}

    def set_watchdog(self, expired: bool) -> None:
        """Show the state of the process data watchdog; expiries are counted."""
        if expired and self.memory[Register.PROCESS_WATCHDOG_STATUS] & 1:
            self.count(Register.WATCHDOG_COUNTERS)
            self.al_events |= AlEvent.WATCHDOG
        self.memory[Register.PROCESS_WATCHDOG_STATUS] = not expired

    def pdi_alive(self, alive: bool = True) -> None:
        """Update the PDI watchdog: the device did something, or nothing for too long."""
        if not alive and self.memory[Register.DL_STATUS] & _PDI_WATCHDOG:
            self.count(Register.WATCHDOG_COUNTERS + 1)
            self.memory[Register.DL_STATUS] &= ~_PDI_WATCHDOG
            self._raise_event(_EVENT_DL_STATUS)
        elif alive and self.operational and not self.memory[Register.DL_STATUS] & _PDI_WATCHDOG:
            self.memory[Register.DL_STATUS] |= _PDI_WATCHDOG
            self._raise_event(_EVENT_DL_STATUS)


def _nothing() -> None:
    """Ignore an event before a listener is set."""


def _plain(first: int, end: int) -> None:
    """Do nothing: the register only keeps its value."""
