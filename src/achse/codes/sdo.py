"""SDO abort codes: why a slave refuses access to an object of its dictionary.

The E series drive itself knows the five rows with source 001 table 2.6.1; masters understand all.
"""

from enum import Enum

from achse.codes.ads import ReturnCode


class AbortCode(Enum):
    """One SDO abort code: `number` is what travels (u32), `text` the meaning."""

    number: int
    text: str

    def __new__(cls, number: int, text: str) -> "AbortCode":
        member = object.__new__(cls)
        member._value_ = number
        member.number = number
        member.text = text
        return member

    def __int__(self) -> int:
        return self.number

    @staticmethod
    def of(number: int) -> "AbortCode | None":
        """Return the code `number`, or None if it is not known here."""
        return _BY_NUMBER.get(number)

    # 001 table 2.6.1
    UNSUPPORTED_ACCESS = (0x0601_0000, "Access to the object in this way is not supported.")
    READ_ONLY = (0x0601_0002, "Object is read-only.")
    NO_OBJECT = (0x0602_0000, "Object is not in the dictionary.")
    PDO_LENGTH = (0x0604_0042, "Mapped objects exceed the PDO in number or length.")
    VALUE_RANGE = (0x0609_0030, "Value is outside the range of the parameter.")

    # the protocol's own
    TOGGLE = (0x0503_0000, "Toggle bit did not change.")
    TIMEOUT = (0x0504_0000, "SDO protocol timed out.")
    COMMAND = (0x0504_0001, "Command specifier is not valid.")
    MEMORY = (0x0504_0005, "Out of memory.")
    WRITE_ONLY = (0x0601_0001, "Object is write-only.")
    SUBINDEX_LOCKED = (0x0601_0003, "Entry cannot be written, subindex 0 must be 0.")
    NO_COMPLETE_ACCESS = (0x0601_0004, "Object has no complete access.")
    EXCEEDS_MAILBOX = (0x0601_0005, "Object is longer than the mailbox.")
    MAPPED = (0x0601_0006, "Object is mapped to a RxPDO, download is blocked.")
    NOT_MAPPABLE = (0x0604_0041, "Object cannot be mapped to the PDO.")
    PARAMETER_INCOMPATIBLE = (0x0604_0043, "Parameters do not fit each other.")
    DEVICE_INCOMPATIBLE = (0x0604_0047, "Internal incompatibility of the device.")
    HARDWARE = (0x0606_0000, "Access failed because of a hardware error.")
    LENGTH = (0x0607_0010, "Length of the value does not match the object.")
    TOO_LONG = (0x0607_0012, "Value is too long.")
    TOO_SHORT = (0x0607_0013, "Value is too short.")
    NO_SUBINDEX = (0x0609_0011, "Subindex does not exist.")
    TOO_HIGH = (0x0609_0031, "Value is too high.")
    TOO_LOW = (0x0609_0032, "Value is too low.")
    MAX_BELOW_MIN = (0x0609_0036, "Maximum is less than minimum.")
    GENERAL = (0x0800_0000, "General error.")
    CANNOT_STORE = (0x0800_0020, "Data cannot be stored.")
    LOCAL_CONTROL = (0x0800_0021, "Data cannot be stored because of local control.")
    DEVICE_STATE = (0x0800_0022, "Data cannot be stored in the present state of the device.")
    NO_DICTIONARY = (0x0800_0023, "There is no object dictionary.")


_BY_NUMBER = {code.number: code for code in AbortCode}


class SdoAbort(Exception):
    """An access to an object was refused with `code`.

    `reason` says more to people, as which step of a procedure was missing; it does not travel.
    """

    def __init__(self, code: AbortCode, reason: str = "") -> None:
        text = f"0x{code.number:08X}: {code.text}"
        super().__init__(f"{text} ({reason})" if reason else text)
        self.code = code
        self.reason = reason


_RETURN_CODES = {
    AbortCode.NO_OBJECT: ReturnCode.INVALID_OFFSET,
    AbortCode.NO_SUBINDEX: ReturnCode.INVALID_OFFSET,
    AbortCode.VALUE_RANGE: ReturnCode.INVALID_DATA,
    AbortCode.TOO_HIGH: ReturnCode.INVALID_DATA,
    AbortCode.TOO_LOW: ReturnCode.INVALID_DATA,
    AbortCode.WRITE_ONLY: ReturnCode.INVALID_ACCESS,
    AbortCode.READ_ONLY: ReturnCode.INVALID_ACCESS,
    AbortCode.TIMEOUT: ReturnCode.DEVICE_TIMEOUT,
    AbortCode.DEVICE_STATE: ReturnCode.INVALID_STATE,
}
"""From the published sample of a master; the manuals list none."""


def return_code_of(abort: AbortCode | None) -> ReturnCode:
    """Return the ADS return code of an abort; 0x70D for those without one."""
    return ReturnCode.SYNTAX if abort is None else _RETURN_CODES.get(abort, ReturnCode.SYNTAX)
