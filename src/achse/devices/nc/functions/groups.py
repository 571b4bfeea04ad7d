"""Functions about groups and masters of an axis, 0x4200 + ID (002 §6.4.4.3)."""

from achse.devices.nc.functions.calling import carry_out, function
from achse.devices.nc.functions.starts import UNIVERSAL_START
from achse.devices.nc.layouts import NO_DATA
from achse.motion import Axis, commands
from achse.server import READ_WRITE, Layout, Service

__all__ = ["GROUPS"]


def _decouple_and_start(axis: Axis, arguments: tuple[float, ...]) -> None:
    start_type, *others = arguments
    carry_out(commands.decouple_and_start(axis, int(start_type), *others))


GROUPS = (
    Service(
        0x17,
        "decouple_and_universal_axis_start",
        READ_WRITE,
        UNIVERSAL_START,
        "uncouple a slave and start it; 0x424D at an axis that is not coupled",
        exchange=_decouple_and_start,
        response=Layout("<HH"),
        non_finite=True,
    ),
    function(
        0x70,
        "return_to_ptp_group",
        commands.return_to_ptp_group,
        NO_DATA,
        "back into the own PTP group",
    ),
)
