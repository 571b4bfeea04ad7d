"""The NC device: service tables over the axes of `achse.motion`.

Read `device` first: all tables on ports 500 and 501. `rows` binds a row of the manual to behaviour,
`layouts` are its numbers on the wire. The rows themselves: `axes`, `functions` (commands to an
axis), `tables`, `groups`, `channels` and `ring0`; `symbols` and `coverage` walk them.
"""

from achse.devices.nc.device import NcDevice

__all__ = ["NcDevice"]
