"""Assignment of axes to the places of a group, and its end."""

from achse.codes import NcError
from achse.codes.nc.table import named_rows
from achse.devices.nc.groups.binding import AnyGroup, group_function, show
from achse.motion.groups.fifo import FifoGroup
from achse.motion.groups.group import AxisGroup
from achse.motion.groups.kinematic import KinematicGroup
from achse.motion.groups.path_group import PathGroup
from achse.motion.groups.ptp import PtpGroup

_STATES = named_rows(0x3100)
_FUNCTIONS = named_rows(0x3200)

_SEVERAL = (PathGroup, FifoGroup, KinematicGroup)
_PTP_OR_PATH = (PtpGroup, PathGroup)


def _assign_all(group: AxisGroup, *ids: int) -> int:
    """Return all places, no more and no less (000, 002 say UINT32[m])."""
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
        _STATES["axis_assignment"],
        lambda group: group.acs_ids if isinstance(group, KinematicGroup) else group.ids,
        *_SEVERAL,
    ),
)

PLACE_FUNCTIONS = (
    group_function(_FUNCTIONS["assign_axes_xyz"], _assign_xyz, *_PTP_OR_PATH),
    group_function(_FUNCTIONS["assign_axis"], _assign_one, PtpGroup, PathGroup, FifoGroup),
    group_function(_FUNCTIONS["assign_axes"], _assign_all, PathGroup, FifoGroup),
    group_function(
        _FUNCTIONS["dissolve_axis_assignment"], lambda group: group.dissolve(), *_SEVERAL
    ),
)
