"""The NC's ADS device: its services bound to the axes. Ports 500 (NC) and 501 (SAF task)."""

from collections.abc import Callable, Iterator
from functools import partial

from achse.ams import DeviceError
from achse.codes import NcError
from achse.devices.nc.axes.controller import CONTROLLER_PARAMETERS, CONTROLLER_STATES
from achse.devices.nc.axes.cyclic import AXIS_CYCLIC
from achse.devices.nc.axes.drive import DRIVE_FUNCTIONS, DRIVE_PARAMETERS, DRIVE_STATES
from achse.devices.nc.axes.encoder import ENCODER_PARAMETERS, ENCODER_STATES
from achse.devices.nc.axes.io_structures import DRIVE_CYCLIC, ENCODER_CYCLIC
from achse.devices.nc.axes.parameters import AXIS_PARAMETERS
from achse.devices.nc.axes.states import AXIS_STATES
from achse.devices.nc.channels import channel_groups
from achse.devices.nc.functions import AXIS_FUNCTIONS, ENCODER_FUNCTIONS
from achse.devices.nc.groups import GROUP_FUNCTIONS, GROUP_PARAMETERS, GROUP_STATES
from achse.devices.nc.groups.binding import GroupFinder
from achse.devices.nc.ring0 import RING0_FUNCTIONS, RING0_PARAMETERS, RING0_STATES
from achse.devices.nc.symbols import NcSymbols, interface_groups
from achse.devices.nc.tables.services import table_groups
from achse.motion import Axis, Nc
from achse.motion.axis import ObjectAxis
from achse.motion.parts import VIEWS, AxisPart
from achse.server import Device, Group, IndexGroup, ObjectGroup, Service

RING0_GROUPS: tuple[tuple[int, tuple[Service, ...]], ...] = (
    (0x1000, RING0_PARAMETERS),
    (0x1100, RING0_STATES),
    (0x1200, RING0_FUNCTIONS),
)
"""Index group, rows."""

GROUPS = (
    (0x3000, GROUP_PARAMETERS),
    (0x3100, GROUP_STATES),
    (0x3200, GROUP_FUNCTIONS),
)
"""Index group + id, rows over the group."""

AXIS_GROUPS = (
    (0x4000, AXIS_PARAMETERS, NcError.AXIS_ID),
    (0x4100, AXIS_STATES, NcError.AXIS_ID),
    (0x4200, AXIS_FUNCTIONS, NcError.AXIS_ID),
    (0x4300, AXIS_CYCLIC, NcError.AXIS_ID),
    (0x5000, ENCODER_PARAMETERS, NcError.ENCODER_ID),
    (0x5100, ENCODER_STATES, NcError.ENCODER_ID),
    (0x5200, ENCODER_FUNCTIONS, NcError.ENCODER_ID),
    (0x5300, ENCODER_CYCLIC, NcError.ENCODER_ID),
    (0x6000, CONTROLLER_PARAMETERS, NcError.CONTROLLER_ID),
    (0x6100, CONTROLLER_STATES, NcError.CONTROLLER_ID),
    (0x7000, DRIVE_PARAMETERS, NcError.DRIVE_ID),
    (0x7100, DRIVE_STATES, NcError.DRIVE_ID),
    (0x7200, DRIVE_FUNCTIONS, NcError.DRIVE_ID),
    (0x7300, DRIVE_CYCLIC, NcError.DRIVE_ID),
)
"""Index group + id, rows, error for an id that no axis has."""

_HIGHEST_ID = 255

_FROM_PLC = next(row for row in AXIS_CYCLIC if row.name == "plc_to_nc_structure")


class NcDevice(Device):
    """Answers for all axes of an NC.

    An id that no axis has is answered 0x4012 (channel 0x4010, group 0x4011, encoder 0x4013,
    controller 0x4014, drive 0x4015, table 0x4016).
    """

    def __init__(self, nc: Nc, *, clock: Callable[[], int]) -> None:
        super().__init__(
            "TwinCAT NC",
            (3, 1, 4024),
            _groups(nc),
            NcSymbols(nc, ((0x4100, AXIS_STATES), (0x4300, AXIS_CYCLIC)), _FROM_PLC, GROUP_STATES),
            clock=clock,
            task_cycle_ns=nc.cycle_ns,
        )
        self.nc = nc


def _groups(nc: Nc) -> Iterator[IndexGroup]:
    for group, rows in RING0_GROUPS:
        yield Group(group, rows, nc)
    yield from channel_groups(nc)
    find_group = GroupFinder(nc).find
    for base, rows in GROUPS:
        yield ObjectGroup(base, _HIGHEST_ID, find_group, rows)
    for base, rows, unknown in AXIS_GROUPS:
        part = _KINDS.get(unknown)
        kind = VIEWS[part][0] if part else ObjectAxis
        yield ObjectGroup(base, _HIGHEST_ID, _finder(nc, unknown), rows, kind=kind, permanent=True)
    yield from table_groups(nc)
    yield from interface_groups(nc, _FROM_PLC)


_KINDS = {
    NcError.ENCODER_ID: "encoder",
    NcError.CONTROLLER_ID: "controller",
    NcError.DRIVE_ID: "drive",
}
"""Kind of a part of an axis, by the error for its unknown id; other errors are for axes."""


def _finder(nc: Nc, unknown: NcError) -> Callable[[int], Axis | AxisPart]:
    kind = _KINDS.get(unknown)
    look_up: Callable[[int], Axis | AxisPart]
    look_up = nc.axis if kind is None else partial(nc.element, kind)

    def find(id: int) -> Axis | AxisPart:
        try:
            return look_up(id)
        except KeyError:
            raise DeviceError(unknown.number, f"id {id}") from None

    return find
