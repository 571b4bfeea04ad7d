"""Couplings of an axis, 0x4200 + ID; of its group, 0x3200 + ID from 0x140 on (002 §6.4.4.3)."""

from dataclasses import replace
from typing import Any

from achse.codes import NcError
from achse.devices.nc.functions.calling import function, numbered
from achse.devices.nc.functions.cams import CAMS, SCALE_SLAVE
from achse.devices.nc.functions.starts import UNIVERSAL_START
from achse.devices.nc.layouts import NO_DATA, NOTHING, request
from achse.motion import Axis, commands
from achse.server import READ_WRITE, Layout, Service

__all__ = ["COUPLINGS", "COUPLINGS_OF_GROUP"]

_COUPLE = request(
    slave_type="I", master_axis_id="I", master_subindex="I", slave_subindex="I",
    parameter1="d", parameter2="d", parameter3="d", parameter4="d",
)  # fmt: skip
_FIELDS_OF_ONE = 8

_TO_SEVERAL = {
    "slave_type": "I", "master_axis_id": "I", "master_subindex": "I", "slave_subindex": "I",
    "master2_axis_id": "I", "master3_axis_id": "I", "master4_axis_id": "I",
    **{f"reserved_master{n}": "I" for n in range(5, 9)}, "reserved": "I",
    "acceleration": "d", "control_mask": "I", "reserved2": "I",
}  # fmt: skip
_SEVERAL = (
    *request(**_TO_SEVERAL),
    *request(**_TO_SEVERAL, deceleration="d", jerk="d", velocity="d", reserved3="d", reserved4="d"),
)
"""Forms of 64 and 104 bytes. No bit of the mask is printed."""
_PARAMETERS = request(parameter1="d", parameter2="d", parameter3="d", parameter4="d")
_FOLLOW_UP = request(
    decoupling_type="I", end_position="d", velocity="d", acceleration="d", deceleration="d",
    jerk="d",
)  # fmt: skip
_UNIVERSAL_SAW = tuple(
    layout
    for mask in ("I", "I4x")
    for layout in request(
        slave_type="I", master_axis_id="I", master_subindex="I", slave_subindex="I",
        gear_ratio="d", master_sync_position="d", slave_sync_position="d", slave_velocity="d",
        slave_acceleration="d", slave_deceleration="d", slave_jerk="d", control_mask=mask,
    )
)  # fmt: skip
"""Without the reserved word (000), with it (002)."""


def _couple(axis: Axis, *request: Any) -> int:
    """By one master, or by several: the length tells."""
    slave_type, *masters = request[:7]
    if len(request) == _FIELDS_OF_ONE:
        return commands.couple(axis, slave_type, *request[1:])
    if masters[1] or masters[2] or any(request[7:11]):
        return NcError.SLAVE_COUPLING_PARAMETER
    acceleration, dynamics = request[12], request[15:18]
    return commands.couple_to_several(
        axis, slave_type, (masters[0], *masters[3:]), acceleration, *dynamics
    )


def _decouple(axis: Axis, *follow_up: float) -> int:
    if not follow_up:
        return commands.decouple(axis)
    decoupling_type, *others = follow_up
    return commands.decouple_with_follow_up(axis, int(decoupling_type), *others)


def _decouple_and_start(axis: Axis, arguments: Any) -> tuple[int, int]:
    """As the universal start: the mask is unused, a blending position of 0 is not given."""
    start_type, _, *others = arguments._replace(
        blending_position=arguments.blending_position or None
    )
    return numbered(axis, commands.decouple_and_start(axis, start_type, *others))


_FUNCTIONS = (
    function(
        0x40,
        "couple",
        _couple,
        (*_COUPLE, *_SEVERAL),
        "let an axis follow a master; the longer forms name up to four",
    ),
    function(
        0x41,
        "decouple",
        _decouple,
        (NOTHING, *_FOLLOW_UP),
        "let a slave go; the longer form says what it does then",
    ),
    function(
        0x42,
        "change_coupling_parameters",
        commands.change_coupling,
        _PARAMETERS,
        "new parameters of a coupling at work; the first is the gear ratio of a linear one",
    ),
    function(0x44, "stop_slave", commands.stop_slave, NO_DATA, "stop the slave of a flying saw"),
)

COUPLINGS = (
    *_FUNCTIONS,
    *CAMS,
    function(
        0x4B,
        "couple_universal_flying_saw",
        commands.synchronise,
        _UNIVERSAL_SAW,
        "let an axis in any motion run with a master, by velocity (5) or from two places on (6)",
    ),
    Service(
        0x17,
        "decouple_and_universal_axis_start",
        READ_WRITE,
        UNIVERSAL_START,
        "uncouple a slave and start it; 0x424D at an axis that is not coupled",
        exchange=_decouple_and_start,
        response=Layout("<HH"),
        non_finite=True,
    ),
)

_FIRST_OF_GROUP = 0x100

COUPLINGS_OF_GROUP = tuple(
    replace(row, offset=_FIRST_OF_GROUP + row.offset) for row in (*_FUNCTIONS, SCALE_SLAVE)
)
