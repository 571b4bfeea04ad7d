"""The watch over the axes of a station: each set point, cycle by cycle, against the invariants.

It sees what clients see, set points, phases and couplings, and is a phase of the station's cycle
behind the NC. While all axes rest and no request comes it is not due, so that the NC does those
cycles in one go.
"""

import math
from collections.abc import Callable, Mapping, Sequence

from achse.motion import Nc
from achse.station import Station
from achse.station.clocks.cycle import Phase, PhasePlace
from achse.swarm.channel_watch import ChannelWatch
from achse.swarm.motion.checks import NAMES, describe
from achse.swarm.motion.kernel import ACTIVE, AxesUnderWatch, WrongSetPoint
from achse.swarm.motion.step import set_limits
from achse.swarm.worlds.world import DrawnAxis, DrawnChannel

_AWAKE_NS = 500_000_000
"""Time for which it looks at each cycle after a request."""

_GENTLEST = 0.01
"""Least part of its jerk that commands of an unknown axis may have."""

Report = Callable[[str, str], None]
"""Called with the name of an invariant and what has happened."""


class MotionWatch(Phase):
    """The phase that looks at all axes of a station, also after a restart."""

    place, name = PhasePlace.SCOPE, "swarm"
    due_ns: float = 0

    def __init__(
        self,
        station: Station,
        parts: Sequence[DrawnAxis],
        checks: Sequence[str],
        report: Report,
        channel: DrawnChannel | None = None,
    ) -> None:
        self._station = station
        self._channel = None if channel is None else ChannelWatch(channel, report)
        self._keep_jerk = channel is not None and channel.keep_jerk
        self._requested = False
        self._parts = {part.name: part for part in parts}
        self._checks = checks
        self._report = report
        self._nc: Nc | None = None
        self._axes: AxesUnderWatch | None = None
        self._until_ns = 0
        self.cycles = 0
        """Cycles of one axis that were looked at."""
        self._moves = self._abrupt_cycles = 0

    @property
    def moves(self) -> int:
        """Commands that axes took."""
        return self._moves + (0 if self._axes is None else self._axes.moves)

    @property
    def abrupt_cycles(self) -> int:
        """Cycles of an axis in which the manuals are abrupt: most is not checked."""
        return self._abrupt_cycles + (0 if self._axes is None else self._axes.abrupt_cycles)

    def wake(self) -> None:
        """Look at the cycles to come: something may move."""
        self._requested = True
        now = self._station.time_ns
        self._until_ns = now + _AWAKE_NS
        if self.due_ns == math.inf:
            self.due_ns = now

    def begin(self, earliest_ns: int) -> None:
        """Look from the first cycle on."""
        self.due_ns = earliest_ns

    def step(self, now_ns: int) -> None:
        """Look at all axes after a cycle of the NC."""
        nc = self._station.nc
        if nc is not self._nc:
            self._bind(nc)
        if nc is None or self._axes is None:
            self.due_ns = now_ns + 1_000_000
            return
        cycle_ns = nc.cycle_ns
        self.due_ns = now_ns - now_ns % cycle_ns + cycle_ns
        verdict = self._axes.look()
        active = verdict >= ACTIVE
        wrong = WrongSetPoint.of(verdict)
        if wrong is not None:
            self._report(*reason_of(wrong, nc, self._axes, self._station.time_ns))
        self.cycles += len(nc)
        if self._channel is not None:
            requested = self._requested or bool(len(self._station.faults))
            when = f"{self._station.time_ns / 1e9:.6f} s"
            active = self._channel.look(when, requested=requested) or active
        self._requested = False
        if len(self._station.faults):  # frames that a fault delays arrive unseen
            self._until_ns = now_ns + _AWAKE_NS
        elif not active and now_ns >= self._until_ns:
            self.due_ns = math.inf

    def _bind(self, nc: Nc | None) -> None:
        self._moves, self._abrupt_cycles = self.moves, self.abrupt_cycles
        self._nc, self._axes = nc, None
        if self._channel is not None:
            self._channel.bind(nc)
        if nc is not None:
            self._axes = axes_under_watch(nc, self._parts, self._checks, self._keep_jerk)


def axes_under_watch(
    nc: Nc, parts: Mapping[str, DrawnAxis], checks: Sequence[str], keep_jerk: bool
) -> AxesUnderWatch:
    """Return the axes of an NC with their limits, ready for the first cycle."""
    watched = AxesUnderWatch(nc, sum(1 << n for n, name in enumerate(NAMES) if name in checks))
    for axis, step in zip(nc, watched.steps, strict=True):
        part = parts.get(axis.name)
        set_limits(
            *(step, axis.max_velocity, axis.max_acceleration, axis.max_deceleration),
            *(axis.default_jerk, _GENTLEST if part is None else part.gentlest),
        )
        step.dt = nc.cycle_seconds
        step.speed = min(axis.max_velocity, axis.drive.reference_velocity)
        step.keep_jerk = int(keep_jerk)
        step.number, step.active_number = axis.command_counter, axis.set_command_number
    watched.look()
    for step in watched.steps:
        step.smooth = step.was_closed = step.abrupt_cycles = 0
    return watched


def reason_of(wrong: WrongSetPoint, nc: Nc, axes: AxesUnderWatch, now_ns: int) -> tuple[str, str]:
    """Return the name of the invariant that does not hold, and what has happened."""
    axis = list(nc)[wrong.axis]
    what = f"axis {axis.name} at {now_ns / 1e9:.6f} s: {describe(axes.steps[wrong.axis])}"
    return NAMES[wrong.check], f"{what}, error {axis.error_code:#x}"
