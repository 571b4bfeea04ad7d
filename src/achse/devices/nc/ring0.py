"""Ring-0 services, 0x1000 and 0x1100: what the NC consists of. Source: 002 §6.4.1."""

from collections.abc import Callable

from achse.codes import NcError
from achse.devices.nc.layouts import INT32, NO_DATA, UINT16, UINT32
from achse.motion import Nc
from achse.server import READ, WRITE, Repeated, Service

__all__ = ["RING0_FUNCTIONS", "RING0_PARAMETERS", "RING0_STATES"]


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


def _plural(kind: str) -> str:
    return "axes" if kind == "axis" else kind + "s"


def _cycle(offset: int, name: str, description: str) -> Service:
    return Service(
        offset, name, READ, UINT32, description, "100 ns", read=lambda nc: nc.cycle_ns // 100
    )


def _count(offset: int, kind: str) -> Service:
    ids = _IDS_OF[kind]
    return Service(
        offset, f"{kind}_count", READ, UINT32, f"number of {_plural(kind)}", "1",
        read=lambda nc: len(ids(nc)),
    )  # fmt: skip


def _ids(offset: int, kind: str) -> Service:
    return Service(
        offset,
        f"{kind}_ids",
        READ,
        Repeated(UINT32),
        f"ids of all {_plural(kind)}",
        read=_IDS_OF[kind],
    )


def _owner(offset: int, kind: str) -> Service:
    def read(nc: Nc, number: int) -> int:
        try:
            axis_id: int = nc.element(kind, number).axis_id
            return axis_id
        except KeyError:
            return 0

    return Service(
        offset, f"axis_id_of_{kind}", READ, UINT32, f"axis that owns {kind} nn, 0 = none", "1",
        read=read, count=256,
    )  # fmt: skip


def _timing(offset: int, name: str, field: str, description: str, unit: str) -> Service:
    return Service(offset, name, READ, UINT32, description, unit, field=field)


RING0_PARAMETERS = (
    _cycle(0x10, "saf_cycle_time", "cycle time of the set-point task"),
    _cycle(0x12, "svb_cycle_time", "cycle time of the preparation task, here that of the other"),
    Service(
        0x14, "global_time_compensation_shift", READ, INT32,
        "time shift of the set-point task: 0, it runs with its inputs", "ns", read=lambda nc: 0,
    ),
    Service(
        0x20, "setpoint_consistency_check_enable", READ | WRITE, UINT16,
        "set points are checked in each cycle", "1",
        field="setpoint_consistency_check", minimum=0, maximum=1,
        code=NcError.REQUEST_PARAMETER.number,
    ),
)  # fmt: skip

RING0_STATES = (
    _count(0x01, "channel"),
    _count(0x02, "group"),
    _count(0x03, "axis"),
    _count(0x04, "encoder"),
    _count(0x05, "controller"),
    _count(0x06, "drive"),
    _count(0x0A, "table"),
    _timing(0x10, "saf_cycle_time_error_count", "late_cycles", "cycles that came late", "1"),
    _timing(0x14, "saf_io_cycle_time_error_count", "late_io_cycles", "late I/O cycles", "1"),
    _timing(0x20, "saf_computing_time", "computing_time_us", "computing time of a cycle", "µs"),
    _ids(0x31, "channel"),
    _ids(0x32, "group"),
    _ids(0x33, "axis"),
    _ids(0x34, "encoder"),
    _ids(0x35, "controller"),
    _ids(0x36, "drive"),
    _ids(0x3A, "table"),
    _owner(0x100, "encoder"),
    _owner(0x200, "controller"),
    _owner(0x300, "drive"),
)

RING0_FUNCTIONS = (
    Service(
        0x20, "clear_cycle_time_error_counters", WRITE, NO_DATA,
        "reset the counters of late cycles", write=lambda nc, _: nc.clear_cycle_time_errors(),
    ),
)  # fmt: skip
