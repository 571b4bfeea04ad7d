"""Configuration of a group at the start of the NC: kind, channel and parameters by name."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from achse.motion.groups.states import FifoInterpolation, GroupType

MOST_AXES = 16
LONGEST_FIFO = 10_000
"""Rows of a FIFO (002, 0x3000+ID:0x702)."""

SAF_TABLE = range(128, 1024 + 1)
"""Entries of the set-point task of a path (002, 0x3000+ID:0x50C)."""


class GroupParametersError(ValueError):
    """The description of a group or channel names something that cannot be."""


@dataclass(frozen=True, slots=True)
class KinematicsParameters:
    """Law from axes to places (a name of `achse.motion.groups.kinematics.table`) and its numbers by
    name: lengths in mm, angles in degrees. `file` is a Python file of a user that has the law
    instead.
    """

    law: str = "identity"
    values: Mapping[str, float] = field(default_factory=dict)
    file: Path | None = None


@dataclass(frozen=True, slots=True)
class GroupParameters:
    """Configuration of a group of several axes at the start of the NC.

    `dimension` and `length` are those of a FIFO (axes, rows); `table_size` is that of a path, and
    `segments_per_cycle` how many go over to it in a cycle at most. `axes` are assigned from the
    start, 0 for an empty place.
    """

    group_id: int
    type: GroupType
    channel_id: int
    name: str = ""
    dimension: int = 8
    length: int = 1000
    time_delta: float = 0.002
    """Time between two rows of a FIFO, s."""
    interpolation: FifoInterpolation = FifoInterpolation.LINEAR
    table_size: int = SAF_TABLE.start
    segments_per_cycle: int = 1
    keep_jerk: bool = False
    """True: a path keeps the jerk of its axes where its curvature jumps too."""
    kinematics: KinematicsParameters = KinematicsParameters()
    axes: Sequence[int] = ()

    def __post_init__(self) -> None:
        what = f"group {self.group_id}"
        for name, value, allowed in (
            ("id", self.group_id, range(1, 256)),
            ("dimension", self.dimension, range(1, MOST_AXES + 1)),
            ("length", self.length, range(1, LONGEST_FIFO + 1)),
            ("table_size", self.table_size, SAF_TABLE),
            ("segments_per_cycle", self.segments_per_cycle, range(1, SAF_TABLE.stop)),
        ):
            if value not in allowed:
                raise GroupParametersError(
                    f"{what}: {name} = {value}, expected {allowed.start}..{allowed.stop - 1}"
                )
