"""3D groups: how the path velocity is reduced, and where the path is (002 §6.4.3)."""

from typing import Any

from achse.codes import NcError
from achse.devices.nc.groups.binding import set_value, show
from achse.devices.nc.layouts import INT32, REAL64, UINT16, UINT32
from achse.motion.channels.program_channel import ProgramChannel
from achse.motion.channels.states import InterpreterState
from achse.motion.groups.path_group import MAIN_AXES, PLACES, PathGroup
from achse.motion.path import PathOverride, ReductionMethod
from achse.server import Layout, Service

__all__ = ["PATH_PARAMETERS", "PATH_STATES"]


def _real(
    offset: int, error: NcError, name: str, field: str, doc: str, unit: str, most: float
) -> Service:
    return set_value(
        *(offset, REAL64, error, name, doc, field, PathGroup),
        unit=unit,
        minimum=0.0,
        maximum=most,
    )


def _flag(offset: int, codecs: Any, name: str, field: str, doc: str) -> Service:
    error = NcError.GROUP_PARAMETER
    return set_value(*(offset, codecs, error, name, doc, field, PathGroup), minimum=0, maximum=1)


_AUXILIARY = PLACES - MAIN_AXES

_REDUCTION = NcError.NCI_VELOCITY_REDUCTION
_ANGLE = NcError.NCI_CRITICAL_ANGLE

PATH_PARAMETERS = (
    set_value(
        *(0x500, INT32, NcError.NCI_CURVE_REDUCTION, "velocity_reduction_method"),
        *("how corners reduce the velocity: 0 Coulomb, 1 cosine, 2 jump", "reduction_method"),
        PathGroup,
        minimum=ReductionMethod.COULOMB,
        maximum=ReductionMethod.VELO_JUMP,  # 3 is not released
    ),
    _real(
        *(0x501, _REDUCTION, "velocity_reduction_factor_c0", "reduction_factor_c0"),
        *("part of the velocity that corners leave", "1", 1.0),
    ),
    _real(
        *(0x502, _REDUCTION, "velocity_reduction_factor_c1", "reduction_factor_c1"),
        *("part of it where the curvature jumps", "1", 1.0),
    ),
    _real(
        *(0x503, _ANGLE, "critical_angle_low", "critical_angle_low"),
        *("smallest angle of a corner that reduces the velocity", "degree", 180.0),
    ),
    _real(
        *(0x504, _ANGLE, "critical_angle_high", "critical_angle_high"),
        *("angle of a corner from which it is reduced as far as it goes", "degree", 180.0),
    ),
    _real(
        *(0x505, NcError.NCI_MINIMUM_VELOCITY, "min_path_velocity", "min_path_velocity"),
        *("velocity that transitions keep", "mm/s", 1e6),
    ),
    _real(
        *(0x507, _REDUCTION, "velocity_reduction_factor_c2", "reduction_factor_c2"),
        *("part of the velocity where the curvature is continuous", "1", 1.0),
    ),
    _flag(
        *(0x508, (UINT16, UINT32), "total_remaining_path_enable", "total_remaining_path_enable"),
        "state 0x522 is calculated",
    ),
    _flag(
        *(0x509, UINT16, "soft_limit_monitoring_enable", "soft_limit_monitoring_enable"),
        "soft limits of X, Y and Z are looked at before a segment is taken",
    ),
    set_value(
        *(0x50A, UINT32, NcError.GROUP_OVERRIDE_TYPE, "override_type"),
        "what 100 % is: 0 reduced velocity, 1 programmed one, 2 reduced, above 100 % too",
        *("override_type", PathGroup),
        choices=PathOverride,
    ),
    _flag(
        *(0x50B, UINT16, "override_above_100_enable", "override_above_full"),
        "the override may be above 100 %",
    ),
    show(
        *(0x50C, UINT32, "nci_saf_table_size", "segments that the table of the path holds"),
        lambda group: group.table_size,
        PathGroup,
    ),
    set_value(
        *(0x514, UINT32, NcError.GROUP_PARAMETER, "max_commands_per_cycle"),
        *("segments that go over to the set-point task in a cycle", "max_commands_per_cycle"),
        PathGroup,
        minimum=1,
        maximum=20,
    ),
)


_SYMBOLS = {
    "set_path_remaining_length": "SetPathRemLength",
    "set_path_length": "SetPathLength",
    "set_path_velocity": "SetPathVelo",
    "set_path_acceleration": "SetPathAcc",
    "set_path_acceleration_abs": "SetPathAbsAcc",
    "set_path_end_velocity_max": "SetPathVeloEnd",
    "set_path_velocity_max": "SetPathVeloMax",
    "set_path_stop_distance": "SetPathStopDist",
    "set_path_safety_distance": "SetPathSecurityDist",
    "set_path_override": "SetPathOverride",
    "actual_path_velocity_abs": "ActPathAbsVelo",
    "actual_path_acceleration": "ActPathAcc",
    "actual_path_acceleration_abs": "ActPathAbsAcc",
    "path_error_tangential": "PathDiffTangential",
    "path_error_orthogonal": "PathDiffOrthogonal",
}
"""Symbols as 002 prints them."""


def _path(offset: int, name: str, field: str, doc: str, unit: str = "e.g. mm") -> Service:
    """A value of the path that the group shows."""

    def read(group: PathGroup) -> float:
        return float(getattr(group.view, field))

    return show(
        *(offset, REAL64, name, doc, read, PathGroup), unit=unit, symbol=_SYMBOLS.get(name, "")
    )


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
    found = channel.found
    if found is not None and channel.state is InterpreterState.SEARCHING:
        rest = (*group.positions, *(0.0,) * PLACES)[MAIN_AXES:PLACES]
        return found.remaining, found.origin.block, found.origin.counter, *found.position, *rest
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


_SPEED, _RAMP = "e.g. mm/s", "e.g. mm/s²"

PATH_STATES = (
    show(
        0x0D,
        UINT32,
        "block_number",
        "N word of the present block",
        _block,
        PathGroup,
        symbol="BlockNumber",
    ),
    _path(0x500, "set_path_remaining_length", "remaining", "way to the end of the segment"),
    _path(0x501, "set_path_length", "done", "way since the beginning of the segment"),
    _path(0x502, "set_path_velocity", "velocity", "velocity on the path", _SPEED),
    _path(0x503, "set_path_acceleration", "acceleration", "acceleration on the path", _RAMP),
    _path(
        *(0x504, "set_path_acceleration_abs", "acceleration_abs"),
        *("size of the acceleration of X, Y and Z", _RAMP),
    ),
    _path(
        *(0x505, "set_path_end_velocity_max", "end_velocity_max"),
        *("velocity that the end of the segment allows", _SPEED),
    ),
    _path(
        *(0x506, "set_path_velocity_max", "velocity_max"),
        *("velocity that the segment allows", _SPEED),
    ),
    _path(0x507, "set_path_stop_distance", "stop_distance", "way until the path would rest"),
    _path(
        *(0x508, "set_path_safety_distance", "safety_distance"),
        "what the stop distance leaves of the segment",
    ),
    show(
        *(0x509, REAL64, "set_path_segment_change", "1 where a segment begins"),
        lambda group: float(group.segment_change),
        PathGroup,
        symbol="SetPathSegmentChange",
    ),
    _path(0x50A, "set_path_override", "override_percent", "override of the path", "%"),
    _path(
        *(0x511, "actual_path_velocity_abs", "actual_velocity"),
        *("size of the actual velocity of X, Y and Z", _SPEED),
    ),
    _path(
        *(0x512, "actual_path_acceleration", "actual_acceleration"),
        *("actual acceleration along the path", _RAMP),
    ),
    _path(
        *(0x513, "actual_path_acceleration_abs", "actual_acceleration_abs"),
        *("size of the actual acceleration of X, Y and Z", _RAMP),
    ),
    _path(
        *(0x514, "path_error_tangential", "tangential_error"),
        "what the axes are behind along the path, negative if ahead",
    ),
    _path(0x515, "path_error_orthogonal", "orthogonal_error", "what they are beside the path"),
    _path(
        *(0x520, "set_path_length_normalized", "done_normalized"),
        *("share of the segment that is done", "1"),
    ),
    show(
        *(0x521, REAL64, "partial_segment_change", "0: auxiliary axes have no tolerance ball"),
        lambda group: 0.0,
        PathGroup,
    ),
    _path(
        *(0x522, "total_remaining_path_length", "total_remaining"),
        "way to the end of the segments so far, while parameter 0x508 is 1",
    ),
    _path(
        *(0x523, "programmed_segment_velocity", "programmed_velocity"),
        *("programmed velocity of the segment", _SPEED),
    ),
    show(
        *(0x524, REAL64, "path_length_since_program_start", "way since the program began"),
        lambda group: group.way,
        PathGroup,
        unit="e.g. mm",
    ),
    show(
        *(0x530, Layout("<3d"), "target_position_main_axes", "where the segment ends: X, Y, Z"),
        lambda group: group.view.target[:MAIN_AXES],
        PathGroup,
        unit="e.g. mm",
    ),
    show(
        *(0x531, Layout("<5d"), "target_position_auxiliary_axes", "where it ends: Q1 … Q5"),
        lambda group: group.view.target[MAIN_AXES:],
        PathGroup,
        unit="e.g. mm",
    ),
    show(
        *(0x532, _Preview(), "path_preview"),
        "time, 0; 11 times length (first: what is left), N word, H, number of the segment, 0",
        lambda group: group,
        PathGroup,
    ),
    show(
        *(0x541, REAL64, "inside_tolerance_ball_auxiliary", "0: there is no tolerance ball"),
        lambda group, index: 0.0,
        PathGroup,
        count=_AUXILIARY,
    ),
    show(
        *(0x546, Layout("<8d"), "set_positions", "set positions of X, Y, Z, Q1 … Q5"),
        lambda group: group.view.set_positions,
        PathGroup,
        unit="e.g. mm",
    ),
    show(
        *(0x547, Layout("<8d"), "actual_positions", "actual positions of X, Y, Z, Q1 … Q5"),
        lambda group: group.view.actual_positions,
        PathGroup,
        unit="e.g. mm",
    ),
    show(
        *(0x548, Layout("<8d"), "position_differences", "set less actual positions"),
        lambda group: group.view.differences,
        PathGroup,
        unit="e.g. mm",
    ),
    show(
        *(0x550, Layout("<3I"), "axis_ids_3d", "ids of X, Y and Z, 0 = none"),
        lambda group: tuple(group.ids[:MAIN_AXES]),
        PathGroup,
    ),
    show(
        *(0x556, (_Searched(0), _Searched(PLACES)), "block_search_data"),
        "found or present block: rest in %, N word, counter; then the positions of its begin",
        _searched,
        PathGroup,
    ),
    show(
        *(0x561, REAL64, "tolerance_ball_error_auxiliary", "0: there is no tolerance ball"),
        lambda group, index: 0.0,
        PathGroup,
        count=_AUXILIARY,
    ),
)
