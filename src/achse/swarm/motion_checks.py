"""Invariants of motion: what holds for the set point of each axis from one cycle to the next.

Excused are the moments in which the manuals themselves are abrupt: a reset in motion, a new actual
position, a control loop that opens or closes, cams with corners, gears whose master is faster than
the slave may be (decision 0186).
"""

from achse.motion.states import MotionPhase

__all__ = ["MotionStep"]

_MORE = 1.0 + 1e-6
"""Rounding of the planner and of the bound."""

_MORE_ON_A_PATH = 1.0 + 1e-4
"""Rounding of a path: that of `tests/motion/path/test_random_paths.py`."""

_LEAST = 1e-9
"""Rounding of a velocity or acceleration near 0, in axis units."""


_PLACED = frozenset((0, 1, 10, 11, 13))
"""Laws that have invariants of their own: none, gear, and cams."""


_JUMPING = frozenset((1, 2, 3, 5, 6, 16))
"""Laws whose velocity jumps to that of a new ratio: gear, saws, bi-linear."""


class MotionStep:
    """Set point of an axis in a cycle and the one before, with the limits that hold."""

    __slots__ = (
        "a0",
        "a1",
        "abrupt",
        "bent",
        "beyond",
        "bumpy",
        "commanded",
        "coupled",
        "deceleration",
        "dt",
        "fall",
        "gear",
        "gear0",
        "grouped",
        "jerk",
        "keep_jerk",
        "law",
        "master",
        "over_master",
        "p0",
        "p1",
        "phase",
        "phase0",
        "pull",
        "rise",
        "shift",
        "smooth",
        "speed",
        "stopping",
        "swing",
        "top",
        "v0",
        "v1",
    )  # fmt: skip

    def __init__(self, top: float, rise: float, fall: float, jerk: float, gentlest: float) -> None:
        self.top = top
        """Largest velocity of a command."""
        self.rise, self.fall, self.jerk = rise, fall, jerk
        strongest = max(rise, fall)
        self.swing = (1.0 / gentlest - 1.0) * strongest * strongest / (2.0 * jerk)
        """Velocity above it, while an acceleration is taken away by a command with less jerk."""
        self.dt = 0.0
        self.p0 = self.p1 = self.v0 = self.v1 = self.a0 = self.a1 = 0.0
        self.shift = 0.0
        """Change of the zero point in this cycle."""
        self.phase = self.phase0 = 0
        self.law = 0
        self.gear = self.gear0 = 0.0
        self.speed = 0.0
        """Largest velocity of axis and drive."""
        self.master = self.pull = 0.0
        """Way of the master in this cycle, and the velocity by which masters change the slave's."""
        self.over_master = False
        """True for a slave on a curve over its master, which has no limit of its own (0037)."""
        self.smooth = self.bent = self.beyond = self.coupled = False
        self.bumpy = False
        """True for a slave of a slave whose velocity may jump: that of a cam or of a new ratio."""
        self.grouped = self.keep_jerk = False
        """On the path of a group, which keeps the jerk of axes everywhere."""
        self.commanded = False
        """True if a command came: a small move may be done within the cycle."""
        self.abrupt = False
        """True if a coupling gave an acceleration that no jerk limits, until the axis rests."""

    # each gives a reason, or None

    def finite(self) -> str | None:
        total = self.p1 + self.v1 + self.a1
        return f"{self.p1}, {self.v1}, {self.a1}" if total - total != 0.0 else None

    def velocity(self) -> str | None:
        if not self.smooth or self.beyond or self.coupled:
            return None
        more = _MORE_ON_A_PATH if self.grouped else _MORE
        limit = (self.top + self.swing) * more
        return None if -limit <= self.v1 <= limit else f"velocity {self.v1}, limit {limit}"

    def acceleration(self) -> str | None:
        """Left over from before a change of direction it may be more, while it is brought down."""
        if not self.smooth or self.beyond or self.coupled or self.bent:
            return None
        a1 = self.a1
        if self.grouped:
            strongest = max(self.rise, self.fall) * _MORE_ON_A_PATH
            return None if abs(a1) <= strongest else f"acceleration {a1}, limit {strongest}"
        if abs(self.v1) <= 1e-6 * self.top or abs(a1) < abs(self.a0):
            return None
        limit = self.rise if a1 * self.v1 > 0.0 else self.fall
        return None if abs(a1) <= limit * _MORE else f"acceleration {a1}, limit {limit}"

    def jerk_limit(self) -> str | None:
        if not self.smooth or self.bent or self.abrupt:
            return None
        if self.grouped:
            return self._jerk_on_path()
        change = abs(self.a1 - self.a0)
        limit = self.jerk * self.dt * _MORE + _LEAST
        if change > limit:
            return f"acceleration {self.a0} -> {self.a1}, jerk limit {self.jerk}"
        bend = abs(self.v1 - self.v0 - 0.5 * (self.a0 + self.a1) * self.dt)
        if bend > self.jerk * self.dt * self.dt / 4.0 * _MORE + _LEAST:
            return f"velocity {self.v0} -> {self.v1} with acceleration {self.a0} -> {self.a1}"
        return None

    def _jerk_on_path(self) -> str | None:
        """Where the curvature jumps, only a group that keeps the jerk has a limit (0123)."""
        if not self.keep_jerk or self.phase != self.phase0:
            return None
        limit = self.jerk * self.dt * _MORE_ON_A_PATH + 1e-6
        if abs(self.a1 - self.a0) > limit:
            return f"acceleration {self.a0} -> {self.a1}, jerk limit {self.jerk}, on a path"
        return None

    def position(self) -> str | None:
        """An axis goes by its velocity."""
        if not self.smooth or (self.coupled and self.law != 1) or self.gear != self.gear0:
            return None
        if self.bumpy:
            return None
        dt = self.dt
        way = abs(self.p1 - self.p0 - self.shift - 0.5 * (self.v0 + self.v1) * dt)
        if self.bent or self.abrupt or self.grouped:
            allowed = (abs(self.a0) + abs(self.a1) + self.rise + self.fall) * dt * dt
        else:
            allowed = self.jerk * dt * dt * dt / 12.0 * _MORE
        if self.coupled:  # its master may have accelerated anywhere in the cycle (decision 0186)
            allowed += 0.5 * abs(self.v1 - self.v0) * dt
        allowed += 1e-12 * (abs(self.p1) + abs(self.shift)) + 1e-9
        if way > allowed:
            return f"position {self.p0} -> {self.p1} at velocity {self.v0} -> {self.v1}"
        return None

    def coupled_way(self) -> str | None:
        """A slave of another law goes by its velocity, and its velocity by its acceleration."""
        if not self.coupled or self.law in _PLACED or not self.smooth or self.bumpy:
            return None
        if self.gear != self.gear0:  # the first cycle of a law, or of its parameters
            return None
        if self.over_master:
            return None
        dt = self.dt
        strength = abs(self.a0) + abs(self.a1) + self.rise + self.fall
        bend = abs(self.v1 - self.v0)
        if bend > strength * dt * _MORE + self.pull + _LEAST:
            return f"velocity {self.v0} -> {self.v1}, acceleration {self.a0} -> {self.a1}"
        way = abs(self.p1 - self.p0 - self.shift - 0.5 * (self.v0 + self.v1) * dt)
        allowed = 0.5 * bend * dt + strength * dt * dt + 1e-12 * abs(self.p1) + 1e-9
        if way > allowed:
            return f"position {self.p0} -> {self.p1} at velocity {self.v0} -> {self.v1}"
        return None

    def new_ratio(self) -> str | None:
        """A new ratio makes no slave faster than axis and drive may be."""
        if not self.coupled or self.law not in _JUMPING or not self.smooth or self.bent:
            return None
        if self.gear0 != self.gear0 or self.gear == self.gear0 or self.gear != self.gear:
            return None
        limit = max(abs(self.v0), self.speed) * _MORE + _LEAST
        limit += 2.0 * max(abs(self.a0), abs(self.a1)) * self.dt
        return None if abs(self.v1) <= limit else f"velocity {self.v1}, limit {limit}"

    def stop(self) -> str | None:
        """A stop takes the acceleration away, it adds none."""
        stopping = MotionPhase.STOPPING
        if self.phase != stopping or self.phase0 != stopping or not self.smooth:
            return None
        if self.bent or self.coupled or self.v0 * self.v1 <= 0.0:
            return None
        sign = 1.0 if self.v1 > 0.0 else -1.0
        if self.a1 * sign > max(self.a0 * sign, 0.0) + _LEAST:
            return f"acceleration {self.a0} -> {self.a1} at velocity {self.v1}, stopping"
        return None

    def rest(self) -> str | None:
        """An axis without a motion keeps its set point."""
        if self.phase or self.phase0 or self.commanded or not self.smooth:
            return None
        if self.bent or self.coupled:
            return None
        if self.v1 or self.p1 != self.p0 + self.shift:
            return f"position {self.p0} -> {self.p1}, velocity {self.v1}, without a motion"
        return None

    def slave_step(self) -> str | None:
        """Slaves of cams keep the velocity of axis and drive, whatever the table asks (0124)."""
        if not self.coupled or self.law not in (10, 11) or not self.smooth:
            return None
        way = abs(self.p1 - self.p0 - self.shift)
        allowed = self.speed * self.dt * _MORE + 1e-9 + 1e-12 * abs(self.p1)
        return None if way <= allowed else f"slave goes {way} in a cycle, limit {allowed}"

    def gear_law(self) -> str | None:
        """A slave of a gear goes as far as its master, times the ratio."""
        if not self.coupled or self.law != 1 or not self.smooth or self.bent:
            return None
        if self.gear != self.gear0:
            return None
        way, law = self.p1 - self.p0 - self.shift, self.gear * self.master
        if abs(way - law) > 1e-9 + 1e-11 * (abs(self.p1) + abs(self.gear * self.p0)):
            return f"slave goes {way}, ratio {self.gear} times master {self.master}"
        return None
