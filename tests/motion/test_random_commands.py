"""Random commands for 200,000 cycles: the set point stays smooth and inside all limits.

Many axes with dynamics over decades, each given commands at random times, whatever it is doing. An
observer sees nothing but the set values of each cycle. Excused are the cycles in which the manual
itself is abrupt: a reset in motion, the loop opening and closing, generators without ramps, the
trapezoid of a section compensation.
"""

import random
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest

from achse.codes.nc.choices import MotionPhase
from achse.motion import Axis, AxisParameters, BufferMode, Nc, OverrideType, StartType, commands
from achse.motion.states import DriveOperationMode
from achse.native.compiled import checked_builds
from tests.motion.fields_seen import view

DT = 0.002
AXES = 64
ENABLED = 7
FULL = 1_000_000

GENTLE = 0.2
"""Part of its jerk that a command to some of the axes may have."""

POSITIONS = [
    *(*3 * [StartType.ABSOLUTE], *3 * [StartType.RELATIVE], StartType.MODULO, StartType.ADDITIVE),
    *(StartType.MODULO_SHORTEST, StartType.MODULO_POSITIVE, StartType.MODULO_NEGATIVE),
    *(StartType.MODULO_CURRENT, StartType.ABSOLUTE_INTERNAL),
]
ENDLESS = [StartType.ENDLESS_POSITIVE, StartType.ENDLESS_NEGATIVE]
JOGS = [kind + way for kind in (0x110, 0x120, 0x210, 0x310, 0x420, 0x520) for way in (0, 1)]
ROUGH = [
    MotionPhase.EXTERNAL, MotionPhase.VELOCITY_STEPS, MotionPhase.SINE, MotionPhase.DRIVE_OUTPUT,
    MotionPhase.TORQUE,
]  # fmt: skip
"""Set points that come from outside, from the axis itself or by steps."""

WRITTEN = [
    "max_velocity", "default_acceleration", "default_deceleration", "jog_velocity_slow",
    "jog_velocity_fast", "rapid_traverse_velocity", "homing_velocity_towards_cam",
    "homing_velocity_off_cam", "loop_distance",
]  # fmt: skip
"""Parameters that are written while the axis moves."""

STOPS = [StartType.HALT, StartType.HALT, StartType.STOP_AND_LOCK]


def axis_values(dice: random.Random) -> dict[str, float]:
    """Parameters of one axis: velocity, dynamics and jerk over decades."""
    top = 10.0 ** dice.uniform(0.0, 3.3)
    acceleration = top * 10.0 ** dice.uniform(0.0, 2.0)
    deceleration = acceleration * 10.0 ** dice.choice([0.0, dice.uniform(-0.5, 0.5)])
    jerk = max(acceleration, deceleration) * 10.0 ** dice.uniform(0.0, 3.0)
    return {
        "max_velocity": top,
        "jog_velocity_slow": 0.2 * top,
        "jog_velocity_fast": top,
        "rapid_traverse_velocity": top,
        "max_acceleration": acceleration,
        "max_deceleration": deceleration,
        "default_acceleration": acceleration,
        "default_deceleration": deceleration,
        "default_jerk": jerk,
        "homing_velocity_towards_cam": 0.3 * top,
        "homing_velocity_off_cam": 0.1 * top,
        "simulation_cam_begin": -0.3 * top,
        "simulation_cam_end": 0.2 * top,
        "loop_enable": dice.choice([0, 0, 1]),
        "loop_distance": 0.05 * top * dice.choice([-1.0, 1.0]),
        "allow_motion_commands_with_external_setpoint": dice.randrange(2),
        "override_type": dice.choice(list(OverrideType)),
        "encoder_modulo_factor": top,
        "encoder_modulo_tolerance_window": dice.choice([0.0, 0.02 * top]),
        "target_position_monitoring_enable": dice.randrange(2),
        "controller_following_error_position_monitoring_enable": 0,
        "velocity_override": FULL,
        "control_dword": ENABLED,
    }


class Player:
    """Gives one axis commands; keeps what was given, to be told when a fault is found."""

    def __init__(self, axis: Axis, dice: random.Random, *, functions: bool) -> None:
        self.axis = axis
        self.dice = dice
        self.gentlest = dice.choice([1.0, 1.0, GENTLE])
        self.at_first = {name: getattr(axis, name) for name in WRITTEN}
        self.reach = axis.max_velocity * 10.0 ** dice.uniform(-2.0, 0.3)
        self.accepted = 0
        self.history: list[str] = []
        self.abrupt = False
        self.compensated = False
        self._moves: list[tuple[float, Callable[[], Any]]] = [
            (40.0, self.start),
            (15.0, self.feed),
            (3.0, self.jog),
            (6.0, self.new_target),
            (4.0, self.new_target_and_velocity),
            (3.0, self.new_dynamics),
            (5.0, self.halt),
            (2.0, self.stop),
            (2.0, self.parameterized_stop),
            (2.0, self.emergency_stop),
            (15.0, self.override),
            (1.0, self.reset),
            (1.0, self.enables),
            (1.0, self.external_error),
            (1.0, self.set_position),
        ]
        if functions:
            self._moves += [
                (2.0, self.home),
                (3.0, self.oriented_stop),
                (1.0, self.clear),
                (1.0, self.freeze_override),
                (12.0, self.compensate),
                (2.0, self.stop_compensation),
                (2.0, self.shift_phase),
                (3.0, self.reverse),
                (2.0, self.velocity_steps),
                (2.0, self.sine),
                (2.0, self.drive_output),
                (2.0, self.torque),
                (3.0, self.external),
                (2.0, self.set_position_on_the_fly),
                (3.0, self.parameter),
            ]
        self._weights = [weight for weight, _ in self._moves]

    def act(self) -> None:
        """One random command; what held the axis before is first cleared away, mostly."""
        axis, dice = self.axis, self.dice
        if (axis.error_code or axis.motion_locked) and dice.random() < 0.9:
            self.log("release", commands.release_lock(axis))
            if axis.error_code:
                self.reset()
        if axis.control_dword != ENABLED and dice.random() < 0.7:
            axis.control_dword = ENABLED
        ((_, move),) = dice.choices(self._moves, self._weights)
        move()

    def log(self, what: str, code: int) -> None:
        self.accepted += code == 0
        self.history.append(f"{self.axis.set_cycle_counter}: {what} -> {code:#x}")

    def call(self, command: Callable[..., int], *arguments: Any) -> int:
        code = command(self.axis, *arguments)
        self.log(f"{command.__name__}{arguments}", code)
        return code

    def velocity(self) -> float:
        share: float = self.dice.choice([1.0, self.dice.uniform(0.1, 1.0)])
        return share * self.axis.max_velocity

    def position(self, kind: int) -> float:
        if kind > StartType.ABSOLUTE_INTERNAL:
            return float(self.dice.uniform(0.0, 0.999) * self.axis.encoder.modulo_factor)
        share = self.dice.uniform(-1.0, 1.0)
        return float(share * share * share * self.reach)

    def dynamics(self) -> tuple[float, float, float]:
        axis, dice = self.axis, self.dice
        if dice.random() < 0.7:
            return 0.0, 0.0, 0.0
        return (
            axis.max_acceleration * dice.uniform(0.2, 1.0),
            axis.max_deceleration * dice.uniform(0.2, 1.0),
            axis.default_jerk * dice.uniform(self.gentlest, 1.0),
        )

    def start(self) -> None:
        dice = self.dice
        kind = dice.choice(POSITIONS + ENDLESS)
        self.call(
            commands.universal_start, int(kind), self.position(kind), self.velocity(),
            *self.dynamics(), int(dice.choice([0, 0, *BufferMode])),
        )  # fmt: skip

    def feed(self) -> None:
        """A chain of blended moves onwards, with all that a row of it can hold."""
        axis, dice = self.axis, self.dice
        way = self.reach * 10.0 ** dice.uniform(-3.0, 0.0)
        for _ in range(dice.randrange(1, 9)):
            target = axis.target_position
            velocity = self.velocity()
            forth = 1.0 if target >= axis.set_position else -1.0
            self.call(
                commands.universal_start, StartType.RELATIVE,
                forth * way * dice.uniform(0.1, 1.0), velocity, *self.dynamics(),
                dice.randrange(18, 22),
                dice.choice([None, None, target - forth * way * dice.random()]),
                dice.choice([0.0, 0.0, velocity * dice.random()]),
                dice.choice([0.0, 0.0, 0.0, velocity * dice.uniform(0.2, 1.0)]),
            )  # fmt: skip

    def jog(self) -> None:
        self.call(commands.universal_start, self.dice.choice(JOGS), 0.0, self.velocity())

    def new_target(self) -> None:
        kind = self.dice.choice([1, 1, 1, 2, 3, 4, 5])
        self.call(commands.new_end_position, kind, self.position(kind))

    def new_target_and_velocity(self) -> None:
        dice, axis = self.dice, self.axis
        switch = axis.set_position + dice.random() * (axis.target_position - axis.set_position)
        self.call(
            commands.new_end_position_and_velocity, dice.choice([1, 2, 3, 9, 10, 11]),
            dice.choice([1, 2]), self.position(1), self.velocity(), switch,
        )  # fmt: skip

    def new_dynamics(self) -> None:
        axis = self.axis
        own = axis.default_acceleration, axis.default_deceleration, axis.default_jerk
        values = self.dynamics()
        self.call(commands.new_dynamics, *(a or b for a, b in zip(values, own, strict=True)))

    def halt(self) -> None:
        kind = self.dice.choice(STOPS)
        mode = int(kind == StartType.HALT and self.dice.random() < 0.3)
        self.call(commands.universal_start, kind, 0.0, 0.0, *self.dynamics(), mode)

    def stop(self) -> None:
        self.call(commands.stop)

    def parameterized_stop(self) -> None:
        axis = self.axis
        self.call(commands.parameterized_stop, axis.default_deceleration, axis.default_jerk)

    def emergency_stop(self) -> None:
        axis = self.axis
        self.call(commands.emergency_stop, axis.max_deceleration, axis.default_jerk)

    def override(self) -> None:
        share = self.dice.choice([0, 1, 1000, 250_000, 500_000, 990_000, *4 * [FULL]])
        self.axis.velocity_override = share
        self.log(f"override {share}", 0)

    def reset(self) -> None:
        self.abrupt = True
        self.call(commands.reset)

    def enables(self) -> None:
        self.axis.control_dword = self.dice.choice([0, 1, 3, 5, 6, 7])
        self.log(f"control {self.axis.control_dword}", 0)

    def external_error(self) -> None:
        self.call(commands.set_external_error, 0x4FFF)

    def set_position(self) -> None:
        if self.call(commands.set_actual_position, 1, self.position(1)) == 0:
            self.abrupt = True

    def home(self) -> None:
        self.call(commands.home)

    def oriented_stop(self) -> None:
        axis = self.axis
        own = axis.default_deceleration, axis.default_jerk
        self.call(commands.oriented_stop, self.position(StartType.MODULO_SHORTEST), *own)

    def clear(self) -> None:
        self.call(commands.clear)

    def freeze_override(self) -> None:
        self.call(commands.freeze_override)

    def compensate(self) -> None:
        axis, dice = self.axis, self.dice
        length = self.reach * dice.uniform(0.01, 1.0)
        compensation = commands.Compensation(
            dice.randrange(1, 5),
            axis.max_acceleration * dice.uniform(0.1, 1.0),
            axis.max_acceleration * dice.uniform(0.1, 1.0),
            self.velocity() * dice.random(),
            axis.max_velocity,
            length * dice.uniform(-0.5, 0.5),
            length,
        )
        code, _ = commands.start_superposition(axis, compensation)
        self.compensated = code == 0
        self.log(f"start_superposition({compensation})", code)

    def stop_compensation(self) -> None:
        self.call(commands.stop_superposition)

    def shift_phase(self) -> None:
        self.call(commands.start_phasing, 1, 0, 0, self.position(1), self.velocity())

    def reverse(self) -> None:
        ends = self.position(1), self.position(1)
        self.call(commands.start_reversing, 1, *ends, self.velocity(), 0.1 * self.dice.random())

    def velocity_steps(self) -> None:
        first, second = self.velocity(), -self.velocity()
        self.call(commands.start_velocity_steps, 1, first, second, 0.1, 0.05, 2)

    def sine(self) -> None:
        axis = self.axis
        fast = min(0.1 * axis.max_velocity, axis.default_jerk / 2000.0)  # stopped with that jerk
        shape = 0.5 * axis.max_velocity, 0.05, fast, 1.0, 1.0, 5.0, 0.2
        self.call(commands.start_sine_oscillation, 1, *shape, 3, 1)

    def drive_output(self) -> None:
        self.call(commands.start_drive_output, 1, self.dice.uniform(-20.0, 20.0))

    def torque(self) -> None:
        top = self.axis.max_velocity
        self.call(
            commands.start_torque_control, 0x3001, 0, 0, 0, self.dice.uniform(-500.0, 500.0),
            1000.0, 0.5 * top, -0.5 * top, 0.0, 0.0, 0.0,
        )  # fmt: skip

    def external(self) -> None:
        """Begin or end to follow an external set point, one that is here."""
        axis = self.axis
        if axis.external_setpoint_active:
            self.call(commands.stop_external_setpoint)
            return
        axis.external_set_position = axis.set_position
        self.call(commands.start_external_setpoint, 2, 0.0)

    def set_position_on_the_fly(self) -> None:
        self.call(commands.set_actual_position_on_the_fly, 2, 0, self.position(1))

    def parameter(self) -> None:
        """Write a parameter, whatever the axis is doing; no limit beyond those it began with."""
        axis, dice = self.axis, self.dice
        name = dice.choice(["loop_enable", "override_type", *WRITTEN])
        if name == "loop_enable":
            axis.loop_enable = dice.randrange(2)
        elif name == "override_type":
            axis.override_type = dice.choice(list(OverrideType))
        else:
            setattr(axis, name, self.at_first[name] * dice.uniform(0.3, 1.0))
        self.log(f"{name} = {getattr(axis, name)}", 0)

    def settle(self) -> None:
        """End what goes on by itself."""
        axis = self.axis
        axis.velocity_override = FULL
        axis.control_dword = ENABLED
        if axis.error_code:
            self.reset()
        if axis.external_setpoint_active:
            self.call(commands.stop_external_setpoint)
        own = axis.set_motion_phase > MotionPhase.STOPPING
        if own or axis.reversing.number or axis.compensating:
            self.call(commands.stop)

    def calm_down(self) -> float:
        """Clear all that holds the axis and give a last target; where it is."""
        self.axis.velocity_override = FULL
        self.axis.control_dword = ENABLED
        self.call(commands.release_lock)
        if self.axis.error_code:
            self.reset()
        target = self.position(1)
        mode = self.dice.choice([BufferMode.ABORTING, BufferMode.BUFFERED])
        queued = self.axis.buffer_count
        code = self.call(
            commands.universal_start, 1, target, self.axis.max_velocity, 0.0, 0.0, 0.0, mode
        )
        if code:
            assert queued == 8 or target == self.axis.target_position, hex(code)
            code = self.call(commands.universal_start, 1, target, self.axis.max_velocity)
            assert code == 0, hex(code)
        return target


SEEN = (
    "set_position", "set_velocity", "set_acceleration", "encoder_set_position_offset",
    "actual_position", "target_position",
)  # fmt: skip
STATES = ("set_motion_phase", "loop_closed", "compensating", "drive_operation_mode")


class Observer:
    """The set values of all axes, cycle by cycle, and what may be said of them."""

    def __init__(self, nc: Nc, players: list[Player]) -> None:
        self.nc = nc
        self.players = players
        self.look = view(nc, SEEN, STATES)
        self.before, self.states = self.look()
        self.beyond = np.zeros(len(players), bool)
        """Axes that something rough may have made faster than any limit, until they rest."""
        axes = [player.axis for player in players]
        self.rise = np.array([axis.max_acceleration for axis in axes])
        self.fall = np.array([axis.max_deceleration for axis in axes])
        self.acceleration = np.maximum(self.rise, self.fall)
        self.jerk = np.array([axis.default_jerk for axis in axes])
        # A command with less jerk releases the acceleration it finds later than was planned.
        self.commanded = np.array([axis.max_velocity for axis in axes])
        less = 1.0 / np.array([player.gentlest for player in players]) - 1.0
        self.top = self.commanded + less * self.acceleration**2 / (2.0 * self.jerk)
        self.cycles = 0

    def cycle(self) -> None:
        """One cycle, and the judgement on it."""
        self.nc.cycle()
        self.cycles += len(self.players)
        now, states = self.look()
        rough = np.isin(states[:, 0], ROUGH) | np.isin(self.states[:, 0], ROUGH)
        rough |= (states[:, 3] == DriveOperationMode.TORQUE) | (self.states[:, 3] != states[:, 3])
        closed = (states[:, 1] == 1) & (self.states[:, 1] == 1)
        bent = (states[:, 2] == 1) | (self.states[:, 2] == 1)
        for i, player in enumerate(self.players):
            if player.abrupt:
                closed[i] = False
                player.abrupt = False
            if player.compensated:
                bent[i] = True
                player.compensated = False
        p0, v0, a0, shift0, _, _ = self.before.T
        p1, v1, a1, shift1, _, _ = now.T
        self.beyond |= rough | bent
        self.beyond &= (states[:, 0] != MotionPhase.NONE) | (v1 != 0.0)
        smooth = closed & ~rough
        ramped = smooth & ~bent
        bent &= smooth & (np.abs(v0) <= self.commanded) & (np.abs(v1) <= self.commanded)
        inside = smooth & ~self.beyond
        more = 1.0 + 1e-6
        growth = np.where(np.abs(v1) > 1e-6 * self.commanded, a1 * np.sign(v1), 0.0)
        jerk = self.jerk * DT
        bend = np.abs(v1 - v0 - 0.5 * (a0 + a1) * DT)
        step = np.abs(p1 - p0 - (shift1 - shift0) - 0.5 * (v0 + v1) * DT)
        rounding = 1e-12 * (np.abs(p1) + np.abs(shift1)) + 1e-10
        wrong = {
            "not finite": ~np.isfinite(now).all(axis=1),
            "velocity": inside & (np.abs(v1) > self.top * more),
            # Left over from before a change of direction it may be more, while it is brought down.
            "acceleration": inside & (growth > self.rise * more) & (np.abs(a1) >= np.abs(a0)),
            "deceleration": inside & (-growth > self.fall * more) & (np.abs(a1) >= np.abs(a0)),
            "jerk": ramped & (np.abs(a1 - a0) > jerk * more + 1e-9),
            "velocity step": ramped & (bend > jerk * DT / 4.0 * more + 1e-9),
            "position step": ramped & (step > jerk * DT * DT / 12.0 * more + rounding),
            "velocity step of a compensation": bent
            & (np.abs(v1 - v0) > 2.0 * self.acceleration * DT * more + 1e-9),
            "position step of a compensation": bent
            & (step > self.acceleration * DT * DT + rounding),
        }
        for what, where in wrong.items():
            if where.any():
                i = int(np.argmax(where))
                player = self.players[i]
                pytest.fail(
                    f"{what} at axis {i + 1}, cycle {player.axis.set_cycle_counter}:"
                    f" {self.before[i].tolist()} -> {now[i].tolist()}\n"
                    f"error {player.axis.error_code:#x}, loop {player.axis.loop_closed},"
                    f" phase {player.axis.set_motion_phase}\n"
                    f"limits {self.top[i]}, {player.axis.max_acceleration},"
                    f" {player.axis.max_deceleration}, {self.jerk[i]}\n"
                    + "\n".join(player.history[-12:])
                )
        self.before, self.states = now, states


def play(
    seed: int, rounds: int, *, compiled: bool, axes: int = AXES, settling: bool = True
) -> tuple[Nc, Observer]:
    """Command `axes` axes at random for `rounds` cycles, then let them come to a last target.

    Every other axis, from the first on, is given commands of all kinds.
    """
    dice = random.Random(seed)
    nc = Nc(
        round(DT * 1e9),
        [AxisParameters(i + 1, values=axis_values(dice)) for i in range(axes)],
        compiled=compiled,
    )
    for _ in range(2):
        nc.cycle()
    players = [
        Player(axis, random.Random(dice.random()), functions=n % 2 == 0)
        for n, axis in enumerate(nc)
    ]
    observer = Observer(nc, players)
    pace = [10.0 ** dice.uniform(-3.0, -1.0) for _ in players]
    for _ in range(rounds):
        for player, often in zip(players, pace, strict=True):
            if dice.random() < often:
                player.act()
        observer.cycle()
    if not settling:
        return nc, observer
    for _ in range(3):
        for player in players:
            player.settle()
        observer.cycle()
    for _ in range(10_000):
        if all(player.axis.set_motion_phase <= MotionPhase.STOPPING for player in players):
            break
        observer.cycle()
    targets = [player.calm_down() for player in players]
    for _ in range(40_000):
        observer.cycle()
        if all(
            player.axis.set_motion_phase == MotionPhase.NONE and player.axis.buffer_count == 0
            for player in players
        ):
            break
    for player, target in zip(players, targets, strict=True):
        axis = player.axis
        arrived = axis.set_motion_phase == MotionPhase.NONE and axis.set_position == target
        assert arrived, f"{axis!r} is not at {target}:\n" + "\n".join(player.history[-12:])
        assert axis.set_velocity == 0.0
        assert axis.set_acceleration == 0.0
    return nc, observer


@pytest.mark.usefixtures("checked_kernels")
def test_random_commands_never_jump_and_end_at_the_last_target(many: Callable[[int], int]) -> None:
    """Half of the axes are given moves only, which others would seldom let end."""
    for seed in range(many(1)):
        _, observer = play(seed, 3000, compiled=True)
        assert observer.cycles > 200_000
        assert sum(player.accepted for player in observer.players) > 3000


def test_the_plain_kernel_does_the_same() -> None:
    plain, fast = (play(99, 1500, compiled=kind, axes=3, settling=False) for kind in (False, True))
    with checked_builds():
        checked = play(99, 1500, compiled=True, axes=3, settling=False)
    assert plain[0].digest() == fast[0].digest() == checked[0].digest()


def test_the_short_way_of_a_plain_move_is_a_way_and_nothing_else(
    compare_ways: Callable[..., None], many: Callable[[int], int]
) -> None:
    def make(seed: int) -> tuple[Nc, list[Player]]:
        dice = random.Random(seed)
        axes = [AxisParameters(number, values=axis_values(dice)) for number in range(1, 9)]
        nc = Nc(2_000_000, axes, compiled=True)
        lots = [random.Random(f"{seed} {row}") for row in range(8)]
        return nc, [Player(axis, lot, functions=True) for axis, lot in zip(nc, lots, strict=True)]

    for seed in range(many(1)):
        compare_ways(partial(make, seed), seed)
