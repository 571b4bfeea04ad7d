"""The machine a drive moves: motor, load, encoder and switches, described in engineering units.

A rotary motor is described in Nm, kg·m², 1/min and counts per revolution, a linear one in N, kg,
m/s and counts per metre. Positions of the machine are in inc, counted from where the encoder of the
machine has its zero. `apply` turns the description into the numbers of the plant.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum

from achse.drive.record import DriveFields
from achse.drive.signals import OutputFunction

_LARGEST_TORQUE = 32_767.0
"""Largest value of 16-bit torque objects, ‰."""


class MachineError(ValueError):
    """A description that no machine can have."""


class MotorKind(IntEnum):
    """3000h."""

    LINEAR = 0
    DIRECT_DRIVE = 1
    AC_SERVO = 2


class EncoderKind(IntEnum):
    """Kind of encoder, by the position that it knows after power-on."""

    INCREMENTAL = 0
    SINGLE_TURN = 1
    MULTI_TURN = 2


@dataclass(frozen=True, slots=True)
class Motor:
    """Motor; rated torque Nm or N, current A, inertia kg·m² or kg, speed 1/min or m/s."""

    kind: MotorKind = MotorKind.AC_SERVO
    rated_torque: float = 1.27
    rated_current: float = 2.7
    peak: float = 3.0
    """Largest torque as a multiple of the rated one."""
    inertia: float = 0.28e-4
    max_speed: float = 6000.0
    torque_time: float = 0.4e-3
    """Time constant of the torque loop, s."""
    overload_time: float = 10.0
    """Time that the motor bears twice its rated torque, s."""


@dataclass(frozen=True, slots=True)
class Load:
    """Load on the motor shaft, referred to the shaft."""

    inertia: float = 0.56e-4
    coulomb: float = 0.02
    """Coulomb friction, Nm or N."""
    viscous: float = 1e-5
    """Viscous friction, Nm per rad/s or N per m/s."""
    gravity: float = 0.0
    """Constant load in negative direction, Nm or N."""


@dataclass(frozen=True, slots=True)
class Encoder:
    """Encoder of the inner loop; `resolution` counts per revolution or metre."""

    kind: EncoderKind = EncoderKind.INCREMENTAL
    resolution: int = 131072
    index_pitch: int | None = None
    """Counts between index pulses; a revolution by default."""
    index_offset: int = 0
    index_width: int = 32
    turns: int = 65536
    """Number of turns that a multi-turn encoder can count."""
    dual_loop: bool = False
    scale_ratio: float = 1.0
    """Dual loop: counts of the external scale per count of the inner encoder."""


@dataclass(frozen=True, slots=True)
class Switches:
    """Switches, stops and probe along the way, inc; None is not there (input not assigned)."""

    negative_stop: float | None = None
    negative_limit: float | None = None
    home: tuple[float, float] | None = None
    positive_limit: float | None = None
    positive_stop: float | None = None
    probe: tuple[float, float] | None = None
    """Range of positions in which the signal EXT-PROBE1 is on."""


@dataclass(frozen=True, slots=True)
class Mechanics:
    """Everything behind the drive."""

    motor: Motor = field(default_factory=Motor)
    load: Load = field(default_factory=Load)
    encoder: Encoder = field(default_factory=Encoder)
    switches: Switches = field(default_factory=Switches)
    brake: bool = False
    gantry: bool = False
    outputs: tuple[OutputFunction, ...] = ()
    """Status outputs assigned to O1, O2, ... in this order."""
    position: float = 0.0
    """Position of the machine at the start, inc."""

    def __post_init__(self) -> None:
        positive = {
            "motor.rated_torque": self.motor.rated_torque,
            "motor.rated_current": self.motor.rated_current,
            "motor.peak": self.motor.peak,
            "motor.inertia": self.motor.inertia,
            "motor.max_speed": self.motor.max_speed,
            "motor.torque_time": self.motor.torque_time,
            "motor.overload_time": self.motor.overload_time,
            "encoder.resolution": self.encoder.resolution,
            "encoder.turns": self.encoder.turns,
            "encoder.scale_ratio": self.encoder.scale_ratio,
        }
        for name, value in positive.items():
            if not (value > 0 and math.isfinite(value)):
                raise MachineError(f"{name} = {value!r}: expected more than 0")
        for name in ("inertia", "coulomb", "viscous"):
            value = getattr(self.load, name)
            if not (value >= 0 and math.isfinite(value)):
                raise MachineError(f"load.{name} = {value!r}: expected 0 or more")
        if self.encoder.index_pitch is not None and self.encoder.index_pitch <= 0:
            raise MachineError(f"encoder.index_pitch = {self.encoder.index_pitch}: expected > 0")
        if len(self.outputs) > 5:
            raise MachineError(f"{len(self.outputs)} status outputs: expected at most 5")

    @property
    def linear(self) -> bool:
        return self.motor.kind is MotorKind.LINEAR

    @property
    def counts_per_unit(self) -> float:
        """Encoder counts per rad or m."""
        resolution = float(self.encoder.resolution)
        return resolution if self.linear else resolution / math.tau

    @property
    def max_velocity(self) -> float:
        """Largest speed of the motor, counts/s."""
        speed = self.motor.max_speed * self.encoder.resolution
        return speed if self.linear else speed / 60.0

    @property
    def inertia_ratio(self) -> int:
        """Load to motor inertia in percent: what Pt103 should be."""
        return round(100.0 * self.load.inertia / self.motor.inertia)


MACHINES: Mapping[str, Mechanics] = {
    "linear": Mechanics(
        Motor(MotorKind.LINEAR, 100.0, 2.5, inertia=1.0, max_speed=3.0),
        Load(inertia=4.0, coulomb=2.0, viscous=5.0),
        Encoder(resolution=1_000_000, index_pitch=20_000),
    ),
    "direct": Mechanics(
        Motor(MotorKind.DIRECT_DRIVE, 10.0, 3.0, inertia=5e-3, max_speed=300.0),
        Load(inertia=2e-2, coulomb=0.1, viscous=1e-3),
        Encoder(resolution=1 << 20),
    ),
    "ac": Mechanics(),
}
"""A usual machine of each motor kind of 3000h."""


def apply(machine: Mechanics, d: DriveFields) -> None:
    """Write the plant's numbers into a record whose gear is set (see `scale`)."""
    motor, load, encoder = machine.motor, machine.load, machine.encoder
    permille = 1000.0 / motor.rated_torque
    unit = machine.counts_per_unit
    d.motor_type = int(motor.kind)
    d.rated_torque = round(motor.rated_torque * 1000.0)
    d.rated_current = round(motor.rated_current * 1000.0)
    d.peak_torque = min(motor.peak * 1000.0, _LARGEST_TORQUE)
    d.max_velocity = machine.max_velocity
    d.torque_time = motor.torque_time
    d.thermal_limit = 3e6 * motor.overload_time
    d.acceleration_gain = unit / permille / (motor.inertia + load.inertia)
    d.velocity_gain = motor.inertia * permille / unit
    d.coulomb = load.coulomb * permille
    d.viscous = load.viscous * permille / unit
    d.gravity = load.gravity * permille
    d.standstill = machine.max_velocity * 1e-4
    d.encoder_resolution = encoder.resolution
    d.absolute = int(encoder.kind)
    d.dual_loop = int(encoder.dual_loop)
    d.scale_ratio = encoder.scale_ratio
    d.index_pitch = float(encoder.index_pitch or encoder.resolution)
    d.index_offset = float(encoder.index_offset)
    d.index_width = float(encoder.index_width)
    d.has_brake = int(machine.brake)
    d.gantry_link = int(machine.gantry)
    d.output_functions = sum(
        function << 4 * terminal for terminal, function in enumerate(machine.outputs)
    )
    d.step_time = 0.0  # what depends on it is computed again


def scale(machine: Mechanics, d: DriveFields) -> None:
    """Take the electronic gear over and place the switches, whose positions are in inc."""
    d.counts_per_inc = d.gear_numerator / d.gear_denominator
    d.inc_per_count = d.gear_denominator / d.gear_numerator
    switches, counts = machine.switches, d.counts_per_inc

    def place(position: float | None, absent: float) -> float:
        return absent if position is None else position * counts

    d.negative_stop = place(switches.negative_stop, -1e300)
    d.positive_stop = place(switches.positive_stop, 1e300)
    d.negative_limit = place(switches.negative_limit, -1e300)
    d.positive_limit = place(switches.positive_limit, 1e300)
    d.negative_limit_assigned = int(switches.negative_limit is not None)
    d.positive_limit_assigned = int(switches.positive_limit is not None)
    d.home_assigned = int(switches.home is not None)
    d.home_from, d.home_to = (position * counts for position in switches.home or (0.0, 0.0))
    d.probe_assigned = int(switches.probe is not None)
    d.probe_from, d.probe_to = (position * counts for position in switches.probe or (0.0, 0.0))


def power_up(machine: Mechanics, d: DriveFields, cleared_turns: int) -> None:
    """Set the encoder to its reading after power-on: count 0, the count within a turn, or turns and
    count.

    `cleared_turns` is the turn of the machine at which the multi-turn counter was cleared.
    """
    count = math.floor(d.motor_position + 0.5)
    resolution = machine.encoder.resolution
    kind = machine.encoder.kind
    if kind is EncoderKind.INCREMENTAL:
        d.encoder_zero = count
    elif kind is EncoderKind.SINGLE_TURN:
        d.encoder_zero = count // resolution * resolution
    else:
        half = machine.encoder.turns // 2
        turns = (count // resolution - cleared_turns + half) % (2 * half or 1) - half
        d.encoder_zero = count - turns * resolution - count % resolution
    d.active_home_offset = d.home_offset
