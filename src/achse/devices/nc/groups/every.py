"""Rows of every group: identity, owner, states, reset, stop, clear."""

from collections.abc import Mapping
from dataclasses import replace

from achse.codes.nc.row import NcRow
from achse.codes.nc.table import named_rows
from achse.devices.nc.groups.binding import AnyGroup, group_function, group_of, show
from achse.motion.groups.path_group import PathGroup
from achse.motion.groups.ptp import PtpGroup
from achse.server import Service

_PARAMETERS = named_rows(0x3000)
_STATES = named_rows(0x3100)
_FUNCTIONS = named_rows(0x3200)
_OF_AXIS = named_rows(0x4000)

_PTP_OR_PATH = (PtpGroup, PathGroup)


def _channel(rows: Mapping[str, NcRow]) -> tuple[Service, ...]:
    """Services about the owning channel."""
    return (
        show(rows["channel_id"], lambda group: group.channel.channel_id),
        show(rows["channel_name"], lambda group: group.channel.name),
        show(rows["channel_type"], lambda group: group.channel.type),
    )


def _group(rows: Mapping[str, NcRow]) -> tuple[Service, ...]:
    """Services about the group itself, or the owning group of an axis."""
    return (
        show(rows["group_id"], lambda group: group.group_id),
        show(rows["group_name"], lambda group: group.name),
        show(rows["group_type"], lambda group: group.type),
    )


def _of_axis(service: Service) -> Service:
    """Return the service about the group that an axis belongs to now."""
    get = service.get
    return replace(service, read=lambda axis: get(group_of(axis)))


OWNERS_OF_AXIS = tuple(map(_of_axis, (*_channel(_OF_AXIS), *_group(_OF_AXIS))))
"""Services of an axis about its channel and its group."""


def _cycle_us(group: AnyGroup) -> int:
    return group.cycle_ns // 1000


EVERY_PARAMETER = (
    *_group(_PARAMETERS),
    show(_PARAMETERS["saf_cycle_time"], _cycle_us),
    show(_PARAMETERS["svb_cycle_time"], _cycle_us),
    show(_PARAMETERS["svb_table_size"], lambda group: group.svb_table_size),
    show(_PARAMETERS["saf_table_size"], lambda group: group.saf_table_size),
    *_channel(_PARAMETERS),
    show(_PARAMETERS["index_in_channel"], lambda group: group.index_in_channel),
)


def _masters(group: AnyGroup) -> int:
    return 1 if isinstance(group, PtpGroup) else len(group.members)


def _slaves(group: AnyGroup) -> int:
    members = [group.axis] if isinstance(group, PtpGroup) else group.members
    return sum(axis.followers for axis in members)


def _motion_state(group: AnyGroup) -> int:
    return group.axis.motion_state if isinstance(group, PtpGroup) else group.motion_state


def _of_single(group: AnyGroup, field: str) -> int:
    """Return a state of the axis of a PTP group; groups of several axes have none."""
    value: int = getattr(group.axis, field) if isinstance(group, PtpGroup) else 0
    return value


EVERY_STATE = (
    show(_STATES["error_code"], lambda group: group.error_code),
    show(_STATES["master_axis_count"], _masters),
    show(_STATES["slave_axis_count"], _slaves),
    show(_STATES["svb_state"], lambda group: group.svb_state),
    show(_STATES["saf_state"], lambda group: group.saf_state),
    show(_STATES["motion_state"], _motion_state),
    show(_STATES["saf_sub_state"], lambda group: group.saf_sub_state),
    show(_STATES["homing_state"], lambda group: _of_single(group, "homing_state")),
    show(_STATES["coupling_state"], lambda group: _of_single(group, "coupling_state")),
    show(_STATES["coupling_table_index"], lambda group: _of_single(group, "coupling_table_index")),
    show(_STATES["svb_entry_count"], lambda group: group.svb_entry_count),
    show(_STATES["saf_entry_count"], lambda group: group.saf_entry_count),
    show(_STATES["svb_free_entry_count"], lambda group: group.svb_free_entry_count),
    show(_STATES["saf_free_entry_count"], lambda group: group.saf_free_entry_count),
    show(_STATES["emergency_stop_active"], lambda group: group.emergency_stop_active),
)

EVERY_FUNCTION = (
    group_function(_FUNCTIONS["reset"], lambda group: group.reset()),
    group_function(_FUNCTIONS["stop"], lambda group: group.stop()),
    group_function(_FUNCTIONS["clear"], lambda group: group.clear()),
    group_function(
        _FUNCTIONS["emergency_stop"],
        lambda group, *ramp: group.emergency_stop(*ramp),
        *_PTP_OR_PATH,
    ),
    group_function(
        _FUNCTIONS["parameterized_stop"],
        lambda group, *ramp: group.parameterized_stop(*ramp),
        PtpGroup,
    ),
    group_function(_FUNCTIONS["step_on"], lambda group: group.step_on(), *_PTP_OR_PATH),
)
