"""Functions about the group of an axis, 0x4200 + ID (002 §6.4.4.3)."""

from achse.devices.nc.functions.calling import function
from achse.devices.nc.layouts import NO_DATA
from achse.motion import commands

__all__ = ["GROUPS"]


GROUPS = (
    function(
        0x70,
        "return_to_ptp_group",
        commands.return_to_ptp_group,
        NO_DATA,
        "back into the own PTP group",
    ),
)
