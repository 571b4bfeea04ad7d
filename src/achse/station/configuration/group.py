"""[[channel]] and [[group]]: axes that move together, and the channels that own them."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, FiniteFloat

from achse.gcode.canon import Handshake
from achse.gcode.state.mfunctions import MRule
from achse.motion.channels.parameters import ChannelParameters
from achse.motion.channels.store import ProgramStore
from achse.motion.groups.parameters import (
    LONGEST_FIFO,
    MOST_AXES,
    GroupParameters,
    KinematicsParameters,
)
from achse.motion.groups.states import (
    ChannelType,
    FifoInterpolation,
    GroupType,
)
from achse.station.configuration.types import ConfigTable, DeviceName, DurationNs

_CHANNELS = {
    "interpreter": ChannelType.INTERPRETER,
    "fifo": ChannelType.FIFO,
    "kinematic": ChannelType.KINEMATIC_TRANSFORMATION,
}
_GROUPS = {"3d": GroupType.THREE_D, "fifo": GroupType.FIFO, "kinematic": GroupType.KINEMATIC}


_WHEN = {
    "none": Handshake.NONE,
    "before": Handshake.BEFORE_MOVE,
    "after": Handshake.AFTER_MOVE,
}
_Number = Annotated[int, Field(ge=0, le=159)]


class MFunctionConfig(ConfigTable):
    """[[channel.m]]: what an M function does; others are passed over."""

    number: _Number
    handshake: Literal["none", "before", "after"] = "none"
    """The path waits for the PLC, before or after the move of the block."""
    fast: Literal["none", "before", "after"] = "none"
    """A bit of the cyclic structure is set, before or after the move."""
    auto_reset: bool = False
    """True if the bit is cleared at the end of the block."""
    clears: Annotated[Sequence[_Number], Field(max_length=10)] = ()
    """Fast M functions whose bits go out."""

    def rule(self) -> MRule:
        """Return the rule as the interpreter takes it."""
        return MRule(_WHEN[self.handshake], _WHEN[self.fast], self.auto_reset, tuple(self.clears))


class ChannelConfig(ConfigTable):
    """[[channel]]: what owns groups of several axes. The channel of all single axes is there
    without, at the lowest id that is free."""

    id: int = Field(ge=1, le=255)
    name: DeviceName = ""
    type: Literal["interpreter", "fifo", "kinematic"] = "interpreter"
    """Kind of its groups: a 3D group that part programs move, a FIFO, kinematics."""
    programs: str | None = None
    """Folder of its part programs (relative to the station.toml)."""
    data: str | None = None
    """Folder for its tools, zero shifts and snapshots (relative to the station.toml); without it
    they are kept in memory."""
    m: Sequence[MFunctionConfig] = ()
    plc: str | Sequence[str] = ()
    """The variables of a PLC that are its cyclic structures, an NCTOPLC_NCICHANNEL_REF and a
    PLCTONC_NCICHANNEL_REF (`["MAIN.fromChannel", "MAIN.toChannel"]`, or their places
    `["%IB2000", "%QB2000"]`; `"852:MAIN.fromChannel"` if several PLCs have it). Without it the only
    pair belongs to the only channel."""

    def parameters(self, base: Path) -> ChannelParameters:
        """Return the channel as the NC takes it. Raises GroupParametersError."""
        store = ProgramStore(
            None if self.programs is None else base / self.programs,
            None if self.data is None else base / self.data,
        )
        rules = {each.number: each.rule() for each in self.m}
        return ChannelParameters(
            self.id, self.name, _CHANNELS[self.type], m_rules=rules, store=store
        )


class GroupConfig(ConfigTable):
    """[[group]]: axes that move together. Single axes have PTP groups of their own ids without."""

    id: int = Field(ge=1, le=255)
    """Not that of an axis."""
    name: DeviceName = ""
    type: Literal["3d", "fifo", "kinematic"] = "3d"
    channel: int = Field(ge=1, le=255)
    """The id of a [[channel]] of the type that fits."""
    axes: Sequence[Annotated[int, Field(ge=0, le=255)]] = ()
    """Ids of axes that belong to it from the start, 0 for an empty place; usually a client assigns
    them."""
    dimension: int = Field(default=8, ge=1, le=MOST_AXES)
    """Axes of a FIFO."""
    length: int = Field(default=1000, ge=1, le=LONGEST_FIFO)
    """Rows of a FIFO."""
    interpolation: Literal["linear", "four_point", "cubic_spline"] = "linear"
    """Interpolation between the rows of a FIFO."""
    time_delta: DurationNs = 2_000_000
    """Time between the rows of a FIFO at 100 %."""
    table_size: int = Field(default=128, ge=128, le=1024)
    """Segments that the path of a 3D group knows ahead."""
    segments_per_cycle: int = Field(default=1, ge=1, le=1024)
    """Segments that go over to the path of a 3D group in a cycle at most (0x514 at the start; by
    ADS 1..20). Very short blocks need as many as the path goes through in a cycle."""
    keep_jerk: bool = False
    """A 3D group keeps the jerk of its axes where the curvature of the path jumps too: lines into
    arcs, corners rounded by a parabola or cubic. It is slower there, and all its ramps have 70 % of
    the jerk."""
    kinematics: str = "identity"
    """Of a kinematic group: identity, portal, scara, parallel, delta, or a Python file (relative to
    the station.toml) with functions `forward` and `inverse`."""
    numbers: Mapping[str, FiniteFloat] = {}
    """Numbers of the kinematics by name, lengths in mm, angles in degrees."""

    def parameters(self, base: Path) -> GroupParameters:
        """Return the group as the NC takes it. Raises GroupParametersError."""
        of_user = self.kinematics.endswith(".py")
        return GroupParameters(
            self.id,
            _GROUPS[self.type],
            self.channel,
            self.name,
            dimension=self.dimension,
            length=self.length,
            time_delta=self.time_delta / 1e9,
            interpolation=FifoInterpolation[self.interpolation.upper()],
            table_size=self.table_size,
            segments_per_cycle=self.segments_per_cycle,
            keep_jerk=self.keep_jerk,
            kinematics=KinematicsParameters(
                "" if of_user else self.kinematics,
                dict(self.numbers),
                base / self.kinematics if of_user else None,
            ),
            axes=self.axes,
        )
