"""FIFO groups: dimension, length, time base, rows (public pages on FIFO axes)."""

from achse.codes import NcError
from achse.codes.nc.table import named_rows
from achse.devices.nc.groups.binding import group_function, set_value, show
from achse.motion.groups.fifo import FifoGroup
from achse.motion.groups.states import FifoOverrideType

_PARAMETERS = named_rows(0x3000)
_FUNCTIONS = named_rows(0x3200)


def _write(group: FifoGroup, *values: float) -> int:
    return group.write(values)


def _overwrite(group: FifoGroup, *values: float) -> int:
    return group.overwrite(values)


FIFO_PARAMETERS = (
    show(_PARAMETERS["fifo_dimension"], lambda group: group.dimension, FifoGroup),
    show(_PARAMETERS["fifo_length"], lambda group: group.length, FifoGroup),
    show(_PARAMETERS["fifo_interpolation_type"], lambda group: group.interpolation_type, FifoGroup),
    set_value(
        _PARAMETERS["fifo_override_type"],
        NcError.FIFO_OVERRIDE_TYPE,
        "override_type",
        FifoGroup,
        choices=FifoOverrideType,
    ),
    set_value(
        _PARAMETERS["fifo_override_pt2_time"],
        NcError.FIFO_OVERRIDE_CHANGE_TIME,
        "override_time",
        FifoGroup,
    ),
    set_value(
        _PARAMETERS["fifo_entry_time_delta"], NcError.FIFO_TIME_UNIT, "time_delta", FifoGroup
    ),
)

FIFO_FUNCTIONS = (
    group_function(_FUNCTIONS["fifo_start"], lambda group: group.start(), FifoGroup),
    group_function(_FUNCTIONS["fifo_write"], _write, FifoGroup),
    group_function(_FUNCTIONS["fifo_overwrite"], _overwrite, FifoGroup),
)
