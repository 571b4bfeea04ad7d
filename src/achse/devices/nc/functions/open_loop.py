"""Control loops, direct output, torque mode and the drive, 0x4200 + ID (002 §6.4.4.3)."""

from achse.codes.nc.table import named_rows
from achse.devices.nc.functions.calling import function, numbered
from achse.devices.nc.rows import bound
from achse.motion import Axis, commands

_ROWS = named_rows(0x4200)


def _start_torque(axis: Axis, arguments: tuple[float, ...]) -> tuple[int, int]:
    return numbered(axis, commands.start_torque_control(axis, *arguments))  # type: ignore[arg-type]


OPEN_LOOP = (
    function(_ROWS["start_drive_output"], commands.start_drive_output),
    function(_ROWS["stop_drive_output"], commands.stop_drive_output),
    function(_ROWS["change_drive_output"], commands.change_drive_output),
    bound(_ROWS["start_torque_control"], exchange=_start_torque, non_finite=True),
    function(_ROWS["release_brake"], commands.release_brake),
    function(_ROWS["set_drive_operation_mode"], commands.set_drive_operation_mode),
)


LOOPS = (function(_ROWS["switch_control_loop"], commands.switch_control_loop),)
