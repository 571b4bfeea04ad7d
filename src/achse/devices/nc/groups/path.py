"""3D groups: how the path velocity is reduced, and where the path is (002 §6.4.3)."""

from typing import Any

from achse.codes import NcError
from achse.codes.nc.row import NcRow
from achse.codes.nc.table import named_rows
from achse.devices.nc.groups.binding import set_value, show
from achse.motion.channels.program_channel import ProgramChannel
from achse.motion.channels.states import InterpreterState
from achse.motion.groups.path_group import MAIN_AXES, PLACES, PathGroup
from achse.motion.path import PathOverride
from achse.server import Layout, Service

_PARAMETERS = named_rows(0x3000)
_STATES = named_rows(0x3100)


def _flag(row: NcRow, field: str) -> Service:
    return set_value(row, NcError.GROUP_PARAMETER, field, PathGroup)


_REDUCTION = NcError.NCI_VELOCITY_REDUCTION
_ANGLE = NcError.NCI_CRITICAL_ANGLE

PATH_PARAMETERS = (
    set_value(
        _PARAMETERS["velocity_reduction_method"],
        NcError.NCI_CURVE_REDUCTION,
        "reduction_method",
        PathGroup,
    ),
    set_value(
        _PARAMETERS["velocity_reduction_factor_c0"], _REDUCTION, "reduction_factor_c0", PathGroup
    ),
    set_value(
        _PARAMETERS["velocity_reduction_factor_c1"], _REDUCTION, "reduction_factor_c1", PathGroup
    ),
    set_value(_PARAMETERS["critical_angle_low"], _ANGLE, "critical_angle_low", PathGroup),
    set_value(_PARAMETERS["critical_angle_high"], _ANGLE, "critical_angle_high", PathGroup),
    set_value(
        _PARAMETERS["min_path_velocity"],
        NcError.NCI_MINIMUM_VELOCITY,
        "min_path_velocity",
        PathGroup,
    ),
    set_value(
        _PARAMETERS["velocity_reduction_factor_c2"], _REDUCTION, "reduction_factor_c2", PathGroup
    ),
    _flag(_PARAMETERS["total_remaining_path_enable"], "total_remaining_path_enable"),
    _flag(_PARAMETERS["soft_limit_monitoring_enable"], "soft_limit_monitoring_enable"),
    set_value(
        _PARAMETERS["override_type"],
        NcError.GROUP_OVERRIDE_TYPE,
        "override_type",
        PathGroup,
        choices=PathOverride,
    ),
    _flag(_PARAMETERS["override_above_100_enable"], "override_above_full"),
    show(_PARAMETERS["nci_saf_table_size"], lambda group: group.table_size, PathGroup),
    set_value(
        _PARAMETERS["max_commands_per_cycle"],
        NcError.GROUP_PARAMETER,
        "max_commands_per_cycle",
        PathGroup,
    ),
)


def _path(row: NcRow, field: str) -> Service:
    """Return a value of the path that the group shows."""

    def read(group: PathGroup) -> float:
        return float(getattr(group.view, field))

    return show(row, read, PathGroup)


def _block(group: PathGroup) -> int:
    channel = group.channel
    return channel.block_number if isinstance(channel, ProgramChannel) else 0


def _searched(group: PathGroup) -> tuple[float, ...]:
    """Remaining percent, N word, counter of the block that a search found, and its positions.

    While a program runs, of the block that the path is on, and where the axes are.
    """
    channel = group.channel
    nothing = 0.0, 0, 0, *(0.0,) * PLACES
    if not isinstance(channel, ProgramChannel):
        return nothing
    result = channel.search_result
    if result is not None and channel.state is InterpreterState.SEARCHING:
        rest = (*group.positions, *(0.0,) * PLACES)[MAIN_AXES:PLACES]
        return result.remaining, result.origin.block, result.origin.counter, *result.position, *rest
    origin = None if channel.feeder is None else channel.feeder.origin
    if origin is None:
        return nothing
    remaining = 100.0 * (1.0 - group.view.done_normalized)
    return remaining, origin.block, origin.counter, *(*group.positions, *(0.0,) * PLACES)[:PLACES]


PREVIEW = 11
"""Segments of the preview (002 §6.4.3.2, 0x532)."""


class _Preview:
    """Time in ns, then the present segment and those behind it, 24 bytes each; 0 where none is."""

    _layout = Layout("<II" + "dIIII" * PREVIEW)
    name, size = _layout.name, _layout.size

    def encode(self, group: PathGroup) -> bytes:
        channel, planner = group.channel, group.planner
        feeder = channel.feeder if isinstance(channel, ProgramChannel) else None
        ahead = [] if planner is None or not group.moving else planner.ahead(PREVIEW)
        first = next(iter(group.members), None)
        values: list[float] = [0 if first is None else first.dc_time_stamp & 0xFFFF_FFFF, 0]
        for number, length in ahead:
            block, auxiliary = (0, 0) if feeder is None else feeder.block_of(number)
            values += length, block, auxiliary & 0xFFFF_FFFF, number & 0xFFFF_FFFF, 0
        values += [0] * (2 + 5 * PREVIEW - len(values))
        return self._layout.encode(tuple(values))

    def decode(self, data: bytes) -> Any:
        return self._layout.decode(data)


class _Searched:
    """The first `places` positions of it, or none of them."""

    def __init__(self, places: int) -> None:
        self._layout = Layout(f"<dII{places}d" if places else "<dII")
        self.name, self.size, self._count = self._layout.name, self._layout.size, 3 + places

    def encode(self, value: tuple[float, ...]) -> bytes:
        return self._layout.encode(value[: self._count])

    def decode(self, data: bytes) -> Any:
        return self._layout.decode(data)


PATH_STATES = (
    show(_STATES["block_number"], _block, PathGroup),
    _path(_STATES["set_path_remaining_length"], "remaining"),
    _path(_STATES["set_path_length"], "done"),
    _path(_STATES["set_path_velocity"], "velocity"),
    _path(_STATES["set_path_acceleration"], "acceleration"),
    _path(_STATES["set_path_acceleration_abs"], "acceleration_abs"),
    _path(_STATES["set_path_end_velocity_max"], "end_velocity_max"),
    _path(_STATES["set_path_velocity_max"], "velocity_max"),
    _path(_STATES["set_path_stop_distance"], "stop_distance"),
    _path(_STATES["set_path_safety_distance"], "safety_distance"),
    show(_STATES["set_path_segment_change"], lambda group: float(group.segment_change), PathGroup),
    _path(_STATES["set_path_override"], "override_percent"),
    _path(_STATES["actual_path_velocity_abs"], "actual_velocity"),
    _path(_STATES["actual_path_acceleration"], "actual_acceleration"),
    _path(_STATES["actual_path_acceleration_abs"], "actual_acceleration_abs"),
    _path(_STATES["path_error_tangential"], "tangential_error"),
    _path(_STATES["path_error_orthogonal"], "orthogonal_error"),
    _path(_STATES["set_path_length_normalized"], "done_normalized"),
    show(_STATES["partial_segment_change"], lambda group: 0.0, PathGroup),
    _path(_STATES["total_remaining_path_length"], "total_remaining"),
    _path(_STATES["programmed_segment_velocity"], "programmed_velocity"),
    show(_STATES["path_length_since_program_start"], lambda group: group.way, PathGroup),
    show(
        _STATES["target_position_main_axes"], lambda group: group.view.target[:MAIN_AXES], PathGroup
    ),
    show(
        _STATES["target_position_auxiliary_axes"],
        lambda group: group.view.target[MAIN_AXES:],
        PathGroup,
    ),
    show(_STATES["path_preview"], lambda group: group, PathGroup, codec=_Preview()),
    show(_STATES["inside_tolerance_ball_auxiliary"], lambda group, index: 0.0, PathGroup),
    show(_STATES["set_positions"], lambda group: group.view.set_positions, PathGroup),
    show(_STATES["actual_positions"], lambda group: group.view.actual_positions, PathGroup),
    show(_STATES["position_differences"], lambda group: group.view.differences, PathGroup),
    show(_STATES["axis_ids_3d"], lambda group: tuple(group.ids[:MAIN_AXES]), PathGroup),
    show(
        _STATES["block_search_data"], _searched, PathGroup, codec=(_Searched(0), _Searched(PLACES))
    ),
    show(_STATES["tolerance_ball_error_auxiliary"], lambda group, index: 0.0, PathGroup),
)
