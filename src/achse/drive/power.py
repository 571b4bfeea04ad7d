"""The power drive system: states, commands and transitions of CiA 402 as a table.

Source: 001 §3.2.1, tables 3.2.1.1 to 3.2.1.3, and 2.4.3 for the coupling to the EtherCAT state
machine. Nothing but `advance` moves the state, and it moves along `TRANSITIONS` only.
"""

from dataclasses import dataclass
from enum import IntEnum

from achse.codes import AlState
from achse.drive.record import DriveFields


class PowerState(IntEnum):
    """State of the power drive system; `word` and `mask` show it in the statusword."""

    word: int
    mask: int

    def __new__(cls, number: int, word: int, mask: int) -> "PowerState":
        member = int.__new__(cls, number)
        member._value_ = number
        member.word = word
        member.mask = mask
        return member

    NOT_READY_TO_SWITCH_ON = (0, 0x0000, 0x004F)
    SWITCH_ON_DISABLED = (1, 0x0040, 0x004F)
    READY_TO_SWITCH_ON = (2, 0x0021, 0x006F)
    SWITCHED_ON = (3, 0x0023, 0x006F)
    OPERATION_ENABLED = (4, 0x0027, 0x006F)
    QUICK_STOP_ACTIVE = (5, 0x0007, 0x006F)
    FAULT_REACTION_ACTIVE = (6, 0x000F, 0x004F)
    FAULT = (7, 0x0008, 0x004F)


class PowerEvent(IntEnum):
    """Events that can change the state: commands of the controlword and events of the drive."""

    NONE = 0
    SHUTDOWN = 1
    SWITCH_ON = 2
    """Also "disable operation": the same bits, the present state decides."""
    ENABLE_OPERATION = 3
    DISABLE_VOLTAGE = 4
    QUICK_STOP = 5
    FAULT_RESET = 6
    AUTOMATIC = 7
    ERROR = 8
    COMMUNICATION_INIT = 9
    """The EtherCAT state machine is in Init."""


@dataclass(frozen=True, slots=True)
class CommandPattern:
    """A command as bits of the controlword."""

    event: PowerEvent
    mask: int
    value: int


COMMANDS = (
    CommandPattern(PowerEvent.SHUTDOWN, 0x0087, 0x0006),
    CommandPattern(PowerEvent.SWITCH_ON, 0x008F, 0x0007),
    CommandPattern(PowerEvent.ENABLE_OPERATION, 0x008F, 0x000F),
    CommandPattern(PowerEvent.DISABLE_VOLTAGE, 0x0082, 0x0000),
    CommandPattern(PowerEvent.QUICK_STOP, 0x0086, 0x0002),
)
"""Table 3.2.1.2; fault reset is the rising edge of bit 7 and has no level."""

FAULT_RESET_BIT = 0x0080


@dataclass(frozen=True, slots=True)
class PowerTransition:
    """One row of table 3.2.1.1."""

    number: int
    source: PowerState
    event: PowerEvent
    target: PowerState


_NOT_READY, _DISABLED, _READY, _ON, _ENABLED, _QUICK, _REACTION, _FAULT = PowerState

TRANSITIONS = (
    # 0 is power-on or reset: a fresh record
    PowerTransition(1, _NOT_READY, PowerEvent.AUTOMATIC, _DISABLED),
    PowerTransition(2, _DISABLED, PowerEvent.SHUTDOWN, _READY),
    PowerTransition(3, _READY, PowerEvent.SWITCH_ON, _ON),
    PowerTransition(3, _READY, PowerEvent.ENABLE_OPERATION, _ON),  # 4 follows by itself
    PowerTransition(4, _ON, PowerEvent.ENABLE_OPERATION, _ENABLED),
    PowerTransition(5, _ENABLED, PowerEvent.SWITCH_ON, _ON),
    PowerTransition(6, _ON, PowerEvent.SHUTDOWN, _READY),
    PowerTransition(7, _READY, PowerEvent.QUICK_STOP, _DISABLED),
    PowerTransition(7, _READY, PowerEvent.DISABLE_VOLTAGE, _DISABLED),
    PowerTransition(7, _READY, PowerEvent.COMMUNICATION_INIT, _DISABLED),
    PowerTransition(8, _ENABLED, PowerEvent.SHUTDOWN, _READY),
    PowerTransition(9, _ENABLED, PowerEvent.DISABLE_VOLTAGE, _DISABLED),
    PowerTransition(9, _ENABLED, PowerEvent.COMMUNICATION_INIT, _DISABLED),
    PowerTransition(10, _ON, PowerEvent.QUICK_STOP, _DISABLED),
    PowerTransition(10, _ON, PowerEvent.DISABLE_VOLTAGE, _DISABLED),
    PowerTransition(10, _ON, PowerEvent.COMMUNICATION_INIT, _DISABLED),
    PowerTransition(11, _ENABLED, PowerEvent.QUICK_STOP, _QUICK),
    PowerTransition(12, _QUICK, PowerEvent.AUTOMATIC, _DISABLED),
    PowerTransition(12, _QUICK, PowerEvent.DISABLE_VOLTAGE, _DISABLED),
    PowerTransition(12, _QUICK, PowerEvent.COMMUNICATION_INIT, _DISABLED),
    *(
        PowerTransition(13, source, PowerEvent.ERROR, _REACTION)
        for source in (_NOT_READY, _DISABLED, _READY, _ON, _ENABLED, _QUICK)
    ),
    PowerTransition(14, _REACTION, PowerEvent.AUTOMATIC, _FAULT),
    PowerTransition(15, _FAULT, PowerEvent.FAULT_RESET, _DISABLED),
)
"""Table 3.2.1.1 with the commands of table 3.2.1.2; what is not listed changes nothing."""


def state_of(statusword: int) -> PowerState:
    """Return the state a statusword shows; ValueError if its bits are not a state."""
    for state in PowerState:
        if statusword & state.mask == state.word:
            return state
    raise ValueError(f"statusword {statusword:#06x} shows no state of the power drive system")


# The kernel's forms of the tables: plain integers, also in tuples.
NOT_READY = int(PowerState.NOT_READY_TO_SWITCH_ON)
ENABLED = int(PowerState.OPERATION_ENABLED)
QUICK_STOP = int(PowerState.QUICK_STOP_ACTIVE)
REACTION = int(PowerState.FAULT_REACTION_ACTIVE)
FAULT = int(PowerState.FAULT)
_EVENTS = len(PowerEvent)


def _command_table() -> tuple[int, ...]:
    events = [int(PowerEvent.NONE)] * 16
    for bits in range(16):
        for row in COMMANDS:
            if bits & row.mask == row.value:
                events[bits] = int(row.event)
    return tuple(events)


def _transition_table() -> tuple[int, ...]:
    """target * 16 + number for state * events + event; -1 where nothing happens."""
    table = [-1] * (len(PowerState) * _EVENTS)
    for row in TRANSITIONS:
        table[row.source * _EVENTS + row.event] = row.target * 16 + row.number
    return tuple(table)


_COMMAND_OF = _command_table()
_NEXT = _transition_table()
_NONE = int(PowerEvent.NONE)
_RESET = int(PowerEvent.FAULT_RESET)
_AUTOMATIC = int(PowerEvent.AUTOMATIC)
_ERROR = int(PowerEvent.ERROR)
_INIT = int(PowerEvent.COMMUNICATION_INIT)
_PREOP = int(AlState.PREOP)


def supply_ready(d: DriveFields) -> bool:
    """Return True if the motor can be powered: main power is on and STO is not active."""
    return d.main_power != 0 and (d.safety_1 != 0 or d.safety_2 != 0)


def advance(d: DriveFields, error: int, cause_left: int) -> int:
    """One evaluation of the state machine; the number of the transition made, 0 if none.

    `error`: an alarm has come in this cycle. `cause_left`: some cause is still there.
    """
    state = d.power_state
    controlword = d.controlword
    event = _NONE
    if error:
        event = _ERROR
    elif state == NOT_READY or (QUICK_STOP <= state <= REACTION and d.standing != 0):
        event = _AUTOMATIC
    elif d.communication < _PREOP:
        event = _INIT
    elif controlword & 0x80:
        if not d.previous_controlword & 0x80:
            event = _RESET
    else:
        event = _COMMAND_OF[controlword & 15]
    transition = _NEXT[state * _EVENTS + event]
    if transition < 0:
        return 0
    number = transition & 15
    if (number == 3 or number == 4) and not supply_ready(d):
        return 0
    if number == 15 and cause_left:
        return 0
    d.power_state = transition >> 4
    d.transition = number
    return number
