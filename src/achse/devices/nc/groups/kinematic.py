"""Kinematic groups: places of the tool (MCS), axes of the machine (ACS), and the way between."""

from collections.abc import Callable, Sequence

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.codes.nc.row import NcRow
from achse.codes.nc.table import named_rows
from achse.devices.nc.groups.binding import AnyGroup, group_function, show
from achse.devices.nc.rows import bound
from achse.motion.groups.kinematic import COORDINATES, KinematicGroup
from achse.server import Service

_PARAMETERS = named_rows(0x3000)
_STATES = named_rows(0x3100)
_FUNCTIONS = named_rows(0x3200)


def _transformation(
    row: NcRow, call: Callable[[KinematicGroup, Sequence[float]], list[float] | int]
) -> Service:
    def exchange(group: AnyGroup, data: tuple[float, ...]) -> tuple[float, ...]:
        if not isinstance(group, KinematicGroup):
            raise DeviceError(ReturnCode.INVALID_OFFSET, "a service of kinematic groups alone")
        result = call(group, data[:COORDINATES])
        if isinstance(result, int):
            raise DeviceError(result, f"{row.name} of {data[:COORDINATES]}")
        return (*result, 0, 0)

    return bound(row, exchange=exchange)


def _assign(group: KinematicGroup, *ids: int) -> int:
    """Return the first reserved word: 1 lets the axes lead the places (our choice)."""
    mcs, acs = ids[:COORDINATES], ids[COORDINATES : 2 * COORDINATES]
    return group.assign_both(mcs, acs, by_axes=ids[2 * COORDINATES] == 1)


KINEMATIC_PARAMETERS = (
    _transformation(_PARAMETERS["kinematic_forward_transformation"], KinematicGroup.forward),
    _transformation(_PARAMETERS["kinematic_inverse_transformation"], KinematicGroup.inverse),
)

KINEMATIC_STATES = (
    show(
        _STATES["kinematic_axis_assignment"],
        lambda group: (*group.mcs_ids, *group.acs_ids, int(group.by_axes), 0),
        KinematicGroup,
    ),
)

KINEMATIC_FUNCTIONS = (
    group_function(_FUNCTIONS["assign_kinematic_axes"], _assign, KinematicGroup),
)
