"""States of an interpreter and their transitions, as a table; nothing else changes the state.

Source: public pages of the vendor (ItpGetState); the seeds print "ENUM". The transitions are ours.
"""

from collections.abc import Mapping
from enum import Enum, IntEnum
from types import MappingProxyType


class InterpreterState(IntEnum):
    """State 0x03 of a channel."""

    INITIALISATION_FAILED = 0
    IDLE = 1
    READY = 2
    STARTED = 3
    SCANNING = 4
    RUNNING = 5
    STAY_RUNNING = 6
    TABLE_FULL = 7
    SEARCHING = 8
    END = 9
    SINGLE_STOP = 10
    ABORTING = 11
    ABORTED = 12
    FAULT = 13
    RESETTING = 14
    STOPPING = 15
    WAITING = 16
    FLUSHING = 17


class InterpreterEvent(Enum):
    """Event of an interpreter."""

    LOAD = "a program was loaded"
    START = "start was commanded"
    SEARCH = "start was commanded, with a block search"
    RETRY = "a retry or skip was commanded: the block at fault is searched"
    RUN = "blocks are interpreted"
    FULL = "the table of segments takes no more"
    WAIT = "a handshake, a decoder stop or a dwell holds it"
    SINGLE = "a single block is done"
    END = "the program is at its end, motion goes on"
    DONE = "all is carried out"
    FAIL = "a block or an axis is at fault"
    FAILED = "the axes are at rest after a fault"
    STOP = "stop was commanded"
    STOPPED = "the axes are at rest after a stop"
    RESET = "reset was commanded"
    WAS_RESET = "the axes are at standstill, errors are reset"


class ProgramMode(IntEnum):
    """State 0x04 of a channel; 0x1000 and 0x2000 are reserved."""

    DEFAULT = 0
    SINGLE_BLOCK = 1
    SINGLE_BLOCK_INTERPRETER = 0x4000


_S, _E = InterpreterState, InterpreterEvent

_RUNNING = (_S.STARTED, _S.RUNNING, _S.TABLE_FULL, _S.WAITING, _S.SINGLE_STOP, _S.SEARCHING)

ACTIVE_STATES = (*_RUNNING, _S.END)
"""A program is under way; a tuple, as members of an enumeration hash in Python."""

TRANSITIONS: Mapping[tuple[InterpreterState, InterpreterEvent], InterpreterState] = (
    MappingProxyType(
        {
            **dict.fromkeys(((state, _E.LOAD) for state in (_S.IDLE, _S.READY)), _S.READY),
            (_S.READY, _E.START): _S.STARTED,
            (_S.READY, _E.SEARCH): _S.SEARCHING,
            (_S.ABORTED, _E.RETRY): _S.SEARCHING,
            (_S.SINGLE_STOP, _E.START): _S.RUNNING,
            **{(state, _E.RUN): _S.RUNNING for state in _RUNNING},
            **{(state, _E.FULL): _S.TABLE_FULL for state in _RUNNING},
            **{(state, _E.WAIT): _S.WAITING for state in _RUNNING},
            **{(state, _E.SINGLE): _S.SINGLE_STOP for state in (*_RUNNING, _S.END)},
            **{(state, _E.END): _S.END for state in _RUNNING},
            (_S.END, _E.DONE): _S.READY,
            **{(state, _E.FAIL): _S.ABORTING for state in ACTIVE_STATES},
            (_S.ABORTING, _E.FAILED): _S.ABORTED,
            **{(state, _E.STOP): _S.STOPPING for state in (*ACTIVE_STATES, _S.ABORTING)},
            (_S.STOPPING, _E.STOPPED): _S.IDLE,
            **{(state, _E.RESET): _S.RESETTING for state in _S},
            (_S.RESETTING, _E.WAS_RESET): _S.IDLE,
        }
    )
)
"""State and event, and the state behind it; what is not here changes nothing or is refused."""
