"""The register map of the slave controller: address, size, name, and what the master may write.

A register that is `writable` counts as written for the working counter; bytes without one are
read-only. What a write does is bound to the register in `achse.ethercat.esc`.

Source: ETG.1000.4 §6; each register has its clause.
"""

from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property

FMMU_BASE = 0x0600
"""Of the first FMMU, 16 bytes each (§6.6, table 57)."""
SM_BASE = 0x0800
"""Of the first SyncManager, 8 bytes each (§6.7, table 59)."""
RAM_BASE = 0x1000
"""Below are registers, from here process data memory."""
DIGITAL_OUTPUTS = 0x0F00
"""Output data of controllers that are digital terminals by themselves; a SyncManager may begin
here."""

FMMUS, SYNC_MANAGERS, RAM_KIB = 3, 4, 8
"""Resources of the drive's controller (001 §2.2); the manual does not state its memory."""

_PORTS_MII = 0b00_00_11_11
_FEATURES = 0x01FC


@dataclass(frozen=True)
class ControllerResources:
    """Resources of a slave controller; `ports` and `features` are the content of their registers.

    By default those of the drive's controller: ports 0 and 1 are MII, with a clock of 64 bits.
    """

    fmmus: int = FMMUS
    sync_managers: int = SYNC_MANAGERS
    ram_kib: int = RAM_KIB
    ports: int = _PORTS_MII
    features: int = _FEATURES

    def show(self, memory: bytearray) -> None:
        """Write the resources to their registers."""
        for register, value in (
            (Register.FMMU_COUNT, self.fmmus),
            (Register.SYNC_MANAGER_COUNT, self.sync_managers),
            (Register.RAM_SIZE, self.ram_kib),
            (Register.PORT_DESCRIPTOR, self.ports),
            (Register.FEATURES, self.features),
        ):
            register.set(memory, value)


RESOURCES = ControllerResources()
"""Resources of the drive's controller."""


class Register(IntEnum):
    """A register by name, which is the address of its first byte; clauses are of ETG.1000.4.

    `size` in bytes; `title` is the name for people; `default` is the value at power-up,
    little-endian over `size` bytes.
    """

    size: int
    title: str
    writable: bool
    default: int

    def __new__(
        cls, address: int, size: int, title: str, writable: bool = False, default: int = 0
    ) -> "Register":
        member = int.__new__(cls, address)
        member._value_ = address
        member.size = size
        member.title = title
        member.writable = writable
        member.default = default
        return member

    @cached_property
    def end(self) -> int:
        """The address behind its last byte."""
        return self + self.size

    @cached_property
    def place(self) -> slice:
        """Its bytes in the controller's memory."""
        return slice(int(self), self + self.size)

    def get(self, memory: bytearray) -> int:
        """Return the value in a controller's memory."""
        return int.from_bytes(memory[self.place], "little")

    def set(self, memory: bytearray, value: int) -> None:
        """Write the value into a controller's memory."""
        memory[self.place] = value.to_bytes(self.size, "little")

    TYPE = (0x0000, 1, "type", False, 0x11)
    """Type of the controller; 0x11 is an ET1100 (§6.1.1)."""
    REVISION = (0x0001, 1, "revision")
    """Revision of the controller (§6.1.1)."""
    BUILD = (0x0002, 2, "build", False, 2)
    """Build of the controller (§6.1.1)."""
    FMMU_COUNT = (0x0004, 1, "FMMUs supported")
    """Number of FMMUs of the controller (§6.1.1)."""
    SYNC_MANAGER_COUNT = (0x0005, 1, "SyncManagers supported")
    """Number of SyncManagers of the controller (§6.1.1)."""
    RAM_SIZE = (0x0006, 1, "RAM size", False, 8)
    """Process data memory in KiB (§6.1.1)."""
    PORT_DESCRIPTOR = (0x0007, 1, "port descriptor")
    """Two bits for each port: none, not configured, EBUS, MII (§6.1.1)."""
    FEATURES = (0x0008, 2, "features", False, _FEATURES)
    """Distributed clocks with 64 bits, enhanced link detection; LRW works (§6.1.1)."""
    STATION_ADDRESS = (0x0010, 2, "configured station address", True)
    """Station address that FPRD and FPWR use; the master sets it (§6.1.2)."""
    STATION_ALIAS = (0x0012, 2, "configured station alias")
    """A second address, of the switches or the EEPROM; the device sets it (§6.1.2)."""
    REGISTER_PROTECTION = (0x0020, 2, "register write enable, protection", True)
    """Write enable and write protection of the registers."""
    ESC_PROTECTION = (0x0030, 2, "ESC write enable, protection", True)
    """Write enable and write protection of the whole controller."""
    RESET = (0x0040, 1, "ESC reset", True)
    """'R', 'E', 'S' in three writes reset the controller."""
    DL_CONTROL = (0x0100, 4, "DL control", True, 0x0000_0001)
    """Bit 0: destroy frames of other protocols; 8..15: loop control, two bits for each port;
    24: use the alias (§6.1.3)."""
    READ_WRITE_OFFSET = (0x0108, 2, "physical read/write offset", True)
    """Added to the address of one part of a read and write (§6.1.3)."""
    DL_STATUS = (0x0110, 2, "DL status")
    """Bit 0: PDI operational, 1: its watchdog; 4..7: links; 8..15: loops and communication of
    the ports (§6.1.4, table 34)."""
    AL_CONTROL = (0x0120, 2, "AL control", True, 1)
    """The state that the master requests; 4: acknowledge, 5: identification (§6.1.5, R1)."""
    AL_STATUS = (0x0130, 2, "AL status", False, 1)
    """The state of the slave; 4: error, 5: identification shown (§6.1.5, R3)."""
    AL_STATUS_CODE = (0x0134, 2, "AL status code")
    """Reason of the error in AL status, see `AlStatus` (§6.1.5, R6)."""
    LIGHT_OVERRIDE = (0x0138, 2, "RUN and ERR light override", True)
    """Pattern that the RUN and ERR lights show instead of the state."""
    PDI_CONTROL = (0x0140, 1, "PDI control")
    """Kind of the interface to the device; from EEPROM word 0 (§6.1.5, R7)."""
    ESC_CONFIGURATION = (0x0141, 1, "ESC configuration")
    """Device emulation, ports, clocks; from EEPROM word 0."""
    PDI_CONFIGURATION = (0x0150, 4, "PDI configuration")
    """The interface to the device; from EEPROM words 1 and 3 (§6.1.5, R8)."""
    ECAT_EVENT_MASK = (0x0200, 2, "ECAT event mask", True)
    """Events that reach the frames (§6.1.6)."""
    AL_EVENT_MASK = (0x0204, 4, "AL event mask")
    """Events that reach the device, see `AlEvent` (§6.1.6)."""
    ECAT_EVENT_REQUEST = (0x0210, 2, "ECAT event request")
    """Events for the master: latch, DL status, AL status, messages (§6.1.6)."""
    AL_EVENT_REQUEST = (0x0220, 4, "AL event request")
    """Events for the device, see `AlEvent` (§6.1.6)."""
    RX_ERRORS = (0x0300, 12, "RX error counters", True)
    """Invalid frames and forwarded errors of each port; a write clears them (§6.2.1)."""
    PROCESSING_ERRORS = (0x030C, 2, "processing unit and PDI error counters", True)
    """Errors of the processing unit, then of the PDI; a write clears them (§6.2.3)."""
    LOST_LINKS = (0x0310, 4, "lost link counters", True)
    """A byte for each port; a write clears them (§6.2.2)."""
    WATCHDOG_DIVIDER = (0x0400, 2, "watchdog divider", True, 0x09C2)
    """Watchdogs count units of (divider + 2) * 40 ns; 100 µs at first (§6.3.1)."""
    PDI_WATCHDOG = (0x0410, 2, "PDI watchdog time", True, 1000)
    """Longest time without an access of the device, 0 = unlimited (§6.3.2)."""
    PROCESS_WATCHDOG = (0x0420, 2, "process data watchdog time", True, 1000)
    """Longest time without outputs, 0 = unlimited (§6.3.3)."""
    PROCESS_WATCHDOG_STATUS = (0x0440, 2, "process data watchdog status", False, 1)
    """Bit 0: outputs come in time (§6.3.4)."""
    WATCHDOG_COUNTERS = (0x0442, 2, "watchdog counters", True)
    """Expiries of the process data watchdog, then of that of the PDI (§6.3.5)."""
    EEPROM_CONFIGURATION = (0x0500, 1, "EEPROM configuration", True)
    """Bit 0: the EEPROM belongs to the PDI (§6.4.1)."""
    EEPROM_PDI_ACCESS = (0x0501, 1, "EEPROM PDI access")
    """Bit 0: the PDI has access (§6.4.2)."""
    EEPROM = (0x0502, 14, "EEPROM control, address, data", True)
    """Control and status, word address, eight bytes of data (§6.4.3 to §6.4.5)."""
    RECEIVE_TIME_PORT_0 = (0x0900, 4, "receive time port 0", True)
    """A write latches the times when the frame passes (§6.8, table 60)."""
    RECEIVE_TIMES_1_TO_3 = (0x0904, 12, "receive times ports 1 to 3")
    """Four bytes for each port (§6.8, table 60)."""
    SYSTEM_TIME = (0x0910, 8, "system time", True)
    """The local copy; a write feeds the time loop and sets nothing (§6.8, table 60)."""
    RECEIVE_TIME_UNIT = (0x0918, 8, "receive time processing unit")
    """Time at which the frame passed the processing unit, latched with port 0 (§6.8, table 60)."""
    SYSTEM_TIME_OFFSET = (0x0920, 8, "system time offset", True)
    """From local to system time (§6.8, table 60)."""
    SYSTEM_TIME_DELAY = (0x0928, 4, "system time delay", True)
    """From the reference clock to here (§6.8, table 60)."""
    SYSTEM_TIME_DIFFERENCE = (0x092C, 4, "system time difference")
    """Of the last comparison; bit 31 is the sign (§6.8, table 60)."""
    SPEED_COUNTER_START = (0x0930, 2, "speed counter start", True, 0x1000)
    """Bandwidth of the time loop; a write lets it forget (§6.8, table 60)."""
    SPEED_COUNTER_DIFFERENCE = (0x0932, 2, "speed counter difference")
    """Deviation of the clocks' speed (§6.8, table 60)."""
    FILTER_DEPTHS = (0x0934, 2, "filter depths", True, 0x0C00)
    """Of system time difference, then of speed counter (§6.8, table 60)."""
    CYCLIC_UNIT_CONTROL = (0x0980, 1, "cyclic unit control", True)
    """Control of SYNC0, SYNC1 and the latches: by the master or by the PDI (§6.8)."""
    ACTIVATION = (0x0981, 1, "activation", True)
    """Bit 0: cyclic operation, 1: SYNC0, 2: SYNC1 (§6.8, table 61, P1)."""
    PULSE_LENGTH = (0x0982, 2, "SYNC pulse length")
    """In 10 ns, 0: until acknowledged; from EEPROM word 2 (§6.8, table 61, P2)."""
    SYNC_STATUS = (0x098E, 2, "SYNC0 and SYNC1 status")
    """A byte each; the device reads them to acknowledge (§6.8, table 61)."""
    START_TIME = (0x0990, 8, "start time of cyclic operation", True)
    """Start time of SYNC0; read, the time of the next SYNC0 (§6.8, table 61, P4)."""
    NEXT_SYNC1 = (0x0998, 8, "next SYNC1 pulse")
    """Time of the next SYNC1 (§6.8, table 61)."""
    SYNC0_CYCLE = (0x09A0, 4, "SYNC0 cycle time", True)
    """In ns (§6.8, table 61, P5)."""
    SYNC1_CYCLE = (0x09A4, 4, "SYNC1 cycle time", True)
    """From SYNC0 to SYNC1, in ns (§6.8, table 61, P6)."""
    LATCH_CONTROL = (0x09A8, 2, "latch control", True)
    """A byte each for latch 0 and 1: single or continuous events (§6.8, table 61)."""
    LATCH_STATUS = (0x09AE, 2, "latch status")
    """A byte each: which edges were seen (§6.8, table 61)."""
    LATCH_TIMES = (0x09B0, 32, "latch times")
    """Eight bytes each: latch 0 rising, falling, latch 1 rising, falling (§6.8, table 61)."""
    DIGITAL_OUTPUT_DATA = (DIGITAL_OUTPUTS, 4, "digital output data", True)
    """Outputs of a controller that is a digital terminal by itself."""
    USER_RAM = (0x0F80, 128, "user RAM", True)
    """Free for the master."""
