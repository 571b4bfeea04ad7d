"""Controller services, 0x6000 and 0x6100 + ID. Source: 002 §6.4.6.

The axis shows most of these rows at 0x00n2_0000, n being the number of the controller.
"""

from collections.abc import Callable
from functools import partial
from operator import attrgetter

from achse.codes import NcError
from achse.codes.nc.choices import ControllerType
from achse.codes.nc.table import named_rows
from achse.devices.nc import rows
from achse.devices.nc.rows import bound, error_state
from achse.motion.parts import AxisController

_PARAMETERS = named_rows(0x6000)
_STATES = named_rows(0x6100)

parameter = partial(rows.parameter, prefix="controller_")
shown = partial(rows.shown, prefix="controller_")

FULL_OUTPUT_VOLTS = 10.0
"""Output of 100 % at an analog drive."""


def _id(controller: AxisController) -> int:
    owner = controller.owner
    return owner.controller_ids[owner.controllers.index(controller)]


CONTROLLER_PARAMETERS = (
    bound(_PARAMETERS["controller_id"], read=_id),
    bound(_PARAMETERS["controller_name"], read=attrgetter("name")),
    shown(_PARAMETERS["controller_type"]),
    parameter(_PARAMETERS["controller_mode"], NcError.CONTROLLER_MODE),
    parameter(_PARAMETERS["velocity_feedforward_weight"], NcError.CONTROLLER_FEEDFORWARD_WEIGHT),
    parameter(
        _PARAMETERS["following_error_position_monitoring_enable"],
        NcError.CONTROLLER_LAG_MONITORING_POSITION,
    ),
    parameter(
        _PARAMETERS["following_error_velocity_monitoring_enable"],
        NcError.CONTROLLER_LAG_MONITORING_VELOCITY,
    ),
    parameter(_PARAMETERS["following_error_position_max"], NcError.CONTROLLER_LAG_WINDOW_POSITION),
    parameter(
        _PARAMETERS["following_error_position_filter_time"], NcError.CONTROLLER_LAG_TIME_POSITION
    ),
    parameter(_PARAMETERS["following_error_velocity_max"], NcError.CONTROLLER_LAG_WINDOW_VELOCITY),
    parameter(
        _PARAMETERS["following_error_velocity_filter_time"], NcError.CONTROLLER_LAG_TIME_VELOCITY
    ),
    parameter(_PARAMETERS["following_error_difference_scaling"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["output_limit"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["position_kv"], NcError.CONTROLLER_KV),
    parameter(_PARAMETERS["position_tn"], NcError.CONTROLLER_TN),
    parameter(_PARAMETERS["position_tv"], NcError.CONTROLLER_TV),
    parameter(_PARAMETERS["position_td"], NcError.CONTROLLER_TD),
    parameter(_PARAMETERS["position_kv_fast"], NcError.CONTROLLER_ADDITIONAL_KV),
    parameter(
        _PARAMETERS["position_kv_velocity_threshold"], NcError.CONTROLLER_ADDITIONAL_KV_VELOCITY
    ),
    parameter(_PARAMETERS["acceleration_feedforward_ka"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["position_dead_band"], NcError.CONTROLLER_DEAD_BAND),
    parameter(_PARAMETERS["slave_coupling_kcp"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["auto_offset_enable"], NcError.CONTROLLER_AUTO_OFFSET),
    parameter(_PARAMETERS["auto_offset_hold"], NcError.CONTROLLER_AUTO_OFFSET),
    parameter(_PARAMETERS["auto_offset_fading"], NcError.CONTROLLER_AUTO_OFFSET),
    parameter(_PARAMETERS["auto_offset_feedforward_limit"], NcError.CONTROLLER_AUTO_OFFSET),
    parameter(_PARAMETERS["auto_offset_time_constant"], NcError.CONTROLLER_AUTO_OFFSET),
    parameter(_PARAMETERS["position_i_limit"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["position_d_limit"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["position_i_disable_while_positioning"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["position_error_filter_time"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["velocity_kp"], NcError.CONTROLLER_KV),
    parameter(_PARAMETERS["velocity_tn"], NcError.CONTROLLER_TN),
    parameter(_PARAMETERS["velocity_tv"], NcError.CONTROLLER_TV),
    parameter(_PARAMETERS["velocity_td"], NcError.CONTROLLER_TD),
    parameter(_PARAMETERS["velocity_i_limit"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["velocity_d_limit"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["velocity_dead_band"], NcError.CONTROLLER_DEAD_BAND),
    parameter(_PARAMETERS["velocity_error_pt2_filter"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["velocity_error_pt1_filter"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["observer_mode"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["motor_torque_constant"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["motor_inertia"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["observer_bandwidth"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["observer_correction_factor"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["observer_velocity_filter_time"], NcError.REQUEST_PARAMETER),
)


def _uncompensated(controller: AxisController) -> float:
    """Following error to the actual position without dead-time compensation."""
    return controller.following_error + controller.owner.encoder.dead_time_position_correction


def _kv(controller: AxisController) -> float:
    """Return the gain in force; only the PP controller changes it with the velocity."""
    if controller.type == ControllerType.PP_POSITION:
        return controller.position_kv_interpolated
    return controller.position_kv


def _volts(percent: float) -> float:
    return percent * FULL_OUTPUT_VOLTS / 100.0


_VELOCITY_TYPES = (ControllerType.P_VELOCITY, ControllerType.PI_VELOCITY)


def _velocity_or(
    other: Callable[[AxisController], float], part: str
) -> Callable[[AxisController], float]:
    """Return a part of the velocity controller, or `other` on axes without one.

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
    error_state(_STATES["error_state"], 0x4500),
    shown(_STATES["output_absolute"], "controller_output"),
    shown(_STATES["output_percent"]),
    bound(_STATES["output_volt"], read=lambda controller: _volts(controller.output_percent)),
    bound(_STATES["following_error_position_uncompensated"], read=_uncompensated),
    shown(_STATES["following_error_position_uncorrected"], "following_error"),
    shown(_STATES["following_error_position"], "following_error"),
    shown(_STATES["following_error_peak_negative"]),
    shown(_STATES["following_error_peak_positive"]),
    shown(_STATES["following_error_velocity"]),
    shown(_STATES["following_error_difference"]),
    shown(_STATES["following_error_difference_peak_negative"]),
    shown(_STATES["following_error_difference_peak_positive"]),
    shown(_STATES["position_p_part"]),
    shown(_STATES["position_i_part"]),
    shown(_STATES["position_d_part"]),
    shown(_STATES["position_i_limit_active"]),
    shown(_STATES["position_d_limit_active"]),
    shown(_STATES["position_arw_active"]),
    shown(_STATES["auto_offset_part"]),
    shown(_STATES["acceleration_feedforward"]),
    bound(_STATES["position_kv_interpolated"], read=_kv),
    bound(
        _STATES["velocity_part_absolute"],
        read=_velocity_or(_velocity_part, "controller_velocity_p_part"),
    ),
    bound(
        _STATES["velocity_part_percent"],
        read=_velocity_or(_velocity_percent, "controller_velocity_i_part"),
    ),
    bound(
        _STATES["velocity_part_volt"],
        read=_velocity_or(_velocity_volts, "controller_velocity_d_part"),
    ),
    shown(_STATES["velocity_i_limit_active"]),
    shown(_STATES["velocity_d_limit_active"]),
    shown(_STATES["velocity_arw_active"]),
    shown(_STATES["velocity_controller_input"]),
    shown(_STATES["observer_position_error"]),
    shown(_STATES["observer_position"]),
    shown(_STATES["observer_velocity2"]),
    shown(_STATES["observer_velocity1"]),
    shown(_STATES["observer_acceleration"]),
    shown(_STATES["observer_motor_current"]),
    shown(_STATES["observer_i_limit_active"]),
    shown(_STATES["mw_acceleration_feedforward"], "acceleration_feedforward"),
)
