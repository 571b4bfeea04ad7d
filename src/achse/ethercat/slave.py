"""A slave: an application behind a slave controller, with state machine, mailbox and local cycle.

Source: 001 §2.4, §2.5, table 2.10.1.
"""

from collections.abc import Callable
from functools import partial

from achse.codes import AlState, AlStatus, ErrorLight
from achse.ethercat.application import (
    Application,
    FileApplication,
    MessagingApplication,
    QuietApplication,
)
from achse.ethercat.clock import Instant
from achse.ethercat.coe import CoeServer
from achse.ethercat.configuration_checks import ConfigurationChecks
from achse.ethercat.description import LAYOUT, SlaveMemory, SyncManagerLayout, describe
from achse.ethercat.esc import Esc
from achse.ethercat.foe import FoeServer
from achse.ethercat.mailbox import MailboxProtocol, MailboxServer
from achse.ethercat.pdi import AlEvent
from achse.ethercat.process_buffers import ProcessBuffer, process_buffers
from achse.ethercat.registers import RESOURCES, ControllerResources, Register
from achse.ethercat.sii import build_sii
from achse.ethercat.statemachine import Light, Transition, request

_NONE = -1
"""Number of a SyncManager that a slave does not have."""

_STATE = 0x0F
_ACKNOWLEDGE = 0x10
_IDENTIFICATION = 0x20

_EMULATION = 0x01
"""Bit of the ESC configuration: the controller takes over states, without a program."""
_STATES = {int(state): state for state in AlState}

_OUTPUTS_WITHIN_NS = 100_000_000
"""Longest time that a request for Op waits for the first outputs, ns."""

_BOOT_SERVICES = frozenset((MailboxProtocol.FOE,))
_NEVER = 1 << 62
_NO_ERROR = AlStatus.NO_ERROR
_UNDISTURBED = AlState.OP, _NO_ERROR, False, None, False, False, True


class Slave:
    """One slave of a segment.

    `alias` is the setting of the rotary switches, 0 for the alias in the EEPROM. `sii` is the
    EEPROM's content if it is not to be made from the application; `memory` its SyncManagers if they
    are others than those of `layout`. Without `coe` the mailbox refuses that protocol.
    `mailbox_delay_ns` lets the application take its time for each message.
    """

    def __init__(
        self,
        application: Application,
        *,
        alias: int = 0,
        sii: bytes | None = None,
        layout: SyncManagerLayout = LAYOUT,
        memory: SlaveMemory | None = None,
        resources: ControllerResources = RESOURCES,
        coe: bool = True,
    ) -> None:
        self.application = application
        self.memory = layout.memory if memory is None else memory
        mailbox = self.memory.mailbox()
        self._has_mailbox = mailbox is not None
        self._mailbox_out, self._mailbox_in = (
            (_NONE, _NONE) if mailbox is None else (mailbox[0][0], mailbox[1][0])
        )
        self.buffers = process_buffers(application, self.memory)
        self._output_buffers = tuple(each for each in self.buffers if each.output)
        self._places = {each.number for each in self.buffers}
        self.mailbox_delay_ns = 0
        self.state = AlState.INIT
        self.error = _NO_ERROR
        self._step = application.step
        self._hung = False
        self._idle_since = 0
        self._pending_request: int | None = None
        self._coe = CoeServer(application)
        self._messaging = application if isinstance(application, MessagingApplication) else None
        self._quiet = application if isinstance(application, QuietApplication) else None
        own = {} if self._messaging is None else self._messaging.services
        services = {**own, MailboxProtocol.COE: self._coe.answer} if coe else dict(own)
        self._foe = FoeServer(application) if isinstance(application, FileApplication) else None
        if self._foe is not None:
            services[MailboxProtocol.FOE] = self._foe.answer
        self._mailbox = MailboxServer(services)
        self._message: bytes | None = None
        self._message_due = 0
        self._outputs: dict[int, bytes] = {}
        """Outputs that came before Op, by SyncManager."""
        self._opening = False
        self._fed_ns = 0
        self._local_cycle_ns = application.local_cycle_ns
        self._patience_ns = _NEVER
        self._timer_due = self._local_cycle_ns
        self._sync0_due = _NEVER
        self.due_ns = self._timer_due
        """Time at which `advance` has something to do."""
        image = sii or build_sii(describe(application, layout))
        self.esc = Esc(self, image, resources=resources, alias=alias)
        self._checks = ConfigurationChecks(application, self.esc, self.memory, self.buffers)
        self._time = self.esc.time
        self._sinks = {each.number: self._operating(each) for each in self._output_buffers}
        self.esc.power_up()

    # the lights

    @property
    def run_light(self) -> Light:
        return Light(self.state)

    @property
    def error_light(self) -> ErrorLight:
        """The ERR light."""
        return self.error.light if self.esc.operational else ErrorLight.FLICKERING

    def join(self, time: Instant) -> None:
        """Share the time of a segment."""
        self._time = self.esc.time = self.esc.clock.time = time
        self._fed_ns = time.now_ns
        self._timer_due = time.now_ns + self._local_cycle_ns
        self._plan_steps()

    # AL control: requests of the master

    def al_control(self, request_word: int) -> None:
        """Process the state that the master requests (`Pdi`)."""
        if self._hung:
            self._pending_request = request_word
            return
        self.esc.acknowledge(AlEvent.AL_CONTROL)
        if self.error is not _NO_ERROR:
            if not request_word & _ACKNOWLEDGE:
                return
            self.error = _NO_ERROR
        self._opening = False
        if self._emulated:
            state = _STATES.get(request_word & _STATE, self.state)
            if state is not self.state:
                self.application.enter(state, self.esc.clock.cycle_ns, _NO_ERROR)
            self._settle(state, _NO_ERROR)
            return
        meaning = request(self.state, request_word & _STATE)
        if isinstance(meaning, AlStatus):
            # of Op the manual's table has no error state: what is refused there ends in SafeOp
            down = self.state is AlState.OP and meaning is AlStatus.INVALID_CHANGE
            if down:
                self.application.enter(AlState.SAFEOP, self.esc.clock.cycle_ns, meaning)
            self._settle(AlState.SAFEOP if down else self.state, meaning)
        else:
            self._change(meaning)
        if request_word & _IDENTIFICATION:
            self.esc.set_al_status(self.state, self.error, self.esc.alias)

    @property
    def _emulated(self) -> bool:
        """True if the controller has no program behind it."""
        return bool(self.esc.memory[Register.ESC_CONFIGURATION] & _EMULATION)

    def _change(self, transition: Transition) -> None:
        if transition is Transition.SO and not self._outputs_valid:
            # complete once outputs come, refused if none come in time
            self._opening = True
            self._fed_ns = self._time.now_ns
            self._plan_steps()
            return
        target = transition.target
        code = self._checks.before(transition)
        if code is _NO_ERROR:
            code = self.application.enter(target, self.esc.clock.cycle_ns, code)
            if target < self.state:
                code = _NO_ERROR  # the way down is always open
        if code is AlStatus.NOT_IN_COMMUNICATION_MODE:
            self._fall(code)
        else:
            self._settle(target if code is _NO_ERROR else self.state, code)

    def fail(self, code: AlStatus) -> None:
        """Fall to the result state of an error of the slave, and show its code."""
        self._fall(code)

    def _fall(self, code: AlStatus) -> None:
        self._opening = False
        result = code.result
        target = self.state if result is None or result > self.state else result
        if target is not self.state:
            self.application.enter(target, self.esc.clock.cycle_ns, code)
        self._settle(target, code)

    def _settle(self, state: AlState, code: AlStatus) -> None:
        """Enter `state`: let its SyncManagers work, show state and code."""
        before = self.state
        self.state = state
        self.error = code
        esc = self.esc
        if before is not state:
            mailbox = state is not AlState.INIT
            if mailbox and before is AlState.INIT:
                self._mailbox.reset()
                self._message = None
                self.reset_services()
                self._mailbox.only = _BOOT_SERVICES if state is AlState.BOOT else None
            if self._has_mailbox:
                esc.lock(self._mailbox_out, not mailbox)
                esc.lock(self._mailbox_in, not mailbox)
            self._open_process_data()
            if state is AlState.OP:
                self._fed_ns = self._time.now_ns
                esc.set_watchdog(expired=False)
                for number, data in self._outputs.items():
                    sink = esc.sync_managers[number].sink
                    assert sink is not None
                    sink(data)
        self._plan_steps()
        esc.set_al_status(state, code)

    def reset_services(self) -> None:
        """Start the mailbox protocols with the lengths that the master configured."""
        if not self._has_mailbox:
            return
        sync_managers = self.esc.sync_managers
        lengths = [sync_managers[each].length for each in (self._mailbox_out, self._mailbox_in)]
        self._coe.reset(lengths[1])
        if self._foe is not None:
            self._foe.reset(*lengths)

    def _open_process_data(self) -> None:
        """Connect the process data to the application as the state has it."""
        esc = self.esc
        closed = self.state < AlState.SAFEOP
        operating = self.state is AlState.OP
        if not operating:
            self._outputs = {}
        for buffer in self.buffers:
            number = buffer.number
            sync_manager = esc.sync_managers[number]
            if self._emulated and sync_manager.length != buffer.size():
                buffer = buffer.resized(sync_manager.length)
            if buffer.output:
                sink = self._sinks[number] = self._operating(buffer)
                sync_manager.sink = sink if operating else partial(self._preview, number)
            else:
                sync_manager.source = buffer.reader()
            esc.lock(number, closed)
        esc.remapped()

    @property
    def _outputs_valid(self) -> bool:
        """True if the master sends outputs, and the watchdog has not expired since the last
        ones."""
        if any(each.size() and each.number not in self._outputs for each in self._output_buffers):
            return False
        if not self._outputs:
            return True
        return not self._watched or self._time.now_ns - self._fed_ns < self.esc.watchdog_ns

    @property
    def _watched(self) -> bool:
        """True if outputs have to come within the watchdog time."""
        sync_managers = self.esc.sync_managers
        return self.esc.watchdog_ns > 0 and any(
            each.size() and sync_managers[each.number].triggers_watchdog
            for each in self._output_buffers
        )

    # process data

    def _preview(self, number: int, data: bytes) -> None:
        """Store outputs that came in SafeOp, without passing them to the application."""
        self._outputs[number] = data
        self._fed_ns = self._time.now_ns
        if self._opening and self._outputs_valid:
            self._opening = False
            self._change(Transition.SO)

    def _operating(self, buffer: ProcessBuffer) -> Callable[[bytes], None]:
        """Return the receiver of outputs in Op."""
        write = buffer.writer()

        def operate(data: bytes) -> None:
            self._fed_ns = self._time.now_ns
            write(data)

        return operate

    # mailbox and registers (Pdi)

    def written(self, number: int, data: bytes) -> None:
        """Note that the master completed a message or outputs (`Pdi`)."""
        sync_manager = self.esc.sync_managers[number]
        if sync_manager.sink is not None:
            sync_manager.sink(data)
        elif number == self._mailbox_out:
            self._message = data
            self._message_due = self._time.now_ns + self.mailbox_delay_ns
            self._serve()

    def taken(self, number: int) -> None:
        """Note that the master read a message: the next takes its place (`Pdi`)."""
        if number == self._mailbox_in:
            self._serve()

    def looked_at(self, number: int) -> None:
        """Offer an emergency that may have come up: the master polls for a message (`Pdi`)."""
        if number == self._mailbox_in:
            quiet = self._quiet is not None and self._quiet.is_quiet
            if not quiet or self._message is not None or self._mailbox.waiting:
                self._serve()

    def _serve(self) -> None:
        """Answer the message that waits, once all before it has been read; fill the mailbox."""
        if self.state is AlState.INIT or self._hung or not self._has_mailbox:
            return
        esc, mailbox = self.esc, self._mailbox
        outgoing = esc.sync_managers[self._mailbox_in]
        if self.state is not AlState.BOOT and not mailbox.waiting:
            self._send_own()
        if (
            self._message is not None
            and not mailbox.waiting
            and self._time.now_ns >= self._message_due
        ):
            received, self._message = self._message, None
            mailbox.receive(received)
            esc.sync_managers[self._mailbox_out].release()
        if outgoing.works and not outgoing.full and (next_message := mailbox.fetch()) is not None:
            esc.put(self._mailbox_in, next_message)

    def _send_own(self) -> None:
        """Put an emergency, else a message of the application, into the mailbox."""
        mailbox = self._mailbox
        while not mailbox.waiting and (emergency := self.application.take_emergency()) is not None:
            mailbox.send(MailboxProtocol.COE, CoeServer.emergency(emergency))
        if self._messaging is not None and not mailbox.waiting:
            message = self._messaging.take_message()
            if message is not None:
                mailbox.send(*message)

    def sync_manager_changed(self, number: int) -> None:
        """Note that the registers of a SyncManager were written (`Pdi`)."""
        if self._hung:
            return
        self.esc.acknowledge(AlEvent.SYNC_MANAGERS)
        sync_manager = self.esc.sync_managers[number]
        if number in self._sinks:
            self._plan_steps()
        repeated = sync_manager.repeat_request != sync_manager.repeat_acknowledge
        if number == self._mailbox_in and repeated:
            sync_manager.repeat_acknowledge = sync_manager.repeat_request
            if self._mailbox.last is not None and sync_manager.works:
                self.esc.put(number, self._mailbox.last)
        if number in self._places and self._emulated:
            self._open_process_data()
        elif number in self._places and self.state >= AlState.SAFEOP:
            code = self._checks.process_data()
            if code is not _NO_ERROR:
                self._fall(code)

    def timing_changed(self) -> None:
        """Apply new times: SYNC0 or the watchdog was set, or the next SYNC0 event moved (`Pdi`)."""
        self._plan_steps()

    def reset(self) -> None:
        """Note that the master reset the slave controller (`Pdi`): as after a power cycle."""
        if self.state is not AlState.INIT:
            self.application.enter(AlState.INIT, 0, AlStatus.RESTARTED)
        self.state = AlState.INIT
        self.error = _NO_ERROR
        self._opening = False
        self._message = None
        self._pending_request = None
        self._mailbox.reset()
        self.esc.power_up()

    def hang(self, on: bool = True) -> None:
        """Let the device's program hang, or continue.

        The controller answers as before: frames pass and count, registers are read, the last
        inputs are sent. Requests, messages and outputs wait, and the PDI watchdog expires.
        """
        if on == self._hung:
            return
        self._hung = on
        self._step = self._do_nothing if on else self.application.step
        self._idle_since = self._time.now_ns
        if on:
            return
        self.esc.pdi_alive()
        for number in range(len(self.esc.sync_managers)):
            self.sync_manager_changed(number)
        request, self._pending_request = self._pending_request, None
        if request is not None:
            self.al_control(request)
        self._serve()

    def _do_nothing(self, elapsed_ns: int) -> AlStatus:
        """Return a local cycle of a device that hangs."""
        allowed = self.esc.pdi_watchdog_ns
        if allowed and self._time.now_ns + elapsed_ns - self._idle_since >= allowed:
            self.esc.pdi_alive(False)
        return _NO_ERROR

    # time

    def advance(self, now_ns: int) -> None:
        """Let time pass up to `now_ns`: local cycles, SYNC0, watchdog."""
        while (due := self.due_ns) <= now_ns:
            self._time.now_ns = due
            cycle = self._local_cycle_ns
            undisturbed = now_ns < self._fed_ns + self._patience_ns
            if not undisturbed and due >= self._fed_ns + self._patience_ns:
                self._outputs_missing()
            if self._message is not None:
                self._serve()
            if due == self._sync0_due:
                clock = self.esc.clock
                elapsed = clock.cycle_ns
                if elapsed < cycle:  # too short: events are missed
                    elapsed *= -(-cycle // elapsed)
                self._timer_due = _NEVER
                self.due_ns = self._sync0_due = clock.sync0(elapsed) or _NEVER
                if clock.astray and self.state is AlState.OP and not self._hung:
                    self._fall(AlStatus.SYNCHRONIZATION)
                    continue
            else:
                elapsed = cycle
                if undisturbed and now_ns < self._sync0_due:
                    elapsed += (now_ns - due) // cycle * cycle  # all at once
                timer_due = self._timer_due = due + elapsed
                self.due_ns = timer_due if timer_due < self._sync0_due else self._sync0_due
            code = self._step(elapsed)
            if code is not _NO_ERROR:
                self._fall(code)

    @property
    def exchanges_only(self) -> bool:
        """True if frames do nothing to it now but exchange its process data in Op."""
        esc, mailbox = self.esc, self._mailbox
        full = self._has_mailbox and esc.sync_managers[self._mailbox_in].full
        state = self.state, self.error, self._hung, self._message
        return (*state, mailbox.waiting, full, esc.clock.steady) == _UNDISTURBED and all(
            esc.sync_managers[number].sink is sink for number, sink in self._sinks.items()
        )

    def steps_by(self, cycle_ns: int) -> bool:
        """Return True if only process data each `cycle_ns` and the step of SYNC0 happen now."""
        in_step = self.due_ns == self._sync0_due and self.esc.clock.cycle_ns == cycle_ns
        return in_step and self.exchanges_only

    def skip(self, elapsed_ns: int, ahead_ns: int = 0) -> None:
        """Count whole cycles whose steps another kernel did: with outputs, on time.

        Steps were done for `ahead_ns` more.
        """
        self._fed_ns += elapsed_ns
        self.due_ns = self._sync0_due = self.esc.clock.sync0(elapsed_ns + ahead_ns) or _NEVER

    def _plan_steps(self) -> None:
        """Schedule the next local cycle: by SYNC0 once it has come, else by the timer."""
        sync0 = self.esc.clock.sync0_due_ns
        if sync0 is not None:
            self._sync0_due = sync0
        else:
            self._sync0_due = _NEVER
            if self._timer_due == _NEVER:
                self._timer_due = self._time.now_ns + self._local_cycle_ns
        self.due_ns = min(self._timer_due, self._sync0_due)
        self._time.due_ns = min(self._time.due_ns, self.due_ns)
        self._patience_ns = _NEVER
        if self._opening:
            self._patience_ns = _OUTPUTS_WITHIN_NS
        elif self.state is AlState.OP and self._watched:
            self._patience_ns = self.esc.watchdog_ns

    def _switch_off(self) -> None:
        """Switch outputs off until the next ones: watchdog of a controller without a program."""
        for buffer in self._output_buffers:
            buffer.writer()(bytes(buffer.size()))
            self.esc.sync_managers[buffer.number].sink = partial(self._switch_on, buffer.number)
        self._patience_ns = _NEVER
        self.esc.remapped()

    def _switch_on(self, number: int, data: bytes) -> None:
        """Switch outputs on: they come again."""
        self.esc.set_watchdog(expired=False)
        self._open_process_data()
        sink = self.esc.sync_managers[number].sink
        assert sink is not None
        sink(data)
        self._plan_steps()

    def _outputs_missing(self) -> None:
        """Handle missing outputs: in Op the watchdog expires, on the way to Op it is refused."""
        if self.state is AlState.OP:
            self.esc.set_watchdog(expired=True)
            if self._emulated:
                self._switch_off()
            elif not self._hung:
                self.esc.acknowledge(AlEvent.WATCHDOG)
                self._fall(AlStatus.WATCHDOG)
        else:
            self._opening = False
            self._settle(self.state, AlStatus.WATCHDOG)
