"""Kinematic groups: places of the tool (MCS), axes of the machine (ACS), and the way between."""

from collections.abc import Callable, Sequence

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.devices.nc.groups.binding import AnyGroup, group_function, show
from achse.motion.groups.kinematic import COORDINATES, KinematicGroup
from achse.server import READ_WRITE, Layout, Service

__all__ = ["KINEMATIC_FUNCTIONS", "KINEMATIC_PARAMETERS", "KINEMATIC_STATES"]

_POSITIONS = Layout("<8d2I")
_IDS = Layout("<8I8I2I")


def _transformation(
    offset: int,
    name: str,
    description: str,
    call: Callable[[KinematicGroup, Sequence[float]], list[float] | int],
) -> Service:
    def exchange(group: AnyGroup, data: tuple[float, ...]) -> tuple[float, ...]:
        if not isinstance(group, KinematicGroup):
            raise DeviceError(ReturnCode.INVALID_OFFSET, "a service of kinematic groups alone")
        found = call(group, data[:COORDINATES])
        if isinstance(found, int):
            raise DeviceError(found, f"{name} of {data[:COORDINATES]}")
        return (*found, 0, 0)

    return Service(
        *(offset, name, READ_WRITE, _POSITIONS, description, "e.g. mm, degree"),
        exchange=exchange,
        response=_POSITIONS,
    )


def _assign(group: KinematicGroup, *ids: int) -> int:
    """The first reserved word: 1 lets the axes lead the places (our choice)."""
    mcs, acs = ids[:COORDINATES], ids[COORDINATES : 2 * COORDINATES]
    return group.assign_both(mcs, acs, by_axes=ids[2 * COORDINATES] == 1)


KINEMATIC_PARAMETERS = (
    _transformation(
        *(0x801, "kinematic_forward_transformation"),
        *("places for axes; nothing moves", KinematicGroup.forward),
    ),
    _transformation(
        *(0x802, "kinematic_inverse_transformation"),
        *("axes for places, in the present pose", KinematicGroup.inverse),
    ),
)

KINEMATIC_STATES = (
    show(
        *(0x553, _IDS, "kinematic_axis_assignment", "ids of places and axes, 0 = none"),
        lambda group: (*group.mcs_ids, *group.acs_ids, int(group.by_axes), 0),
        KinematicGroup,
    ),
)

KINEMATIC_FUNCTIONS = (
    group_function(
        *(0x54, "assign_kinematic_axes", _assign, _IDS),
        "have these axes as places and as axes of the machine, 0 = none",
        KinematicGroup,
    ),
)
