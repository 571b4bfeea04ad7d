"""Couplings by tables, 0x4200 + ID:0x43 … 0x4D (002 §6.4.4.3), and what they show (§6.4.4.2)."""

from typing import Any

from achse.ams import DeviceError
from achse.codes import NcError, ReturnCode
from achse.codes.nc.table import named_rows
from achse.devices.nc.functions.calling import carry_out, function
from achse.devices.nc.rows import bound
from achse.motion import Axis, commands
from achse.motion.commands import CamDemand
from achse.motion.couplings.cams import master_position_of, names_of, part_at
from achse.motion.fields.cams import CAM_LIST
from achse.motion.record import CamFields
from achse.motion.states import CAM_COUPLINGS, SlaveType
from achse.motion.tables import Table
from achse.motion.tables.memory import BEGIN, PERIOD, STROKE, cam_values

_FUNCTIONS = named_rows(0x4200)
_STATES = named_rows(0x4100)


def _refuse_places(request: Any) -> None:
    """Refuse places within an axis, which only groups have."""
    if request.master_subindex or request.slave_subindex:
        raise DeviceError(NcError.SLAVE_COUPLING_PARAMETER.number, "subindices, expected 0")


def _couple_by_table(axis: Axis, request: Any) -> None:
    """Couple by one table, whose count of tables is then the interpolation, or by several: beside
    the first one they are corrections and profiles that 0x46 starts."""
    _refuse_places(request)
    several = request.slave_type == SlaveType.MULTI_TABULAR
    others: list[int] = []
    if several:
        if max(request.table_count, request.profile_table_count) > CAM_LIST:
            raise DeviceError(NcError.TOO_MANY_TABLES.number, f"{request.table_count} tables")
        others = [getattr(request, f"table_id{n + 1}") for n in range(request.table_count)]
    demand = CamDemand(
        request.table_id,
        0 if several else request.table_count,
        request.slave_offset,
        request.master_offset,
        slave_absolute=request.slave_absolute,
        master_absolute=request.master_absolute,
    )
    carry_out(
        commands.couple_by_cam(
            axis, request.slave_type, request.master_axis_id, demand, further_tables=others
        )
    )


def _couple(axis: Axis, request: Any) -> None:
    _refuse_places(request)
    demand = CamDemand(
        *(
            request.table_id,
            request.interpolation_type,
            request.slave_offset,
            request.master_offset,
        ),
        *(request.slave_scaling, request.master_scaling),
        *(request.slave_absolute, request.master_absolute),
        *(request.activation_type, request.activation_position),
        *(request.master_scaling_type, request.slave_scaling_type),
    )
    further = getattr(request, "cam_operation_mode", 0), getattr(request, "reference_table_id", 0)
    carry_out(
        commands.couple_by_cam(axis, request.slave_type, request.master_axis_id, demand, *further)
    )


def _change_scaling(axis: Axis, request: Any) -> None:
    """Change the scaling; here alone the master's values come before the slave's."""
    demand = CamDemand(
        getattr(request, "table_id", 0),
        slave_offset=request.slave_offset,
        master_offset=request.master_offset,
        slave_scaling=request.slave_scaling,
        master_scaling=request.master_scaling,
        activation=request.activation_type,
        position=request.activation_position,
        master_type=request.master_scaling_type,
        slave_type=request.slave_scaling_type,
    )
    carry_out(commands.change_cam_scaling(axis, demand))


def _change_offsets(axis: Axis, values: tuple[float, ...]) -> None:
    carry_out(commands.change_cam_offsets(axis, *values))


def _correct(axis: Axis, request: Any) -> None:
    table_id, *position = request if isinstance(request, tuple) else (request,)
    carry_out(commands.follow_correction(axis, table_id, *position))


def _last_correction(axis: Axis, table_id: int) -> float:
    correction = commands.last_correction(axis, table_id)
    if correction is None:
        raise DeviceError(NcError.TABLE_NOT_FOUND.number, f"no correction by table {table_id}")
    return correction


SCALE_SLAVE = function(_FUNCTIONS["set_slave_table_scaling"], commands.scale_slave)

CAMS = (
    bound(_FUNCTIONS["change_table_coupling_offsets"], write=_change_offsets, non_finite=True),
    bound(_FUNCTIONS["couple_table"], write=_couple_by_table, non_finite=True),
    bound(_FUNCTIONS["activate_correction_table"], write=_correct, non_finite=True),
    function(_FUNCTIONS["deactivate_profile_table"], commands.end_profile),
    bound(_FUNCTIONS["last_correction_offset"], exchange=_last_correction),
    SCALE_SLAVE,
    bound(_FUNCTIONS["couple_solo_table"], write=_couple, non_finite=True),
    bound(_FUNCTIONS["change_table_scaling"], write=_change_scaling, non_finite=True),
)


_FARTHEST = 1e12


def _layer(axis: Axis, table_id: int) -> tuple[int, CamFields, Table]:
    """Return a cam at work: 0x425C at an axis that follows none, 0x4261 for a table that it does
    not."""
    if axis.coupling.law not in CAM_COUPLINGS:
        raise DeviceError(NcError.SLAVE_TYPE.number, "the axis follows no table")
    for number, layer in enumerate(axis.cams[: axis.camming.count]):
        if layer.now.table and table_id in (0, layer.now.table):
            return number, layer, axis.tables.find(layer.now.table)
    raise DeviceError(NcError.TABLE_NOT_FOUND.number, f"no table {table_id} is at work")


def _place_of(request: Any) -> tuple[int, float | None]:
    """Table and master position; 0: the first, None: now."""
    if isinstance(request, float):
        return 0, request
    return (request.table_id, request.master_position) if request else (0, None)


def _info(axis: Axis, request: Any) -> tuple[float, ...]:
    """Return the state of a followed cam, now or for a master position."""
    table_id, position = _place_of(request)
    if position is not None and abs(position) > _FARTHEST:
        raise DeviceError(ReturnCode.INVALID_DATA, f"master position up to {_FARTHEST:g}")
    _, layer, table = _layer(axis, table_id)
    now = layer.now
    rows, cam = axis.rows, now.cam
    names = names_of(rows, layer)
    master = master_position_of(axis, rows, layer) if position is None else position - names
    near, within, value = layer.near, layer.cam_position, layer.value
    origin = now.master_reference + now.master_offset
    part, *_, strokes = part_at(rows, layer, (master - origin) / now.master_scaling)
    cam_position, slave_position = layer.cam_position, layer.value
    layer.near, layer.cam_position, layer.value = near, within, value
    slave = (
        axis.set_position
        if position is None
        else axis.coupling.slave_base + part + axis.coupling.offset
    )
    return (
        *(now.table, table.table_main_type, table.table_sub_type, now.interpolation),
        *(table.row_count, table.column_count),
        *(rows.cams[cam + BEGIN], cam_values(rows.cams, cam, 0, rows.cams[cam + BEGIN])[0]),
        *(rows.cams[cam + PERIOD], rows.cams[cam + STROKE]),
        *(origin + names, axis.coupling.slave_base + now.slave_reference + now.slave_offset),
        *(now.master_absolute, now.slave_absolute),
        *(
            now.master_offset,
            now.slave_offset,
            now.master_scaling,
            now.slave_scaling,
        ),
        *(now.slave_scaling * strokes, axis.coupling.offset),
        *(master + names, slave, cam_position, slave_position),
        axis.state_dword & 0xFFFF_FFFF,
    )


def _info_of_several(axis: Axis, table_id: int) -> tuple[float, ...]:
    """Return the state of one of several followed cams."""
    number, layer, table = _layer(axis, table_id)
    now = layer.now
    return (
        *(now.table, number, table.table_main_type, table.table_sub_type),
        *(
            now.master_offset,
            now.slave_offset,
            now.master_scaling,
            now.slave_scaling,
        ),
        *(layer.cam_position, layer.value, now.slave_scaling * layer.strokes),
        *(now.master_reference, now.slave_reference),
    )


CAM_STATES = (
    bound(_STATES["table_coupling_info"], exchange=_info),
    bound(_STATES["multi_table_coupling_info"], exchange=_info_of_several),
)
