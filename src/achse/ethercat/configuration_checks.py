"""Checks of a slave before it changes state: what the master configured must fit the device.

Source: 001 §2.4, §2.5, table 2.10.1.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from achse.codes import AlStatus
from achse.ethercat.application import Application, FileApplication
from achse.ethercat.description import SlaveMemory, SyncManagerArea
from achse.ethercat.esc import Esc
from achse.ethercat.process_buffers import ProcessBuffer
from achse.ethercat.registers import DIGITAL_OUTPUTS, RAM_BASE
from achse.ethercat.statemachine import Transition
from achse.ethercat.syncmanager import SyncManager

_NO_ERROR = AlStatus.NO_ERROR

_LEAST_MAILBOX = 34
"""Shortest mailbox in which the services work, bytes."""


@dataclass(frozen=True, eq=False)
class ConfigurationChecks:
    """The checks of one slave: each returns `NO_ERROR`, or the code of the first fault."""

    application: Application
    esc: Esc
    memory: SlaveMemory
    buffers: Sequence[ProcessBuffer]

    def before(self, transition: Transition) -> AlStatus:
        """Check what a transition needs, before the application is called."""
        match transition:
            case Transition.IP:
                return self.mailbox()
            case Transition.IB:
                return self.bootstrap()
            case Transition.PS:
                return self.safe_op()
            case Transition.SO:
                return self.sync0()
        return _NO_ERROR

    def mailbox(self) -> AlStatus:
        """Check the SyncManagers of the mailbox, if the device has one."""
        mailbox = self.memory.mailbox()
        if mailbox is None:
            return _NO_ERROR
        return self._mailbox_areas(*mailbox)

    def bootstrap(self) -> AlStatus:
        """Check that the device has that state, and that the mailboxes are those of it."""
        files, mailbox = self.application, self.memory.mailbox()
        if mailbox is None or not (isinstance(files, FileApplication) and files.bootstrap):
            return AlStatus.NO_BOOTSTRAP
        (out, _), (into, _) = mailbox
        return self._mailbox_areas((out, self.memory.boot_out), (into, self.memory.boot_in))

    def process_data(self) -> AlStatus:
        """Check that the SyncManagers of process data are as long as what is mapped."""
        for buffer in self.buffers:
            sync_manager, size = self.esc.sync_managers[buffer.number], buffer.size()
            length = sync_manager.length if sync_manager.enabled else 0
            if length != size or (size and not self._placed(sync_manager, buffer.area)):
                return buffer.fault
        return _NO_ERROR

    def safe_op(self) -> AlStatus:
        """Check process data as mapped, and the cycle of SYNC0 if that is on."""
        code = self.process_data()
        clock = self.esc.clock
        if code is _NO_ERROR and clock.sync0_on and not clock.cycle_ns:
            return AlStatus.SYNC_CYCLE
        return code

    def sync0(self) -> AlStatus:
        """Check that SYNC0 comes: on before its start time, and in its place."""
        clock = self.esc.clock
        lost = clock.sync0_on and (clock.sync0_due_ns is None or clock.astray)
        return AlStatus.SYNCHRONIZATION if lost else _NO_ERROR

    def _mailbox_areas(self, *areas: tuple[int, SyncManagerArea]) -> AlStatus:
        for number, area in areas:
            sync_manager = self.esc.sync_managers[number]
            if not (
                sync_manager.is_like(area.control)
                and sync_manager.enabled
                and sync_manager.start == area.start
                and min(_LEAST_MAILBOX, area.length) <= sync_manager.length <= area.length
            ):
                return AlStatus.MAILBOX_CONFIGURATION
        return _NO_ERROR

    def _placed(self, sync_manager: SyncManager, area: SyncManagerArea) -> bool:
        """Return True if mode and direction are right, three buffers fit into memory, no mailbox is
        overlaid."""
        return (
            sync_manager.is_like(area.control)
            and sync_manager.start >= min(area.start, RAM_BASE)
            and sync_manager.start >= DIGITAL_OUTPUTS
            and sync_manager.start + 3 * sync_manager.length <= self.esc.ram_end
            and all(
                other is sync_manager
                or not other.guards
                or sync_manager.end <= other.start
                or other.end <= sync_manager.start
                for other in self.esc.sync_managers
            )
        )
