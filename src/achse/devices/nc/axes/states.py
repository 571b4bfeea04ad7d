"""Axis state services, 0x4100 + ID: set values, actual values and the online structure.

Source: 002 §6.4.4.2.
"""

from collections.abc import Callable
from dataclasses import replace
from operator import attrgetter
from typing import NamedTuple

from achse.ams import DeviceError
from achse.codes import NcError
from achse.codes.nc.table import named_rows, rows_of
from achse.devices.nc.axes.controller import CONTROLLER_STATES
from achse.devices.nc.axes.drive import DRIVE_STATES
from achse.devices.nc.axes.encoder import ENCODER_STATES
from achse.devices.nc.functions.cams import CAM_STATES
from achse.devices.nc.layouts import (
    ONLINE_TC2,
    ONLINE_TC3,
    OfAxis,
)
from achse.devices.nc.rows import at_axis, bound, parameter, per_element, sample_of_floats, shown
from achse.motion import Axis, commands
from achse.motion.couplings.flying_saws.characteristic import (
    CHARACTERISTIC_VALUES,
    characteristic_of,
    course_of,
)
from achse.motion.fields.coupling import MASTERS
from achse.motion.states import SlaveType
from achse.server import Layout

_ROWS = named_rows(0x4100)

_ONLINE = bound(
    _ROWS["axis_online_structure"], codec=(ONLINE_TC2, ONLINE_TC3), read=lambda axis: axis
)


_REMAINING = bound(
    _ROWS["remaining_time_and_distance"],
    read=attrgetter("remaining_time", "remaining_distance"),
    sample=sample_of_floats("remaining_time", "remaining_distance"),
)


_STOP_INFORMATION = bound(
    _ROWS["stop_information"], exchange=lambda axis, ramp: commands.stop_information(axis, *ramp)
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
    "external_set_velocity",
    "external_set_acceleration",
    "external_set_direction",
    "external_set_jerk",
)
_FED_TORQUE = ("external_set_torque", "external_set_torque_derivative")

_SET_POINT_STRUCTURES = (
    bound(
        _ROWS["setpoint_structure"],
        codec=(
            _set_points(*_POSITION, *_DYNAMICS),
            _set_points(*_POSITION, *_DYNAMICS, "set_torque"),
            _set_points(*_POSITION, *_DYNAMICS, *_TORQUE),
        ),
        read=lambda axis: axis,
        write=_feed("external_set_position", *_FED_DYNAMICS, *_FED_TORQUE),
    ),
    bound(
        _ROWS["dynamic_setpoint_structure"],
        codec=(
            _set_points(*_DYNAMICS),
            _set_points(*_DYNAMICS, "set_torque"),
            _set_points(*_DYNAMICS, *_TORQUE),
        ),
        read=lambda axis: axis,
        write=_feed(*_FED_DYNAMICS, *_FED_TORQUE),
    ),
    bound(
        _ROWS["torque_setpoint_structure"],
        codec=_set_points(*_TORQUE),
        read=lambda axis: axis,
        write=_feed(*_FED_TORQUE),
    ),
)

_OPERATION_MODE = bound(
    _ROWS["drive_operation_mode"], exchange=lambda axis, _: (axis.drive_operation_mode,)
)


_COUPLING_PARAMETERS = bound(
    _ROWS["coupling_parameters"], read=lambda axis: tuple(axis.coupling.parameters)
)


class _RatioTo(NamedTuple):
    """The ratio of an axis to its master number `master`, the first for 0."""

    axis: Axis
    master: int

    @property
    def value(self) -> float:
        if self.master == 0:
            return self.axis.set_gear_ratio
        coupling = self.axis.coupling
        places = coupling.ratio_places[: coupling.master_count]
        if coupling.law != SlaveType.MULTI_MASTER:
            return self.axis.set_gear_ratio if self.master == 1 else 0.0
        return sum(coupling.ratios[n] for n, place in enumerate(places) if place == self.master - 1)


def _ratio_to(axis: Axis, n: int) -> _RatioTo:
    if n > MASTERS:
        raise DeviceError(NcError.AXIS_ID.number, f"an axis has {MASTERS} masters at most, not {n}")
    return _RatioTo(axis, n)


_GEAR_RATIO = bound(
    _ROWS["set_gear_ratio"],
    read=attrgetter("value"),
    element=_ratio_to,
    sample=lambda ratio, length: (
        None if ratio.master else ratio.axis.place_of("set_gear_ratio", min(length, 8))
    ),
)


def _characteristic(axis: Axis) -> tuple[float, ...]:
    course = course_of(axis)
    return tuple(characteristic_of(course)) if course else (0.0,) * CHARACTERISTIC_VALUES


_SYNCHRONISING = bound(_ROWS["sync_profile_characteristic_values"], read=_characteristic)

_REINITIALIZATION = replace(shown(_ROWS["encoder_reinitialization_state"]), offset=0x18)
"""The axis alone shows it, among the services of the encoder."""

AXIS_STATES = (
    _GEAR_RATIO,
    *per_element(
        _ONLINE,
        shown(_ROWS["set_cycle_counter"]),
        shown(_ROWS["set_position"]),
        shown(_ROWS["set_position_modulo"]),
        shown(_ROWS["set_modulo_turns"]),
        shown(_ROWS["set_direction"]),
        shown(_ROWS["set_velocity"]),
        shown(_ROWS["set_acceleration"]),
        shown(_ROWS["set_jerk"]),
        shown(_ROWS["set_torque"]),
        shown(_ROWS["target_position"]),
        _REMAINING,
        shown(_ROWS["set_command_number"]),
        shown(_ROWS["last_positioning_time"]),
        shown(_ROWS["set_velocity_override"]),
        shown(_ROWS["uncorrected_set_position"], "set_position"),
        shown(_ROWS["uncorrected_set_direction"], "set_direction"),
        shown(_ROWS["uncorrected_set_velocity"], "set_velocity"),
        shown(_ROWS["uncorrected_set_acceleration"], "set_acceleration"),
        *_SET_POINT_STRUCTURES,
    ),
    shown(_ROWS["error_code"]),
    _STOP_INFORMATION,
    shown(_ROWS["coupling_state"]),
    shown(_ROWS["coupling_table_index"]),
    _COUPLING_PARAMETERS,
    shown(_ROWS["gear_ratio"], "set_gear_ratio"),
    shown(_ROWS["active_control_loop"]),
    shown(_ROWS["external_setpoint_active"]),
    *CAM_STATES,
    _SYNCHRONISING,
    shown(_ROWS["delayed_error_code"]),
    shown(_ROWS["fading_position_difference"]),
    shown(_ROWS["fading_relative_velocity"]),
    shown(_ROWS["fading_relative_acceleration"]),
    shown(_ROWS["initialize_command_counter"]),
    shown(_ROWS["reset_command_counter"]),
    shown(_ROWS["set_torque_derivative"]),
    parameter(_ROWS["set_torque_offset"], NcError.REQUEST_PARAMETER),
    shown(_ROWS["setpoint_correction_counter"]),
    shown(_ROWS["set_motion_phase"]),
    shown(_ROWS["axis_disabled"]),
    _OPERATION_MODE,
    *at_axis("encoder_", rows_of(0x4100), (*ENCODER_STATES, _REINITIALIZATION)),
    *at_axis("controller_", rows_of(0x4100), CONTROLLER_STATES),
    *at_axis("drive_", rows_of(0x4100), DRIVE_STATES),
)
