"""What an axis belongs to: its own PTP group, or a master that leads it."""

from achse.codes import NcError
from achse.motion.axis import Axis
from achse.motion.checks import OK

__all__ = ["decouple_and_start", "return_to_ptp_group"]


def decouple_and_start(axis: Axis, start_type: int, *_: float) -> int:
    """Uncouple a slave and start it (0x17); an axis that is not a slave cannot be uncoupled."""
    return NcError.DECOUPLING_NOT_POSSIBLE.number


def return_to_ptp_group(axis: Axis) -> int:
    """Back into the axis' own PTP group (0x70), where a single axis is already."""
    return OK
