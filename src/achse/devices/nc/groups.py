"""Groups, 0x3000 … 0x3200 + ID: each axis has a PTP group of its own, which has the axis' id.

Groups of several axes are not built yet. Source: 002 §6.4.3.
"""

from collections.abc import Callable
from enum import IntEnum
from typing import Any

from achse.codes import NcError
from achse.devices.nc.binding import shown
from achse.devices.nc.functions.calling import function
from achse.devices.nc.layouts import INT32, NO_DATA, UINT16, UINT32, Text
from achse.motion import Axis, MotionPhase, Nc, commands
from achse.motion.record import COMMAND_BUFFER
from achse.motion.states import StateBit
from achse.server import READ, WRITE, Codec, Service

__all__ = [
    "CHANNEL_ID",
    "CHANNEL_NAME",
    "GROUP_FUNCTIONS",
    "GROUP_PARAMETERS",
    "GROUP_STATES",
    "OWNERS_OF_AXIS",
    "ChannelType",
    "GroupType",
    "SafState",
    "group_ids",
    "index_in_channel",
]

CHANNEL_ID = 1
CHANNEL_NAME = "Axes"
"""The channel of all PTP groups."""


class ChannelType(IntEnum):
    """What a channel works on."""

    NONE = 0
    STANDARD = 1
    INTERPRETER = 2
    FIFO = 3
    KINEMATIC_TRANSFORMATION = 4


class GroupType(IntEnum):
    """What moves in a group; the manual names no other of a single axis that is moved."""

    NOT_DEFINED = 0
    PTP = 1


class SafState(IntEnum):
    """State of a group in the set-point task; our numbers, the manuals print none."""

    IDLE = 0
    READY = 1
    RUNNING = 2
    STOPPING = 3
    ERROR = 4


def group_ids(nc: Nc) -> list[int]:
    """Ids of all groups."""
    return [axis.axis_id for axis in nc]


def _saf_state(axis: Axis) -> SafState:
    if axis.error_code:
        return SafState.ERROR
    if axis.set_motion_phase == MotionPhase.STOPPING:
        return SafState.STOPPING
    if axis.set_motion_phase != MotionPhase.NONE:
        return SafState.RUNNING
    return SafState.READY if axis.state_dword & StateBit.OPERATIONAL else SafState.IDLE


def _row(
    offset: int, codec: Codec, name: str, description: str, read: Callable[[Axis], Any], unit: str
) -> Service:
    return Service(offset, name, READ, codec, description, unit, read=read)


def _fixed(offset: int, codec: Codec, name: str, value: Any, description: str) -> Service:
    """What is the same for every group of one axis."""
    return _row(offset, codec, name, description, lambda axis: value, "1")


def _only(offset: int, codec: Codec, name: str, value: int, error: NcError, doc: str) -> Service:
    """A parameter that has one value so far; others are refused, as they would do nothing."""
    return Service(
        *(offset, name, READ | WRITE, codec, doc, "1"),
        read=lambda axis: value,
        write=lambda axis, _: None,
        minimum=value,
        maximum=value,
        code=error.number,
    )


def _cycle_us(axis: Axis) -> int:
    return axis.cycle_ns // 1000


def _channel(first: int) -> tuple[Service, ...]:
    """Rows about the owning channel from offset `first` on."""
    kind = ChannelType.STANDARD
    return (
        _fixed(first, UINT32, "channel_id", CHANNEL_ID, "id of the owning channel"),
        _fixed(first + 1, Text(31), "channel_name", CHANNEL_NAME, "name of the owning channel"),
        _fixed(first + 2, UINT32, "channel_type", kind, "type of the owning channel"),
    )


def _group(first: int, of: str) -> tuple[Service, ...]:
    """Rows about the group itself, or the owning group of an axis, from offset `first` on."""
    return (
        _row(first, UINT32, "group_id", f"id of the {of}", lambda axis: axis.axis_id, "1"),
        _row(
            *(first + 1, Text(31), "group_name", f"name of the {of}, that of the axis"),
            lambda axis: axis.name,
            "1",
        ),
        _fixed(first + 2, UINT32, "group_type", GroupType.PTP, f"type of the {of}"),
    )


OWNERS_OF_AXIS = (*_channel(0x51), *_group(0x54, "owning group"))
"""Rows of an axis about its channel and its group."""

GROUP_PARAMETERS = (
    *_group(0x01, "group"),
    _row(0x04, UINT32, "saf_cycle_time", "cycle time of the set-point task", _cycle_us, "µs"),
    _row(0x05, UINT32, "svb_cycle_time", "cycle time of the preparation task", _cycle_us, "µs"),
    _only(
        *(0x06, UINT16, "single_block_mode", 0, NcError.SINGLE_STEP_FLAG),
        "single blocks: 0 = off, as the commands of one axis are none",
    ),
    _fixed(0x0B, UINT32, "svb_table_size", 0, "entries of the preparation table: there is none"),
    _fixed(0x0C, UINT32, "saf_table_size", COMMAND_BUFFER, "commands that can wait"),
    _only(
        *(0x10, UINT32, "saf_cycle_time_divisor", 1, NcError.SAF_CYCLE_TIME),
        "part of the cycle of the set-point task: every axis moves in each",
    ),
    *_channel(0x21),
)


def index_in_channel(nc: Nc) -> Service:
    """The row of a group's place in the channel, which all axes of `nc` share."""
    return _row(
        *(0x24, UINT32, "index_in_channel", "place in the channel, from 1 on"),
        lambda axis: group_ids(nc).index(axis.axis_id) + 1,
        "1",
    )


GROUP_STATES = (
    shown(0x01, INT32, "error_code"),
    _fixed(0x02, UINT32, "master_axis_count", 1, "number of master axes"),
    _fixed(0x03, UINT32, "slave_axis_count", 0, "number of slave axes"),
    _fixed(0x04, UINT32, "svb_state", SafState.READY, "state in the preparation task"),
    _row(0x05, UINT32, "saf_state", "state in the set-point task", _saf_state, "1"),
    shown(0x06, UINT32, "motion_state"),
    _fixed(0x07, UINT32, "saf_sub_state", 0, "state within the state: there is none"),
    shown(0x08, UINT32, "homing_state"),
    shown(0x09, UINT32, "coupling_state"),
    shown(0x0A, UINT32, "coupling_table_index"),
    _fixed(0x0B, UINT32, "svb_entry_count", 0, "entries of the preparation table"),
    shown(0x0C, UINT32, "saf_entry_count", "buffer_count"),
    _fixed(0x0E, UINT32, "svb_free_entry_count", 0, "free entries of the preparation table"),
    _row(
        *(0x0F, UINT32, "saf_free_entry_count", "commands that can still wait"),
        lambda axis: COMMAND_BUFFER - axis.buffer_count,
        "1",
    ),
)

GROUP_FUNCTIONS = (
    function(0x01, "reset", commands.reset, NO_DATA, "reset the axis of the group"),
    function(0x02, "stop", commands.stop, NO_DATA, "stop with the running deceleration"),
    function(0x03, "clear", commands.clear, NO_DATA, "take the job and waiting commands away"),
)
