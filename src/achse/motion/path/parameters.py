"""Parameters of a path: limits of its axes, transitions, smoothing, dynamics, override."""

from dataclasses import dataclass, field
from enum import IntEnum
from math import isfinite, radians

from achse.motion.path.corners import ReductionMethod
from achse.motion.path.record import PathAxis, PathState
from achse.motion.path.segments import PathError
from achse.motion.path.smoothing import Smoothing, SmoothingSubtype

_JUMP_SHARE = 0.3
"""Share of the jerk of an axis that jumps of curvature may take, with `keep_jerk`."""


class PathOverride(IntEnum):
    """Values that the override scales (0x3000+ID:0x50A)."""

    REDUCED = 0
    """The velocity that corners and axes have reduced already."""
    ORIGINAL = 1
    """The programmed velocity, which is reduced then."""
    REDUCED_ABOVE = 2
    """As 0, also above 100 %, as far as the axes allow."""


@dataclass(frozen=True, slots=True)
class PathLimits:
    """Limits of an axis on the path: mm/s, mm/s², mm/s³; all above 0.

    `velo_jump`, 0 or more, is the factor of paramVeloJump: at a corner the velocity of the axis
    jumps by at most this times the lower of acceleration and deceleration times the cycle time.
    """

    velocity: float
    acceleration: float
    jerk: float
    deceleration: float = 0.0
    """0: as acceleration."""
    velo_jump: float = 1.0

    def __post_init__(self) -> None:
        for name in ("velocity", "acceleration", "jerk"):
            value = getattr(self, name)
            if not (isfinite(value) and value > 0.0):
                raise PathError(f"path axis: {name} {value}, expected above 0")
        for name in ("deceleration", "velo_jump"):
            value = getattr(self, name)
            if not (isfinite(value) and value >= 0.0):
                raise PathError(f"path axis: {name} {value}, expected 0 or more")

    def fill(self, row: PathAxis, cycle_time: float, *, keep_jerk: bool = False) -> None:
        """Write them into the kernel's record; `keep_jerk` as in `PathParameters`."""
        row.velocity, row.acceleration, row.jerk = self.velocity, self.acceleration, self.jerk
        if keep_jerk:
            row.jerk = (1.0 - _JUMP_SHARE) * self.jerk
        row.bend_jump = _JUMP_SHARE * self.jerk * cycle_time
        row.deceleration = self.deceleration or self.acceleration
        row.jump = self.velo_jump * min(row.acceleration, row.deceleration) * cycle_time


@dataclass(frozen=True, slots=True)
class PathParameters:
    """Parameters of segments from now on; 002 §6.4.3.1 and the `#set` commands of the dialect."""

    method: ReductionMethod = ReductionMethod.COULOMB
    """Corners (0x500)."""
    c0: float = 0.0
    """Factor at corners, 0..1 (0x501). With Coulomb and 0 the path rests at each corner."""
    c1: float = 1.0
    """Factor where the curvature jumps, 0..1 (0x502)."""
    c2: float = 1.0
    """Factor where the curvature goes on, 0..1 (0x507)."""
    angle_low: float = 0.0
    """Corners up to this angle reduce nothing, degrees 0..180 (0x503)."""
    angle_high: float = 180.0
    """Cosine: from here on the full factor; degrees, above the low one (0x504)."""
    least_velocity: float = 0.0
    """Transitions reduce to no less, mm/s (0x505)."""
    keep_jerk: bool = False
    """True: keep the jerk of the axes where the curvature jumps, and their accelerations with it.
    In each cycle these jumps take 30 % of the jerk, ramps and bends 70 %."""
    smoothing: Smoothing = Smoothing.OFF
    smoothing_subtype: SmoothingSubtype = SmoothingSubtype.RADIUS
    smoothing_radius: float = 0.0
    """mm; 0 is off."""
    acceleration: float = 0.0
    """Along the path, mm/s²; 0: what the axes allow (paramPathDynamics)."""
    deceleration: float = 0.0
    jerk: float = 0.0
    override_type: PathOverride = PathOverride.REDUCED
    most_override: float = field(default=1.0)
    """Override that is possible; above 1 only with type 2."""

    def __post_init__(self) -> None:
        for name, least, most in (
            ("c0", 0.0, 1.0),
            ("c1", 0.0, 1.0),
            ("c2", 0.0, 1.0),
            ("angle_low", 0.0, 180.0),
            ("angle_high", 0.0, 180.0),
            ("least_velocity", 0.0, 1e9),
            ("smoothing_radius", 0.0, 1e6),
            ("acceleration", 0.0, 1e12),
            ("deceleration", 0.0, 1e12),
            ("jerk", 0.0, 1e15),
            ("most_override", 1.0, 10.0),
        ):
            value = getattr(self, name)
            if not least <= value <= most:
                raise PathError(f"path: {name} {value}, expected {least:g}..{most:g}")
        if self.method == ReductionMethod.COSINE and not self.angle_low < self.angle_high:
            raise PathError(
                f"path: angle_low {self.angle_low}, expected below angle_high {self.angle_high}"
            )

    def fill(self, state: PathState) -> None:
        """Write them into the kernel's record."""
        state.method = int(self.method)
        state.c0, state.c1, state.c2 = self.c0, self.c1, self.c2
        state.angle_low, state.angle_high = radians(self.angle_low), radians(self.angle_high)
        state.least_velocity = self.least_velocity
        state.keep_jerk = int(self.keep_jerk)
        on = self.smoothing_radius > 0.0
        state.smoothing = int(self.smoothing) if on else 0
        state.smoothing_subtype = int(self.smoothing_subtype)
        state.smoothing_radius = self.smoothing_radius
        state.path_acceleration = self.acceleration
        state.path_deceleration = self.deceleration
        state.path_jerk = self.jerk
        state.override_type = int(self.override_type)
        above = self.override_type == PathOverride.REDUCED_ABOVE
        state.most_override = self.most_override if above else 1.0
        state.fresh = 0
        state.out = min(state.out, 1)
