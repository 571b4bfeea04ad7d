"""Axes that follow axes: coupled by a gear or a cam, changed in motion, let go in several ways.

Services of 002 §6.4.4.3: couple (0x4200 + id: 0x40), uncouple (0x41), change (0x42), offsets and
scalings of a cam (0x43), couple by a table (0x4A).
"""

import struct
from enum import IntEnum
from typing import TYPE_CHECKING, Literal

from achse.client.nc.access import AxisAccess
from achse.client.nc.arguments import choice, real
from achse.client.nc.services import FUNCTIONS, named
from achse.client.nc.tables import RemoteTable

if TYPE_CHECKING:
    from achse.client.nc.axis import RemoteAxis

Interpolation = Literal["linear", "four points", "spline", "local"]
AfterCoupling = Literal["go on", "stop", "stop oriented", "new velocity", "new position", "at once"]

_INTERPOLATIONS = {"linear": 0, "four points": 1, "spline": 2, "local": 3}
_AFTER = {
    "go on": None,
    "stop": 0,
    "stop oriented": 1,
    "new velocity": 3,
    "new position": 4,
    "at once": 6,
}
"""Decoupling types (002 §6.4.9); without a type the slave keeps its velocity."""

_NEW_POSITION_AND_VELOCITY = 5
_LINEAR = 1

_COUPLE = struct.Struct("<4I4d")
_UNCOUPLE = struct.Struct("<I4x5d")
_CHANGE = struct.Struct("<4d")
_OFFSETS = struct.Struct("<4d")
_CAM = struct.Struct("<6I4d3I4xd2I")


class CouplingState(IntEnum):
    """Role of an axis in couplings (004 §5.1.1)."""

    SINGLE = 0
    MASTER = 1
    MASTER_AND_SLAVE = 2
    SLAVE = 3


class AxisCouplings(AxisAccess):
    """Commands that couple, change and decouple an axis as a slave.

    All methods raise `AxisRefused` with the NC's code and then nothing has changed; ValueError for
    numbers that are not finite. A master is an axis, its name or its id.
    """

    async def gear_in(self, master: "RemoteAxis | str | int", ratio: float = 1.0) -> None:
        """Follow a master: from now on slave way = `ratio` · master way; positions do not jump.

        Both stand. `ratio` is slave units per master unit, either sign, up to 1e6; 0 is 0x421B, a
        master or slave in motion 0x425A, a ring of axes 0x4210, a slave already coupled 0x4249.
        """
        factor = real("ratio", ratio)
        await self._send(
            "couple",
            _COUPLE.pack(_LINEAR, await self._master_id(master), 0, 0, factor, 0.0, 0.0, 0.0),
        )

    async def change_gear(self, ratio: float) -> None:
        """Set another gear ratio at once: the slave's velocity jumps, its position does not."""
        factor = real("ratio", ratio)
        await self._send("change_coupling_parameters", _CHANGE.pack(factor, 0.0, 0.0, 0.0))

    async def cam_in(
        self,
        master: "RemoteAxis | str | int",
        table: "RemoteTable | int",
        *,
        interpolation: Interpolation = "spline",
        master_absolute: bool = True,
        slave_absolute: bool = True,
        master_offset: float = 0.0,
        slave_offset: float = 0.0,
        master_scaling: float = 1.0,
        slave_scaling: float = 1.0,
    ) -> None:
        """Follow a master by a table of the NC: a cam table or a motion function.

        Relative positions count from where master and slave are now; absolute ones are those of the
        axes, then the slave is at the position of the table. Offsets are in units of their axis, a
        scaling of 2 stretches the cam to twice its length (master) or height (slave).
        `interpolation` says how rows are joined; a motion function has its laws instead. 0x4261: no
        such table, 0x4262: one for drives, 0x4256: nothing was written to it.
        """
        joined = choice("interpolation", interpolation, _INTERPOLATIONS)
        numbers = [
            real(name, value)
            for name, value in (
                ("slave_offset", slave_offset),
                ("master_offset", master_offset),
                ("slave_scaling", slave_scaling),
                ("master_scaling", master_scaling),
            )
        ]
        if not isinstance(table, RemoteTable):
            table = RemoteTable(self.nc, table)
        master_id = await self._master_id(master)
        slave_type = await table.slave_type()
        await self._send(
            "couple_solo_table",
            _CAM.pack(
                *(slave_type, master_id, 0, 0, table.id, joined),
                *numbers,
                *(int(bool(slave_absolute)), int(bool(master_absolute)), 0, 0.0, 0, 0),
            ),
        )

    async def change_cam(
        self,
        *,
        slave_offset: float = 0.0,
        master_offset: float = 0.0,
        slave_scaling: float = 1.0,
        master_scaling: float = 1.0,
    ) -> None:
        """Set other offsets and scalings of the active cam at once. A scaling of 0 is refused."""
        values = (
            real("slave_offset", slave_offset),
            real("master_offset", master_offset),
            real("slave_scaling", slave_scaling),
            real("master_scaling", master_scaling),
        )
        await self._send("change_table_coupling_offsets", _OFFSETS.pack(*values))

    async def gear_out(
        self,
        then: AfterCoupling = "go on",
        *,
        position: float = 0.0,
        velocity: float = 0.0,
        acceleration: float = 0.0,
        deceleration: float = 0.0,
        jerk: float = 0.0,
    ) -> None:
        """Follow no longer; position and velocity do not jump unless `then` is "at once".

        A slave at rest is free. One in motion goes on at its velocity, or comes to rest ("stop", at
        a modulo position with "stop oriented"), takes a `velocity` ("new velocity"), goes to a
        `position`, with `velocity` if that is not 0 ("new position"), or has velocity 0 in the same
        cycle ("at once"). Dynamics of 0 are those of the axis. 0x424D: it is not coupled.
        """
        kind = choice("then", then, _AFTER)
        numbers = [
            real(name, value)
            for name, value in (
                ("position", position),
                ("velocity", velocity),
                ("acceleration", acceleration),
                ("deceleration", deceleration),
                ("jerk", jerk),
            )
        ]
        if kind is None:
            await self._send("decouple", b"")
            return
        if then == "new position" and numbers[1]:
            kind = _NEW_POSITION_AND_VELOCITY
        await self._send("decouple", _UNCOUPLE.pack(kind, *numbers))

    async def cam_out(self) -> None:
        """Follow no cam any longer: as `gear_out`, and the slave keeps its velocity."""
        await self.gear_out()

    async def coupling(self) -> CouplingState:
        """Return the role of the axis: single, master, slave or both."""
        return CouplingState(int(await self.states["coupling state"]))

    async def _master_id(self, master: "RemoteAxis | str | int") -> int:
        if isinstance(master, AxisAccess):
            return await master.id()
        from achse.client.nc.controller import RemoteNc  # which makes axes

        return await RemoteNc(self.nc).axis(master).id()

    async def _send(self, function: str, data: bytes) -> None:
        service = named((FUNCTIONS,), function)
        await self.request(service, lambda nc, at: nc.write_raw(*at, data))
