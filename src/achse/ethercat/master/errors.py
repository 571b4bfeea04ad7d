"""Errors between master and slave, each with the request and the answer.

Source: ETG.1000.4 §6 (working counter), §6.1.5 (AL status); 001 §2.6 for mailbox errors.
"""

from achse.codes import AbortCode, AlState, AlStatus
from achse.ethercat.mailbox import MailboxError


class BusError(Exception):
    """A request on the bus failed."""


class FrameLost(BusError):
    """A frame did not come back, however often it was sent."""


class NoAnswer(BusError):
    """A datagram came back with a working counter that is too low: the slave did not act."""

    def __init__(self, station: int, address: int, counter: int, expected: int = 1) -> None:
        super().__init__(
            f"station {station}: access to 0x{address:04X} has working counter {counter},"
            f" expected {expected}"
        )
        self.station = station
        self.address = address


class WrongAnswer(BusError):
    """An answer came whose bytes do not hold what it should."""


class MailboxTimeout(BusError):
    """No message came in time."""


class MailboxRefusal(BusError):
    """The slave answered with a mailbox error; `number` is its detail."""

    def __init__(self, station: int, number: int) -> None:
        known = {int(each): each.name for each in MailboxError}
        super().__init__(f"station {station}: mailbox error {known.get(number, number)}")
        self.number = number


class SdoRefusal(BusError):
    """The slave refused access to an object; `number` is the abort code, known here or not."""

    def __init__(self, station: int, index: int, subindex: int, number: int) -> None:
        code = AbortCode.of(number)
        text = code.text if code else "unknown abort code"
        super().__init__(f"station {station}: {index:04X}:{subindex:02X}: 0x{number:08X} {text}")
        self.number = number
        self.code = code


class StateRefusal(BusError):
    """The slave shows an error instead of the requested state."""

    def __init__(self, station: int, target: AlState, state: int, number: int) -> None:
        code = AlStatus.of(number)
        text = code.text if code else "unknown AL status code"
        super().__init__(
            f"station {station}: {target.name} refused in state {state}: 0x{number:04X} {text}"
        )
        self.number = number
        self.code = code
        self.state = state


class StateTimeout(BusError):
    """The slave did not reach a state in its time."""


class EepromTrouble(BusError):
    """The EEPROM interface reports an error or stays busy."""


class SlaveNotReady(BusError):
    """The slave does not answer, or is in Init, where it has no mailbox."""


class NoMailbox(BusError):
    """The slave has no mailbox, or none that speaks CoE."""
