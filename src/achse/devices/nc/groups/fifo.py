"""FIFO groups: dimension, length, time base, rows (public pages on FIFO axes)."""

from achse.codes import NcError
from achse.devices.nc.groups.binding import group_function, set_value, show
from achse.devices.nc.layouts import NO_DATA, REAL64, UINT32
from achse.motion.groups.fifo import FifoGroup
from achse.motion.groups.states import FifoOverrideType
from achse.server import Repeated

__all__ = ["FIFO_FUNCTIONS", "FIFO_PARAMETERS"]

_SHORTEST = 1e-6
"""Time constant of an override, s: above 0."""

_LONGEST = 60.0

_ROWS = Repeated(REAL64)


def _write(group: FifoGroup, *values: float) -> int:
    return group.write(values)


def _overwrite(group: FifoGroup, *values: float) -> int:
    return group.overwrite(values)


FIFO_PARAMETERS = (
    show(
        *(0x701, UINT32, "fifo_dimension", "axes of a row"),
        lambda group: group.dimension,
        FifoGroup,
    ),
    show(0x702, UINT32, "fifo_length", "rows it holds", lambda group: group.length, FifoGroup),
    show(
        *(0x703, UINT32, "fifo_interpolation_type", "what is between rows: 0 lines, 1 4 points, 4"),
        lambda group: group.interpolation_type,
        FifoGroup,
    ),
    set_value(
        *(0x704, UINT32, NcError.FIFO_OVERRIDE_TYPE, "fifo_override_type"),
        *("how the override changes: 1 at once, 2 by a PT2 element", "override_type", FifoGroup),
        choices=FifoOverrideType,
    ),
    set_value(
        *(0x705, REAL64, NcError.FIFO_OVERRIDE_CHANGE_TIME, "fifo_override_pt2_time"),
        *("time constant T0 of the PT2 element", "override_time", FifoGroup),
        unit="s",
        minimum=_SHORTEST,
        maximum=_LONGEST,
    ),
    set_value(
        *(0x706, REAL64, NcError.FIFO_TIME_UNIT, "fifo_entry_time_delta"),
        *("time between two rows at 100 %", "time_delta", FifoGroup),
        unit="s",
        minimum=0.0,
        maximum=1e6,
    ),
)

FIFO_FUNCTIONS = (
    group_function(
        *(0x701, "fifo_start", lambda group: group.start(), NO_DATA),
        "begin with the first row, where the axes are",
        FifoGroup,
    ),
    group_function(
        *(0x710, "fifo_write", _write, _ROWS, "append rows; all fit or none are taken"),
        FifoGroup,
    ),
    group_function(
        *(0x711, "fifo_overwrite", _overwrite, _ROWS),
        "replace the rows that are not yet taken",
        FifoGroup,
    ),
)
