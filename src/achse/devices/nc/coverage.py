"""What the manual lists and no row serves, and parameters without effect: each with its reason.

With the rows themselves this is the coverage page, `docs/coverage/nc.md`. Source: 002 §6.4.
"""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from achse.codes import ReservedGroup
from achse.devices.nc.device import AXIS_GROUPS
from achse.devices.nc.unserved import OF_CHANNELS_AND_GROUPS
from achse.server import RowFacts

__all__ = ["CONSTANT", "UNSERVED", "WITHOUT_EFFECT", "Covered", "coverage"]


class Covered(NamedTuple):
    """A service of the manual and what comes of it; ids and numbers are those of the first."""

    index_group: int
    index_offset: int
    access: str
    name: str
    answer: str


_UNSERVED = {
    "a longer form of the row at the same offset: told by length": (
        (0x4000, 0x31, "R", "hardware_ams_address_extended"),
        (0x4100, 0x60, "RW", "setpoint_structure_extended"),
        (0x4100, 0x61, "RW", "dynamic_setpoint_structure_extended"),
        (0x5100, 0x201, "R", "latch_active_canopen"),
        (0x5100, 0x202, "R", "latch_valid_canopen"),
        (0x5100, 0x205, "R", "latch_position_canopen"),
        (0x5100, 0x210, "R", "latch_rising_edge_active_canopen"),
        (0x5100, 0x211, "R", "latch_falling_edge_active_canopen"),
        (0x5300, 0x0, "RW", "output_structure_64bit"),
        (0x5300, 0x80, "R", "input_structure_64bit"),
    ),
    "not implemented by the NC of the manual either: answers 0x703": (
        (0x4000, 0x205, "RW", "stepper_sync_pulse_mask"),
        (0x4000, 0x10013, "RW", "encoder_physical_unit"),
        (0x4000, 0x10014, "RW", "encoder_unit_interpretation"),
        (0x4000, 0x1001A, "R", "encoder_position_initialization"),
        (0x4000, 0x10104, "RW", "encoder_cam_sync_distance_monitoring_enable"),
        (0x4000, 0x10105, "RW", "encoder_cam_sync_min_distance"),
        (0x5000, 0x13, "RW", "physical_unit"),
        (0x5000, 0x14, "RW", "unit_interpretation"),
        (0x5000, 0x1A, "RW", "position_initialization"),
        (0x5000, 0x104, "RW", "cam_sync_distance_monitoring_enable"),
        (0x5000, 0x105, "RW", "cam_sync_min_distance"),
    ),
    "reserved, of the pressure controller PID (MW): of no printed controller type, law, source of "
    "the set pressure or switch from position control: answers 0x703": (
        (0x4000, 0x20A03, "RW", "controller_cylinder_area_a"),
        (0x4000, 0x20A04, "RW", "controller_cylinder_area_b"),
        (0x4000, 0x20A05, "RW", "controller_nominal_volume_flow"),
        (0x4000, 0x20A06, "RW", "controller_nominal_pressure"),
        (0x4000, 0x20A07, "RW", "controller_system_pressure_axis_id"),
        (0x4100, 0x20A00, "R", "controller_mw_velocity_feedforward"),
        (0x4100, 0x20A01, "R", "controller_mw_p_part"),
        (0x4100, 0x20A02, "R", "controller_mw_i_part"),
        (0x4100, 0x20A03, "R", "controller_mw_d_part"),
        (0x4100, 0x20A04, "R", "controller_mw_i_limit_active"),
        (0x4100, 0x20A05, "R", "controller_mw_d_limit_active"),
        (0x4100, 0x20A06, "R", "controller_mw_arw_active"),
        (0x6000, 0xA03, "RW", "cylinder_area_a"),
        (0x6000, 0xA04, "RW", "cylinder_area_b"),
        (0x6000, 0xA05, "RW", "nominal_volume_flow"),
        (0x6000, 0xA06, "RW", "nominal_pressure"),
        (0x6000, 0xA07, "RW", "system_pressure_axis_id"),
        (0x6100, 0xA00, "R", "mw_velocity_feedforward"),
        (0x6100, 0xA01, "R", "mw_p_part"),
        (0x6100, 0xA02, "R", "mw_i_part"),
        (0x6100, 0xA03, "R", "mw_d_part"),
        (0x6100, 0xA04, "R", "mw_i_limit_active"),
        (0x6100, 0xA05, "R", "mw_d_limit_active"),
    ),
    "shares its offset with `velocity_part_…`; the controller type tells which answers": (
        (0x4100, 0x20201, "R", "controller_velocity_p_part"),
        (0x4100, 0x20202, "R", "controller_velocity_i_part"),
        (0x4100, 0x20203, "R", "controller_velocity_d_part"),
        (0x6100, 0x201, "R", "velocity_p_part"),
        (0x6100, 0x202, "R", "velocity_i_part"),
        (0x6100, 0x203, "R", "velocity_d_part"),
    ),
    "reserved, no standard: of its 32 bytes no manual prints a field, nor what offset it "
    "calculates: answers 0x703": (
        (0x4200, 0x2A, "W", "calculate_encoder_offset"),
    ),
    "reserved, without layout or meaning: answers 0x703": (
        (0x4200, 0x2E, "", "reserved_2e"),
        (0x4200, 0x2F, "", "reserved_2f"),
        (0x4300, 0xC2, "R", "reserved_c2"),
        (0x4300, 0xC3, "R", "reserved_c3"),
        (0x4300, 0xC4, "R", "reserved_c4"),
    ),
    "another form of the row at the same offset: told by length": (
        (0x4200, 0x40, "W", "couple_multi_master"),
        (0x4200, 0x41, "W", "decouple_with_follow_up"),
        (0x4200, 0x43, "W", "change_table_coupling_at_position"),
        (0x4200, 0x43, "W", "change_table_coupling_offsets_scaling"),
        (0x4200, 0x46, "W", "activate_correction_table_at_position"),
        (0x4200, 0x4A, "W", "couple_multi_cam"),
        (0x5200, 0x201, "W", "activate_latch_rising_canopen"),
        (0x5200, 0x202, "W", "activate_latch_falling_canopen"),
        (0x5200, 0x205, "W", "deactivate_latch"),
        (0x5200, 0x205, "W", "deactivate_latch_canopen"),
    ),
    "of a reserved filter without a documented effect: answers 0x703": (
        (0x6000, 0x10A, "RW", "set_velocity_slope_filter_mode"),
        (0x6000, 0x10B, "RW", "set_velocity_slope_filter_value"),
        (0x6100, 0x11A, "R", "set_velocity_filter_phase"),
        (0x6100, 0x11B, "R", "set_velocity_filter_position_error"),
        (0x6100, 0x11C, "R", "set_velocity_filter_test_velocity"),
        (0x6100, 0x11D, "R", "set_velocity_filter_limited_velocity"),
        (0x6100, 0x11E, "R", "set_velocity_filter_acceleration"),
        (0x6100, 0x11F, "R", "set_velocity_filter_position"),
        (0x6100, 0x120, "R", "set_velocity_filter_position_corrected"),
        (0x6100, 0x121, "R", "set_velocity_filter_velocity_corrected"),
        (0x6100, 0x122, "R", "set_velocity_filter_acceleration_corrected"),
        (0x6100, 0x123, "R", "set_velocity_filter_test_velocity_corrected"),
        (0x6100, 0x124, "R", "set_velocity_filter_test_acceleration_corrected"),
    ),
}  # fmt: skip
"""Reason, and the services it holds for."""

UNSERVED = tuple(
    Covered(*service, reason)
    for table in (_UNSERVED, OF_CHANNELS_AND_GROUPS)
    for reason, services in table.items()
    for service in services
)
"""Services without a row of their own."""

_OF_AN_IMAGE = (
    "the place in the image of the bus, for who looks there; `[[drive]]` says where the data are"
)
_INTERNAL = "internal to the NC; no manual prints a bit of it"
_ONE_MODE = "1, standard, is the only mode that a manual prints; others are refused"
_OF_A_PULSE = "of two-speed axes; the start types that pulse (288, 289) are for servo axes alone"
_OF_INTERPOLATION = "auxiliary axes follow the path in proportion, without a tolerance ball"

WITHOUT_EFFECT = {
    "auxiliary_axis_limiting_enable": _OF_INTERPOLATION,
    "auxiliary_axis_tolerance_ball": _OF_INTERPOLATION,
    "auxiliary_axis_max_position_deviation": _OF_INTERPOLATION,
    "pulse_time_positive": _OF_A_PULSE,
    "pulse_time_negative": _OF_A_PULSE,
    "fast_axis_stop_acceleration": "a stop does not accelerate",
    "unit_interpretation": "of displays, but for bit 2 in the operation mode word",
    "encoder_input_address_offset": _OF_AN_IMAGE,
    "encoder_output_address_offset": _OF_AN_IMAGE,
    "encoder_control_dword": _INTERNAL,
    "controller_mode": _ONE_MODE,
    "drive_input_address_offset": _OF_AN_IMAGE,
    "drive_output_address_offset": _OF_AN_IMAGE,
    "drive_mode": _ONE_MODE,
    "drive_control_dword": _INTERNAL,
    "drive_reset_counter": "how long the NC asks a drive on a bus to reset; the simulated one "
    "needs no longer than the cycle that asks",
    "drive_dead_time_compensation_control": "times in the structures are relative to the cycle, "
    "on a bus and without one",
    "drive_stepper_mask_cycle7": "no excitation has more than six cycles",
    "drive_stepper_mask_cycle8": "no excitation has more than six cycles",
}
"""Parameters by their field that can be written and read back, and why they change nothing."""

_CONSTANT = "served; answers a constant"
_NO_BALL = f"{_CONSTANT}: {_OF_INTERPOLATION}"

OF_PROGRAMS = {
    "tolerance_ball_radius": f"served; kept and shown only: {_OF_INTERPOLATION}",
    "program_load_buffer_size": f"{_CONSTANT}: no program may be longer",
    "interpreter_simulation_mode": f"{_CONSTANT}: the switch is not released",
    "partial_segment_change": _NO_BALL,
    "inside_tolerance_ball_auxiliary": _NO_BALL,
    "tolerance_ball_error_auxiliary": _NO_BALL,
}
"""What comes of rows of channels with an interpreter and of 3D groups that do less than others."""

_CONFIGURED = "of the configuration"
_SINGLE = "of single axes; groups of several have their own"
_NO_PREPARATION = "commands are prepared in the set-point task itself"

CONSTANT = {
    (0x1000, 0x14): "the set-point task runs with its inputs",
    (0x1100, 0x01): _CONFIGURED,
    (0x1100, 0x31): _CONFIGURED,
    (0x2000, 0x01): _CONFIGURED,
    (0x2000, 0x02): _CONFIGURED,
    (0x2000, 0x03): _CONFIGURED,
    (0x2000, 0x04): _CONFIGURED,
    (0x2100, 0x01): f"{_SINGLE}: errors of the standard channel are those of its axes",
    (0x3000, 0x03): _CONFIGURED,
    (0x3000, 0x06): "0 for single axes and FIFOs; another value is refused",
    (0x3000, 0x0B): _NO_PREPARATION,
    (0x3000, 0x0C): _CONFIGURED,
    (0x3000, 0x10): "every group has set points in each cycle; another value is refused",
    (0x3000, 0x21): _CONFIGURED,
    (0x3000, 0x22): _CONFIGURED,
    (0x3000, 0x23): _CONFIGURED,
    (0x3100, 0x02): _SINGLE,
    (0x3100, 0x04): _NO_PREPARATION,
    (0x3100, 0x07): "no manual prints a state within a state",
    (0x3100, 0x0B): _NO_PREPARATION,
    (0x3100, 0x0E): _NO_PREPARATION,
    (
        0x4000,
        0x31,
    ): "a simulated drive has no hardware address; ids and types are the axis'",
    (0x4300, 0xB6): _NO_PREPARATION,
}
"""Index group and offset of rows that answer the same whatever the axes do, and why."""

_PREFIXES = {group: error.name.lower().removesuffix("id") for group, _, error in AXIS_GROUPS}
"""What the fields of an encoder, controller or drive begin with, by index group."""


def coverage(rows: Iterable[RowFacts]) -> Iterator[Covered]:
    """Every service of the manual in order: those of `rows`, and those that have none."""
    served = (
        Covered(row.index_group, row.index_offset, str(row.access), row.name, _answer(row))
        for row in rows
        if row.index_group < min(ReservedGroup)
    )
    yield from sorted((*served, *UNSERVED))


def _answer(row: RowFacts) -> str:
    if row.name in OF_PROGRAMS:
        return OF_PROGRAMS[row.name]
    reason = CONSTANT.get((row.index_group, row.index_offset))
    if reason:
        return f"{_CONSTANT}: {reason}"
    for name in (_PREFIXES.get(row.index_group, "") + row.name, row.name):
        if name in WITHOUT_EFFECT:
            return f"served; kept and shown only: {WITHOUT_EFFECT[name]}"
    return "served"
