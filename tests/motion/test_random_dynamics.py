"""Random dynamics: no command, error or withdrawn enable makes an axis faster than it may be.

Everything is drawn: the dynamics of each command, axis and fault ramp over decades, limits,
enables, overrides, errors, kinds of commands and their times. An observer knows what was commanded
and sees the set values of each cycle. From the cycle before and the strongest jerk at work it
computes what running out the present acceleration gives. Nothing may be faster than that or than
the commanded velocity, nothing faster than the axis maximum. No set position may be beyond a soft
limit that the strongest ramp of the axis could still keep, no fault brake more weakly than that.

`ACHSE_RANDOM_COMMANDS=100000 pytest tests/motion/test_random_dynamics.py` is the long form.
"""

import importlib.util
import os
import random
from collections.abc import Callable
from functools import partial
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from achse.codes.nc.choices import MotionPhase
from achse.motion import AxisParameters, Nc
from achse.motion.states import DriveOperationMode
from tests.motion.fields_seen import view


def _load(name: str) -> Any:
    spec = importlib.util.spec_from_file_location(name, Path(__file__).with_name(f"{name}.py"))
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


drawn = _load("drawn_commands")
DT = drawn.DT
AXES = 64
COMMANDS = int(os.environ.get("ACHSE_RANDOM_COMMANDS", "6000"))

MORE = 1.0 + 1e-6
"""Rounding of anyone who plans and of anyone who computes the bound."""

MOVING = (MotionPhase.POSITIONING, MotionPhase.ENDLESS, MotionPhase.HOMING, MotionPhase.REVERSING)
OPEN = (MotionPhase.DRIVE_OUTPUT, MotionPhase.TORQUE)
"""The set point follows the axis, which no table plans."""


def stopping_way(v: float, a: float, deceleration: float, jerk: float) -> float:
    """Way from (v, a), v >= 0, to rest with this ramp; integrated, so a little more is added."""
    if v <= 0.0:
        return 0.0
    if a < 0.0:  # made by a stronger jerk, which takes it away in time, too
        jerk = max(jerk, a * a / (2.0 * v))
    peak = min(deceleration, (v * jerk + a * a) ** 0.5)
    step = (v / peak + (peak + abs(a)) / jerk) / 300.0
    way = 0.0
    while v > 0.0:
        if a < -deceleration:
            a = min(a + jerk * step, -deceleration)
        elif v > (a * a / (2.0 * jerk) if a < 0.0 else 0.0):
            a = max(a - jerk * step, -deceleration)
        else:
            a += jerk * step
            if a >= 0.0:
                break
        way += v * step
        v += a * step
    return float(1.01 * way + 2.0 * max(v, 0.0) * step)


SEEN = (
    "set_position", "set_velocity", "set_acceleration", "encoder_set_position_offset",
    "encoder_soft_limit_min", "encoder_soft_limit_max", "max_velocity",
)  # fmt: skip
STATES = (
    "set_motion_phase", "loop_closed", "compensating", "drive_operation_mode", "error_code",
    "external_setpoint_active", "set_command_number", "encoder_soft_limit_min_enable",
    "encoder_soft_limit_max_enable",
)  # fmt: skip
PHASE, LOOP, COMPENSATING, MODE, ERROR, EXTERNAL, NUMBER, LOW, HIGH = range(len(STATES))


class Observer:
    """The set values of all axes, cycle by cycle, and what may be said of them."""

    def __init__(self, nc: Nc, players: list[Any]) -> None:
        self.nc = nc
        self.players = players
        self.look = view(nc, SEEN, STATES)
        self.before, self.states = self.look()
        count = len(players)
        self.commanded = np.zeros(count)
        self.jerk = np.array([player.axis.default_jerk for player in players])
        self.active_jerk = self.jerk.copy()
        self.cap = self.before[:, 6].copy()
        self.reach = np.array([self.before[:, 0], self.before[:, 0]])
        """Farthest positions, below and above, that soft limits leave open."""
        self.slack = np.zeros(count)
        self.unsure = np.zeros(count, bool)
        """What moves on top has hidden with which jerk the acceleration of the table was made."""
        self.faults: dict[int, tuple[float, float, float]] = {}
        """Axes that a fault brakes: where, in which direction, how far at most."""
        self.cycles = self.seen_faults = 0
        for i in range(count):
            self.open_limits(i)

    def learn(self, i: int) -> None:
        """What the commands of axis `i` allow from now on."""
        player = self.players[i]
        self.commanded[i] = player.allowed()
        if player.axis.set_motion_phase != MotionPhase.STOPPING:
            player.jerks.pop(0, None)
        jerk = player.jerks.get(0) or player.jerks.get(player.axis.set_command_number, 0.0)
        self.active_jerk[i] = jerk or player.axis.default_jerk
        self.jerk[i] = max(self.jerk[i], jerk)

    def open_limits(self, i: int) -> None:
        """Limits or positions changed: what is beyond, or too fast to stay before, is excused."""
        p, v, a = self.before[i, :3]
        way = stopping_way(abs(v), a if v > 0.0 else -a, *self.players[i].ramp()) + abs(v) * DT
        self.reach[0, i] = p - (way if v < 0.0 else 0.0)
        self.reach[1, i] = p + (way if v > 0.0 else 0.0)

    def cycle(self) -> None:
        """One cycle, and the judgement on it."""
        before = self.jerk.copy()
        for i, player in enumerate(self.players):
            if player.acted:
                self.learn(i)
            player.lead()
        self.nc.cycle()
        self.cycles += len(self.players)
        now, states = self.look()
        jerks = self.jerk.copy()  # a command that begins within the cycle finds those of before
        wanted = self.commanded.copy()
        for i in map(int, np.flatnonzero(states[:, NUMBER] != self.states[:, NUMBER])):
            if states[i, PHASE] != MotionPhase.STOPPING:  # what was changed is over already
                jerks[i] = self.jerk[i] = before[i]
            self.learn(i)
        wanted = np.maximum(wanted, self.commanded)
        _, v0, a0, shift0, *_ = self.before.T.copy()
        p1, v1, a1, shift1, low, high, top = now.T
        phase, phase0 = states[:, PHASE], self.states[:, PHASE]
        closed = (states[:, LOOP] == 1) & (self.states[:, LOOP] == 1)
        open_loop = np.isin(phase, OPEN) | np.isin(phase0, OPEN)
        open_loop |= (states[:, MODE] == DriveOperationMode.TORQUE) | (
            self.states[:, MODE] != states[:, MODE]
        )
        open_loop |= [player.opened for player in self.players]
        led = (states[:, EXTERNAL] == 1) | (self.states[:, EXTERNAL] == 1)
        bent = (states[:, COMPENSATING] == 1) | (self.states[:, COMPENSATING] == 1)
        sine = (phase == MotionPhase.SINE) | (phase0 == MotionPhase.SINE)
        rough = led | bent | sine | (phase0 == MotionPhase.VELOCITY_STEPS)
        speed0, speed1 = np.abs(v0), np.abs(v1)
        swing = a0 * a0 / (2.0 * jerks)
        swing1 = a1 * a1 / (2.0 * self.jerk)
        run_out = np.where(a0 * v0 >= 0.0, speed0 + swing, np.maximum(speed0, swing - speed0))
        after = np.where(a1 * v1 >= 0.0, speed1 + swing1, speed1)
        moving = np.isin(phase, [*MOVING, MotionPhase.VELOCITY_STEPS, MotionPhase.SINE])
        moving |= np.isin(phase0, [*MOVING, MotionPhase.VELOCITY_STEPS, MotionPhase.SINE])
        moving |= [player.acted for player in self.players]
        self.cap = np.where(bent | sine, self.cap, np.maximum(top, np.minimum(self.cap, run_out)))
        self.cap = np.where(open_loop, np.maximum(self.cap, speed1), self.cap)
        wanted = np.where(moving, wanted, 0.0)
        wanted = np.where(led | bent, self.cap, wanted)
        most = np.minimum(np.maximum(wanted, run_out), self.cap) * MORE + 1e-9
        # limits
        changed = (shift1 != shift0) | (self.states[:, LOOP] == 0) | open_loop
        changed |= (low != self.before[:, 4]) | (high != self.before[:, 5])
        changed |= (states[:, LOW] != self.states[:, LOW]) | (
            states[:, HIGH] != self.states[:, HIGH]
        )
        for i, player in enumerate(self.players):
            if player.cut or player.renamed or changed[i]:
                changed[i] = True
                player.cut = player.renamed = player.opened = False
                if open_loop[i] or not self.states[i, LOOP]:
                    self.before[i, :3] = now[i, :3]
                elif shift1[i] != shift0[i]:
                    self.before[i, 0] += shift1[i] - shift0[i]
                self.open_limits(i)
                self.faults.pop(i, None)
        floor = np.where(states[:, LOW] == 1, low, -inf)
        ceiling = np.where(states[:, HIGH] == 1, high, inf)
        self.slack = np.where(
            rough | open_loop, np.maximum(self.slack, 2.0 * np.maximum(speed0, speed1) * DT),
            self.slack,
        )  # fmt: skip
        margin = self.slack + 2e-6 + 1e-11 * np.abs(p1)
        lowest = np.minimum(floor, self.reach[0]) - margin
        highest = np.maximum(ceiling, self.reach[1]) + margin
        self.reach[0] = np.where(v1 >= 0.0, np.maximum(self.reach[0], p1), self.reach[0])
        self.reach[1] = np.where(v1 <= 0.0, np.minimum(self.reach[1], p1), self.reach[1])
        rests = speed1 == 0.0
        self.reach = np.where(rests, p1, self.reach)
        self.slack = np.where(rests, 0.0, self.slack)
        wrong = {
            "not finite": ~np.isfinite(now[:, :4]).all(axis=1),
            "velocity": closed & ~open_loop & (speed1 > most),
            "acceleration kept too long": closed
            & ~(open_loop | rough | self.unsure)
            & (after > most),
            "upper soft limit": closed & ~open_loop & (p1 > highest),
            "lower soft limit": closed & ~open_loop & (p1 < lowest),
        }
        for what, where in wrong.items():
            if where.any():
                i = int(np.argmax(where))
                bound = f"{most[i]} {lowest[i]} … {highest[i]}"
                self.log(what, i, now, bound)
        self.watch_faults(now, states, closed & ~open_loop)
        fresh = np.abs(a1) <= 1.01 * DT * self.active_jerk  # made with the jerk of what works
        self.jerk = np.where(fresh, self.active_jerk, self.jerk)
        hidden = bent | led | sine
        self.unsure = hidden | (self.unsure & ~fresh)
        self.jerk = np.where(hidden, np.minimum(self.jerk, self.active_jerk), self.jerk)
        self.before, self.states = now, states

    def watch_faults(self, now: Any, states: Any, closed: Any) -> None:
        """A fault brakes at least with the strongest of default and fast axis stop."""
        new = (states[:, ERROR] != 0) & (self.states[:, ERROR] == 0) & closed
        for i in map(int, np.flatnonzero(new)):
            p, v, a = max(now[i, :3], self.before[i, :3], key=lambda state: abs(float(state[1])))
            sign = 1.0 if v >= 0.0 else -1.0
            if self.states[i, EXTERNAL]:  # what comes from outside ends at once
                a = (
                    0.0
                    if self.states[i, PHASE] == MotionPhase.EXTERNAL
                    else max(a * sign, 0.0) * sign
                )
            way = stopping_way(abs(v), a * sign, *self.players[i].ramp()) + 3.0 * abs(v) * DT
            self.faults[i] = p, sign, way + abs(a) * DT * DT + 1e-9
            self.seen_faults += 1
        for i, (begin, sign, way) in list(self.faults.items()):
            rests = states[i, PHASE] in (MotionPhase.NONE, *MOVING)
            if rests or not closed[i] or not states[i, ERROR]:
                del self.faults[i]
            elif (now[i, 0] - begin) * sign > way + 1e-11 * abs(begin):
                self.log("fault braked too weakly", i, now, f"{begin} {sign} {way}")

    def log(self, what: str, i: int, now: Any, bound: str) -> None:
        axis = self.players[i].axis
        pytest.fail(
            f"{what} at axis {i + 1}, cycle {axis.set_cycle_counter}:"
            f" {self.before[i].tolist()} -> {now[i].tolist()}\n"
            f"bound {bound}, error {axis.error_code:#x}, phase {axis.set_motion_phase},"
            f" number {axis.set_command_number}\n"
            f"commanded {self.commanded[i]}, jerk {self.jerk[i]}, cap {self.cap[i]},"
            f" ramp {self.players[i].ramp()}\n" + "\n".join(self.players[i].history[-14:])
        )


def play(seed: int, count: int, *, compiled: bool, axes: int = AXES) -> tuple[Nc, Observer]:
    """Give `axes` axes `count` random commands in all."""
    dice = random.Random(seed)
    nc = Nc(
        round(DT * 1e9),
        [AxisParameters(i + 1, values=drawn.axis_values(dice)) for i in range(axes)],
        compiled=compiled,
    )
    for _ in range(2):
        nc.cycle()
    players = [drawn.Player(axis, random.Random(dice.random())) for axis in nc]
    observer = Observer(nc, players)
    pace = [drawn.decades(dice, -2.5, -0.5) for _ in players]
    while sum(player.command_count for player in players) < count:
        for player, often in zip(players, pace, strict=True):
            player.acted = dice.random() < often
            if player.acted:
                player.act()
        observer.cycle()
    return nc, observer


@pytest.mark.usefixtures("checked_kernels")
def test_nothing_makes_an_axis_faster_than_it_may_be(many: Callable[[int], int]) -> None:
    for seed in range(many(1)):
        _, observer = play(seed, COMMANDS, compiled=True)
        assert sum(player.accepted for player in observer.players) > COMMANDS // 5 * 2
        assert observer.seen_faults > COMMANDS // 100


def test_the_plain_kernel_does_the_same() -> None:
    plain, _ = play(99, 150, compiled=False, axes=3)
    fast, _ = play(99, 150, compiled=True, axes=3)
    assert plain.digest() == fast.digest()


def _watched(dice: random.Random, values: dict[str, float]) -> dict[str, float]:
    """Supervisions with windows that random moves leave now and then, and delayed errors."""
    way = values["max_velocity"] * drawn.decades(dice, -3.0, 0.0)
    seldom = [0, 0, 0, 0, 1]
    return values | {
        "encoder_soft_limit_min_enable": dice.choice(seldom),
        "encoder_soft_limit_max_enable": dice.choice(seldom),
        "loop_enable": dice.choice(seldom),
        "error_reaction_mode": dice.randrange(2),
        "error_reaction_delay": dice.choice([0.0, 0.01, 0.1]),
        "controller_following_error_position_monitoring_enable": dice.choice(seldom),
        "controller_following_error_position_max": way,
        "controller_following_error_position_filter_time": dice.choice([0.0, 0.01]),
        "position_range_monitoring_enable": dice.randrange(2),
        "position_range_window": way,
        "target_position_monitoring_enable": dice.randrange(2),
        "target_position_window": way,
        "target_position_monitoring_time": dice.choice([0.0, 0.02]),
        "peh_monitoring_enable": dice.choice(seldom),
        "peh_monitoring_time": dice.choice([0.001, 0.05]),
        "motion_monitoring_window": way,
        "motion_monitoring_time": dice.choice([0.0, 0.05]),
        "motion_monitoring_enable": dice.choice(seldom),
    }


def test_the_short_way_of_a_plain_move_holds_with_supervisions_too(
    compare_ways: Callable[..., None], many: Callable[[int], int]
) -> None:
    def make(seed: int) -> tuple[Nc, list[Any]]:
        dice = random.Random(seed)
        axes = [
            AxisParameters(number, values=_watched(dice, drawn.axis_values(dice)))
            for number in range(1, 9)
        ]
        nc = Nc(round(DT * 1e9), axes, compiled=True)
        return nc, [
            drawn.Player(axis, random.Random(f"{seed} {row}")) for row, axis in enumerate(nc)
        ]

    for seed in range(many(1)):
        compare_ways(partial(make, seed), seed)
