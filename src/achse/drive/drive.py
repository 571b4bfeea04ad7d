"""Drive: one virtual servo drive with objects, process data, states and a step.

It knows no bus. A slave hosts it by structure: SDO access is `read_object` and `write_object`,
process data are `write_outputs` and `read_inputs`, `enter` sets the state of communication, `step`
lets time pass. Everything between is the kernel (achse.drive.kernel) on one record.
"""

import math
from collections import deque
from collections.abc import Callable, Iterable, Mapping, MutableMapping, Sequence
from struct import Struct
from typing import TYPE_CHECKING

from achse.codes import AbortCode, AlState, AlStatus, FileRefusal, FoeError, SdoAbort
from achse.codes.cia import Number
from achse.drive.alarms import Alarm, Warn
from achse.drive.faults import FaultSwitches
from achse.drive.firmware import LONGEST_FIRMWARE, Firmware
from achse.drive.identity import DriveIdentity
from achse.drive.kernel import cycle
from achse.drive.machine import EncoderKind, Mechanics, apply, power_up, scale
from achse.drive.mapping import PdoMapping, ProcessData
from achse.drive.objects import OBJECTS, ROWS, find
from achse.drive.objects.dictionary import Object
from achse.drive.power import PowerState
from achse.drive.record import FIELDS, DriveFields, DriveSlots, collector, distributor

if TYPE_CHECKING:
    from achse.drive.compiled import Bank, CompiledRecord

LONGEST_CYCLE_NS = 1_000_000
"""A longer step is done in equal cycles of at most this; the plant's parts are 125 µs or less."""

_LOCAL_CYCLE_NS = 250_000
_SYNC_CYCLES_NS = range(250_000, 4_000_001, 250_000)
_STORE_NS = 500_000_000
_CLEAR_NS = 100_000_000

_EMERGENCY = Struct("<HB5x")
_UNREAD = 64
"""Emergencies buffered for a master that reads none; the newest count."""

_MISSED, _RECEIVED = 3, 1
_MOST_MISSED = 0xFFFF
_SERVICE_REQUEST = FIELDS["service_request"].offset

_LASTING = (
    "communication",
    "main_power",
    "safety_1",
    "safety_2",
    "inputs_on",
    "inputs_off",
    "probe_input",
    "encoder_fault",
    "alarm_forced",
    "warnings_forced_1",
    "warnings_forced_2",
    "jammed",
    "external_load",
    "yaw_alarm",
    "motor_position",
    "motor_velocity",
    "sync_type",
    "sync_cycle",
    "reset_command",
    "encoder_clear_command",
    "commands",
)
"""Record fields that a reset of the drive keeps: the drive's environment."""

_STATES = tuple(PowerState)

_IDLE, _SENT, _RUNNING, _DONE, _REFUSED, _FAILED = 0, 1, 2, 4, 16, 32


class Drive:
    """A virtual servo drive.

    `machine` is what it moves. `parameters` presets writable objects, by index or (index,
    subindex). `store` keeps what 1010h saves, by index << 8 | subindex, over power cycles; one that
    raises OSError is an alarm (AL.860).
    `strict_mapping` False accepts what some masters do beyond the manual (achse.drive.mapping).
    `voltage_bit` is the value of statusword bit 4 while main power is normal: 0 in the manual, 1 in
    CiA 402. `mapping` has entries of 1600h … 1A03h other than the manual's. `firmware` is its file.
    `compiled` runs the kernel as machine code; it needs llvmlite and seconds the first
    time. The drives of one segment share a `Bank` of memory, which does their steps in one call.
    """

    local_cycle_ns = _LOCAL_CYCLE_NS

    def __init__(
        self,
        machine: Mechanics | None = None,
        *,
        name: str = "Virtual servo drive",
        identity: DriveIdentity | None = None,
        parameters: Mapping[int | tuple[int, int], Number] | None = None,
        store: MutableMapping[int, Number] | None = None,
        strict_mapping: bool = True,
        voltage_bit: int = 0,
        mapping: Mapping[int, Sequence[int]] | None = None,
        compiled: "bool | Bank" = False,
        firmware: Firmware | None = None,
    ) -> None:
        self.name = name
        self.identity = identity or DriveIdentity()
        self.machine = machine or Mechanics()
        self.firmware = firmware or Firmware()
        """The file that a master reads and writes by mailbox."""
        self._record: DriveFields
        self._compiled: CompiledRecord | None = None
        self._turn = -1
        if compiled:
            from achse.drive import compiled as machine_code

            bank = machine_code.Bank(1) if compiled is True else compiled
            self._record = self._compiled = machine_code.CompiledRecord(bank, self._service)
        else:
            self._record = DriveSlots()
        self.faults = FaultSwitches(self)
        self.local = False
        """True while the drive is operated at its panel: it is not in communication mode
        (0x8000)."""
        self.state = AlState.INIT
        self.sync_error_counter = 0
        self.missed_events = 0
        """SM2 events that did not come since Op was entered (1C32h:0Bh)."""
        self.sync_error = False
        """True if lost synchronization ended Op (1C32h:20h), until Op is entered again."""
        self._strict = strict_mapping
        self._voltage_bit = voltage_bit
        self._presets = dict(parameters or {})
        self._store: MutableMapping[int, Number] = {} if store is None else store
        self._own_mapping = dict(mapping or {})
        self.mapping = self._first_mapping()
        self._emergencies: deque[bytes] = deque(maxlen=_UNREAD)
        self._outputs: bytes | None = None
        self._inputs: bytes | None = None
        self._elapsed_ns = 0
        self._dt, self._count = 0.0, 0
        self._storing_ns = 0
        self._clearing_ns = 0
        self._cleared_turns = 0
        self._reported_alarms = 0
        self._reported_resets = 0
        self._commands_seen = 0
        self._busy = False
        self._reset_due = False
        self._clear_due = False
        self._synchronous = False
        self._rx_data: ProcessData
        self._tx_data: ProcessData
        self._distribute: Callable[[tuple[Number, ...]], None]
        self._collect: Callable[[], tuple[Number, ...]]
        self._start()
        self.record.motor_position = self.machine.position * self.record.counts_per_inc
        self._take_encoder()
        self._take_mapping()

    @property
    def record(self) -> DriveFields:
        """The state of the drive, all steps done."""
        self._settle()
        return self._record

    def _settle(self) -> None:
        if self._compiled is not None and self._turn == self._compiled.bank.turn:
            self._compiled.bank.settle()

    # -- objects -----------------------------------------------------------------------------

    def objects(self) -> Iterable[Object]:
        """Return the dictionary, by ascending index."""
        return OBJECTS

    def read_object(self, index: int, subindex: int) -> bytes:
        """Return the value as little-endian bytes; raises `SdoAbort`."""
        row = find(index, subindex)
        return row.type.pack(row.get(self))

    def write_object(self, index: int, subindex: int, data: bytes) -> None:
        """Take over a value as little-endian bytes; raises `SdoAbort`, also for a wrong length."""
        row = find(index, subindex)
        if row.writable and 8 * len(data) != row.type.bits:
            raise SdoAbort(AbortCode.UNSUPPORTED_ACCESS)
        self.set(index, row.type.unpack(data) if row.writable else 0, subindex)

    def get(self, index: int, subindex: int = 0) -> Number:
        """Return the value of an object; raises `SdoAbort`."""
        return find(index, subindex).get(self)

    def set(self, index: int, value: Number, subindex: int = 0) -> None:
        """Write an object as an SDO does; raises `SdoAbort`.

        While 1010h stores, writes are ignored; so are those to objects the RxPDO updates in Op.
        """
        row = find(index, subindex)
        if not row.writable:
            raise SdoAbort(AbortCode.READ_ONLY)
        row.check(value)
        if self._storing_ns or (self.state == AlState.OP and row.key in self._rx_data.keys):
            return
        changes = row.restart and row.get(self) != value
        row.put(self, value)
        if changes:
            self.faults.warning(Warn.RESTART_REQUIRED)
        if index < 0x2000:
            self._take_mapping()

    @property
    def storing(self) -> bool:
        """True while 1010h stores."""
        return self._storing_ns > 0

    def save(self) -> None:
        """Store all parameters; done half a second later."""
        self._storing_ns = _STORE_NS
        self._busy = True

    def request_reset(self) -> None:
        """Reset the drive with the next step (3215h)."""
        self._reset_due = self._busy = True
        self.record.reset_state = 1

    def request_encoder_clear(self) -> None:
        """Clear the turns of a multi-turn encoder (3200h)."""
        self._clear_due = self._busy = True
        self.record.encoder_clear_state = _SENT

    # -- files -------------------------------------------------------------------------------

    @property
    def bootstrap(self) -> bool:
        """True if the drive has the state Bootstrap; the drive of the manual does not."""
        return self.firmware.bootstrap

    @property
    def longest_file(self) -> int:
        """Bytes of the longest file."""
        return LONGEST_FIRMWARE

    @property
    def programming(self) -> tuple[int, int] | None:
        """Number of firmware bytes programmed, and of all; None while nothing is programmed."""
        return self.firmware.programming

    def read_file(self, name: str, password: int) -> bytes:
        """Return the firmware; raises `FileRefusal`."""
        self.firmware.check(name, password)
        return self.firmware.content

    def begin_file(self, name: str, password: int) -> None:
        """Raise `FileRefusal` for a file that must not be written, or not in this state."""
        self.firmware.check(name, password)
        if self.firmware.bootstrap and self.state != AlState.BOOT:
            raise FileRefusal(FoeError.BOOTSTRAP_ONLY)
        if self.state > AlState.BOOT:
            raise FileRefusal(FoeError.ILLEGAL, "firmware is written in PreOp")

    def write_file(self, name: str, data: bytes) -> None:
        """Program other firmware, which takes its time. Raises `FileRefusal`."""
        self.firmware.program(data)
        self._busy = True

    @property
    def power_state(self) -> PowerState:
        """State of the power drive system."""
        return _STATES[self.record.power_state]

    # -- process data and states -------------------------------------------------------------

    @property
    def output_size(self) -> int:
        """Bytes the master sends."""
        return self._rx_data.size

    @property
    def input_size(self) -> int:
        """Bytes the master gets."""
        return self._tx_data.size

    def write_outputs(self, data: bytes) -> None:
        """Store the master's outputs, `output_size` bytes, for the next step."""
        self._outputs = data

    def read_inputs(self) -> bytes:
        """Inputs for the master, `input_size` bytes, as the last step left them."""
        if self._inputs is None and self._compiled is not None:
            bank = self._compiled.bank
            if self._turn == bank.turn:
                bank.settle()
            if self._inputs is None:
                return self._compiled.newest_inputs()
        return self._inputs or b""

    def take_emergency(self) -> bytes | None:
        """Return the oldest emergency message, 8 bytes (001 §2.7); None if there is none."""
        self._settle()
        return self._emergencies.popleft() if self._emergencies else None

    def enter(self, state: AlState, sync0_ns: int, cause: AlStatus) -> AlStatus:
        """Communication is about to enter `state`.

        The way up is refused while the drive is operated locally, and with a Sync0 cycle that it
        cannot keep. Leaving Op while Operation enabled is a fault (001 table 2.4.3 note 2), Init
        takes the power state to Switch on disabled (note 1).
        """
        if state > self.state:
            if self.local:
                return AlStatus.NOT_IN_COMMUNICATION_MODE
            if state >= AlState.SAFEOP and sync0_ns and sync0_ns not in _SYNC_CYCLES_NS:
                return AlStatus.SYNC_CYCLE
        record = self.record
        if cause is AlStatus.SYNCHRONIZATION:
            self.sync_error = True
        if state == AlState.OP:
            record.communication_lost = 0
            self.missed_events = 0
            self.sync_error = False
        elif self.state == AlState.OP:
            if record.power_state == PowerState.OPERATION_ENABLED:
                record.communication_lost = 1
            self._outputs = None
        self.state = state
        record.communication = int(AlState.INIT if state == AlState.BOOT else state)
        self.mapping.open = state == AlState.PREOP
        self.sync_error_counter = 0
        record.sync_type = 2 if sync0_ns else 0
        self._synchronous = sync0_ns > 0 and state == AlState.OP
        record.sync_cycle = sync0_ns or _LOCAL_CYCLE_NS
        if sync0_ns:
            self._take_period(sync0_ns)
        self._pack_inputs()
        return AlStatus.NO_ERROR

    def _take_period(self, cycle_ns: int) -> None:
        """Accept the Sync0 cycle as communication cycle, in 60C2h too.

        There 250 µs is 25 and -5, 1 ms is 1 and -3. A few cycles have no such form, 2.75 ms
        for one; 60C2h then stays as it is.
        """
        self.record.communication_cycle = cycle_ns * 1e-9
        for exponent in (-3, -4, -5):
            value, rest = divmod(cycle_ns, 10 ** (9 + exponent))
            if not rest and value <= 255:
                self.record.interpolation_value = value
                self.record.interpolation_index = exponent
                return

    def step(self, elapsed_ns: int) -> AlStatus:
        """Let time pass; an AL status other than NO_ERROR ends Op."""
        compiled = self._compiled
        if compiled is not None and self._turn == compiled.bank.turn:
            compiled.bank.settle()
        status = AlStatus.NO_ERROR
        outputs = self._outputs
        self._outputs = None
        if self._synchronous:
            status = self._supervise(outputs is not None)
        if self.local and self.state > AlState.INIT:
            status = AlStatus.NOT_IN_COMMUNICATION_MODE
        if elapsed_ns != self._elapsed_ns:
            self._elapsed_ns = elapsed_ns
            self._count = -(-elapsed_ns // LONGEST_CYCLE_NS)
            self._dt = elapsed_ns * 1e-9 / self._count if self._count else 0.0
        if compiled is not None and compiled.mapped:
            compiled.postpone(outputs, self._dt, self._count, self._busy)
            self._turn = compiled.bank.turn
            self._inputs = None
            return status
        if outputs is not None:
            self._distribute(self._rx_data.layout.unpack(outputs))
            self._record.fresh_outputs = 1
        if compiled is not None:
            compiled.postpone(None, self._dt, self._count, True)
            compiled.bank.settle()
            return status
        for _ in range(self._count):
            cycle(self._record, self._dt)
        if self._busy or self._record.service_request:
            self._service()
        else:
            self._pack_inputs()
        return status

    def kernel_record(self, elapsed_ns: int) -> "CompiledRecord | None":
        """Return its record, if steps of `elapsed_ns` may be done in the kernel by others now.

        That is with outputs in each step, while nothing takes its time and no service is requested.
        """
        compiled = self._compiled
        self._settle()
        if (
            compiled is None
            or not compiled.mapped
            or not self._synchronous
            or self._busy
            or self.local
            or self.sync_error_counter
            or self._outputs is None
            or self._elapsed_ns != elapsed_ns
            or self._emergencies
            or compiled.ints[_SERVICE_REQUEST]
        ):
            return None
        return compiled

    def take_steps(self, outputs: bytes | None) -> None:
        """Catch up with the kernel's steps; `outputs` came since the last one, None: none yet."""
        self._outputs, self._inputs = outputs, None
        if self._record.service_request:
            self._service()

    def _supervise(self, received: bool) -> AlStatus:
        """SM2 events that are missing count; those in the counter of 10F1h 3, received ones -1."""
        counter = self.sync_error_counter
        limit = self._record.sync_error_limit
        if not received:
            self.missed_events = min(self.missed_events + 1, _MOST_MISSED)
        if not limit:
            return AlStatus.NO_ERROR
        if not received:
            counter = min(limit, counter + _MISSED)
        elif counter < limit:
            counter = max(0, counter - _RECEIVED)
        self.sync_error_counter = counter
        return AlStatus.NO_ERROR if counter < limit else AlStatus.SYNCHRONIZATION

    def _service(self) -> None:
        """Handle what the kernel reports after a step, and what takes its time."""
        record, elapsed_ns = self._record, self._elapsed_ns
        record.service_request = 0
        if record.alarm_count != self._reported_alarms:
            self._reported_alarms = record.alarm_count
            self._send_emergency(record.error_code, 1)
        if record.reset_count != self._reported_resets:
            self._reported_resets = record.reset_count
            self._send_emergency(0, 0)
        seen = self._commands_seen
        if record.commands & ~seen & 1:
            self.request_reset()
        if record.commands & ~seen & 2:
            self.request_encoder_clear()
        self._commands_seen = record.commands
        if self._storing_ns:
            self._storing_ns = max(0, self._storing_ns - elapsed_ns)
            if not self._storing_ns:
                self._keep()
        if self._clearing_ns:
            self._clearing_ns = max(0, self._clearing_ns - elapsed_ns)
            self._go_on_clearing()
        if self._reset_due:
            self._reset_due = False
            self._reset()
        if self._clear_due:
            self._clear_due = False
            self._clearing_ns = _CLEAR_NS
            self._go_on_clearing()
        self.firmware.advance(elapsed_ns)
        self._busy = (
            self._storing_ns > 0 or self._clearing_ns > 0 or self.firmware.programming is not None
        )
        self._pack_inputs()

    def _keep(self) -> None:
        try:
            self._store.update({row.key: row.get(self) for row in ROWS if row.stored})
        except OSError:
            self.faults.alarm(Alarm.WRITE_DATA_FAIL_ERROR, lasting=False)

    def _send_emergency(self, code: int, register: int) -> None:
        if self._record.diagnosis_flags & 1 and self.state >= AlState.PREOP:
            self._emergencies.append(_EMERGENCY.pack(code, register))

    def _go_on_clearing(self) -> None:
        """Continue 3200h: refused while the motor is enabled, failed without multi-turn encoder."""
        record = self.record
        enabled = PowerState.OPERATION_ENABLED <= record.power_state < PowerState.FAULT
        if enabled:
            running = record.encoder_clear_state == _RUNNING
            record.encoder_clear_state = _FAILED if running else _REFUSED
            self._clearing_ns = 0
        elif self.machine.encoder.kind is not EncoderKind.MULTI_TURN or record.encoder_fault:
            record.encoder_clear_state = _FAILED
            self._clearing_ns = 0
        elif self._clearing_ns:
            record.encoder_clear_state = _RUNNING
        else:
            record.encoder_clear_state = _DONE
            self._cleared_turns = (
                math.floor(record.motor_position + 0.5) // self.machine.encoder.resolution
            )
            self.faults.clear(Alarm.BATTERY_ERROR)

    # -- power-on and reset ------------------------------------------------------------------

    def _first_mapping(self) -> PdoMapping:
        """Return the mapping after power-on: the manual's, or another one, and what was stored."""
        mapping = PdoMapping(strict=self._strict)
        for index, entries in self._own_mapping.items():
            key = index << 8
            mapping.restore({key: len(entries), **dict(enumerate(entries, key + 1))})
        mapping.restore(self._store)
        return mapping

    def power_cycle(self) -> None:
        """Switch the drive off and on: stored parameters and mapping, encoder as after power-on."""
        self.state = AlState.INIT
        self.record.communication = int(AlState.INIT)
        self.mapping = self._first_mapping()
        self._emergencies.clear()
        self._outputs = None
        self._storing_ns = 0
        self._reset()

    def _reset(self) -> None:
        """Begin again with stored parameters (transition 0); communication and mapping stay."""
        self.firmware.abandon()
        self._start()
        self._take_encoder()
        self._take_mapping()

    def _start(self) -> None:
        record = self.record
        lasting = {name: getattr(record, name) for name in _LASTING}
        for name, slot in FIELDS.items():
            if slot.length:
                for n in range(slot.length):
                    getattr(record, name)[n] = slot.default
            else:
                setattr(record, name, slot.default)
        for row in ROWS:
            if row.field and row.writable:
                setattr(record, row.field, row.default)
        self._derive()
        for key, value in self._presets.items():
            index, subindex = key if isinstance(key, tuple) else (key, 0)
            row = find(index, subindex)
            row.check(value)
            setattr(record, row.field, value)
        for row in ROWS:
            if row.stored and row.field and row.key in self._store:
                setattr(record, row.field, self._store[row.key])
        for name, value in lasting.items():
            setattr(record, name, value)
        self.faults.warning(Warn.RESTART_REQUIRED, False)
        record.voltage_bit = self._voltage_bit
        self._reported_alarms = self._reported_resets = 0
        self._clearing_ns = 0
        self._reset_due = self._clear_due = False
        apply(self.machine, record)
        scale(self.machine, record)
        for row in ROWS:  # 60C2h sets the interpolation period
            if row.index == 0x60C2 and row.write is not None:
                row.write(self, row.get(self))
        if record.sync_type:
            self._take_period(record.sync_cycle)

    def _derive(self) -> None:
        """Set the parameters whose default depends on the machine."""
        record, machine = self.record, self.machine
        peak = round(1000.0 * machine.motor.peak)
        record.inertia_ratio = min(20_000, machine.inertia_ratio)
        record.max_torque = record.positive_torque_limit = record.negative_torque_limit = peak
        record.max_profile_velocity = round(machine.max_velocity)
        if not machine.linear:
            record.deviation_alarm = 5 * machine.encoder.resolution

    def _take_encoder(self) -> None:
        power_up(self.machine, self.record, self._cleared_turns)

    def _take_mapping(self) -> None:
        self._rx_data = self.mapping.rx_data
        self._tx_data = self.mapping.tx_data
        self._settle()
        self._distribute = distributor(self._record, self._rx_data.places)
        self._collect = collector(self._record, self._tx_data.fields)
        if self._compiled is not None:
            self._compiled.map(self._rx_data, self._tx_data)
        self._pack_inputs()

    def _pack_inputs(self) -> None:
        self._inputs = self._tx_data.layout.pack(*self._collect())

    def __repr__(self) -> str:
        state = self.power_state.name.lower().replace("_", " ")
        return f"<Drive {self.name!r} {self.state.name}, {state}, at {self.record.position_actual}>"
