"""Controller services, 0x6000 and 0x6100 + ID. Source: 002 §6.4.6.

The axis shows most of these rows at 0x00n2_0000, n being the number of the controller.
"""

from collections.abc import Callable
from functools import partial
from operator import attrgetter

from achse.codes import NcError
from achse.devices.nc import binding
from achse.devices.nc.binding import error_state, in_sub_range
from achse.devices.nc.layouts import REAL64, UINT16, UINT32, Text
from achse.motion.parts import AxisController
from achse.motion.states import ControllerType
from achse.server import READ, Service

__all__ = ["CONTROLLER_PARAMETERS", "CONTROLLER_STATES", "CONTROLLER_VIEWS"]

parameter = partial(binding.parameter, prefix="controller_")
shown = partial(binding.shown, prefix="controller_")

FULL_OUTPUT_VOLTS = 10.0
"""Output of 100 % at an analog drive."""


def _id(controller: AxisController) -> int:
    owner = controller.owner
    return owner.controller_ids[owner.controllers.index(controller)]


CONTROLLER_PARAMETERS = (
    Service(0x01, "controller_id", READ, UINT32, "id of the controller", "1", read=_id),
    Service(0x02, "controller_name", READ, Text(31), "name", read=attrgetter("name")),
    shown(0x03, UINT32, "controller_type"),
    parameter(0x0A, UINT32, NcError.CONTROLLER_MODE, "controller_mode"),
    parameter(0x0B, REAL64, NcError.CONTROLLER_FEEDFORWARD_WEIGHT, "velocity_feedforward_weight"),
    parameter(
        0x10,
        UINT16,
        NcError.CONTROLLER_LAG_MONITORING_POSITION,
        "following_error_position_monitoring_enable",
    ),
    parameter(
        0x11,
        UINT16,
        NcError.CONTROLLER_LAG_MONITORING_VELOCITY,
        "following_error_velocity_monitoring_enable",
    ),
    parameter(0x12, REAL64, NcError.CONTROLLER_LAG_WINDOW_POSITION, "following_error_position_max"),
    parameter(
        0x13, REAL64, NcError.CONTROLLER_LAG_TIME_POSITION, "following_error_position_filter_time"
    ),
    parameter(0x14, REAL64, NcError.CONTROLLER_LAG_WINDOW_VELOCITY, "following_error_velocity_max"),
    parameter(
        0x15, REAL64, NcError.CONTROLLER_LAG_TIME_VELOCITY, "following_error_velocity_filter_time"
    ),
    parameter(0x21, REAL64, NcError.REQUEST_PARAMETER, "following_error_difference_scaling"),
    parameter(0x100, REAL64, NcError.REQUEST_PARAMETER, "output_limit"),
    parameter(0x102, REAL64, NcError.CONTROLLER_KV, "position_kv"),
    parameter(0x103, REAL64, NcError.CONTROLLER_TN, "position_tn"),
    parameter(0x104, REAL64, NcError.CONTROLLER_TV, "position_tv"),
    parameter(0x105, REAL64, NcError.CONTROLLER_TD, "position_td"),
    parameter(0x106, REAL64, NcError.CONTROLLER_ADDITIONAL_KV, "position_kv_fast"),
    parameter(
        0x107, REAL64, NcError.CONTROLLER_ADDITIONAL_KV_VELOCITY, "position_kv_velocity_threshold"
    ),
    parameter(0x108, REAL64, NcError.REQUEST_PARAMETER, "acceleration_feedforward_ka"),
    parameter(0x10D, REAL64, NcError.CONTROLLER_DEAD_BAND, "position_dead_band"),
    parameter(0x10F, REAL64, NcError.REQUEST_PARAMETER, "slave_coupling_kcp"),
    parameter(0x110, UINT16, NcError.CONTROLLER_AUTO_OFFSET, "auto_offset_enable"),
    parameter(0x111, UINT16, NcError.CONTROLLER_AUTO_OFFSET, "auto_offset_hold"),
    parameter(0x112, UINT16, NcError.CONTROLLER_AUTO_OFFSET, "auto_offset_fading"),
    parameter(0x114, REAL64, NcError.CONTROLLER_AUTO_OFFSET, "auto_offset_feedforward_limit"),
    parameter(0x115, REAL64, NcError.CONTROLLER_AUTO_OFFSET, "auto_offset_time_constant"),
    parameter(0x116, REAL64, NcError.REQUEST_PARAMETER, "position_i_limit"),
    parameter(0x117, REAL64, NcError.REQUEST_PARAMETER, "position_d_limit"),
    parameter(0x118, UINT16, NcError.REQUEST_PARAMETER, "position_i_disable_while_positioning"),
    parameter(0x120, REAL64, NcError.REQUEST_PARAMETER, "position_error_filter_time"),
    parameter(0x202, REAL64, NcError.CONTROLLER_KV, "velocity_kp"),
    parameter(0x203, REAL64, NcError.CONTROLLER_TN, "velocity_tn"),
    parameter(0x204, REAL64, NcError.CONTROLLER_TV, "velocity_tv"),
    parameter(0x205, REAL64, NcError.CONTROLLER_TD, "velocity_td"),
    parameter(0x206, REAL64, NcError.REQUEST_PARAMETER, "velocity_i_limit"),
    parameter(0x207, REAL64, NcError.REQUEST_PARAMETER, "velocity_d_limit"),
    parameter(0x20D, REAL64, NcError.CONTROLLER_DEAD_BAND, "velocity_dead_band"),
    parameter(0x220, REAL64, NcError.REQUEST_PARAMETER, "velocity_error_pt2_filter"),
    parameter(0x221, REAL64, NcError.REQUEST_PARAMETER, "velocity_error_pt1_filter"),
    parameter(0x250, UINT32, NcError.REQUEST_PARAMETER, "observer_mode"),
    parameter(0x251, REAL64, NcError.REQUEST_PARAMETER, "motor_torque_constant"),
    parameter(0x252, REAL64, NcError.REQUEST_PARAMETER, "motor_inertia"),
    parameter(0x253, REAL64, NcError.REQUEST_PARAMETER, "observer_bandwidth"),
    parameter(0x254, REAL64, NcError.REQUEST_PARAMETER, "observer_correction_factor"),
    parameter(0x255, REAL64, NcError.REQUEST_PARAMETER, "observer_velocity_filter_time"),
)


def _uncompensated(controller: AxisController) -> float:
    """Following error to the actual position without dead-time compensation."""
    return controller.following_error + controller.owner.encoder.dead_time_position_correction


def _kv(controller: AxisController) -> float:
    """The gain in force; only the PP controller changes it with the velocity."""
    if controller.type == ControllerType.PP_POSITION:
        return controller.position_kv_interpolated
    return controller.position_kv


def _volts(percent: float) -> float:
    return percent * FULL_OUTPUT_VOLTS / 100.0


_VELOCITY_TYPES = (ControllerType.P_VELOCITY, ControllerType.PI_VELOCITY)


def _velocity_or(
    other: Callable[[AxisController], float], part: str
) -> Callable[[AxisController], float]:
    """A part of the velocity controller, or `other` on axes without one.

    At 0x201 … 0x203 two rows share an offset: which one answers follows from the controller type.
    """
    own = attrgetter(part)

    def read(controller: AxisController) -> float:
        return float((own if controller.type in _VELOCITY_TYPES else other)(controller))

    return read


def _velocity_part(controller: AxisController) -> float:
    """Feed-forward of the velocity: what the output has beside the position controller."""
    if not controller.owner.loop_closed:
        return 0.0
    return controller.velocity_feedforward_weight * controller.owner.set_velocity


def _velocity_percent(controller: AxisController) -> float:
    return 100.0 * _velocity_part(controller) / controller.owner.drive.full


def _velocity_volts(controller: AxisController) -> float:
    return _volts(_velocity_percent(controller))


CONTROLLER_STATES = (
    error_state(0x4500, "error code of the controller"),
    shown(0x02, REAL64, "output_absolute", "controller_output", symbol="CtrlOutput"),
    shown(0x03, REAL64, "output_percent"),
    Service(
        0x04, "output_volt", READ, REAL64, "output of the controller", "V",
        read=lambda controller: _volts(controller.output_percent),
    ),
    Service(
        0x0D, "following_error_position_uncompensated", READ, REAL64,
        "following error without dead-time compensation", "mm", read=_uncompensated,
    ),
    shown(0x0E, REAL64, "following_error_position_uncorrected", "following_error"),
    shown(0x0F, REAL64, "following_error_position", "following_error", symbol="PosDiff"),
    shown(0x10, REAL64, "following_error_peak_negative"),
    shown(0x11, REAL64, "following_error_peak_positive"),
    shown(0x12, REAL64, "following_error_velocity"),
    shown(0x21, REAL64, "following_error_difference", symbol="PosDiffCouple"),
    shown(0x22, REAL64, "following_error_difference_peak_negative"),
    shown(0x23, REAL64, "following_error_difference_peak_positive"),
    shown(0x101, REAL64, "position_p_part"),
    shown(0x102, REAL64, "position_i_part"),
    shown(0x103, REAL64, "position_d_part"),
    shown(0x104, UINT16, "position_i_limit_active"),
    shown(0x105, UINT16, "position_d_limit_active"),
    shown(0x106, UINT16, "position_arw_active"),
    shown(0x10F, REAL64, "auto_offset_part"),
    shown(0x110, REAL64, "acceleration_feedforward"),
    Service(
        0x111, "position_kv_interpolated", READ, REAL64, "gain in force", "1/s", read=_kv,
    ),
    Service(
        0x201, "velocity_part_absolute", READ, REAL64,
        "velocity part of the output; with a velocity controller its P-part", "mm/s",
        read=_velocity_or(_velocity_part, "controller_velocity_p_part"),
    ),
    Service(
        0x202, "velocity_part_percent", READ, REAL64,
        "velocity part of the output in %; with a velocity controller its I-part", "%, mm/s",
        read=_velocity_or(_velocity_percent, "controller_velocity_i_part"),
    ),
    Service(
        0x203, "velocity_part_volt", READ, REAL64,
        "velocity part of the output in V; with a velocity controller its D-part", "V, mm/s",
        read=_velocity_or(_velocity_volts, "controller_velocity_d_part"),
    ),
    shown(0x204, UINT16, "velocity_i_limit_active"),
    shown(0x205, UINT16, "velocity_d_limit_active"),
    shown(0x206, UINT16, "velocity_arw_active"),
    shown(0x20A, REAL64, "velocity_controller_input"),
    shown(0x250, REAL64, "observer_position_error"),
    shown(0x251, REAL64, "observer_position"),
    shown(0x252, REAL64, "observer_velocity2"),
    shown(0x253, REAL64, "observer_velocity1"),
    shown(0x254, REAL64, "observer_acceleration"),
    shown(0x255, REAL64, "observer_motor_current"),
    shown(0x256, UINT16, "observer_i_limit_active"),
    shown(0xA10, REAL64, "mw_acceleration_feedforward", "acceleration_feedforward"),
)  # fmt: skip

CONTROLLER_VIEWS = {
    "parameters": tuple(in_sub_range("controller_", CONTROLLER_PARAMETERS, without={0x21})),
    "states": tuple(
        in_sub_range("controller_", CONTROLLER_STATES, without={0x0E, 0x10F, *range(0x250, 0x257)})
    ),
}
"""The rows as the axis shows them."""
