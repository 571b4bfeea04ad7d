"""Chains of plans in one call: draw, plan, check and walk on, as plain Python or as machine code.

Kernel source, in the language of `achse.native`.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from achse.motion.compiled import KERNEL as MOTION
from achse.motion.machine.kernel import HardwareRows
from achse.motion.record import AxisFields
from achse.motion.rows import NcRows
from achse.motion.setpoints.planning import TO_PAUSE, TO_TARGET, plan
from achse.motion.setpoints.setpoint import follow_segment, generate
from achse.native.compiled import Kernel
from achse.native.declare import Slot, lay_out, within
from achse.swarm.plans.chain import command, draw_axis, expect
from achse.swarm.plans.check import (
    PLAN,
    REFUSED,
    SET_POINT,
    CheckedPlan,
    check,
    lose,
    walk,
)
from achse.swarm.plans.numbers import DRAWS, Draws, begin_draws, chance, decades, draw, one_of

_LEAST_TIME = 1e-9
"""Time in which an axis at rest on a border passes it."""

_ROUNDING = 4e-15
"""Relative rounding error of a time that is summed over the segments of a plan."""


class ChainRun:
    """Progress of the chains of a seed, and the move that is wrong."""

    draws: Draws = within(DRAWS)
    plan: CheckedPlan = within(PLAN)
    moves: int = 0
    chain: int = 0
    move: int = 0
    verdict: int = 0
    unavoidable: int = 0
    """Plans that pass a soft limit, which no ramp of the axis can keep."""
    seconds: float = 0.0
    """Time that the axes moved."""
    checksum: float = 0.0


RUN = lay_out("chain run", (ChainRun,), Slot)


@dataclass
class RunRows:
    """The run; machine code gets its address."""

    runs: Sequence[ChainRun]


def play_chains(
    rows: NcRows,
    hardware: HardwareRows,
    dt: float,
    watched: RunRows,
    low: int,
    high: int,
    first: int,
    count: int,
    moves: int,
) -> int:
    """Play `count` chains from `first` on, of so many moves each; return the verdict, 0 if good.

    `low` and `high` are the halves of the seed. It ends with the first move that is wrong.
    """
    run = watched.runs[0]
    ax = rows.axes[0]
    for n in range(count):
        run.chain = first + n
        begin_draws(run.draws, low, high, run.chain)
        draw_axis(ax, run.draws)
        run.plan.running = ax.profile.running_jerk
        run.move = 0
        while run.move < moves:
            run.verdict = _play_move(run, ax)
            if run.verdict != 0:
                return run.verdict
            run.move += 1
    return 0


def _play_move(run: ChainRun, ax: AxisFields) -> int:
    """Give a command, check its plan, and walk on to the time of the next command."""
    if ax.profile.replan == 0:
        command(ax, run.draws, run.plan)
    if ax.profile.replan:
        expect(ax, run.plan)
        if plan(ax) < 0:
            return REFUSED
        if ax.profile.replan:  # put off: the next command begins here
            ax.border.time = -1.0
            run.plan.has_target = 0
            generate(ax, _LEAST_TIME)
            lose(run.plan, ax)
            return REFUSED if ax.error_code else 0
        verdict = _check(run, ax)
        if verdict != 0:
            return verdict
    return _walk_on(run, ax)


def _check(run: ChainRun, ax: AxisFields) -> int:
    run.moves += 1
    if ax.limits.reached:
        run.unavoidable += 1
    verdict = check(run.plan, ax)
    run.checksum = 0.5 * run.checksum + run.plan.total + run.plan.p
    return verdict


def _time(run: ChainRun, ax: AxisFields) -> float:
    """Draw the time until the next command: within a segment, at its end, or behind all."""
    draws = run.draws
    total = run.plan.total
    kind = draw(draws)
    if kind < 0.5:
        return total * draw(draws)
    if kind < 0.7:
        return decades(draws, -4.0, -1.0)
    if kind < 0.85 and ax.profile.count > 0:
        time = 0.0
        for i in range(1 + one_of(draws, ax.profile.count)):
            time += ax.profile.time[i]
        if chance(draws, 0.5):
            time *= 1.0 + (draw(draws) - 0.5) * decades(draws, -15.0, -3.0)
        return time
    return total + decades(draws, -4.0, -1.0)


def _walk_on(run: ChainRun, ax: AxisFields) -> int:
    """Let the axis go on for a time, and compare its set point with the integral.

    It goes no farther than to the next command, whose plan is checked from there.
    """
    plan = run.plan
    profile = ax.profile
    time = _time(run, ax)
    passes = profile.end == TO_PAUSE or ax.loop.outward != 0
    passes = passes or (profile.end == TO_TARGET and profile.end_velocity > 0.0)
    end = ax.border.time if ax.border.time >= 0.0 else plan.total - plan.at
    if (passes or ax.border.time >= 0.0) and time > end:
        time = end
    if time <= 0.0:
        return 0
    if plan.known == 0:
        generate(ax, time)
        lose(plan, ax)
        return REFUSED if ax.error_code else 0
    plan.at += time
    walk(plan, ax, plan.at)
    running = plan.running
    p = plan.p
    v = plan.v
    known = profile.fastest
    profile.fastest = -1.0
    if not follow_segment(ax, time):
        generate(ax, time)
    run.seconds += time
    if ax.error_code:
        return REFUSED
    if profile.fastest < 0.0:
        profile.fastest = known
        return _compare(run, ax, p, v, ax.set.position, ax.set.velocity)
    # another plan was made at the end of this one
    plan.has_target = 0
    verdict = _compare(run, ax, p, v, profile.position, profile.velocity)
    if verdict != 0:
        return verdict
    plan.running = running
    if profile.index != 0 or profile.replan != 0:
        lose(plan, ax)
        return 0
    expect(ax, plan)
    verdict = _check(run, ax)
    plan.at = profile.elapsed
    walk(plan, ax, plan.at)
    return verdict


def _compare(
    run: ChainRun, ax: AxisFields, p: float, v: float, position: float, velocity: float
) -> int:
    """Compare a set point with its integral; rounding is that of way, velocity and time.

    A time of months is rounded to more than a short ramp at its end takes.
    """
    plan = run.plan
    way = abs(plan.p0) + abs(p) + abs(ax.border.position)
    speed = max(plan.highest, abs(plan.v0), abs(v))
    strength = plan.rise + plan.fall + abs(plan.a0)
    if abs(position - p) > 1e-9 * (way + speed * plan.at):
        return SET_POINT
    if abs(velocity - v) > 1e-7 * (speed + strength * 1e-9) + strength * _ROUNDING * plan.at:
        return SET_POINT
    return 0


CHAINS = Kernel(
    "swarm-plans",
    play_chains,
    {**MOTION.layouts, Draws: DRAWS, CheckedPlan: PLAN, ChainRun: RUN},
)
"""Called with rows and cycle time of an NC, the run, the seed and the numbers of chains."""
