"""Axis state services, 0x4100 + ID: set values, actual values and the online structure.

Source: 002 §6.4.4.2.
"""

from collections import namedtuple
from collections.abc import Callable
from operator import attrgetter
from typing import NamedTuple

from achse.ams import DeviceError
from achse.codes import NcError
from achse.devices.nc.binding import (
    in_sub_range,
    parameter,
    per_element,
    sample_of_reals,
    shown,
)
from achse.devices.nc.controller import CONTROLLER_VIEWS
from achse.devices.nc.drive import DRIVE_VIEWS
from achse.devices.nc.encoder import ENCODER_VIEWS
from achse.devices.nc.functions.cams import CAM_STATES
from achse.devices.nc.layouts import (
    INT32,
    ONLINE_TC2,
    ONLINE_TC3,
    REAL64,
    UINT16,
    UINT32,
    OfAxis,
    request,
)
from achse.motion import Axis, commands
from achse.motion.couplings.characteristic import (
    CHARACTERISTIC_VALUES,
    characteristic_of,
    course_of,
)
from achse.motion.record import MASTERS
from achse.motion.states import SlaveType
from achse.server import READ, READ_WRITE, WRITE, Layout, Service

__all__ = ["AXIS_STATES"]

_ONLINE = Service(
    0x00,
    "axis_online_structure",
    READ,
    (ONLINE_TC2, ONLINE_TC3),
    "online data of the axis, TwinCAT 2 or 3 by length",
    read=lambda axis: axis,
)


_REMAINING = Service(
    0x14,
    "remaining_time_and_distance",
    READ,
    Layout("<dd"),
    "until the set point arrives: time, distance",
    "s, mm",
    read=attrgetter("remaining_time", "remaining_distance"),
    sample=sample_of_reals("remaining_time", "remaining_distance"),
)


_STOP_INFORMATION = Service(
    0x18,
    "stop_information",
    READ_WRITE,
    request(deceleration="d", jerk="d"),
    "distance and time of a stop begun now; 0 is the value of the running command",
    "mm, s",
    exchange=lambda axis, ramp: commands.stop_information(axis, *ramp),
    response=Layout("<dd"),
)


def _set_points(*fields: str) -> OfAxis:
    return OfAxis(Layout(f"<{len(fields)}d"), attrgetter(*fields))


_POSITION = ("set_position",)
_DYNAMICS = ("set_velocity", "set_acceleration", "set_direction", "set_jerk")
_TORQUE = ("set_torque", "set_torque_derivative")


def _feed(*targets: str) -> Callable[[Axis, tuple[float, ...]], None]:
    """Set points from outside: taken while the external generator is active."""

    def write(axis: Axis, values: tuple[float, ...]) -> None:
        if not axis.external_setpoint_active:
            raise DeviceError(
                NcError.EXTERNAL_GENERATOR_NOT_ACTIVE.number,
                "set points are taken while the external generator is active",
            )
        for target, value in zip(targets, values, strict=False):
            setattr(axis, target, int(value) if target == "external_set_direction" else value)

    return write


_FED_DYNAMICS = (
    "external_set_velocity", "external_set_acceleration", "external_set_direction",
    "external_set_jerk",
)  # fmt: skip
_FED_TORQUE = ("external_set_torque", "external_set_torque_derivative")

_SET_POINT_STRUCTURES = (
    Service(
        0x60,
        "setpoint_structure",
        READ | WRITE,
        (
            _set_points(*_POSITION, *_DYNAMICS),
            _set_points(*_POSITION, *_DYNAMICS, "set_torque"),
            _set_points(*_POSITION, *_DYNAMICS, *_TORQUE),
        ),
        "set position, velocity, acceleration, direction, jerk; longer forms with torque",
        read=lambda axis: axis,
        write=_feed("external_set_position", *_FED_DYNAMICS, *_FED_TORQUE),
    ),
    Service(
        0x61,
        "dynamic_setpoint_structure",
        READ | WRITE,
        (
            _set_points(*_DYNAMICS),
            _set_points(*_DYNAMICS, "set_torque"),
            _set_points(*_DYNAMICS, *_TORQUE),
        ),
        "set velocity, acceleration, direction, jerk; longer forms with torque",
        read=lambda axis: axis,
        write=_feed(*_FED_DYNAMICS, *_FED_TORQUE),
    ),
    Service(
        0x62,
        "torque_setpoint_structure",
        READ | WRITE,
        _set_points(*_TORQUE),
        "set torque and its derivative",
        read=lambda axis: axis,
        write=_feed(*_FED_TORQUE),
    ),
)

_OPERATION_MODE = Service(
    0x63,
    "drive_operation_mode",
    READ_WRITE,
    Layout("<II"),
    "operation mode of the drive",
    exchange=lambda axis, _: (axis.drive_operation_mode,),
    response=Layout("<i4x", namedtuple("OperationMode", "mode")),
)


_COUPLING_PARAMETERS = Service(
    0x22,
    "coupling_parameters",
    READ,
    Layout("<4d"),
    "parameters of the coupling, 0 without one; the first is the gear ratio of a linear one",
    "1",
    read=lambda axis: tuple(axis.coupling_parameter),
)


class _RatioTo(NamedTuple):
    """The ratio of an axis to its master number `master`, the first for 0."""

    axis: Axis
    master: int

    @property
    def value(self) -> float:
        if self.master == 0:
            return self.axis.set_gear_ratio
        places = self.axis.ratio_place[: self.axis.master_count]
        if self.axis.coupling != SlaveType.MULTI_MASTER:
            return self.axis.set_gear_ratio if self.master == 1 else 0.0
        return sum(self.axis.ratio[n] for n, place in enumerate(places) if place == self.master - 1)


def _ratio_to(axis: Axis, n: int) -> _RatioTo:
    if n > MASTERS:
        raise DeviceError(NcError.AXIS_ID.number, f"an axis has {MASTERS} masters at most, not {n}")
    return _RatioTo(axis, n)


_GEAR_RATIO = Service(
    0x12,
    "set_gear_ratio",
    READ,
    REAL64,
    "gear ratio in force, 0 = not coupled; of several masters, that to master n",
    "1",
    read=attrgetter("value"),
    element=_ratio_to,
    sample=lambda ratio, length: (
        None if ratio.master else ratio.axis.place_of("set_gear_ratio", min(length, 8))
    ),
)


def _characteristic(axis: Axis) -> tuple[float, ...]:
    course = course_of(axis)
    return tuple(characteristic_of(course)) if course else (0.0,) * CHARACTERISTIC_VALUES


_SYNCHRONISING = Service(
    0x26,
    "sync_profile_characteristic_values",
    READ,
    Layout(f"<{CHARACTERISTIC_VALUES}d"),
    "way on which a slave synchronises: begin, end, extremes and means; 0 of other axes",
    "1",
    read=_characteristic,
)

AXIS_STATES = (
    _GEAR_RATIO,
    *per_element(
        _ONLINE,
        shown(0x09, UINT32, "set_cycle_counter"),
        shown(0x0A, REAL64, "set_position", symbol="SetPos"),
        shown(0x0B, REAL64, "set_position_modulo", symbol="SetPosModulo"),
        shown(0x0C, INT32, "set_modulo_turns"),
        shown(0x0D, REAL64, "set_direction"),
        shown(0x0E, REAL64, "set_velocity", symbol="SetVelo"),
        shown(0x0F, REAL64, "set_acceleration", symbol="SetAcc"),
        shown(0x10, REAL64, "set_jerk", symbol="SetJerk"),
        shown(0x11, REAL64, "set_torque", symbol="SetTorque"),
        shown(0x13, REAL64, "target_position"),
        _REMAINING,
        shown(0x15, UINT32, "set_command_number", symbol="CmdNo"),
        shown(0x16, REAL64, "last_positioning_time"),
        shown(0x17, REAL64, "set_velocity_override"),
        shown(0x1A, REAL64, "uncorrected_set_position", "set_position"),
        shown(0x1D, REAL64, "uncorrected_set_direction", "set_direction"),
        shown(0x1E, REAL64, "uncorrected_set_velocity", "set_velocity"),
        shown(0x1F, REAL64, "uncorrected_set_acceleration", "set_acceleration"),
        *_SET_POINT_STRUCTURES,
    ),
    shown(0x01, UINT32, "error_code", symbol="ErrState"),
    _STOP_INFORMATION,
    shown(0x20, UINT32, "coupling_state"),
    shown(0x21, UINT32, "coupling_table_index"),
    _COUPLING_PARAMETERS,
    shown(0x23, REAL64, "gear_ratio", "set_gear_ratio"),
    shown(0x24, UINT32, "active_control_loop"),
    shown(0x25, UINT16, "external_setpoint_active"),
    *CAM_STATES,
    _SYNCHRONISING,
    shown(0x29, UINT32, "delayed_error_code"),
    shown(0x2A, REAL64, "fading_position_difference"),
    shown(0x2B, REAL64, "fading_relative_velocity"),
    shown(0x2C, REAL64, "fading_relative_acceleration"),
    shown(0x2D, UINT32, "initialize_command_counter"),
    shown(0x2E, UINT32, "reset_command_counter"),
    shown(0x30, REAL64, "set_torque_derivative"),
    parameter(0x31, REAL64, NcError.REQUEST_PARAMETER, "set_torque_offset", symbol="TorqueOffset"),
    shown(0x40, UINT32, "setpoint_correction_counter"),
    shown(0x50, UINT32, "set_motion_phase"),
    shown(0x51, UINT16, "axis_disabled"),
    _OPERATION_MODE,
    *ENCODER_VIEWS["states"],
    *in_sub_range("encoder_", (shown(0x18, UINT32, "encoder_reinitialization_state"),)),
    *CONTROLLER_VIEWS["states"],
    *DRIVE_VIEWS["states"],
)
