"""Ring-0 services, 0x1000 and 0x1100: what the NC consists of. Source: 002 §6.4.1."""

from achse.devices.nc.layouts import UINT32
from achse.motion import Nc
from achse.server import READ, Repeated, Service

__all__ = ["RING0_PARAMETERS", "RING0_STATES"]


def _axes(nc: Nc) -> list[int]:
    return [axis.axis_id for axis in nc]


def _none(nc: Nc) -> list[int]:
    return []


_IDS_OF = {
    "channel": _none,
    "group": _none,
    "axis": _axes,
    "encoder": _axes,
    "controller": _axes,
    "drive": _axes,
    "table": _none,
}
"""Encoder, controller and drive carry the id of their axis."""


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
        return number if number in _axes(nc) else 0

    return Service(
        offset, f"axis_id_of_{kind}", READ, UINT32, f"axis that owns {kind} nn, 0 = none", "1",
        read=read, count=256,
    )  # fmt: skip


RING0_PARAMETERS = (_cycle(0x10, "saf_cycle_time", "cycle time of the set-point task"),)

RING0_STATES = (
    _count(0x01, "channel"),
    _count(0x02, "group"),
    _count(0x03, "axis"),
    _count(0x04, "encoder"),
    _count(0x05, "controller"),
    _count(0x06, "drive"),
    _count(0x0A, "table"),
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
