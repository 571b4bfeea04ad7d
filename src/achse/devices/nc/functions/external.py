"""External set points, 0x4200 + ID (002 §6.4.4.3)."""

from typing import Any

from achse.devices.nc.functions.calling import function, numbered
from achse.devices.nc.functions.starts import UNIVERSAL_START
from achse.devices.nc.layouts import NO_DATA
from achse.motion import Axis, commands
from achse.server import READ_WRITE, Layout, Service

__all__ = ["EXTERNAL"]


def _stop_endless(axis: Axis, arguments: Any) -> tuple[int, int]:
    start_type, _, *others = arguments
    return numbered(axis, commands.stop_external_setpoint_endless(axis, start_type, *others))


EXTERNAL = (
    function(
        0x23,
        "start_external_setpoint",
        commands.start_external_setpoint,
        (Layout("<Id"), Layout("<I4xd8x")),
        "let the cyclic interface give the set point: start type 1 or 2, end position to monitor",
    ),
    function(
        0x24,
        "stop_external_setpoint",
        commands.stop_external_setpoint,
        NO_DATA,
        "take no more external set points",
    ),
    Service(
        0x2B,
        "stop_external_setpoint_continuous",
        READ_WRITE,
        UNIVERSAL_START,
        "go over from external set points into an endless move; answers command number and state",
        exchange=_stop_endless,
        response=Layout("<HH"),
        non_finite=True,
    ),
)
