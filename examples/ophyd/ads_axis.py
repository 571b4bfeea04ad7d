"""An axis of a TwinCAT NC, or of an achse station, as an ophyd positioner, by pyads."""

import contextlib
import struct
import threading
import time
from typing import Any

import pyads
from ophyd.positioner import PositionerBase
from ophyd.status import MoveStatus
from ophyd.utils.errors import InvalidState

NC_PORT = 500
PARAMETER, STATE, FUNCTION, CYCLIC = 0x4000, 0x4100, 0x4200, 0x4300
"""Index groups; the id of the axis is added."""

UNIT, HIGHEST_VELOCITY = 0x05, 0x27
RESET, STOP, START = 0x01, 0x02, 0x20
CONTROL, OVERRIDE, STATUS, ERROR, POSITION = 0x01, 0x21, 0x81, 0xB1, 0xBA
"""Index offsets: parameters, functions, cyclic interface."""

ENABLES, FULL_OVERRIDE, ABSOLUTE = 0b111, 1_000_000, 1
READY, HAS_BEEN_STOPPED, HAS_JOB = 1 << 0, 1 << 7, 1 << 8


class AxisFault(RuntimeError):
    """The axis is in error."""


class AdsAxis(PositionerBase):
    """Axis `axis_id` behind an open pyads connection to the NC.

    `set` gives a status that is done when the axis is at rest at its target, and fails with an
    `AxisFault` (NC code) or, after a stop, with what ophyd says of an unsuccessful move.
    """

    def __init__(
        self, nc: pyads.Connection, axis_id: int, *, velocity: float, name: str, **fields: Any
    ) -> None:
        super().__init__(name=name, **fields)
        self._nc = nc
        self._id = axis_id
        self.velocity = velocity
        text = nc.read(PARAMETER + axis_id, UNIT, pyads.PLCTYPE_BYTE * 11)
        self._egu = bytes(text).split(b"\0", 1)[0].decode()
        self._position = self._read(POSITION, pyads.PLCTYPE_LREAL)

    @property
    def egu(self) -> str:
        return self._egu

    def enable(self, timeout: float = 5.0) -> None:
        """Enable it; on a controller whose PLC does that, leave this out."""
        self._nc.write(CYCLIC + self._id, OVERRIDE, FULL_OVERRIDE, pyads.PLCTYPE_UDINT)
        self._nc.write(CYCLIC + self._id, CONTROL, ENABLES, pyads.PLCTYPE_UDINT)
        deadline = time.monotonic() + timeout
        while not self._status() & READY:
            if time.monotonic() > deadline:
                raise TimeoutError(f"{self.name} is not ready")
            time.sleep(0.01)

    def move(
        self,
        position: float,
        wait: bool = True,
        timeout: float | None = None,
        moved_cb: Any = None,
    ) -> MoveStatus:
        status: MoveStatus = super().move(position, timeout=timeout, moved_cb=moved_cb)
        order = struct.pack("<I4xdd", ABSOLUTE, position, self.velocity)
        self._moving = True
        self._started_moving = True
        try:
            self._nc.write(FUNCTION + self._id, START, list(order), pyads.PLCTYPE_BYTE * len(order))
        except pyads.ADSError as refusal:
            self._moving = False
            self._fail(status, refusal)
            return status
        threading.Thread(target=self._follow, args=(status,), daemon=True).start()
        if wait:
            status.wait(timeout)
        return status

    def stop(self, *, success: bool = False) -> None:
        """End the move that was begun here; ophyd calls it too, after each that failed."""
        if not self._moving:
            return
        self._nc.write(FUNCTION + self._id, STOP, [], pyads.PLCTYPE_BYTE * 0)
        super().stop(success=success)

    def _follow(self, status: MoveStatus) -> None:
        try:
            time.sleep(0.01)  # a command is taken over at the next cycle of the NC
            while (word := self._status()) & HAS_JOB and not status.done:
                self._set_position(self._read(POSITION, pyads.PLCTYPE_LREAL))
                time.sleep(0.01)
            error = self._read(ERROR, pyads.PLCTYPE_UDINT)
            self._set_position(self._read(POSITION, pyads.PLCTYPE_LREAL))
            if error:
                raise AxisFault(f"{self.name}: 0x{error:X}")
        except Exception as failure:
            self._moving = False
            self._fail(status, failure)
            return
        if not status.done:
            self._done_moving(success=not word & HAS_BEEN_STOPPED)

    @staticmethod
    def _fail(status: MoveStatus, failure: Exception) -> None:
        """Tell once: ophyd itself ends a status whose move was replaced."""
        with contextlib.suppress(InvalidState):
            status.set_exception(failure)

    def _status(self) -> int:
        return int(self._read(STATUS, pyads.PLCTYPE_UDINT))

    def _read(self, offset: int, type: Any) -> Any:
        return self._nc.read(CYCLIC + self._id, offset, type)
