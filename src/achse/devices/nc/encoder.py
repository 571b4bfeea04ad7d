"""Encoder services, 0x5000 and 0x5100 + ID. Source: 002 §6.4.5.

The axis shows most of these rows at 0x00n1_0000, n being the number of the encoder.
"""

from functools import partial
from operator import attrgetter

from achse.ams import DeviceError
from achse.codes import NcError
from achse.devices.nc import binding
from achse.devices.nc.binding import error_state, in_sub_range, not_while_enabled
from achse.devices.nc.layouts import INT32, INT64, REAL64, UINT16, UINT32, Text
from achse.devices.nc.touch_probe import TOUCH_PROBE
from achse.motion.machine.record import PARAMETERS as MACHINE_PARAMETERS
from achse.motion.parts import AxisEncoder
from achse.motion.record import POSITION_HISTORY
from achse.server import READ, WRITE, Layout, Repeated, Service

__all__ = ["ENCODER_PARAMETERS", "ENCODER_STATES", "ENCODER_VIEWS"]

parameter = partial(binding.parameter, prefix="encoder_")
shown = partial(binding.shown, prefix="encoder_")
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
    """Of the form 2^n - 1; the range of the encoder is a whole multiple of it (213)."""
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


_, NOISE = MACHINE_PARAMETERS["encoder_simulation_noise_scaling"]

ENCODER_PARAMETERS = (
    Service(0x01, "encoder_id", READ, UINT32, "id of the encoder", "1", read=_id),
    Service(0x02, "encoder_name", READ, Text(31), "name", read=attrgetter("name")),
    shown(0x03, UINT32, "encoder_type"),
    parameter(0x04, UINT32, NcError.ENCODER_ADDRESS_INPUT, "input_address_offset"),
    parameter(0x05, UINT32, NcError.ENCODER_ADDRESS_OUTPUT, "output_address_offset"),
    scaling(0x06, REAL64, NcError.ENCODER_SCALING_FACTOR, "scaling_factor", write=_set_factor),
    scaling(0x07, REAL64, NcError.ENCODER_POSITION_OFFSET, "position_offset"),
    scaling(0x08, UINT16, NcError.ENCODER_COUNT_DIRECTION, "count_direction"),
    parameter(0x09, REAL64, NcError.ENCODER_MODULO_FACTOR, "modulo_factor"),
    parameter(0x0A, UINT32, NcError.ENCODER_MODE, "encoder_mode"),
    parameter(0x0B, UINT16, NcError.ENCODER_SOFT_LIMIT_MIN_ENABLE, "soft_limit_min_enable"),
    parameter(0x0C, UINT16, NcError.ENCODER_SOFT_LIMIT_MAX_ENABLE, "soft_limit_max_enable"),
    parameter(0x0D, REAL64, NcError.ENCODER_SOFT_LIMIT_MIN, "soft_limit_min"),
    parameter(0x0E, REAL64, NcError.ENCODER_SOFT_LIMIT_MAX, "soft_limit_max"),
    parameter(0x0F, UINT32, NcError.ENCODER_EVALUATION_DIRECTION, "evaluation_direction"),
    parameter(0x10, REAL64, NcError.ENCODER_POSITION_FILTER_TIME, "position_filter_time"),
    parameter(0x11, REAL64, NcError.ENCODER_VELOCITY_FILTER_TIME, "velocity_filter_time"),
    parameter(0x12, REAL64, NcError.ENCODER_ACCELERATION_FILTER_TIME, "acceleration_filter_time"),
    scaling(0x15, UINT32, NcError.ENCODER_RAW_MASK, "encoder_mask"),
    parameter(
        0x16, UINT16, NcError.ENCODER_POSITION_CORRECTION, "actual_position_correction_enable"
    ),
    parameter(
        0x17,
        REAL64,
        NcError.ENCODER_POSITION_CORRECTION_FILTER,
        "actual_position_correction_filter_time",
    ),
    parameter(0x18, UINT32, NcError.ENCODER_RAW_MASK, "raw_value_filter_mask"),
    scaling(0x19, UINT32, NcError.ENCODER_REFERENCE_SYSTEM, "reference_system"),
    parameter(
        0x1B,
        REAL64,
        NcError.ENCODER_MODULO_TOLERANCE_WINDOW,
        "modulo_tolerance_window",
        write=_set_tolerance_window,
    ),
    shown(0x1C, UINT32, "sign_interpretation"),
    shown(0x1D, UINT16, "is_absolute"),
    parameter(0x20, UINT32, NcError.DEAD_TIME_COMPENSATION, "dead_time_compensation_mode"),
    parameter(0x21, UINT32, NcError.DEAD_TIME_COMPENSATION, "dead_time_compensation_control"),
    parameter(0x22, INT32, NcError.DEAD_TIME_COMPENSATION, "dead_time_compensation_shift"),
    scaling(
        0x23, REAL64, NcError.ENCODER_SCALING_FACTOR, "scaling_numerator", write=_set_numerator
    ),
    scaling(
        0x24, REAL64, NcError.ENCODER_SCALING_FACTOR, "scaling_denominator", write=_set_denominator
    ),
    Service(
        0x25,
        "scaling_factor_components",
        READ | WRITE,
        Layout("<dd"),
        "numerator and denominator of the scaling factor",
        "mm/INC, 1",
        read=attrgetter("encoder_scaling_numerator", "encoder_scaling_denominator"),
        write=_set_components,
        code=NcError.ENCODER_SCALING_FACTOR.number,
        guard=not_while_enabled,
    ),
    parameter(0x30, UINT32, NcError.REQUEST_PARAMETER, "control_dword", "encoder_control_dword"),
    parameter(0x101, UINT16, NcError.ENCODER_CAM_SEARCH_DIRECTION, "homing_cam_search_inverse"),
    parameter(0x102, UINT16, NcError.ENCODER_SYNC_SEARCH_DIRECTION, "sync_pulse_search_inverse"),
    parameter(0x103, REAL64, NcError.ENCODER_REFERENCE_POSITION, "reference_position"),
    parameter(0x106, UINT16, NcError.ENCODER_EXTERNAL_SYNC_PULSE, "external_sync_pulse"),
    parameter(0x107, UINT32, NcError.ENCODER_REFERENCE_MODE, "reference_mode"),
    parameter(0x108, UINT32, NcError.ENCODER_HOMING_MASK, "encoder_sub_mask", write=_set_sub_mask),
    parameter(0x109, UINT32, NcError.ENCODER_REFERENCE_MODE, "homing_sensor_source"),
    Service(
        0x110,
        "simulation_noise_scaling",
        READ | WRITE,
        REAL64,
        NOISE.doc,
        NOISE.unit,
        field="encoder_simulation_noise_scaling",
        minimum=NOISE.least,
        maximum=NOISE.most,
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
    error_state(0x4400, "error code of the encoder"),
    shown(0x02, REAL64, "actual_position", symbol="ActPos"),
    shown(0x03, REAL64, "actual_position_modulo", symbol="ActPosModulo"),
    shown(0x04, INT32, "actual_modulo_turns"),
    shown(0x05, REAL64, "actual_velocity", symbol="ActVelo"),
    shown(0x06, REAL64, "actual_acceleration", symbol="ActAcc"),
    shown(0x07, INT32, "hardware_increments"),
    shown(0x08, INT64, "software_increments"),
    Service(
        0x09, "homed_flag", READ | WRITE, UINT16, "the axis is homed", "1",
        field="homed",
        minimum=0, maximum=1, code=NcError.ENCODER_HOMED_FLAG,
    ),
    shown(0x0A, REAL64, "position_correction"),
    Service(
        0x0B, "actual_position_uncorrected", READ, REAL64,
        "actual position without the position correction", "mm", read=_uncorrected,
    ),
    shown(0x0C, REAL64, "dead_time_position_correction"),
    Service(
        0x0D, "dead_time_total_shift", READ, REAL64, "dead time that is compensated", "s",
        read=_shift,
    ),
    Service(
        0x0E, "modulo_reduction_offset", READ, REAL64, "from the position to its modulo part",
        "mm", read=_reduction,
    ),
    Service(
        0x10, "actual_velocity_uncorrected", READ, REAL64,
        "actual velocity without that of the position correction", "mm/s",
        read=_uncorrected_velocity,
    ),
    shown(0x12, REAL64, "actual_position_unfiltered"),
    shown(0x13, REAL64, "actual_position_filtered"),
    Service(
        0x14, "drive_actual_velocity", READ, REAL64, "velocity as the drive itself knows it",
        "mm/s", read=attrgetter("owner.drive_actual_velocity"),
    ),
    shown(0x15, REAL64, "actual_velocity_unfiltered"),
    Service(
        0x16, "actual_position_buffer", READ, Repeated(Layout("<I4xd")),
        "the last actual positions with time stamps, oldest first", "ns, mm", read=_history,
    ),
    shown(0x17, REAL64, "set_position_offset"),
    *TOUCH_PROBE,
)  # fmt: skip

_NOT_AT_THE_AXIS = {0x18, 0x20, 0x21, 0x22, 0x109}
_STATES_NOT_AT_THE_AXIS = {
    0x01, 0x0C, 0x0D, 0x0E, 0x13, 0x16,
    *range(0x200, 0x214),
}  # fmt: skip

ENCODER_VIEWS = {
    "parameters": tuple(
        in_sub_range("encoder_", ENCODER_PARAMETERS, without=_NOT_AT_THE_AXIS, read_only={0x15})
    ),
    "states": tuple(
        in_sub_range("encoder_", ENCODER_STATES, without=_STATES_NOT_AT_THE_AXIS, read_only={0x09})
    ),
}
"""The rows as the axis shows them."""
