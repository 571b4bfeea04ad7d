"""Ring-0 services, 0x1000 to 0x1100: what the NC consists of. Source: 002 §6.4.1."""

from collections.abc import Callable

from achse.devices.nc.layouts import UINT32
from achse.motion import Nc
from achse.server import READ, Repeated, Service

__all__ = ["RING0_PARAMETERS", "RING0_STATES"]

RING0_PARAMETERS = (
    Service(
        0x10,
        "saf_cycle_time",
        READ,
        UINT32,
        "cycle time of the set-point task",
        "100 ns",
        read=lambda nc: nc.cycle_ns // 100,
    ),
)


def _nothing(nc: Nc) -> list[int]:
    return []


def _axis_ids(nc: Nc) -> list[int]:
    return [axis.axis_id for axis in nc]


_OBJECTS: tuple[tuple[int, str, Callable[[Nc], list[int]]], ...] = (
    (1, "channel", _nothing),
    (2, "group", _nothing),
    (3, "axis", _axis_ids),
    (4, "encoder", _axis_ids),
    (5, "controller", _axis_ids),
    (6, "drive", _axis_ids),
    (0x0A, "table", _nothing),
)


def _count(offset: int, kind: str, ids: Callable[[Nc], list[int]]) -> Service:
    return Service(
        offset,
        f"{kind}_count",
        READ,
        UINT32,
        f"number of {kind}s",
        "1",
        read=lambda nc: len(ids(nc)),
    )


def _ids(offset: int, kind: str, ids: Callable[[Nc], list[int]]) -> Service:
    return Service(
        0x30 + offset,
        f"{kind}_ids",
        READ,
        Repeated(UINT32),
        f"ids of all {kind}s",
        "1",
        read=ids,
    )


def _owner(base: int, kind: str) -> Service:
    def read(nc: Nc, index: int) -> int:
        # encoder, controller and drive carry the id of their axis; 0 where there is none
        return index if index in _axis_ids(nc) else 0

    return Service(
        base,
        f"axis_id_of_{kind}",
        READ,
        UINT32,
        f"axis that owns {kind} nn, 0 = none",
        "1",
        read=read,
        count=256,
    )


RING0_STATES = (
    *(_count(*row) for row in _OBJECTS),
    *(_ids(*row) for row in _OBJECTS),
    _owner(0x100, "encoder"),
    _owner(0x200, "controller"),
    _owner(0x300, "drive"),
)
