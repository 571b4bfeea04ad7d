"""Direct drive output, torque mode and what belongs to the drive, 0x4200 + ID (002 §6.4.4.3)."""

from achse.devices.nc.functions.calling import function, numbered
from achse.devices.nc.layouts import NO_DATA, UINT16, request
from achse.motion import Axis, commands
from achse.server import READ_WRITE, Layout, Service

__all__ = ["OPEN_LOOP"]

_OUTPUT = request(output_type="I", output_value="d")

_TORQUE = request(
    torque_start_type="I", control_mask="I", mode="I", buffer_mode="I",
    torque="d", torque_ramp="d", velocity_limit_high="d", velocity_limit_low="d",
    acceleration="d", deceleration="d", manual_torque="d",
)  # fmt: skip


def _start_torque(axis: Axis, arguments: tuple[float, ...]) -> tuple[int, int]:
    return numbered(axis, commands.start_torque_control(axis, *arguments))  # type: ignore[arg-type]


OPEN_LOOP = (
    function(
        0x26,
        "start_drive_output",
        commands.start_drive_output,
        _OUTPUT,
        "give the drive an output past the controller: type 1 in %, 2 as velocity",
    ),
    function(0x27, "stop_drive_output", commands.stop_drive_output, NO_DATA, "end the output"),
    function(
        0x28, "change_drive_output", commands.change_drive_output, _OUTPUT, "change the output"
    ),
    Service(
        0x2D,
        "start_torque_control",
        READ_WRITE,
        _TORQUE,
        "switch the drive to torque mode (CST); answers command number and state",
        exchange=_start_torque,
        response=Layout("<HH"),
        non_finite=True,
    ),
    function(
        0x62,
        "release_brake",
        commands.release_brake,
        UINT16,
        "parking brake of a two-speed axis: 0 automatic, 1 always released",
    ),
    function(
        0x63,
        "set_drive_operation_mode",
        commands.set_drive_operation_mode,
        Layout("<i12x"),
        "operation mode of the drive: DriveOperationMode",
    ),
)
