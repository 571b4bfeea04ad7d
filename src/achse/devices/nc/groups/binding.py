"""Binding of group rows to groups: by attribute, some only to certain kinds of group."""

from collections.abc import Callable
from enum import IntEnum
from typing import Any

from achse.ams import DeviceError
from achse.codes import NcError, ReturnCode
from achse.codes.nc.row import NcRow
from achse.devices.nc.functions.calling import carry_out
from achse.devices.nc.rows import bound
from achse.motion import Axis, Nc
from achse.motion.groups.group import AxisGroup
from achse.motion.groups.ptp import PtpGroup
from achse.motion.path import PathError
from achse.server import Codec, Service

AnyGroup = AxisGroup | PtpGroup


def group_of(axis: Axis) -> AnyGroup:
    """Return the group that the axis belongs to now."""
    return PtpGroup(axis) if axis.group is None else axis.group


class GroupFinder:
    """All groups of an NC by their ids, PTP groups included."""

    def __init__(self, nc: Nc) -> None:
        self._nc = nc
        self._single = {axis.axis_id: PtpGroup(axis) for axis in nc}

    def ids(self) -> list[int]:
        return sorted([*self._single, *(group.group_id for group in self._nc.groups)])

    def find(self, group_id: int) -> AnyGroup:
        """Return the group with this id. Raises DeviceError 0x4011."""
        group = self._single.get(group_id)
        if group is not None:
            return group
        try:
            return self._nc.groups.group(group_id)
        except KeyError:
            raise DeviceError(NcError.GROUP_ID.number, f"id {group_id}") from None


def _checked(kinds: tuple[type, ...], function: Callable[..., Any]) -> Callable[..., Any]:
    """`function`, or 0x703 for a group of another kind."""

    def call(group: AnyGroup, *arguments: Any) -> Any:
        if not isinstance(group, kinds):
            raise DeviceError(ReturnCode.INVALID_OFFSET, f"not of a group of type {group.type}")
        return function(group, *arguments)

    return call


def show(
    row: NcRow,
    read: Callable[..., Any],
    *kinds: type,
    codec: Codec | tuple[Codec, ...] | None = None,
) -> Service:
    """Return the service that shows a value, of groups of these kinds alone if there are any."""
    return bound(row, codec=codec, read=_checked(kinds, read) if kinds else read)


def set_value(
    row: NcRow, error: NcError, field: str, *kinds: type, choices: type[IntEnum] | None = None
) -> Service:
    """Return the service that shows and sets an attribute of groups of these kinds."""

    def read(group: AnyGroup) -> Any:
        return getattr(group, field)

    def write(group: AnyGroup, value: Any) -> None:
        try:
            setattr(group, field, value)
        except PathError as refused:
            raise DeviceError(error.number, str(refused)) from None

    if kinds:
        read, write = _checked(kinds, read), _checked(kinds, write)
    return bound(
        row,
        read=read,
        write=write,
        code=error.number,
        guard=_checked(kinds, lambda group: None) if kinds else None,
        choices=choices,
    )


def group_function(row: NcRow, call: Callable[..., int], *kinds: type) -> Service:
    """Return the service that is written with the arguments of `call`, a function of groups."""

    def write(group: AnyGroup, data: Any) -> None:
        carry_out(call(group, *data) if isinstance(data, tuple) else call(group, data))

    return bound(row, write=_checked(kinds, write) if kinds else write, non_finite=True)
