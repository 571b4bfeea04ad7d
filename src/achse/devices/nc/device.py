"""The NC's ADS device: its services bound to the axes. Ports 500 (NC) and 501 (SAF task)."""

from collections.abc import Callable, Iterator

from achse.ams import DeviceError
from achse.codes import NcError
from achse.devices.nc.axis_cyclic import AXIS_CYCLIC
from achse.devices.nc.axis_functions import AXIS_FUNCTIONS
from achse.devices.nc.axis_parameters import AXIS_PARAMETERS
from achse.devices.nc.axis_states import AXIS_STATES
from achse.devices.nc.elements import (
    CONTROLLER_PARAMETERS,
    CONTROLLER_STATES,
    DRIVE_PARAMETERS,
    DRIVE_STATES,
    ENCODER_PARAMETERS,
    ENCODER_STATES,
)
from achse.devices.nc.ring0 import RING0_PARAMETERS, RING0_STATES
from achse.motion import Axis, Nc
from achse.motion.axis import ObjectAxis
from achse.server import Device, Group, IndexGroup, ObjectGroup

__all__ = ["NcDevice"]

_AXIS_GROUPS = (
    (0x4000, AXIS_PARAMETERS, NcError.AXIS_ID),
    (0x4100, AXIS_STATES, NcError.AXIS_ID),
    (0x4200, AXIS_FUNCTIONS, NcError.AXIS_ID),
    (0x4300, AXIS_CYCLIC, NcError.AXIS_ID),
    (0x5000, ENCODER_PARAMETERS, NcError.ENCODER_ID),
    (0x5100, ENCODER_STATES, NcError.ENCODER_ID),
    (0x6000, CONTROLLER_PARAMETERS, NcError.CONTROLLER_ID),
    (0x6100, CONTROLLER_STATES, NcError.CONTROLLER_ID),
    (0x7000, DRIVE_PARAMETERS, NcError.DRIVE_ID),
    (0x7100, DRIVE_STATES, NcError.DRIVE_ID),
)
"""Index group + id, rows, error for an id that no axis has."""

_HIGHEST_ID = 255


class NcDevice(Device):
    """Answers for all axes of an NC.

    An id that no axis has is answered 0x4012 (encoder 0x4013, controller 0x4014, drive 0x4015).
    """

    def __init__(self, nc: Nc, *, clock: Callable[[], int]) -> None:
        super().__init__(
            "TwinCAT NC", (3, 1, 4024), _groups(nc), clock=clock, task_cycle_ns=nc.cycle_ns
        )
        self.nc = nc


def _groups(nc: Nc) -> Iterator[IndexGroup]:
    yield Group(0x1000, RING0_PARAMETERS, nc)
    yield Group(0x1100, RING0_STATES, nc)
    for base, rows, unknown in _AXIS_GROUPS:
        yield ObjectGroup(base, _HIGHEST_ID, _finder(nc, unknown), rows, kind=ObjectAxis)


def _finder(nc: Nc, unknown: NcError) -> Callable[[int], Axis]:
    axes = {axis.axis_id: axis for axis in nc}

    def find(axis_id: int) -> Axis:
        try:
            return axes[axis_id]
        except KeyError:
            raise DeviceError(unknown.number, f"id {axis_id}") from None

    return find
