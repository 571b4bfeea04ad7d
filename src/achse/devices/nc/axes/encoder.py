"""Encoder services, 0x5000 and 0x5100 + ID. Source: 002 §6.4.5.

The axis shows most of these rows at 0x00n1_0000, n being the number of the encoder.
"""

from functools import partial
from operator import attrgetter

from achse.ams import DeviceError
from achse.codes import NcError
from achse.codes.nc.table import named_rows
from achse.devices.nc import rows
from achse.devices.nc.axes.touch_probe import TOUCH_PROBE
from achse.devices.nc.rows import bound, error_state, not_while_enabled
from achse.motion.fields.encoder import POSITION_HISTORY
from achse.motion.parts import AxisEncoder

_PARAMETERS = named_rows(0x5000)
_STATES = named_rows(0x5100)

parameter = partial(rows.parameter, prefix="encoder_")
shown = partial(rows.shown, prefix="encoder_")
scaling = partial(parameter, guard=not_while_enabled)
"""A parameter that scales position or direction."""


def _id(encoder: AxisEncoder) -> int:
    owner = encoder.owner
    return owner.encoder_ids[owner.encoders.index(encoder)]


def _set_scaling(encoder: AxisEncoder, numerator: float, denominator: float) -> None:
    factor = numerator / denominator
    if not 1e-12 <= factor <= 1e30:
        raise DeviceError(NcError.ENCODER_SCALING_FACTOR.number, f"scaling factor {factor:g}")
    encoder.scaling_numerator = numerator
    encoder.scaling_denominator = denominator
    encoder.scaling_factor = factor


def _set_factor(encoder: AxisEncoder, factor: float) -> None:
    _set_scaling(encoder, factor, 1.0)


def _set_numerator(encoder: AxisEncoder, numerator: float) -> None:
    _set_scaling(encoder, numerator, encoder.scaling_denominator)


def _set_denominator(encoder: AxisEncoder, denominator: float) -> None:
    _set_scaling(encoder, encoder.scaling_numerator, denominator)


def _set_components(encoder: AxisEncoder, components: tuple[float, float]) -> None:
    if not all(1e-12 <= part <= 1e30 for part in components):
        raise DeviceError(NcError.ENCODER_SCALING_FACTOR.number, f"components {components}")
    _set_scaling(encoder, *components)


def _set_sub_mask(encoder: AxisEncoder, sub_mask: int) -> None:
    """Set the sub mask 2^n - 1; the encoder's range is a whole multiple of it (213)."""
    if sub_mask & (sub_mask + 1) or sub_mask > encoder.mask or (encoder.mask + 1) % (sub_mask + 1):
        raise DeviceError(NcError.ENCODER_HOMING_MASK.number, f"sub mask 0x{sub_mask:X}")
    encoder.sub_mask = sub_mask


def _set_tolerance_window(encoder: AxisEncoder, window: float) -> None:
    if window > 0.5 * encoder.modulo_factor:
        raise DeviceError(
            NcError.ENCODER_MODULO_TOLERANCE_WINDOW.number,
            f"window {window:g}, at most half a period",
        )
    encoder.modulo_tolerance_window = window


ENCODER_PARAMETERS = (
    bound(_PARAMETERS["encoder_id"], read=_id),
    bound(_PARAMETERS["encoder_name"], read=attrgetter("name")),
    shown(_PARAMETERS["encoder_type"]),
    parameter(_PARAMETERS["input_address_offset"], NcError.ENCODER_ADDRESS_INPUT),
    parameter(_PARAMETERS["output_address_offset"], NcError.ENCODER_ADDRESS_OUTPUT),
    scaling(_PARAMETERS["scaling_factor"], NcError.ENCODER_SCALING_FACTOR, write=_set_factor),
    scaling(_PARAMETERS["position_offset"], NcError.ENCODER_POSITION_OFFSET),
    scaling(_PARAMETERS["count_direction"], NcError.ENCODER_COUNT_DIRECTION),
    parameter(_PARAMETERS["modulo_factor"], NcError.ENCODER_MODULO_FACTOR),
    parameter(_PARAMETERS["encoder_mode"], NcError.ENCODER_MODE),
    parameter(_PARAMETERS["soft_limit_min_enable"], NcError.ENCODER_SOFT_LIMIT_MIN_ENABLE),
    parameter(_PARAMETERS["soft_limit_max_enable"], NcError.ENCODER_SOFT_LIMIT_MAX_ENABLE),
    parameter(_PARAMETERS["soft_limit_min"], NcError.ENCODER_SOFT_LIMIT_MIN),
    parameter(_PARAMETERS["soft_limit_max"], NcError.ENCODER_SOFT_LIMIT_MAX),
    parameter(_PARAMETERS["evaluation_direction"], NcError.ENCODER_EVALUATION_DIRECTION),
    parameter(_PARAMETERS["position_filter_time"], NcError.ENCODER_POSITION_FILTER_TIME),
    parameter(_PARAMETERS["velocity_filter_time"], NcError.ENCODER_VELOCITY_FILTER_TIME),
    parameter(_PARAMETERS["acceleration_filter_time"], NcError.ENCODER_ACCELERATION_FILTER_TIME),
    scaling(_PARAMETERS["encoder_mask"], NcError.ENCODER_RAW_MASK),
    parameter(
        _PARAMETERS["actual_position_correction_enable"], NcError.ENCODER_POSITION_CORRECTION
    ),
    parameter(
        _PARAMETERS["actual_position_correction_filter_time"],
        NcError.ENCODER_POSITION_CORRECTION_FILTER,
    ),
    parameter(_PARAMETERS["raw_value_filter_mask"], NcError.ENCODER_RAW_MASK),
    scaling(_PARAMETERS["reference_system"], NcError.ENCODER_REFERENCE_SYSTEM),
    parameter(
        _PARAMETERS["modulo_tolerance_window"],
        NcError.ENCODER_MODULO_TOLERANCE_WINDOW,
        write=_set_tolerance_window,
    ),
    shown(_PARAMETERS["sign_interpretation"]),
    shown(_PARAMETERS["is_absolute"]),
    parameter(_PARAMETERS["dead_time_compensation_mode"], NcError.DEAD_TIME_COMPENSATION),
    parameter(_PARAMETERS["dead_time_compensation_control"], NcError.DEAD_TIME_COMPENSATION),
    parameter(_PARAMETERS["dead_time_compensation_shift"], NcError.DEAD_TIME_COMPENSATION),
    scaling(_PARAMETERS["scaling_numerator"], NcError.ENCODER_SCALING_FACTOR, write=_set_numerator),
    scaling(
        _PARAMETERS["scaling_denominator"], NcError.ENCODER_SCALING_FACTOR, write=_set_denominator
    ),
    bound(
        _PARAMETERS["scaling_factor_components"],
        read=attrgetter("encoder_scaling_numerator", "encoder_scaling_denominator"),
        write=_set_components,
        code=NcError.ENCODER_SCALING_FACTOR.number,
        guard=not_while_enabled,
    ),
    parameter(_PARAMETERS["control_dword"], NcError.REQUEST_PARAMETER, "encoder_control_dword"),
    parameter(_PARAMETERS["homing_cam_search_inverse"], NcError.ENCODER_CAM_SEARCH_DIRECTION),
    parameter(_PARAMETERS["sync_pulse_search_inverse"], NcError.ENCODER_SYNC_SEARCH_DIRECTION),
    parameter(_PARAMETERS["reference_position"], NcError.ENCODER_REFERENCE_POSITION),
    parameter(_PARAMETERS["external_sync_pulse"], NcError.ENCODER_EXTERNAL_SYNC_PULSE),
    parameter(_PARAMETERS["reference_mode"], NcError.ENCODER_REFERENCE_MODE),
    parameter(_PARAMETERS["encoder_sub_mask"], NcError.ENCODER_HOMING_MASK, write=_set_sub_mask),
    parameter(_PARAMETERS["homing_sensor_source"], NcError.ENCODER_REFERENCE_MODE),
    bound(
        _PARAMETERS["simulation_noise_scaling"],
        field="encoder_simulation_noise_scaling",
        code=NcError.REQUEST_PARAMETER.number,
    ),
)


def _uncorrected(encoder: AxisEncoder) -> float:
    return encoder.actual_position - encoder.position_correction


def _uncorrected_velocity(encoder: AxisEncoder) -> float:
    if encoder.special:
        return encoder.actual_velocity_uncorrected
    return encoder.actual_velocity


def _shift(encoder: AxisEncoder) -> float:
    mode = encoder.dead_time_compensation_mode
    return encoder.dead_time_compensation_shift * 1e-9 if mode else 0.0


def _reduction(encoder: AxisEncoder) -> float:
    return encoder.actual_position_modulo - encoder.actual_position


def _history(encoder: AxisEncoder) -> list[tuple[int, float]]:
    """Actual positions with their times, oldest first; the time is that of the NC, 32 bits."""
    now = encoder.owner.set_cycle_counter
    return [
        (
            (now - age) * encoder.owner.cycle_ns & 0xFFFF_FFFF,
            encoder.history[(now - age) % POSITION_HISTORY],
        )
        for age in range(POSITION_HISTORY - 1, -1, -1)
    ]


ENCODER_STATES = (
    error_state(_STATES["error_state"], 0x4400),
    shown(_STATES["actual_position"]),
    shown(_STATES["actual_position_modulo"]),
    shown(_STATES["actual_modulo_turns"]),
    shown(_STATES["actual_velocity"]),
    shown(_STATES["actual_acceleration"]),
    shown(_STATES["hardware_increments"]),
    shown(_STATES["software_increments"]),
    bound(_STATES["homed_flag"], field="homed", code=NcError.ENCODER_HOMED_FLAG),
    shown(_STATES["position_correction"]),
    bound(_STATES["actual_position_uncorrected"], read=_uncorrected),
    shown(_STATES["dead_time_position_correction"]),
    bound(_STATES["dead_time_total_shift"], read=_shift),
    bound(_STATES["modulo_reduction_offset"], read=_reduction),
    bound(_STATES["actual_velocity_uncorrected"], read=_uncorrected_velocity),
    shown(_STATES["actual_position_unfiltered"]),
    shown(_STATES["actual_position_filtered"]),
    bound(_STATES["drive_actual_velocity"], read=attrgetter("owner.drive_actual_velocity")),
    shown(_STATES["actual_velocity_unfiltered"]),
    bound(_STATES["actual_position_buffer"], read=_history),
    shown(_STATES["set_position_offset"]),
    *TOUCH_PROBE,
)

"""The rows as the axis shows them."""
