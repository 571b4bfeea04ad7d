"""Random commands: an axis with random parameters, and a player that commands it.

The player knows what each accepted command allows: velocities and jerks of what works and waits.
Loaded by `test_random_dynamics`.
"""

import random
from collections.abc import Callable
from typing import Any

from achse.codes.nc.choices import MotionPhase
from achse.motion import Axis, BufferMode, OverrideType, StartType, commands

DT = 0.002
ENABLED = 7
FULL = 1_000_000

ENDLESS = [StartType.ENDLESS_POSITIVE, StartType.ENDLESS_NEGATIVE]
POSITIONS = [
    *(*3 * [StartType.ABSOLUTE], *3 * [StartType.RELATIVE], StartType.MODULO, StartType.ADDITIVE),
    *(StartType.MODULO_SHORTEST, StartType.MODULO_POSITIVE, StartType.MODULO_NEGATIVE),
    *(StartType.MODULO_CURRENT, StartType.ABSOLUTE_INTERNAL),
]
JOGS = [kind + way for kind in (0x110, 0x120, 0x210, 0x310, 0x420, 0x520) for way in (0, 1)]
STOPS = [StartType.HALT, StartType.HALT, StartType.STOP_AND_LOCK]


def decades(dice: random.Random, low: float, high: float) -> float:
    return float(10.0 ** dice.uniform(low, high))


def axis_values(dice: random.Random) -> dict[str, float]:
    """Parameters of one axis, dynamics and limits over decades."""
    top = decades(dice, 0.0, 3.3)
    strongest = top * decades(dice, 0.0, 2.5)
    fault = dice.choice([0.0, 0.0, strongest * decades(dice, -2.0, 1.0)])
    brake = min(fault or strongest, strongest) * decades(dice, -2.0, 0.0)
    window = top * top / brake * decades(dice, -1.0, 1.0)
    return {
        "max_velocity": top,
        "jog_velocity_slow": 0.2 * top,
        "jog_velocity_fast": top,
        "rapid_traverse_velocity": top,
        "max_acceleration": strongest * decades(dice, 0.0, 1.0),
        "max_deceleration": strongest * decades(dice, 0.0, 1.0),
        "default_acceleration": strongest * decades(dice, -2.0, 0.5),
        "default_deceleration": strongest * decades(dice, -2.0, 0.5),
        "default_jerk": strongest * decades(dice, -1.0, 3.0),
        "fast_axis_stop_deceleration": fault,
        "fast_axis_stop_jerk": dice.choice([0.0, strongest * decades(dice, -1.0, 4.0)]),
        "fast_axis_stop_signal_type": dice.choice([0, 1, 2, 3, 4]),
        "encoder_soft_limit_min": -window,
        "encoder_soft_limit_max": window * dice.uniform(0.5, 1.0),
        "encoder_soft_limit_min_enable": dice.randrange(2),
        "encoder_soft_limit_max_enable": dice.randrange(2),
        "error_reaction_mode": dice.choice([0, 0, 0, 1]),
        "error_reaction_delay": dice.choice([0.0, 0.1]),
        "homing_velocity_towards_cam": 0.3 * top,
        "homing_velocity_off_cam": 0.1 * top,
        "simulation_cam_begin": -0.3 * top,
        "simulation_cam_end": 0.2 * top,
        "loop_enable": dice.choice([0, 0, 0, 1]),
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
    """Gives one axis commands and knows what they allow."""

    def __init__(self, axis: Axis, dice: random.Random) -> None:
        self.axis = axis
        self.dice = dice
        self.reach = axis.encoder.soft_limit_max * decades(dice, -1.0, 0.3)
        self.at_first = axis.max_velocity, axis.encoder.soft_limit_min, axis.encoder.soft_limit_max
        self.command_count = 0
        self.accepted = 0
        self.history: list[str] = []
        self.velocities: dict[int, float] = {}
        """Velocity of each command that works or waits, by its number."""
        self.jerks: dict[int, float] = {}
        self.aside = 0.0
        """Velocity that what works allows beside its number: oscillations, jogs."""
        self.renamed = False
        self.acted = self.opened = False
        self.cut = False
        """A position was renamed, or a velocity dropped, by this command."""
        moves: list[tuple[float, Callable[[], None]]] = [
            (30.0, self.start),
            (12.0, self.feed),
            (3.0, self.plain_start),
            (2.0, self.special_start),
            (3.0, self.jog),
            (5.0, self.new_target),
            (5.0, self.new_target_and_velocity),
            (4.0, self.new_dynamics),
            (9.0, self.halt),
            (2.0, self.stop),
            (4.0, self.parameterized_stop),
            (3.0, self.emergency_stop),
            (2.0, self.oriented_stop),
            (1.0, self.clear),
            (1.0, self.freeze_override),
            (12.0, self.override),
            (2.0, self.reset),
            (5.0, self.enables),
            (2.0, self.error),
            (2.0, self.inject),
            (1.0, self.disable),
            (2.0, self.set_position),
            (2.0, self.set_position_on_the_fly),
            (1.0, self.home),
            (8.0, self.compensate),
            (2.0, self.stop_compensation),
            (1.0, self.shift_phase),
            (2.0, self.reverse),
            (1.0, self.velocity_steps),
            (2.0, self.sine),
            (1.0, self.drive_output),
            (1.0, self.torque),
            (3.0, self.external),
            (6.0, self.limits),
            (3.0, self.dynamics_of_the_axis),
        ]
        self.moves = [move for _, move in moves]
        self.weights = [weight * decades(dice, -1.0, 1.0) for weight, _ in moves]

    def act(self) -> None:
        """One random command; what held the axis before is first cleared away, mostly."""
        axis, dice = self.axis, self.dice
        if dice.random() < 0.5:
            axis.machine.not_ready = axis.machine.io_invalid = 0
            axis.axis_disabled = axis.drive_output_disabled = 0
        if (axis.error_code or axis.motion_locked) and dice.random() < 0.8:
            commands.release_lock(axis)
            if axis.error_code:
                self.reset()
        if axis.control_dword != ENABLED and dice.random() < 0.6:
            axis.control_dword = ENABLED
            self.log("control 7", 0)
        dice.choices(self.moves, self.weights)[0]()

    def log(self, what: str, code: int) -> None:
        self.command_count += 1
        self.accepted += code == 0
        self.history.append(f"{self.axis.set_cycle_counter}: {what} -> {code:#x}")
        del self.history[:-40]

    def call(self, command: Callable[..., int], *arguments: Any) -> bool:
        code = command(self.axis, *arguments)
        self.log(f"{command.__name__}{arguments}", code)
        return code == 0

    def began(self, velocity: float, jerk: float, *, aborting: bool = True) -> None:
        """A command was accepted: it counts until it is dropped."""
        if aborting:
            self.velocities.clear()
            self.jerks.clear()
            self.aside = 0.0
        number = self.axis.command_counter
        self.velocities[number] = velocity
        self.jerks[number] = jerk or self.axis.default_jerk

    def velocity(self) -> float:
        share: float = self.dice.choice([1.0, self.dice.random(), decades(self.dice, -3.0, 0.0)])
        return share * self.axis.max_velocity

    def position(self, kind: int) -> float:
        if kind > StartType.ABSOLUTE_INTERNAL:
            return self.dice.uniform(0.0, 0.999) * self.axis.encoder.modulo_factor
        share = self.dice.uniform(-1.0, 1.0)
        return share * abs(share) * self.reach

    def jerk(self) -> float:
        return self.axis.max_velocity * decades(self.dice, -2.0, 6.0)

    def dynamics(self) -> tuple[float, float, float]:
        axis, dice = self.axis, self.dice
        if dice.random() < 0.2:
            return 0.0, 0.0, 0.0
        return (
            axis.max_acceleration * decades(dice, -3.0, 0.0),
            axis.max_deceleration * decades(dice, -3.0, 0.0),
            dice.choice([0.0, self.jerk(), self.jerk()]),
        )

    def start(self) -> None:
        dice = self.dice
        kind = dice.choice(POSITIONS + 2 * ENDLESS)
        mode = int(dice.choice([0, 0, 0, *BufferMode]))
        velocity, dynamics = self.velocity(), self.dynamics()
        waits = mode != BufferMode.ABORTING and self.occupied()
        if self.call(
            commands.universal_start, int(kind), self.position(kind), velocity, *dynamics, mode
        ):
            self.began(velocity, dynamics[2], aborting=not waits)

    def occupied(self) -> bool:
        axis = self.axis
        return axis.buffer_count > 0 or axis.set_motion_phase not in (
            MotionPhase.NONE,
            MotionPhase.EXTERNAL,
        )

    def feed(self) -> None:
        """A chain of blended moves onwards, with all that a row of it can hold."""
        axis, dice = self.axis, self.dice
        way = self.reach * decades(dice, -3.0, 0.0)
        for _ in range(dice.randrange(1, 6)):
            target = axis.target_position
            velocity, dynamics = self.velocity(), self.dynamics()
            forth = 1.0 if target >= axis.set_position else -1.0
            waits = self.occupied()
            if self.call(
                commands.universal_start, StartType.RELATIVE,
                forth * way * dice.uniform(0.1, 1.0), velocity, *dynamics,
                dice.randrange(18, 22),
                dice.choice([None, None, target - forth * way * dice.random()]),
                dice.choice([0.0, 0.0, velocity * dice.random()]),
                dice.choice([0.0, 0.0, 0.0, velocity * dice.uniform(0.2, 1.0)]),
            ):  # fmt: skip
                self.began(velocity, dynamics[2], aborting=not waits)

    def plain_start(self) -> None:
        kind, velocity = self.dice.choice([1, 2, 3, 4]), self.velocity()
        jerk = self.jerk()
        if self.call(commands.start, kind, self.position(kind), velocity, None, None, jerk):
            self.began(velocity, jerk)

    def special_start(self) -> None:
        axis, dice = self.axis, self.dice
        kind, first, second = dice.choice([1, 2, 3, 4]), self.velocity(), self.velocity()
        where = axis.set_position + self.position(1) * dice.random()
        jerk = self.jerk()
        if self.call(
            commands.start_special,
            kind,
            self.position(kind),
            first,
            where,
            second,
            None,
            None,
            jerk,
        ):
            self.began(max(first, second), jerk)

    def jog(self) -> None:
        if self.call(commands.universal_start, self.dice.choice(JOGS), 0.0, self.velocity()):
            self.began(self.axis.max_velocity, 0.0)

    def new_target(self) -> None:
        kind = self.dice.choice([1, 1, 1, 2, 3, 4, 5])
        self.call(commands.new_end_position, kind, self.position(kind))

    def new_target_and_velocity(self) -> None:
        dice, axis = self.dice, self.axis
        switch = axis.set_position + dice.random() * (axis.target_position - axis.set_position)
        velocity = self.velocity()
        if self.call(
            commands.new_end_position_and_velocity, dice.choice([1, 2, 3, 9, 10, 11]),
            dice.choice([1, 2]), self.position(1), velocity, switch,
        ):  # fmt: skip
            number = axis.set_command_number
            self.velocities[number] = max(self.velocities.get(number, 0.0), velocity)

    def new_dynamics(self) -> None:
        axis = self.axis
        own = axis.default_acceleration, axis.default_deceleration, 0.0
        values = self.dynamics()
        if (
            self.call(commands.new_dynamics, *(a or b for a, b in zip(values, own, strict=True)))
            and values[2]
        ):
            self.jerks[axis.set_command_number] = values[2]

    def stopped(self, jerk: float) -> None:
        self.velocities.clear()
        self.jerks[0] = max(self.jerks.get(0, 0.0), jerk or self.axis.default_jerk)

    def halt(self) -> None:
        kind, dynamics = self.dice.choice(STOPS), self.dynamics()
        mode = int(kind == StartType.HALT and self.dice.random() < 0.3)
        waits = mode != 0 and self.occupied()
        moves = self.axis.set_motion_phase in (MotionPhase.POSITIONING, MotionPhase.ENDLESS)
        jerk = dynamics[2] or (self.axis.job.jerk if moves else 0.0)  # 0 is what the move has
        if self.call(commands.universal_start, kind, 0.0, 0.0, *dynamics, mode):
            if waits:
                self.began(0.0, jerk, aborting=False)
            else:
                self.stopped(jerk)

    def stop(self) -> None:
        self.call(commands.stop)

    def parameterized_stop(self) -> None:
        axis = self.axis
        deceleration, jerk = axis.max_deceleration * decades(self.dice, -3.0, 0.0), self.jerk()
        if self.call(commands.parameterized_stop, deceleration, jerk):
            self.stopped(jerk)

    def emergency_stop(self) -> None:
        axis = self.axis
        deceleration, jerk = axis.max_deceleration * decades(self.dice, -1.0, 0.0), self.jerk()
        if self.call(commands.emergency_stop, deceleration, jerk):
            self.stopped(jerk)

    def oriented_stop(self) -> None:
        axis = self.axis
        own = axis.default_deceleration, axis.default_jerk
        self.call(commands.oriented_stop, self.position(StartType.MODULO_SHORTEST), *own)

    def clear(self) -> None:
        self.call(commands.clear)

    def freeze_override(self) -> None:
        self.call(commands.freeze_override)

    def override(self) -> None:
        share = self.dice.choice([0, 0, 1, 1000, 250_000, 990_000, *4 * [FULL]])
        self.axis.velocity_override = share
        self.log(f"override {share}", 0)

    def reset(self) -> None:
        self.cut = True
        self.call(commands.reset)

    def enables(self) -> None:
        self.axis.control_dword = self.dice.choice([0, 1, 3, 5, 6, 7])
        self.log(f"control {self.axis.control_dword}", 0)

    def error(self) -> None:
        self.call(commands.set_external_error, 0x4FFF)

    def inject(self) -> None:
        """Something in drive, bus or output fails, or works again."""
        name = self.dice.choice(
            ["simulation_not_ready", "simulation_io_invalid", "simulation_fast_stop_signal",
             "drive_output_disabled"]
        )  # fmt: skip
        setattr(self.axis, name, self.dice.randrange(2))
        self.log(f"{name} = {getattr(self.axis, name)}", 0)

    def disable(self) -> None:
        self.call(self.dice.choice([commands.disable, commands.enable]))

    def set_position(self) -> None:
        if self.call(commands.set_actual_position, 1, self.position(1)):
            self.renamed = self.cut = True

    def set_position_on_the_fly(self) -> None:
        self.renamed |= self.call(commands.set_actual_position_on_the_fly, 2, 0, self.position(1))

    def home(self) -> None:
        if self.call(commands.home):
            self.began(self.axis.max_velocity, 0.0)

    def compensate(self) -> None:
        axis, dice = self.axis, self.dice
        length = self.reach * dice.uniform(0.01, 1.0)
        compensation = commands.Compensation(
            dice.randrange(1, 7),
            axis.max_acceleration * decades(dice, -2.0, 0.0),
            axis.max_acceleration * decades(dice, -2.0, 0.0),
            self.velocity() * dice.random(),
            axis.max_velocity,
            length * dice.uniform(-0.5, 0.5),
            length,
        )
        code, _ = commands.start_superposition(axis, compensation)
        self.log(f"start_superposition({compensation})", code)

    def stop_compensation(self) -> None:
        self.call(commands.stop_superposition)

    def shift_phase(self) -> None:
        self.call(commands.start_phasing, 1, 0, 0, self.position(1), self.velocity())

    def reverse(self) -> None:
        ends = self.position(1), self.position(1)
        velocity = self.velocity()
        if self.call(commands.start_reversing, 1, *ends, velocity, 0.1 * self.dice.random()):
            self.began(velocity, 0.0)

    def velocity_steps(self) -> None:
        first, second = self.velocity(), -self.velocity()
        if self.call(commands.start_velocity_steps, 1, first, second, 0.1, 0.05, 2):
            self.began(max(first, -second), 0.0)

    def sine(self) -> None:
        dice, top = self.dice, self.axis.max_velocity
        base, fast = top * decades(dice, -3.0, -0.4), top * decades(dice, -4.0, -1.0)
        slow, quick = decades(dice, -2.0, 0.0), decades(dice, 0.0, 1.0)
        if self.call(
            commands.start_sine_oscillation, 1, base, slow, fast, 1.0, 1.0, quick, 0.2, 3, 1
        ):
            self.began(base + fast, 0.0)
            self.aside = base + fast

    def drive_output(self) -> None:
        if self.call(commands.start_drive_output, 1, self.dice.uniform(-20.0, 20.0)):
            self.began(0.0, 0.0)
            self.opened = True

    def torque(self) -> None:
        top = self.axis.max_velocity
        if self.call(
            commands.start_torque_control, 0x3001, 0, 0, 0, self.dice.uniform(-500.0, 500.0),
            1000.0, 0.5 * top, -0.5 * top, 0.0, 0.0, 0.0,
        ):  # fmt: skip
            self.began(0.0, 0.0)
            self.opened = True

    def external(self) -> None:
        """Begin or end to follow an external set point."""
        axis = self.axis
        if axis.external_setpoint_active:
            self.call(commands.stop_external_setpoint)
            return
        axis.external_set_position = axis.set_position
        axis.external_set_velocity = axis.external_set_acceleration = 0.0
        if self.call(commands.start_external_setpoint, 2, 0.0):
            self.began(0.0, 0.0)

    def lead(self) -> None:
        """The external set point of the next cycle: it gains speed up to the limits of the axis."""
        axis, dice = self.axis, self.dice
        if not axis.external_setpoint_active:
            return
        before = axis.external_set_velocity
        most = 0.3 * min(axis.default_deceleration, axis.max_acceleration)
        a = axis.external_set_acceleration
        if dice.random() < 0.05:
            a = most * dice.uniform(-1.0, 1.0)
        v = max(-axis.max_velocity, min(axis.max_velocity, before + a * DT))
        axis.external_set_acceleration = a if abs(v) < axis.max_velocity else 0.0
        axis.external_set_velocity = v
        axis.external_set_position += 0.5 * (before + v) * DT

    def limits(self) -> None:
        """Move, switch on or off a limit, whatever the axis is doing."""
        axis, dice = self.axis, self.dice
        name = dice.choice(
            ["max_velocity", *2 * ["encoder_soft_limit_min_enable"],
             *2 * ["encoder_soft_limit_max_enable"], "encoder_soft_limit_min",
             "encoder_soft_limit_max"]
        )  # fmt: skip
        if name.endswith("enable"):
            value: float = dice.randrange(2)
        elif name == "max_velocity":
            value = self.at_first[0] * dice.uniform(0.3, 1.0)
        else:
            value = self.at_first[1 + name.endswith("max")] * decades(dice, -1.0, 1.0)
        setattr(axis, name, value)
        self.log(f"{name} = {value}", 0)

    def dynamics_of_the_axis(self) -> None:
        axis, dice = self.axis, self.dice
        name = dice.choice(
            ["default_acceleration", "default_deceleration", "default_jerk",
             "fast_axis_stop_deceleration", "fast_axis_stop_jerk"]
        )  # fmt: skip
        setattr(axis, name, getattr(axis, name) * decades(dice, -0.3, 0.3))
        self.log(f"{name} = {getattr(axis, name)}", 0)

    def allowed(self) -> float:
        """Largest velocity of what works and what waits."""
        axis = self.axis
        active = axis.set_command_number
        for number in [n for n in self.velocities if 0 < (active - n) % 0xFFFF < 0x7FFF]:
            del self.velocities[number]
            self.jerks.pop(number, None)
        return max(self.velocities.values(), default=0.0)

    def ramp(self) -> tuple[float, float]:
        """The ramp that a fault has at least: the stronger of default and fast axis stop."""
        axis = self.axis
        return (
            max(min(axis.default_deceleration, axis.max_deceleration),
                axis.fast_axis_stop_deceleration),
            max(axis.default_jerk, axis.fast_axis_stop_jerk),
        )  # fmt: skip
