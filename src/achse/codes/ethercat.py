"""EtherCAT states and AL status codes: what a slave reports about its communication.

Source: 001 §2.4 and table 2.10.1 (the codes of the E series drive, with result state and ERR
light); the generic codes are those that masters know besides.
"""

from enum import Enum, IntEnum


class AlState(IntEnum):
    """State of the EtherCAT state machine, as in AL control and AL status bits 0..3."""

    INIT = 1
    PREOP = 2
    BOOT = 3
    SAFEOP = 4
    OP = 8


class ErrorLight(Enum):
    """State of the ERR light for a communication error (001 table 2.9.2.1)."""

    OFF = "off"
    BLINKING = "blinking"
    SINGLE_FLASH = "single flash"
    DOUBLE_FLASH = "double flash"
    FLICKERING = "flickering"


_BLINKING = ErrorLight.BLINKING
_INIT, _PREOP, _SAFEOP = AlState.INIT, AlState.PREOP, AlState.SAFEOP


class AlStatus(Enum):
    """One AL status code, register 0x0134.

    `number` is what the register holds; `text` is the meaning; `result` is the state in which the
    slave ends when it finds this error while running, None if it stays where it is (a state above
    the present one never results); `light` is the ERR light.
    """

    number: int
    text: str
    result: AlState | None
    light: ErrorLight

    def __new__(
        cls,
        number: int,
        text: str,
        result: AlState | None = None,
        light: ErrorLight = _BLINKING,
    ) -> "AlStatus":
        member = object.__new__(cls)
        member._value_ = number
        member.number = number
        member.text = text
        member.result = result
        member.light = light
        return member

    def __int__(self) -> int:
        return self.number

    @staticmethod
    def of(number: int) -> "AlStatus | None":
        """Return the code `number`, or None if it is not known here."""
        return _BY_NUMBER.get(number)

    NO_ERROR = (0x0000, "No error.", None, ErrorLight.OFF)
    UNSPECIFIED = (0x0001, "Error without a code of its own.")
    NO_MEMORY = (0x0002, "Local application ran out of memory.")
    INVALID_CHANGE = (0x0011, "Requested state cannot be reached from the present one.")
    UNKNOWN_STATE = (0x0012, "Requested state does not exist.")
    NO_BOOTSTRAP = (0x0013, "Bootstrap is not supported.")
    NO_FIRMWARE = (0x0014, "No valid firmware.")
    BOOT_MAILBOX = (0x0015, "Mailbox configuration is not valid for bootstrap.")
    MAILBOX_CONFIGURATION = (0x0016, "Mailbox configuration is not valid.", _INIT)
    SYNC_MANAGER_CONFIGURATION = (0x0017, "SyncManager configuration is not valid.", _PREOP)
    NO_INPUTS = (0x0018, "No valid inputs.", _SAFEOP)
    NO_OUTPUTS = (0x0019, "No valid outputs.", _SAFEOP)
    SYNCHRONIZATION = (0x001A, "Synchronization was lost.", _SAFEOP, ErrorLight.SINGLE_FLASH)
    WATCHDOG = (0x001B, "SyncManager watchdog expired.", _SAFEOP, ErrorLight.DOUBLE_FLASH)
    SYNC_MANAGER_TYPES = (0x001C, "SyncManager types are not valid.", _PREOP)
    OUTPUT_CONFIGURATION = (0x001D, "Output configuration is not valid.", _PREOP)
    INPUT_CONFIGURATION = (0x001E, "Input configuration is not valid.", _PREOP)
    WATCHDOG_CONFIGURATION = (0x001F, "Watchdog configuration is not valid.", _PREOP)
    NEEDS_COLD_START = (0x0020, "Slave needs a cold start.")
    NEEDS_INIT = (0x0021, "Slave needs Init.")
    NEEDS_PREOP = (0x0022, "Slave needs PreOp.")
    NEEDS_SAFEOP = (0x0023, "Slave needs SafeOp.")
    INPUT_MAPPING = (0x0024, "Input mapping is not valid.", _PREOP)
    OUTPUT_MAPPING = (0x0025, "Output mapping is not valid.", _PREOP)
    INCONSISTENT_SETTINGS = (0x0026, "Settings contradict each other.", _PREOP)
    NO_FREE_RUN = (0x0027, "FreeRun is not supported.", _PREOP)
    NO_SYNCHRONOUS = (0x0028, "Synchronous operation is not supported.", _PREOP)
    FREE_RUN_NEEDS_BUFFERS = (0x0029, "FreeRun needs three buffers.", _PREOP)
    BACKGROUND_WATCHDOG = (0x002A, "Background watchdog expired.", _SAFEOP)
    NO_VALID_DATA = (0x002B, "Neither inputs nor outputs are valid.", _SAFEOP)
    FATAL_SYNC = (0x002C, "Synchronization failed for good.", _SAFEOP, ErrorLight.SINGLE_FLASH)
    NO_SYNC0 = (0x002D, "SYNC0 does not come.", _SAFEOP, ErrorLight.SINGLE_FLASH)
    DC_CONFIGURATION = (0x0030, "DC sync configuration is not valid.", _PREOP)
    DC_LATCH_CONFIGURATION = (0x0031, "DC latch configuration is not valid.", _PREOP)
    PLL = (0x0032, "PLL failed.", _SAFEOP, ErrorLight.SINGLE_FLASH)
    DC_IO = (0x0033, "DC sync input or output failed.", _SAFEOP, ErrorLight.SINGLE_FLASH)
    DC_TIMEOUT = (0x0034, "DC sync timed out.", _SAFEOP, ErrorLight.SINGLE_FLASH)
    SYNC_CYCLE = (0x0035, "DC sync cycle time is not valid.", _PREOP)
    SYNC0_CYCLE = (0x0036, "DC SYNC0 cycle time is not valid.", _PREOP)
    SYNC1_CYCLE = (0x0037, "DC SYNC1 cycle time is not valid.", _PREOP)
    MAILBOX_AOE = (0x0041, "Mailbox: AoE failed.")
    MAILBOX_EOE = (0x0042, "Mailbox: EoE failed.")
    MAILBOX_COE = (0x0043, "Mailbox: CoE failed.")
    MAILBOX_FOE = (0x0044, "Mailbox: FoE failed.")
    MAILBOX_SOE = (0x0045, "Mailbox: SoE failed.")
    MAILBOX_VOE = (0x004F, "Mailbox: VoE failed.")
    EEPROM_NO_ACCESS = (0x0050, "EEPROM cannot be accessed.")
    EEPROM_ERROR = (0x0051, "EEPROM has an error.")
    RESTARTED = (0x0060, "Slave restarted by itself.", _INIT)
    IDENTIFICATION_CHANGED = (0x0061, "Device identification was updated.")
    NOT_IN_COMMUNICATION_MODE = (0x8000, "Drive is not in communication mode.", _INIT)


_BY_NUMBER = {code.number: code for code in AlStatus}
