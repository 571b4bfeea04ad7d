"""The EtherCAT state machine of a slave: a table of every request in every state.

Source: 001 §2.4 and table 2.10.1.
"""

from collections.abc import Mapping
from enum import Enum

from achse.codes import AlState, AlStatus

_I, _P, _B, _S, _O = AlState.INIT, AlState.PREOP, AlState.BOOT, AlState.SAFEOP, AlState.OP


class Transition(Enum):
    """The state changes there are, with the state they lead to."""

    target: AlState

    def __new__(cls, name: str, target: AlState) -> "Transition":
        member = object.__new__(cls)
        member._value_ = name
        member.target = target
        return member

    IP = ("IP", _P)
    PI = ("PI", _I)
    PS = ("PS", _S)
    SP = ("SP", _P)
    SI = ("SI", _I)
    SO = ("SO", _O)
    OS = ("OS", _S)
    OP = ("OP", _P)
    OI = ("OI", _I)
    IB = ("IB", _B)
    BI = ("BI", _I)


TRANSITIONS: Mapping[tuple[AlState, AlState], Transition | AlStatus] = {
    (_I, _I): AlStatus.NO_ERROR,
    (_I, _P): Transition.IP,
    (_I, _B): Transition.IB,
    (_I, _S): AlStatus.INVALID_CHANGE,
    (_I, _O): AlStatus.INVALID_CHANGE,
    (_B, _I): Transition.BI,
    (_B, _P): AlStatus.INVALID_CHANGE,
    (_B, _B): AlStatus.NO_ERROR,
    (_B, _S): AlStatus.INVALID_CHANGE,
    (_B, _O): AlStatus.INVALID_CHANGE,
    (_P, _I): Transition.PI,
    (_P, _P): AlStatus.NO_ERROR,
    (_P, _B): AlStatus.INVALID_CHANGE,
    (_P, _S): Transition.PS,
    (_P, _O): AlStatus.INVALID_CHANGE,
    (_S, _I): Transition.SI,
    (_S, _P): Transition.SP,
    (_S, _B): AlStatus.INVALID_CHANGE,
    (_S, _S): AlStatus.NO_ERROR,
    (_S, _O): Transition.SO,
    (_O, _I): Transition.OI,
    (_O, _P): Transition.OP,
    (_O, _B): AlStatus.INVALID_CHANGE,
    (_O, _S): Transition.OS,
    (_O, _O): AlStatus.NO_ERROR,
}
"""Response to a state request, by current and requested state: a transition, nothing (NO_ERROR), or
an AL status code.

A slave without Bootstrap refuses `IB` with 0x0013, as the drive of the manual does."""


def request(state: AlState, number: int) -> Transition | AlStatus:
    """Return the response to a request for state `number` (0..15) in `state`."""
    try:
        return TRANSITIONS[state, AlState(number)]
    except ValueError:
        return AlStatus.UNKNOWN_STATE


class Light(Enum):
    """Pattern of the RUN light in each state (001 table 2.9.2.1)."""

    OFF = _I
    BLINKING = _P
    SINGLE_FLASH = _S
    ON = _O
    FLICKERING = _B
    """Not in the manual, whose drive has no Bootstrap; ETG.1300."""
