"""An axis of a TwinCAT NC, or of an achse station, as EPICS process variables, by pyads."""

import argparse
import struct

import pyads
from caproto.asyncio.server import run
from caproto.server import PVGroup, pvproperty

NC_PORT = 500
FUNCTION, CYCLIC = 0x4200, 0x4300
"""Index groups; the id of the axis is added."""

STOP, START = 0x02, 0x20
CONTROL, OVERRIDE, STATUS, ERROR, POSITION = 0x01, 0x21, 0x81, 0xB1, 0xBA
"""Index offsets: functions, cyclic interface."""

ENABLES, FULL_OVERRIDE, ABSOLUTE = 0b111, 1_000_000, 1
HAS_JOB = 1 << 8


class Axis(PVGroup):
    """One axis, in the names of the motor record."""

    target = pvproperty(name="VAL", value=0.0, doc="target; writing it moves the axis")
    velocity = pvproperty(name="VELO", value=100.0, doc="velocity of moves")
    readback = pvproperty(name="RBV", value=0.0, read_only=True, doc="actual position")
    done = pvproperty(name="DMOV", value=1, read_only=True, doc="1 when the move is done")
    stop = pvproperty(name="STOP", value=0, doc="1 stops")
    fault = pvproperty(name="MSTA", value=0, read_only=True, doc="error code of the axis")
    enable = pvproperty(name="CNEN", value=0, doc="1 enables the axis")

    def __init__(self, prefix: str, nc: pyads.Connection, axis_id: int) -> None:
        super().__init__(prefix)
        self._nc = nc
        self._id = axis_id

    @target.putter
    async def target(self, instance, value):
        order = struct.pack("<I4xdd", ABSOLUTE, value, self.velocity.value)
        self._call(START, order)
        await self.done.write(0)

    @stop.putter
    async def stop(self, instance, value):
        if value:
            self._call(STOP, b"")
        return 0

    @enable.putter
    async def enable(self, instance, value):
        self._write(OVERRIDE, FULL_OVERRIDE)
        self._write(CONTROL, ENABLES if value else 0)

    @readback.startup
    async def readback(self, instance, async_lib):
        while True:
            moving = self._read(STATUS, pyads.PLCTYPE_UDINT) & HAS_JOB
            await self.readback.write(self._read(POSITION, pyads.PLCTYPE_LREAL))
            await self.fault.write(self._read(ERROR, pyads.PLCTYPE_UDINT))
            await self.done.write(0 if moving else 1)
            await async_lib.library.sleep(0.05)

    def _call(self, function: int, data: bytes) -> None:
        self._nc.write(FUNCTION + self._id, function, list(data), pyads.PLCTYPE_BYTE * len(data))

    def _write(self, offset: int, value: int) -> None:
        self._nc.write(CYCLIC + self._id, offset, value, pyads.PLCTYPE_UDINT)

    def _read(self, offset: int, type):
        return self._nc.read(CYCLIC + self._id, offset, type)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--host", default="127.0.0.1")
    parser.add_argument("--prefix", default="X:")
    parser.add_argument("--axis", type=int, default=1, help="id of the axis")
    parser.add_argument("--interface", default="0.0.0.0", help="where Channel Access listens")
    arguments = parser.parse_args()
    with pyads.Connection(f"{arguments.host}.1.1", NC_PORT, arguments.host) as nc:
        axis = Axis(arguments.prefix, nc, arguments.axis)
        run(axis.pvdb, interfaces=[arguments.interface])


if __name__ == "__main__":
    main()
