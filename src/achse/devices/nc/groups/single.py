"""Groups of one axis: parameters of their own, functions that are those of the axis.

Source: 002 §6.4.3.3; the offset is that of the axis function, from 0x100 on.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from achse.ams import DeviceError
from achse.codes import NcError, ReturnCode
from achse.codes.nc.choices import AxisType
from achse.codes.nc.row import NcRow
from achse.codes.nc.rows.groups import OF_SINGLE_AXES
from achse.codes.nc.table import named_rows
from achse.devices.nc.functions import AXIS_FUNCTIONS
from achse.devices.nc.groups.binding import AnyGroup
from achse.devices.nc.rows import bound
from achse.motion import Axis
from achse.motion.groups.path_group import PathGroup
from achse.motion.groups.ptp import PtpGroup
from achse.server import Service

_PARAMETERS = named_rows(0x3000)
_FUNCTIONS = named_rows(0x3200)
_OF_AXES = {service.name: service for service in AXIS_FUNCTIONS if service.write}


def _axis_of(group: AnyGroup) -> Axis:
    """Return the axis of a group of one; raises DeviceError 0x703 for others."""
    if not isinstance(group, PtpGroup):
        raise DeviceError(ReturnCode.INVALID_OFFSET, "a function of groups of one axis")
    return group.axis


def _encoder_of(group: AnyGroup) -> Axis:
    """Return the axis of an encoder group; raises DeviceError 0x703 for others."""
    axis = _axis_of(group)
    if axis.axis_type != AxisType.ENCODER:
        raise DeviceError(ReturnCode.INVALID_OFFSET, "a parameter of encoder groups alone")
    return axis


def _two_speed(group: AnyGroup) -> Axis:
    """Return the axis of a rapid/creep group; raises DeviceError 0x703 for others."""
    axis = _axis_of(group)
    if axis.axis_type != AxisType.DISCRETE_RAPID_CREEP:
        raise DeviceError(ReturnCode.INVALID_OFFSET, "a function of rapid/creep axes alone")
    return axis


def _of_group(row: NcRow, axis_of: Callable[[AnyGroup], Axis]) -> Service:
    """Return an axis function as one of its group."""
    service = _OF_AXES[row.name]
    write, element = service.write, service.element
    assert write is not None

    def carry(group: AnyGroup, data: Any) -> None:
        axis = axis_of(group)
        write(axis if element is None else element(axis, 0), data)

    return replace(service, offset=row.offset, write=carry, element=None)


SINGLE_FUNCTIONS = (
    *(_of_group(_FUNCTIONS[name], _axis_of) for name in sorted(OF_SINGLE_AXES)),
    _of_group(_FUNCTIONS["release_brake"], _two_speed),
)


def _encoder_parameter(row: NcRow, field: str, error: NcError) -> Service:
    def write(group: AnyGroup, value: float) -> None:
        axis = _encoder_of(group)
        setattr(axis, field, value)
        axis.wake()

    return bound(
        row,
        read=lambda group: getattr(_encoder_of(group), field),
        write=write,
        code=error.number,
    )


def _only(row: NcRow, field: str, error: NcError) -> Service:
    """Return a parameter that does something to paths alone; other groups keep to its first
    value."""

    def write(group: AnyGroup, value: int) -> None:
        if isinstance(group, PathGroup):
            setattr(group, field, value)
        elif value != getattr(group, field):
            raise DeviceError(error.number, f"{row.name} = {value}: not of this group")

    return bound(row, read=lambda group: getattr(group, field), write=write, code=error.number)


SINGLE_PARAMETERS = (
    _only(_PARAMETERS["single_block_mode"], "single_block_mode", NcError.SINGLE_STEP_FLAG),
    _only(_PARAMETERS["saf_cycle_time_divisor"], "saf_divisor", NcError.SAF_CYCLE_TIME),
    _encoder_parameter(
        _PARAMETERS["standstill_velocity_window"], "no_motion_window", NcError.NO_MOTION_WINDOW
    ),
    _encoder_parameter(
        _PARAMETERS["standstill_filter_time"], "no_motion_time", NcError.NO_MOTION_FILTER_TIME
    ),
    _encoder_parameter(
        _PARAMETERS["coupling_dead_time_compensation"],
        "coupling_dead_time",
        NcError.DEAD_TIME_COMPENSATION,
    ),
)
