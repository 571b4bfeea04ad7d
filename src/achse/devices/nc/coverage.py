"""Services of the manual without a row, and parameters without effect, each with its reason.

With the rows themselves this is the page coverage/nc.md of the site. Source: 002 §6.4.
"""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from achse.codes import ReservedGroup
from achse.codes.nc.unserved import OF_AXES, OF_CHANNELS_AND_GROUPS
from achse.devices.nc.device import AXIS_GROUPS
from achse.server import RowFacts


class Covered(NamedTuple):
    """A service of the manual and what comes of it; ids and numbers are those of the first."""

    index_group: int
    index_offset: int
    access: str
    name: str
    answer: str


UNSERVED = tuple(
    Covered(*service, reason)
    for table in (OF_AXES, OF_CHANNELS_AND_GROUPS)
    for reason, services in table.items()
    for service in services
)
"""Services without a row of their own."""

_OF_AN_IMAGE = (
    "the place in the image of the bus, for readers of it; `[[drive]]` says where the data are"
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
    "drive_reset_counter": "how long the NC requests a reset of a drive on a bus; the simulated "
    "one needs no longer than the cycle of the request",
    "drive_dead_time_compensation_control": "times in the structures are relative to the cycle, "
    "on a bus and without one",
    "drive_stepper_mask_cycle7": "no excitation has more than six cycles",
    "drive_stepper_mask_cycle8": "no excitation has more than six cycles",
}
"""Parameters by their field that can be written and read back, and why they change nothing."""

_CONSTANT = "served; answers a constant"
_NO_BALL = f"{_CONSTANT}: {_OF_INTERPOLATION}"

OF_PROGRAMS = {
    "tolerance_ball_radius": f"served; stored and shown only: {_OF_INTERPOLATION}",
    "program_load_buffer_size": f"{_CONSTANT}: no program may be longer",
    "interpreter_simulation_mode": f"{_CONSTANT}: the switch is not released",
    "partial_segment_change": _NO_BALL,
    "inside_tolerance_ball_auxiliary": _NO_BALL,
    "tolerance_ball_error_auxiliary": _NO_BALL,
}
"""Effect of rows that do less than others, for channels with an interpreter and for 3D groups."""

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
"""Prefixes of the fields of an encoder, controller or drive, by index group."""


def coverage(rows: Iterable[RowFacts]) -> Iterator[Covered]:
    """Yield every service of the manual in order: those of `rows`, and those that have none."""
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
            return f"served; stored and shown only: {WITHOUT_EFFECT[name]}"
    return "served"
