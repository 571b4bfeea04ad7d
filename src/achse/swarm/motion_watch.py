"""The watch over the axes of a station: each set point, cycle by cycle, against the invariants.

It sees what clients see, set points, phases and couplings, and is a phase of the station's cycle
behind the NC. While all axes rest and no request comes it is not due, so that the NC does those
cycles in one go.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

from achse.motion import Axis, Nc
from achse.motion.couplings.flying_saws.approach import BY_POSITION
from achse.motion.states import MotionPhase
from achse.station import Station
from achse.station.clocks.cycle import Phase, PhasePlace
from achse.swarm.channel_watch import ChannelWatch
from achse.swarm.motion_checks import MotionStep
from achse.swarm.worlds.world import DrawnAxis, DrawnChannel

__all__ = ["MotionCheck", "MotionWatch"]

MotionCheck = tuple[str, Callable[[MotionStep], str | None]]
"""Name of an invariant, and what returns the reason why it does not hold, or None."""

_AWAKE_NS = 500_000_000
"""Time for which it looks at each cycle after a request."""

_ROUGH = frozenset(
    (
        MotionPhase.EXTERNAL, MotionPhase.VELOCITY_STEPS, MotionPhase.SINE,
        MotionPhase.DRIVE_OUTPUT, MotionPhase.TORQUE,
    )
)  # fmt: skip
"""Set points that come from outside, from the axis itself or by steps."""

Report = Callable[[str, str], None]
"""Called with the name of an invariant and what has happened."""


class _AxisWatch:
    """What was seen of one axis."""

    def __init__(self, axis: Axis, part: DrawnAxis, dt: float) -> None:
        self.axis = axis
        self.name = part.name
        self.step = MotionStep(
            axis.max_velocity,
            axis.max_acceleration,
            axis.max_deceleration,
            axis.default_jerk,
            part.gentlest,
        )
        self.step.dt = dt
        self.step.speed = min(axis.max_velocity, axis.drive.reference_velocity)
        self.closed = self.bent = False
        self.resets = axis.reset_command_counter
        self.zero = axis.encoder.set_position_offset
        self.superposed = (0.0, 0.0, 0.0)
        self.law = self.master = 0
        self.led = axis.leading_value.position
        self.speeds: list[float] = []
        self.active = False
        self.moves = 0
        self._number = axis.command_counter
        self._active_number = axis.set_command_number

    def look(self, masters: Sequence[Axis]) -> None:
        """Take the values of this cycle in."""
        axis, step = self.axis, self.step
        now = axis.set
        step.p0, step.v0, step.a0 = step.p1, step.v1, step.a1
        step.p1, step.v1, step.a1 = now.position, now.velocity, now.acceleration
        step.phase0, step.phase = step.phase, axis.set_motion_phase
        zero, resets, closed = (
            axis.encoder.set_position_offset,
            axis.reset_command_counter,
            axis.loop_closed,
        )
        grouped = MotionPhase.GROUPED
        step.grouped = step.phase == grouped or step.phase0 == grouped
        step.shift, self.zero = zero - self.zero, zero
        rough = step.phase in _ROUGH or step.phase0 in _ROUGH
        step.smooth = bool(
            closed and self.closed and resets == self.resets and not step.shift and not rough
        )
        self.closed, self.resets = bool(closed), resets
        superposed = axis.superposed
        plan = superposed.distance, superposed.end, superposed.acceleration
        bent = bool(axis.compensating or plan != self.superposed)  # it may end within the cycle
        self.superposed = plan
        step.bent, self.bent = bent or self.bent, bent
        coupling = axis.coupling
        law = coupling.law
        step.law, step.coupled = law, bool(law or self.law)
        step.gear0 = step.gear
        gear = coupling.gear if law == 1 else sum(coupling.parameters)
        step.gear = gear if law == self.law else math.nan
        self.law = law
        if law:
            self.master = coupling.masters[0]
            shift = axis.phasing.position  # of what the slave sees of its master
            master = masters[self.master].leading_value.position + shift
            step.master, self.led = master - self.led, master
            leaders = coupling.masters[: coupling.master_count]
            speeds = [masters[each].leading_value.velocity for each in leaders]
            speeds.append(axis.phasing.velocity)
            changes = (abs(a - b) for a, b in zip(speeds, self.speeds, strict=False))
            ratios = (abs(coupling.gear), *map(abs, coupling.parameters[:2]))
            step.pull, self.speeds = max(ratios) * sum(changes), speeds
            step.over_master = axis.sync.method == BY_POSITION
        moving = bool(step.phase != 0 or step.v1 != 0.0 or step.v0 != 0.0 or law)
        step.abrupt = moving and (step.abrupt or step.coupled)
        step.beyond = moving and (
            step.beyond or rough or step.bent or step.coupled or not step.smooth
        )
        waits = axis.buffer_count  # a command that waits for the arrival of an axis at rest
        self.active = bool(step.phase or step.v1 or law or bent or waits or not closed)
        number = axis.command_counter
        active = axis.set_command_number
        self.moves += number != self._number
        step.commanded = number != self._number or active != self._active_number
        self._number, self._active_number = number, active


class MotionWatch(Phase):
    """The phase that looks at all axes of a station, also after a restart."""

    place, name = PhasePlace.SCOPE, "swarm"
    due_ns: float = 0

    def __init__(
        self,
        station: Station,
        parts: Sequence[DrawnAxis],
        checks: Sequence[MotionCheck],
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
        self._axes: list[_AxisWatch] = []
        self._rows: Sequence[Axis] = ()
        self._until_ns = 0
        self.cycles = 0
        """Cycles of one axis that were looked at."""
        self._moves = 0
        self.abrupt_cycles = 0
        """Cycles of an axis in which the manuals are abrupt: most is not checked."""

    @property
    def moves(self) -> int:
        """Commands that axes took."""
        return self._moves + sum(each.moves for each in self._axes)

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
        if nc is None:
            self.due_ns = now_ns + 1_000_000
            return
        cycle_ns = nc.cycle_ns
        self.due_ns = now_ns - now_ns % cycle_ns + cycle_ns
        active = False
        coupled = False
        for each in self._axes:
            each.look(self._rows)
            active = active or each.active
            coupled = coupled or each.step.coupled
        if coupled:
            self._excuse_slaves()
        for each in self._axes:
            step = each.step
            if step.phase or step.v1 or step.v0 or step.p1 != step.p0:
                self.abrupt_cycles += not step.smooth
                for name, check in self._checks:
                    reason = check(step)
                    if reason is not None:
                        self._tell(name, each, reason)
        self.cycles += len(self._axes)
        if self._channel is not None:
            requested = self._requested or bool(len(self._station.faults))
            when = f"{self._station.time_ns / 1e9:.6f} s"
            active = self._channel.look(when, requested=requested) or active
        self._requested = False
        if len(self._station.faults):  # frames that a fault delays arrive unseen
            self._until_ns = now_ns + _AWAKE_NS
        elif not active and now_ns >= self._until_ns:
            self.due_ns = math.inf

    def _excuse_slaves(self) -> None:
        """A slave is as smooth as its masters are."""
        axes = self._axes
        for each in axes:
            each.step.bumpy = False
        for _ in axes:
            for each in axes:
                if each.law and each.step.smooth:
                    step, master = each.step, axes[each.master].step
                    jumps = master.coupled and (master.law != 1 or master.gear != master.gear0)
                    step.bumpy = step.bumpy or jumps or master.bumpy
                    step.smooth = master.smooth or master.phase == master.phase0 == 0 == master.v0

    def _tell(self, name: str, each: _AxisWatch, reason: str) -> None:
        step = each.step
        self._report(
            name,
            f"axis {each.name} at {self._station.time_ns / 1e9:.6f} s: {reason};"
            f" phase {step.phase0} -> {step.phase}, law {step.law},"
            f" error {each.axis.error_code:#x}",
        )

    def _bind(self, nc: Nc | None) -> None:
        self._moves = self.moves
        self._nc, self._axes, self._rows = nc, [], ()
        if self._channel is not None:
            self._channel.bind(nc)
        if nc is None:
            return
        dt = nc.cycle_ns / 1e9
        self._rows = list(nc)
        self._axes = [
            _AxisWatch(axis, self._parts.get(axis.name) or _unknown(axis.name), dt) for axis in nc
        ]
        for each in self._axes:
            each.step.keep_jerk = self._keep_jerk
            each.look(self._rows)
            each.step.smooth = each.closed = False


def _unknown(name: str) -> DrawnAxis:
    return replace(DrawnAxis(name, "mm", False, {}), gentlest=0.01)
