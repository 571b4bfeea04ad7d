"""What every group has: who it is, its owner, its states, reset, stop, clear."""

from achse.devices.nc.groups.binding import AnyGroup, group_function, group_of, show
from achse.devices.nc.layouts import INT32, NO_DATA, UINT16, UINT32, Text, request
from achse.motion.groups.path_group import PathGroup
from achse.motion.groups.ptp import PtpGroup
from achse.server import Service

__all__ = ["EVERY_FUNCTION", "EVERY_PARAMETER", "EVERY_STATE", "OWNERS_OF_AXIS"]

_RAMP = request(deceleration="d", jerk="d")
_PTP_OR_PATH = (PtpGroup, PathGroup)


def _channel(first: int, of: str = "") -> tuple[Service, ...]:
    """Rows about the owning channel from offset `first` on."""
    return (
        show(
            *(first, UINT32, "channel_id", f"id of the owning channel{of}"),
            lambda group: group.channel.channel_id,
        ),
        show(
            *(first + 1, Text(31), "channel_name", f"name of the owning channel{of}"),
            lambda group: group.channel.name,
        ),
        show(
            *(first + 2, UINT32, "channel_type", f"type of the owning channel{of}"),
            lambda group: group.channel.type,
        ),
    )


def _group(first: int, of: str) -> tuple[Service, ...]:
    """Rows about the group itself, or the owning group of an axis, from offset `first` on."""
    return (
        show(first, UINT32, "group_id", f"id of the {of}", lambda group: group.group_id),
        show(
            *(first + 1, Text(31), "group_name", f"name of the {of}; a PTP group has the axis'"),
            lambda group: group.name,
        ),
        show(first + 2, UINT32, "group_type", f"type of the {of}", lambda group: group.type),
    )


def _of_axis(row: Service) -> Service:
    """The row about the group that an axis belongs to now."""
    get = row.get
    return Service(
        *(row.offset, row.name, row.access, row.codec, row.description, row.unit),
        read=lambda axis: get(group_of(axis)),
    )


OWNERS_OF_AXIS = tuple(map(_of_axis, (*_channel(0x51), *_group(0x54, "owning group"))))
"""Rows of an axis about its channel and its group."""


def _cycle_us(group: AnyGroup) -> int:
    return group.cycle_ns // 1000


EVERY_PARAMETER = (
    *_group(0x01, "group"),
    show(0x04, UINT32, "saf_cycle_time", "cycle time of the set-point task", _cycle_us, unit="µs"),
    show(0x05, UINT32, "svb_cycle_time", "cycle time of preparation", _cycle_us, unit="µs"),
    show(
        *(0x0B, UINT32, "svb_table_size", "entries of the preparation table: there is none"),
        lambda group: group.svb_table_size,
    ),
    show(
        *(0x0C, UINT32, "saf_table_size", "commands, segments or rows that can wait"),
        lambda group: group.saf_table_size,
    ),
    *_channel(0x21),
    show(
        *(0x24, UINT32, "index_in_channel", "place in the channel, from 1 on"),
        lambda group: group.index_in_channel,
    ),
)


def _masters(group: AnyGroup) -> int:
    return 1 if isinstance(group, PtpGroup) else len(group.members)


def _slaves(group: AnyGroup) -> int:
    members = [group.axis] if isinstance(group, PtpGroup) else group.members
    return sum(axis.followers for axis in members)


def _motion_state(group: AnyGroup) -> int:
    return group.axis.motion_state if isinstance(group, PtpGroup) else group.motion_state


def _of_single(group: AnyGroup, field: str) -> int:
    """A state of the axis of a PTP group; groups of several axes have none."""
    value: int = getattr(group.axis, field) if isinstance(group, PtpGroup) else 0
    return value


EVERY_STATE = (
    show(0x01, INT32, "error_code", "error of the group", lambda group: group.error_code),
    show(0x02, UINT32, "master_axis_count", "number of master axes", _masters),
    show(0x03, UINT32, "slave_axis_count", "axes that follow those of the group", _slaves),
    show(
        *(0x04, UINT32, "svb_state", "state in the preparation task"),
        lambda group: group.svb_state,
    ),
    show(0x05, UINT32, "saf_state", "state in the set-point task", lambda group: group.saf_state),
    show(0x06, UINT32, "motion_state", "what the set point does", _motion_state),
    show(
        *(0x07, UINT32, "saf_sub_state", "state within the state: there is none"),
        lambda group: group.saf_sub_state,
    ),
    show(
        *(0x08, UINT32, "homing_state", "step of the homing of a single axis"),
        lambda group: _of_single(group, "homing_state"),
    ),
    show(
        *(0x09, UINT32, "coupling_state", "coupling of a single axis"),
        lambda group: _of_single(group, "coupling_state"),
    ),
    show(
        *(0x0A, UINT32, "coupling_table_index", "table that a single axis follows"),
        lambda group: _of_single(group, "coupling_table_index"),
    ),
    show(
        *(0x0B, UINT32, "svb_entry_count", "entries of the preparation table"),
        lambda group: group.svb_entry_count,
        symbol="SvbEntries",
    ),
    show(
        *(0x0C, UINT32, "saf_entry_count", "commands, segments or rows that wait"),
        lambda group: group.saf_entry_count,
        symbol="SafEntries",
    ),
    show(
        *(0x0E, UINT32, "svb_free_entry_count", "free entries of the preparation table"),
        lambda group: group.svb_free_entry_count,
    ),
    show(
        *(0x0F, UINT32, "saf_free_entry_count", "commands, segments or rows that can still wait"),
        lambda group: group.saf_free_entry_count,
    ),
    show(
        *(0x11, UINT16, "emergency_stop_active", "an emergency stop waits for step on"),
        lambda group: group.emergency_stop_active,
    ),
)

EVERY_FUNCTION = (
    group_function(0x01, "reset", lambda group: group.reset(), NO_DATA, "reset errors"),
    group_function(0x02, "stop", lambda group: group.stop(), NO_DATA, "bring the axes to a halt"),
    group_function(
        *(0x03, "clear", lambda group: group.clear(), NO_DATA),
        "take the job and all that waits away",
    ),
    group_function(
        *(0x04, "emergency_stop", lambda group, *ramp: group.emergency_stop(*ramp), _RAMP),
        "stop, not weaker than now, so that it can go on",
        *_PTP_OR_PATH,
    ),
    group_function(
        *(0x05, "parameterized_stop", lambda group, *ramp: group.parameterized_stop(*ramp), _RAMP),
        "stop by a ramp",
        PtpGroup,
    ),
    group_function(
        *(0x06, "step_on", lambda group: group.step_on(), NO_DATA),
        "go on after an emergency stop",
        *_PTP_OR_PATH,
    ),
)
