"""The way of one slave to its state: mailbox, start commands, PDOs, SyncManagers, FMMUs, clock.

Each step is done in the state in which it is allowed; an error of the slave is acknowledged and the
way begins again from the state that its AL status code requires, at most three times.

Source: ETG.1000.4 §6.1.5; ETG.1020 for the order; 001 §2.8 for PDO mapping.
"""

import struct
from collections.abc import Callable

from achse.codes import AlState, AlStatus
from achse.ethercat.description import Pdo, SyncManagerArea
from achse.ethercat.master.bus_slave import BusSlave
from achse.ethercat.master.clocks import correct_offset, difference_of, start_sync, stop_sync
from achse.ethercat.master.configuration import BusConfiguration, InitCommand
from achse.ethercat.master.errors import BusError, SdoRefusal, StateRefusal
from achse.ethercat.master.process_image import ProcessImage
from achse.ethercat.master.soe_client import SoeRefusal
from achse.ethercat.master.states import UPWARD, acknowledge, change_state
from achse.ethercat.master.steps import Pause, Steps, now, read_number, write
from achse.ethercat.registers import FMMU_BASE, SM_BASE, Register

_FMMU_SIZE, _SM_SIZE = 16, 8
_ENABLED = 1
_TRIES = 3
_RETRY_NS = 10_000_000
_ASSIGNMENT = 0x1C10
_CLOCK_POLL_NS = 10_000_000
_WATCHDOG_UNITS = 10
"""Units of the watchdog in a millisecond (100 µs with the divider's default)."""

_RESTART = {
    AlStatus.NEEDS_INIT: AlState.INIT,
    AlStatus.NEEDS_PREOP: AlState.PREOP,
    AlStatus.NEEDS_SAFEOP: AlState.SAFEOP,
    AlStatus.MAILBOX_CONFIGURATION: AlState.INIT,
    AlStatus.SYNC_MANAGER_CONFIGURATION: AlState.PREOP,
    AlStatus.OUTPUT_CONFIGURATION: AlState.PREOP,
    AlStatus.INPUT_CONFIGURATION: AlState.PREOP,
    AlStatus.SYNCHRONIZATION: AlState.PREOP,
    AlStatus.FATAL_SYNC: AlState.PREOP,
    AlStatus.NO_SYNC0: AlState.PREOP,
    AlStatus.DC_CONFIGURATION: AlState.PREOP,
    AlStatus.SYNC_CYCLE: AlState.PREOP,
    AlStatus.PLL: AlState.PREOP,
    AlStatus.RESTARTED: AlState.INIT,
}
"""State to restart from after an AL status code; after other codes the slave continues from its
state."""

_HOPELESS = {
    AlStatus.UNKNOWN_STATE,
    AlStatus.NO_BOOTSTRAP,
    AlStatus.NEEDS_COLD_START,
    AlStatus.SYNC_MANAGER_TYPES,
    AlStatus.INPUT_MAPPING,
    AlStatus.OUTPUT_MAPPING,
    AlStatus.INCONSISTENT_SETTINGS,
    AlStatus.NOT_IN_COMMUNICATION_MODE,
}
"""Codes that a second try does not change."""


class BringUp:
    """State changes of slaves. `reached` is called with each state that a slave has come to."""

    def __init__(
        self,
        bus: BusConfiguration,
        image: ProcessImage,
        reached: Callable[[BusSlave, AlState], None],
        clock_warning: Callable[[BusSlave], None],
    ) -> None:
        self._bus = bus
        self._image = image
        self._reached = reached
        self._clock_warning = clock_warning

    def run(self, slave: BusSlave, fresh: bool = False) -> Steps[None]:
        """Bring a slave to `slave.requested_state`; with `fresh` by way of Init.

        Raises the `BusError` that it ended with, after three tries.
        """
        restart = AlState.INIT if fresh else None
        for attempt in range(_TRIES):
            try:
                yield from self._run_once(slave, restart)
                slave.last_trouble = ""
                slave.failed_command = False
                return
            except (SdoRefusal, SoeRefusal) as refusal:
                slave.failed_command = True
                slave.last_trouble = str(refusal)
                raise
            except StateRefusal as refusal:
                slave.last_trouble = str(refusal)
                slave.al_code = refusal.number
                if refusal.code in _HOPELESS or attempt + 1 == _TRIES:
                    slave.error = True
                    raise
                restart = _RESTART.get(refusal.code) if refusal.code else None
            except BusError as trouble:
                slave.last_trouble = str(trouble)
                if attempt + 1 == _TRIES:
                    raise
            yield Pause(_RETRY_NS)

    def _run_once(self, slave: BusSlave, restart: AlState | None) -> Steps[None]:
        report = yield from acknowledge(slave.station)
        self._note(slave, report.state)
        if report.state == slave.requested_state == AlState.BOOT:
            return
        known = report.state in tuple(UPWARD)
        state = AlState(report.state) if known else AlState.INIT
        if not known:
            restart = AlState.INIT
        if restart is not None and (restart < state or not known):
            yield from self._go(slave, state, restart)
            state = restart
        if restart is AlState.INIT or state is AlState.INIT:
            yield from self._clear(slave)
        if slave.requested_state is AlState.BOOT:
            yield from self._boot(slave, state)
            return
        while state is not slave.requested_state:
            target: AlState = slave.requested_state
            if target > state:
                target = UPWARD[UPWARD.index(state) + 1]
            yield from self._prepare(slave, state, target)
            yield from self._go(slave, state, target)
            if (state, target) == (AlState.INIT, AlState.PREOP):  # there is a mailbox only now
                yield from self._commands(slave, "IP")
            state = target

    def _boot(self, slave: BusSlave, state: AlState) -> Steps[None]:
        """To Bootstrap, by way of Init, with the mailboxes of that state."""
        out, into = slave.configuration.boot_out, slave.configuration.boot_in
        if out is None or into is None or slave.mailbox is None:
            raise BusError(f"{slave.name} has no mailbox for Bootstrap")
        if state is not AlState.INIT:
            yield from self._go(slave, state, AlState.INIT)
            yield from self._clear(slave)
        yield from write(slave.station, SM_BASE, mailbox_registers(out, into))
        yield from slave.eeprom.hand_over()
        yield from self._go(slave, AlState.INIT, AlState.BOOT)
        slave.mailbox.outgoing, slave.mailbox.incoming = out, into

    def _go(self, slave: BusSlave, before: AlState, target: AlState) -> Steps[None]:
        allowed = slave.configuration.times.allowed(before, target)
        yield from change_state(slave.station, target, allowed)
        self._note(slave, target)
        slave.al_code = 0
        slave.error = False
        if before is AlState.INIT and slave.mailbox is not None:
            slave.mailbox.reset()
        if target is AlState.PREOP and before is not AlState.INIT:
            yield from stop_sync_if(slave)
        self._reached(slave, target)

    def _note(self, slave: BusSlave, state: int) -> None:
        slave.state = state

    def _clear(self, slave: BusSlave) -> Steps[None]:
        """In Init: no FMMU, no SyncManager."""
        facts = slave.facts
        slave.reads_mailbox_bit = False
        if facts.fmmus:
            yield from write(slave.station, FMMU_BASE, bytes(_FMMU_SIZE * facts.fmmus))
        if facts.sync_managers:
            yield from write(slave.station, SM_BASE, bytes(_SM_SIZE * facts.sync_managers))
        yield from stop_sync_if(slave)

    def _prepare(self, slave: BusSlave, state: AlState, target: AlState) -> Steps[None]:
        """Do the work that a slave needs before the transition from `state` to `target`."""
        if (state, target) == (AlState.INIT, AlState.PREOP):
            yield from self._open_mailbox(slave)
            yield from slave.eeprom.hand_over()
        elif (state, target) == (AlState.PREOP, AlState.SAFEOP):
            yield from self._commands(slave, "PS")
            yield from self._map(slave)
            yield from self._open_process_data(slave)
            yield from self._start_clock(slave)
        elif (state, target) == (AlState.SAFEOP, AlState.OP):
            yield from self._commands(slave, "SO")
        elif (state, target) == (AlState.OP, AlState.SAFEOP):
            yield from self._commands(slave, "OS")
        elif (state, target) == (AlState.SAFEOP, AlState.PREOP):
            yield from self._commands(slave, "SP")

    def _open_mailbox(self, slave: BusSlave) -> Steps[None]:
        out, into = slave.configuration.mailbox_out, slave.configuration.mailbox_in
        if out is not None and into is not None:
            yield from write(slave.station, SM_BASE, mailbox_registers(out, into))
        if slave.mailbox is not None and out is not None and into is not None:
            slave.mailbox.outgoing, slave.mailbox.incoming = out, into

    def _commands(self, slave: BusSlave, transition: str) -> Steps[None]:
        for command in slave.configuration.commands:
            if command.transition == transition:
                yield from self._command(slave, command)
        yield from self._idn_commands(slave, transition)

    def _command(self, slave: BusSlave, command: InitCommand) -> Steps[None]:
        if slave.sdo is not None:
            yield from slave.sdo.download(
                command.index, command.subindex, command.data, complete=command.complete
            )

    def _idn_commands(self, slave: BusSlave, transition: str) -> Steps[None]:
        if slave.soe is None:
            return
        configuration = slave.configuration
        for command in configuration.idn_commands:
            if command.transition == transition:
                data = configuration.idn_data(command, self._bus.cycle_ns)
                yield from slave.soe.write(command.idn, data, drive=command.drive)

    def _map(self, slave: BusSlave) -> Steps[None]:
        """Assignment off, entries, assignment on: the order that strict slaves require."""
        configuration, sdo = slave.configuration, slave.sdo
        if sdo is None or not configuration.assign:
            return
        for manager in configuration.sync_managers:
            pdos = configuration.outputs if manager.output else configuration.inputs
            mine = [each for each in pdos if configuration.manager_of(each) == manager.number]
            assignment = _ASSIGNMENT + manager.number
            yield from sdo.download(assignment, 0, b"\0")
            for pdo in mine:
                if configuration.configure and not pdo.fixed:
                    yield from self._write_entries(slave, pdo)
            for number, pdo in enumerate(mine, 1):
                yield from sdo.download(assignment, number, pdo.index.to_bytes(2, "little"))
            yield from sdo.download(assignment, 0, bytes((len(mine),)))

    def _write_entries(self, slave: BusSlave, pdo: Pdo) -> Steps[None]:
        sdo = slave.sdo
        assert sdo is not None
        yield from sdo.download(pdo.index, 0, b"\0")
        for number, entry in enumerate(pdo.entries, 1):
            value = entry.index << 16 | entry.subindex << 8 | entry.bits
            yield from sdo.download(pdo.index, number, value.to_bytes(4, "little"))
        yield from sdo.download(pdo.index, 0, bytes((len(pdo.entries),)))

    def _open_process_data(self, slave: BusSlave) -> Steps[None]:
        configuration, position = slave.configuration, slave.position
        lengths = self._image.lengths(position)
        for manager in configuration.sync_managers:
            area = SyncManagerArea(manager.start, lengths[manager.number], manager.control)
            registers = _sync_manager(area, enable=bool(area.length))
            yield from write(slave.station, SM_BASE + _SM_SIZE * manager.number, registers)
        if configuration.watchdog_ms is not None:
            units = min(configuration.watchdog_ms * _WATCHDOG_UNITS, 0xFFFF)
            watchdog = Register.PROCESS_WATCHDOG
            yield from write(slave.station, watchdog, units.to_bytes(2, "little"))
        try:
            fmmus = self._image.fmmus(position, slave.facts.fmmus)
        except ValueError as fault:
            raise BusError(str(fault)) from None
        if fmmus:  # a coupler has none
            yield from write(slave.station, FMMU_BASE, b"".join(each.encode() for each in fmmus))
        slave.reads_mailbox_bit = any(each.physical == _MAILBOX_STATE for each in fmmus)

    def _start_clock(self, slave: BusSlave) -> Steps[None]:
        clock = slave.configuration.clock
        if clock is None or not slave.facts.has_clock:
            return
        yield from self._settle(slave)
        yield from start_sync(slave, clock, self._bus.cycle_ns)

    def _settle(self, slave: BusSlave) -> Steps[None]:
        """Wait until the clock is close to the reference; after a time go on with a warning."""
        start = yield from now()
        corrected = False
        while True:
            number = yield from read_number(slave.station, Register.SYSTEM_TIME_DIFFERENCE)
            slave.clock_difference_ns = difference_of(number)
            if abs(slave.clock_difference_ns) <= self._bus.clock_window_ns:
                return
            if not corrected:
                corrected = True
                yield from correct_offset(slave)
            elif (yield from now()) - start > self._bus.settle_ns:
                self._clock_warning(slave)
                return
            yield Pause(_CLOCK_POLL_NS)


_MAILBOX_STATE = SM_BASE + _SM_SIZE + 5
"""Status of SyncManager 1."""


def stop_sync_if(slave: BusSlave) -> Steps[None]:
    """No SYNC signals, where there is a clock."""
    if slave.facts.has_clock:
        yield from stop_sync(slave.station)


def mailbox_registers(out: SyncManagerArea, into: SyncManagerArea) -> bytes:
    """SyncManagers 0 and 1 for a mailbox."""
    return _sync_manager(out) + _sync_manager(into)


def _sync_manager(area: SyncManagerArea, enable: bool = True) -> bytes:
    return struct.pack("<HHBBBB", area.start, area.length, area.control, 0, _ENABLED * enable, 0)
