"""Groups of one axis: parameters of their own, functions that are those of the axis.

Source: 002 §6.4.3.3; the offset is that of the axis function, from 0x100 on.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from achse.ams import DeviceError
from achse.codes import NcError, ReturnCode
from achse.devices.nc.functions import AXIS_FUNCTIONS, COUPLINGS_OF_GROUP
from achse.devices.nc.groups.binding import AnyGroup
from achse.devices.nc.layouts import REAL64, UINT16, UINT32
from achse.motion import Axis
from achse.motion.groups.path_group import PathGroup
from achse.motion.groups.ptp import PtpGroup
from achse.motion.states import AxisType
from achse.server import READ, WRITE, Service

__all__ = ["SINGLE_FUNCTIONS", "SINGLE_PARAMETERS"]

_FIRST = 0x100


def _axis_of(group: AnyGroup) -> Axis:
    """The axis of a group of one; raises DeviceError 0x703 for others."""
    if not isinstance(group, PtpGroup):
        raise DeviceError(ReturnCode.INVALID_OFFSET, "a function of groups of one axis")
    return group.axis


def _encoder_of(group: AnyGroup) -> Axis:
    """The axis of an encoder group; raises DeviceError 0x703 for others."""
    axis = _axis_of(group)
    if axis.axis_type != AxisType.ENCODER:
        raise DeviceError(ReturnCode.INVALID_OFFSET, "a parameter of encoder groups alone")
    return axis


def _two_speed(group: AnyGroup) -> Axis:
    """The axis of a rapid/creep group; raises DeviceError 0x703 for others."""
    axis = _axis_of(group)
    if axis.axis_type != AxisType.DISCRETE_RAPID_CREEP:
        raise DeviceError(ReturnCode.INVALID_OFFSET, "a function of rapid/creep axes alone")
    return axis


def _of_group(row: Service, axis_of: Callable[[AnyGroup], Axis], offset: int = 0) -> Service:
    """An axis function as one of its group."""
    write, element = row.write, row.element
    assert write is not None

    def carry(group: AnyGroup, data: Any) -> None:
        axis = axis_of(group)
        write(axis if element is None else element(axis, 0), data)

    return replace(row, offset=offset or row.offset, write=carry, element=None)


_SHARED = frozenset(
    {
        *("home", "new_end_position", "set_actual_position", "set_homed_flag"),
        *("start", "start_extended", "start_special"),
        *("start_drive_output", "stop_drive_output", "change_drive_output"),
        *("start_superposition", "stop_superposition"),
        *("disable", "enable", "disable_drive_output", "enable_drive_output"),
    }
)

SINGLE_FUNCTIONS = (
    *(
        _of_group(row, _axis_of, _FIRST + row.offset)
        for row in AXIS_FUNCTIONS
        if row.name in _SHARED and WRITE in row.access
    ),
    *(_of_group(row, _axis_of) for row in COUPLINGS_OF_GROUP),
    *(_of_group(row, _two_speed, 0x362) for row in AXIS_FUNCTIONS if row.name == "release_brake"),
)


def _encoder_parameter(
    offset: int, name: str, field: str, error: NcError, unit: str, most: float, doc: str
) -> Service:
    def write(group: AnyGroup, value: float) -> None:
        axis = _encoder_of(group)
        setattr(axis, field, value)
        axis.wake()

    return Service(
        *(offset, name, READ | WRITE, REAL64, doc, unit),
        read=lambda group: getattr(_encoder_of(group), field),
        write=write,
        minimum=0.0,
        maximum=most,
        code=error.number,
    )


def _only(
    offset: int, codec: Any, name: str, field: str, error: NcError, most: int, doc: str
) -> Service:
    """A parameter that does something to paths alone; other groups keep to its first value."""

    def write(group: AnyGroup, value: int) -> None:
        if isinstance(group, PathGroup):
            setattr(group, field, value)
        elif value != getattr(group, field):
            raise DeviceError(error.number, f"{name} = {value}: not of this group")

    return Service(
        *(offset, name, READ | WRITE, codec, doc, "1"),
        read=lambda group: getattr(group, field),
        write=write,
        minimum=0 if codec is UINT16 else 1,
        maximum=most,
        code=error.number,
    )


SINGLE_PARAMETERS = (
    _only(
        *(0x06, UINT16, "single_block_mode", "single_block_mode", NcError.SINGLE_STEP_FLAG, 1),
        "single blocks of a path: it waits for a start after each; of other groups 0 alone",
    ),
    Service(
        *(0x10, "saf_cycle_time_divisor", READ | WRITE, UINT32),
        "part of the cycle of the set-point task: 1, every group has set points in each",
        "1",
        read=lambda group: group.saf_divisor,
        write=lambda group, _: None,
        minimum=1,
        maximum=1,
        code=NcError.SAF_CYCLE_TIME.number,
    ),
    _encoder_parameter(
        *(0x604, "standstill_velocity_window", "no_motion_window", NcError.NO_MOTION_WINDOW),
        *("mm/s", 1000.0, "an encoder axis below this velocity does not move"),
    ),
    _encoder_parameter(
        *(0x605, "standstill_filter_time", "no_motion_time", NcError.NO_MOTION_FILTER_TIME),
        *("s", 60.0, "time below the window until it shows so"),
    ),
    _encoder_parameter(
        *(0x606, "coupling_dead_time_compensation", "coupling_dead_time"),
        *(NcError.DEAD_TIME_COMPENSATION, "s", 60.0),
        "how far ahead followers see an encoder axis, by its velocity",
    ),
)
