"""Rights: what a client may, and which of them a request needs.

Nothing like it is in the manuals: a router there lets in or it does not. A request without its
right is answered with 0x723, access denied.
"""

import struct
from collections.abc import Iterable, Iterator, Mapping
from enum import Flag

from achse.ams import AmsAddress, Command, Frame
from achse.codes import ReservedGroup
from achse.codes.groups import FILES, NAMED, SUMS
from achse.codes.ports import SYSTEM_PORT
from achse.codes.station import SERVICE_PORT


class Right(Flag):
    """Rights of a client."""

    READ = 1
    """Read values, states, symbols; subscribe."""
    WRITE = 2
    """Write values and parameters: also commands of axes, which are writes."""
    STATE = 4
    """Change states of devices and of the station (WriteControl)."""
    FILES = 8
    """The file services of port 10000, reading ones too."""
    METHODS = 16
    """Call methods of a PLC."""


NO_RIGHTS = Right(0)
ALL_RIGHTS = Right.READ | Right.WRITE | Right.STATE | Right.FILES | Right.METHODS

_UNLIMITED = (500, 801, 802)
"""Of the system service: a program that is started may do anything, and a client that adds a route
may grant it every right."""

_CHANGES = (Command.WRITE, Command.READ_WRITE)
"""At port 26000 they record what others may, cause faults that restart the station, stop PLCs."""

_READS = NAMED | {
    ReservedGroup.SUM_READ,
    ReservedGroup.SUM_READ_WITH_LENGTHS,
    ReservedGroup.SUM_READ_SHORT,
    ReservedGroup.SUM_ADD_NOTIFICATION,
    ReservedGroup.SUM_DELETE_NOTIFICATION,
}
"""Index groups of ReadWrite requests that only read."""

_ALWAYS: Mapping[int, Right] = {
    Command.READ_DEVICE_INFO: Right.READ,
    Command.READ_STATE: Right.READ,
    Command.DELETE_NOTIFICATION: Right.READ,
    Command.WRITE_CONTROL: Right.STATE,
}
"""Commands that need the same, whatever they are about."""

_SHORT_PART, _PART = struct.Struct("<III"), struct.Struct("<IIII")
"""A part of a sum of writes, and one of a sum of ReadWrites."""

_HEAD = 16
_MOST_PARTS = 500


def rights_named(names: Iterable[str]) -> Right:
    """The rights with these names (`read`, `write`, `state`, `files`, `methods`).

    Raises ValueError.
    """
    rights = NO_RIGHTS
    known = [str(right.name).lower() for right in Right]
    for name in names:
        if name not in known:
            raise ValueError(f"rights are {', '.join(known)}, got {name!r:.40}")
        rights |= Right[name.upper()]
    return rights


def needed_rights(frame: Frame) -> Right:
    """Return the rights that the sender of a request needs; all of them for an unknown request."""
    command, data = frame.command, frame.data
    if command in _ALWAYS:
        return _ALWAYS[command]
    group = _group_of(data)
    port = AmsAddress(frame.target).port
    if port == SYSTEM_PORT:
        if group in FILES:
            return Right.FILES
        if (
            group in SUMS and command == Command.READ_WRITE
        ):  # its parts may be about files, and about routes
            return Right.FILES | Right.READ if group in _READS else ALL_RIGHTS
        if group in _UNLIMITED and command in _CHANGES:
            return ALL_RIGHTS
    elif port == SERVICE_PORT and command in _CHANGES:
        return Right.READ if group in _READS else ALL_RIGHTS
    if command in (Command.READ, Command.ADD_NOTIFICATION):
        return Right.READ
    if command == Command.WRITE:
        return _needed_by_write(group)
    return _needed_by_read_write(group, data) if command == Command.READ_WRITE else ALL_RIGHTS


def _group_of(data: bytes) -> int:
    return int.from_bytes(data[:4], "little") if len(data) >= 4 else -1


def _needed_by_write(group: int) -> Right:
    """To give a handle back is no more than to take one."""
    return Right.READ if group == ReservedGroup.RELEASE_SYMBOL_HANDLE else Right.WRITE


def _needed_by_read_write(group: int, data: bytes) -> Right:
    if group in _READS:
        return Right.READ
    if group == ReservedGroup.SYMBOL_VALUE_BY_HANDLE:
        return Right.METHODS
    needed = NO_RIGHTS
    if group == ReservedGroup.SUM_WRITE:
        for part in _groups_of_parts(data, _SHORT_PART):
            needed |= _needed_by_write(part)
        return needed or Right.WRITE
    if group == ReservedGroup.SUM_READ_WRITE:
        for part in _groups_of_parts(data, _PART):
            needed |= _needed_by_read_write(part, b"")
    return needed or Right.READ | Right.WRITE


def _groups_of_parts(data: bytes, layout: struct.Struct) -> Iterator[int]:
    """Yield the groups in a sum command; its offset says how many parts there are."""
    count = min(int.from_bytes(data[4:8], "little"), _MOST_PARTS)
    for start in range(_HEAD, min(len(data), _HEAD + count * layout.size), layout.size):
        yield _group_of(data[start:])
