"""Waits of a channel with an interpreter: one table of all reasons.

    state        waits for                               ended by                   then
    IDLE         LOAD: a program                         function 0x01, 0x04        START
    READY        START: the start                        function 0x02              -
    TABLE_FULL   TABLE_FULL: room for segments           motion                     -
    WAITING      PATH: all motion before a block         motion                     -
    WAITING      DELETABLE_MOVE: a move with DelDTG      motion, function 0x40      -
    WAITING      HANDSHAKE: an M function                the PLC                    -
    WAITING      HOMING: the axis of a G74               motion                     -
    WAITING      EXTERNAL_TRIGGER: a decoder stop @717   function 0x30              -
    WAITING      FAULT: moves before a block at fault    motion                     ABORT
    SEARCHING    FOUND_BLOCK: axes at the found block    function 0x19              -
    SINGLE_STOP  SINGLE_BLOCK: the next block            function 0x02              -
    END          PROGRAM_END: all motion of the program  motion                     START
    ABORTING     ABORT: axes at rest after a fault       rest                       RETRY
    ABORTED      RETRY: a retry, skip or reset           function 0x10, 0x12, 0x13  -
    STOPPING     STOP: axes at rest after a stop         rest                       LOAD
    RESETTING    RESET: axes at rest after a reset       rest                       LOAD

Without a reason blocks are interpreted. Stop (0x11) and reset (0x10) end each wait of a program.
Source: 002 §6.4.2.3 for the functions; the order of waits is ours.
"""

from collections.abc import Mapping
from enum import Enum, IntEnum
from types import MappingProxyType
from typing import NamedTuple

from achse.motion.channels.states import InterpreterEvent, InterpreterState


class WaitReason(Enum):
    """Reason why a channel does not interpret blocks."""

    LOAD = "a program"
    START = "the start"
    TABLE_FULL = "room for segments"
    PATH = "all motion before a block"
    DELETABLE_MOVE = "a move with DelDTG"
    HANDSHAKE = "an M function"
    HOMING = "the axis of a G74"
    EXTERNAL_TRIGGER = "a decoder stop @717"
    FAULT = "moves before a block at fault"
    FOUND_BLOCK = "axes at the found block"
    SINGLE_BLOCK = "the next block"
    PROGRAM_END = "all motion of the program"
    ABORT = "axes at rest after a fault"
    RETRY = "a retry, skip or reset"
    STOP = "axes at rest after a stop"
    RESET = "axes at rest after a reset"


class ChannelFunction(IntEnum):
    """Index offsets of the functions that end a wait (index group 0x2200 + channel id)."""

    LOAD_NUMBER = 0x01
    START = 0x02
    LOAD = 0x04
    RESET = 0x10
    RETRY = 0x12
    SKIP = 0x13
    STEP_ON = 0x19
    GO_AHEAD = 0x30
    DELETE_DISTANCE = 0x40


class WaitEnd(Enum):
    """Origin of the end of a wait."""

    FUNCTION = "a function of the channel"
    MOTION = "motion along the path"
    PLC = "the PLC"
    REST = "axes at rest"


class WaitRow(NamedTuple):
    """A wait: the state that shows it, and its end."""

    state: InterpreterState
    """State of the interpreter during the wait."""
    begins: InterpreterEvent | None
    """Event that brings the interpreter into that state; None if it is in it already."""
    ended_by: WaitEnd
    functions: tuple[ChannelFunction, ...] = ()
    """Functions that end the wait."""
    ends: InterpreterEvent | None = None
    """Event at the end of the wait; None if the next block or the next wait has one."""
    then: WaitReason | None = None
    """Reason of the next wait, if the end does not go on with blocks."""


_S, _E, _W, _F, _END = InterpreterState, InterpreterEvent, WaitReason, ChannelFunction, WaitEnd

WAITS: Mapping[WaitReason, WaitRow] = MappingProxyType(
    {
        _W.LOAD: WaitRow(
            _S.IDLE, None, _END.FUNCTION, (_F.LOAD_NUMBER, _F.LOAD), _E.LOAD, _W.START
        ),
        _W.START: WaitRow(_S.READY, None, _END.FUNCTION, (_F.START,)),
        _W.TABLE_FULL: WaitRow(_S.TABLE_FULL, _E.FULL, _END.MOTION),
        _W.PATH: WaitRow(_S.WAITING, _E.WAIT, _END.MOTION),
        _W.DELETABLE_MOVE: WaitRow(_S.WAITING, _E.WAIT, _END.MOTION, (_F.DELETE_DISTANCE,)),
        _W.HANDSHAKE: WaitRow(_S.WAITING, _E.WAIT, _END.PLC),
        _W.HOMING: WaitRow(_S.WAITING, _E.WAIT, _END.MOTION),
        _W.EXTERNAL_TRIGGER: WaitRow(_S.WAITING, _E.WAIT, _END.FUNCTION, (_F.GO_AHEAD,)),
        _W.FAULT: WaitRow(_S.WAITING, _E.WAIT, _END.MOTION, then=_W.ABORT),
        _W.FOUND_BLOCK: WaitRow(_S.SEARCHING, None, _END.FUNCTION, (_F.STEP_ON,)),
        _W.SINGLE_BLOCK: WaitRow(_S.SINGLE_STOP, _E.SINGLE, _END.FUNCTION, (_F.START,), _E.RUN),
        _W.PROGRAM_END: WaitRow(_S.END, _E.END, _END.MOTION, (), _E.DONE, _W.START),
        _W.ABORT: WaitRow(_S.ABORTING, _E.FAIL, _END.REST, (), _E.FAILED, _W.RETRY),
        _W.RETRY: WaitRow(_S.ABORTED, None, _END.FUNCTION, (_F.RESET, _F.RETRY, _F.SKIP)),
        _W.STOP: WaitRow(_S.STOPPING, _E.STOP, _END.REST, (), _E.STOPPED, _W.LOAD),
        _W.RESET: WaitRow(_S.RESETTING, _E.RESET, _END.REST, (), _E.WAS_RESET, _W.LOAD),
    }
)
"""The row of each reason; `ProgramStates.wait` and `end_wait` go by it."""
