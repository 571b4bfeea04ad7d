"""A recorded run of the NC: does this tree compute, value by value, what another one computes?

Axes of all kinds, one with several encoders, controllers and drives, commissioned and driven at
random in virtual time: homing, moves, jogs, parameters, probes, torque, other control loops,
errors; an hour of the demo besides. A line is a hash of every value that an axis shows, by its
name, so records may be laid out otherwise.
Usage: python benchmarks/nc_recorded.py [--hours H] [--save FILE | --compare FILE]
"""

import argparse
import hashlib
import random
import struct
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from achse.motion import Axis, AxisParameters, Nc, commands
from achse.motion.fields.declare import Role
from achse.motion.record import FIELDS
from achse.native.backend import compiler_installed
from achse.station import Station

PRESETS = {"control_dword": 7, "velocity_override": 1_000_000}
PARTS = {"encoders": "encoder_", "drives": "drive_"}
"""The controller in force shows at the axis; others are only kept."""

KINDS: tuple[dict[str, float], ...] = (
    {},
    {"controller_type": 3, "controller_position_tn": 0.3, "simulation_load_torque": 80.0},
    {"controller_type": 9, "drive_type": 9, "drive_output_filter_type": 1,
     "drive_output_filter_time": 0.02},
    {"controller_type": 6, "controller_velocity_tn": 0.1, "controller_observer_mode": 1},
    {"axis_type": 2, "drive_type": 7, "controller_type": 7},
    {"axis_type": 3, "drive_type": 8, "controller_type": 8},
    {"unit_interpretation": 4, "encoder_modulo_factor": 100.0, "encoder_mask": 0xFFFF,
     "backlash": 0.2, "backlash_compensation_enable": 1},
    {"drive_type": 6, "drive_output_reference_point": 0.6, "simulation_dead_time": 0.006,
     "encoder_dead_time_compensation_mode": 1, "encoder_dead_time_compensation_shift": 2_000_000},
)  # fmt: skip

SECOND = {"encoder_scaling_factor": 1e-3, "controller_position_kv": 12.0}


SHOWN = sorted(name for name, row in FIELDS.items() if row.role is not Role.INTERNAL)
"""Names of values; what the kernel remembers besides shows in these sooner or later."""


def axes() -> Iterator[AxisParameters]:
    for number, values in enumerate(KINDS, 1):
        cam = {"simulation_cam_end": -5.0, "encoder_reference_mode": 1 + number % 5}
        yield AxisParameters(number, values=PRESETS | cam | values)
    number = len(KINDS) + 1
    ids = (number, number + 1)
    yield AxisParameters(
        number, values=PRESETS, encoder_ids=ids, controller_ids=ids, drive_ids=ids,
        elements=[SECOND],
    )  # fmt: skip


def act(axis: Axis, dice: random.Random) -> None:
    """One thing that is done to an axis."""
    position, velocity = dice.uniform(-200.0, 200.0), dice.uniform(5.0, 400.0)
    match dice.randrange(16):
        case 0 | 1 | 2:
            commands.universal_start(axis, 1, position, velocity, buffer_mode=dice.choice((0, 1)))
        case 3:
            commands.start(axis, dice.choice((2, 3, 4, 272, 273, 528)), position, velocity)
        case 4 | 5:
            commands.reset(axis)
        case 6:
            commands.stop(axis)
        case 7:
            commands.home(axis)
        case 8:
            axis.velocity_override = dice.choice((0, 300_000, 1_000_000))
        case 9:
            axis.control_dword = dice.choice((0, 3, 5, 7, 7, 7))
        case 10:
            commands.activate_touch_probe(axis.encoders[-1], 1, 0, 1, 128)
        case 11:
            commands.set_actual_position_on_the_fly(axis.encoders[0], 2, 0, dice.uniform(-9.0, 9.0))
        case 12:
            name = dice.choice(("encoder_velocity_filter_time", "controller_position_kv"))
            setattr(axis, name, dice.uniform(0.0, 0.02) if "time" in name else 15.0)
        case 13:
            commands.switch_control_loop(axis, dice.randrange(2), dice.choice((1, 2)), 0.0)
        case 14:
            commands.start_torque_control(
                axis, 0x3001, 0, 0, 0, dice.uniform(-90.0, 90.0), 500.0, 80.0, -80.0, 0.0, 0.0, 0.0
            )
        case 15:
            commands.set_external_error(axis, 0x4650)


def values(axis: Axis) -> Iterator[Any]:
    """Every value that an axis and its parts show, in the order of their names."""
    yield from (getattr(axis, name) for name in SHOWN)
    for part, prefix in PARTS.items():
        for element in getattr(axis, part):
            for name in SHOWN:
                if name.startswith(prefix) and FIELDS[name].role is not Role.INPUT:
                    yield getattr(element, name)
    machine = axis.machine
    yield from (machine.position, machine.velocity, machine.torque)


def digest(axes_: Iterator[Axis]) -> str:
    total = hashlib.blake2b(digest_size=12)
    for axis in axes_:
        for value in values(axis):
            for number in [value] if isinstance(value, int | float) else value:
                kind = "<d" if isinstance(number, float) else "<q"
                total.update(struct.pack(kind, number))
    return total.hexdigest()


def session(compiled: bool, seconds: float) -> Iterator[str]:
    """The commissioning, a line every two seconds."""
    nc = Nc(2_000_000, axes(), compiled=compiled)
    dice = random.Random(4)
    for _ in range(round(seconds / 2.0)):
        for _ in range(20):
            for axis in nc:
                if dice.random() < 0.25:
                    act(axis, dice)
            nc.cycle(50)
        yield digest(iter(nc))


def demo(hours: float) -> Iterator[str]:
    """The demo station as `achse run --speed max` runs it."""
    station = Station.demo()
    assert station.nc is not None
    for _ in range(max(1, round(60 * hours))):
        station.advance(60.0)
        yield digest(iter(station.nc))


def lines(hours: float) -> Iterator[str]:
    for compiled in (False, True) if compiler_installed() else (False,):
        yield from (f"session {each}" for each in session(compiled, 3600.0 * hours / 60.0))
    yield from (f"demo {each}" for each in demo(hours))


def main() -> int:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--hours", type=float, default=1.0)
    options.add_argument("--save", type=Path)
    options.add_argument("--compare", type=Path)
    chosen = options.parse_args()
    recorded = list(lines(chosen.hours))
    sessions = [line for line in recorded if line.startswith("session")]
    half = len(sessions) // 2
    if sessions[:half] != sessions[half:] and compiler_installed():
        print("the two kernels differ")
        return 1
    if chosen.save:
        chosen.save.write_text("\n".join(recorded), encoding="utf-8")
    if chosen.compare:
        before = chosen.compare.read_text(encoding="utf-8").splitlines()
        same = sum(a == b for a, b in zip(recorded, before, strict=False))
        print(f"{same} of {len(before)} lines are the same")
        return int(recorded != before)
    digest = hashlib.blake2b(repr(recorded).encode(), digest_size=8).hexdigest()
    print(f"{len(recorded)} lines, {digest}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
