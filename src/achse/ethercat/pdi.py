"""The device's side of a slave controller: notifications, AL events, accesses by PDI.

A device of this package is called when something happened (`Pdi`). One that looks by itself, as
firmware does, reads the AL event request and the registers through `PdiAccess`.

Source: ETG.1000.4 §6.1.5, §6.1.6 and §6.3.
"""

from enum import IntFlag
from typing import TYPE_CHECKING, Protocol

from achse.codes import AlState
from achse.ethercat.registers import RAM_BASE, SM_BASE, Register

if TYPE_CHECKING:
    from achse.ethercat.esc import Esc


class AlEvent(IntFlag):
    """Bits of AL event request and mask; from bit 8 on SyncManagers."""

    AL_CONTROL = 0x01
    LATCH = 0x02
    SYNC0 = 0x04
    SYNC1 = 0x08
    SYNC_MANAGERS = 0x10
    """A SyncManager was switched on, off or set up."""
    WATCHDOG = 0x40
    """The process data watchdog has expired."""
    SYNC_MANAGER_0 = 0x100
    """Shifted by the number: a message or buffer was written, or a message taken."""


class Pdi(Protocol):
    """The device behind a slave controller, notified of the master's accesses."""

    def al_control(self, request: int) -> None:
        """Handle a write to AL control: bits 0..3 state, 4 acknowledge, 5 identification."""
        ...

    def sync_manager_changed(self, number: int) -> None:
        """Note that the registers of a SyncManager were written."""
        ...

    def written(self, number: int, data: bytes) -> None:
        """Note that the master completed a buffer or message."""
        ...

    def taken(self, number: int) -> None:
        """Note that the master read a message."""
        ...

    def looked_at(self, number: int) -> None:
        """Note that the master is about to read the status of a SyncManager."""
        ...

    def timing_changed(self) -> None:
        """Note that SYNC0 or the watchdog was set, or the next SYNC0 event has moved."""
        ...

    def reset(self) -> None:
        """Note that the master reset the slave controller."""
        ...


_STATE = 0x0F
_STATES = {int(state) for state in AlState}
_MANAGER_SIZE, _PDI_CONTROL = 8, 7
"""Registers of a SyncManager, and which of them the device writes."""
_OFF, _REPEAT_ACKNOWLEDGE = 0x01, 0x02
_OWN = (Register.STATION_ALIAS, Register.AL_EVENT_MASK)
"""Registers that only the device writes."""


class PdiAccess:
    """Reads and writes of the device at the controller's memory; both end events as they should."""

    def __init__(self, esc: "Esc") -> None:
        self._esc = esc

    @property
    def request(self) -> AlEvent:
        """Pending events that pass the AL event mask, as on the interrupt line."""
        mask = Register.AL_EVENT_MASK.get(self._esc.memory)
        return AlEvent(self._esc.al_event_request & mask)

    def read(self, address: int, length: int) -> bytes:
        """`length` bytes from `address`; reading what has changed ends its event."""
        esc = self._esc
        esc.pdi_alive()
        end = address + length
        if address >= RAM_BASE:
            for sync_manager in esc.sync_managers:
                if sync_manager.start <= address and end <= sync_manager.end:
                    if not sync_manager.to_application:
                        break
                    low = address - sync_manager.start
                    data = sync_manager.newest[low : low + length]
                    if end == sync_manager.end:
                        sync_manager.release()
                    return data
            return bytes(esc.memory[address:end])
        data = esc.look(address, length)
        if address <= Register.AL_CONTROL < end:
            esc.acknowledge(AlEvent.AL_CONTROL)
        if address <= Register.PROCESS_WATCHDOG_STATUS < end:
            esc.acknowledge(AlEvent.WATCHDOG)
        if address < SM_BASE + 8 * len(esc.sync_managers) and end > SM_BASE:
            esc.acknowledge(AlEvent.SYNC_MANAGERS)
        if address <= Register.SYNC_STATUS < end:
            esc.clock.sync0_seen()
        if address <= Register.SYNC_STATUS + 1 < end:
            esc.clock.sync1_seen()
        return data

    def write(self, address: int, data: bytes) -> bool:
        """Write what the device may write; False if it may not.

        That is AL status and its code, alias, event mask, PDI control of SyncManagers, messages and
        memory. A message is complete when its last byte is written.
        """
        esc = self._esc
        esc.pdi_alive()
        end = address + len(data)
        if address >= RAM_BASE:
            return self._write_ram(address, data)
        if address >= Register.AL_STATUS and end <= Register.AL_STATUS_CODE.end:
            if address == Register.AL_STATUS and data[0] & _STATE not in _STATES:
                return False
            esc.show_al_status(address, data)
            return True
        number, place = divmod(address - SM_BASE, _MANAGER_SIZE)
        if place == _PDI_CONTROL and 0 <= number < len(esc.sync_managers) and len(data) == 1:
            esc.lock(number, bool(data[0] & _OFF))
            esc.sync_managers[number].repeat_acknowledge = bool(data[0] & _REPEAT_ACKNOWLEDGE)
            return True
        for register in _OWN:
            if register <= address and end <= register.end:
                esc.memory[address:end] = data
                esc.readdressed()
                return True
        return False

    def _write_ram(self, address: int, data: bytes) -> bool:
        esc, end = self._esc, address + len(data)
        for sync_manager in esc.sync_managers:
            if sync_manager.start <= address and end <= sync_manager.end:
                if sync_manager.to_application or sync_manager.full:
                    return False
                break
        else:
            sync_manager = None
        esc.memory[address:end] = data
        if sync_manager is None:
            return True
        if address == sync_manager.start:
            sync_manager.events = 0  # that the message before was taken
        if end == sync_manager.end:
            esc.put(sync_manager.number, bytes(esc.memory[sync_manager.start : sync_manager.end]))
        return True
