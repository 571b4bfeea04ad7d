"""Which axes are at the places of a group: assignment and its end."""

from achse.codes import NcError
from achse.devices.nc.groups.binding import AnyGroup, group_function, show
from achse.devices.nc.layouts import NO_DATA, UINT32, request
from achse.motion.groups.fifo import FifoGroup
from achse.motion.groups.group import AxisGroup
from achse.motion.groups.kinematic import KinematicGroup
from achse.motion.groups.path_group import PathGroup
from achse.motion.groups.ptp import PtpGroup
from achse.server import Repeated

__all__ = ["PLACE_FUNCTIONS", "PLACE_STATES"]

_SEVERAL = (PathGroup, FifoGroup, KinematicGroup)
_PTP_OR_PATH = (PtpGroup, PathGroup)
_ALL = Repeated(UINT32)


def _assign_all(group: AxisGroup, *ids: int) -> int:
    """All places, no more and no less (000, 002 say UINT32[m])."""
    if len(ids) != len(group.places):
        return NcError.GROUP_MASTER_INDEX
    return group.assign(ids)


def _assign_xyz(group: AnyGroup, x: int, y: int, z: int) -> int:
    if isinstance(group, PtpGroup):
        return _keep(group, x if not y and not z else 0)
    return group.assign((x, y, z))


def _assign_one(group: AnyGroup, axis_id: int, place: int) -> int:
    if isinstance(group, PtpGroup):
        return NcError.GROUP_MASTER_INDEX if place else _keep(group, axis_id)
    return group.assign_one(axis_id, place)


def _keep(group: PtpGroup, axis_id: int) -> int:
    """A PTP group takes its own axis alone, back out of a group of several."""
    if axis_id != group.group_id:
        return NcError.MASTER_NOT_INSERTED
    owner = group.axis.group
    return 0 if owner is None else owner.remove(group.axis)


PLACE_STATES = (
    show(
        *(0x552, _ALL, "axis_assignment", "id of the axis at each place, 0 = none"),
        lambda group: group.acs_ids if isinstance(group, KinematicGroup) else group.ids,
        *_SEVERAL,
    ),
)

PLACE_FUNCTIONS = (
    group_function(
        *(0x50, "assign_axes_xyz", _assign_xyz, request(x="I", y="I", z="I")),
        "have these axes as X, Y and Z, 0 = none",
        *_PTP_OR_PATH,
    ),
    group_function(
        *(0x51, "assign_axis", _assign_one, request(axis_id="I", place="I")),
        "have one more axis at a place, from 0 on",
        *(PtpGroup, PathGroup, FifoGroup),
    ),
    group_function(
        *(0x52, "assign_axes", _assign_all, _ALL),
        "have these axes at all places, 0 = none",
        *(PathGroup, FifoGroup),
    ),
    group_function(
        *(0x53, "dissolve_axis_assignment", lambda group: group.dissolve(), NO_DATA),
        "give the axes back to their PTP groups",
        *_SEVERAL,
    ),
)
