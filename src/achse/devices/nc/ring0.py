"""Ring-0 services, 0x1000 and 0x1100: what the NC consists of. Source: 002 §6.4.1."""

from collections.abc import Callable

from achse.codes import NcError
from achse.codes.nc.row import NcRow
from achse.codes.nc.table import named_rows
from achse.devices.nc.rows import bound
from achse.motion import Nc
from achse.server import Service

_PARAMETERS = named_rows(0x1000)
_STATES = named_rows(0x1100)
_FUNCTIONS = named_rows(0x1200)


def _axes(nc: Nc) -> list[int]:
    return [axis.axis_id for axis in nc]


def _tables(nc: Nc) -> list[int]:
    return nc.tables.ids()


def _group_ids(nc: Nc) -> list[int]:
    return sorted([*_axes(nc), *(group.group_id for group in nc.groups)])


_IDS_OF: dict[str, Callable[[Nc], list[int]]] = {
    "channel": lambda nc: nc.channels.ids(),
    "group": _group_ids,
    "axis": _axes,
    "encoder": lambda nc: nc.ids("encoder"),
    "controller": lambda nc: nc.ids("controller"),
    "drive": lambda nc: nc.ids("drive"),
    "table": _tables,
}


def _cycle(row: NcRow) -> Service:
    return bound(row, read=lambda nc: nc.cycle_ns // 100)


def _count(kind: str) -> Service:
    ids = _IDS_OF[kind]
    return bound(_STATES[f"{kind}_count"], read=lambda nc: len(ids(nc)))


def _ids(kind: str) -> Service:
    return bound(_STATES[f"{kind}_ids"], read=_IDS_OF[kind])


def _owner(kind: str) -> Service:
    def read(nc: Nc, number: int) -> int:
        try:
            axis_id: int = nc.element(kind, number).axis_id
            return axis_id
        except KeyError:
            return 0

    return bound(_STATES[f"axis_id_of_{kind}"], read=read)


RING0_PARAMETERS = (
    _cycle(_PARAMETERS["saf_cycle_time"]),
    _cycle(_PARAMETERS["svb_cycle_time"]),
    bound(_PARAMETERS["global_time_compensation_shift"], read=lambda nc: 0),
    bound(
        _PARAMETERS["setpoint_consistency_check_enable"],
        field="setpoint_consistency_check",
        code=NcError.REQUEST_PARAMETER.number,
    ),
)

RING0_STATES = (
    *map(_count, _IDS_OF),
    bound(_STATES["saf_cycle_time_error_count"], field="late_cycles"),
    bound(_STATES["saf_io_cycle_time_error_count"], field="late_io_cycles"),
    bound(_STATES["saf_computing_time"], field="computing_time_us"),
    *map(_ids, _IDS_OF),
    *map(_owner, ("encoder", "controller", "drive")),
)

RING0_FUNCTIONS = (
    bound(
        _FUNCTIONS["clear_cycle_time_error_counters"],
        write=lambda nc, _: nc.clear_cycle_time_errors(),
    ),
)
