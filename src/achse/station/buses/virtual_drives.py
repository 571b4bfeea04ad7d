"""The virtual drives of a bus within this process, made as the tables [[drive]] say."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from achse.drive import IDENTITIES, Drive
from achse.drive.machine import MACHINES, Encoder, EncoderKind, Mechanics, Motor, Switches
from achse.drive.record import FIELDS, DriveFields, ExchangeFields
from achse.station.configuration.bus import DriveConfig, DriveMachineConfig

if TYPE_CHECKING:
    from achse.drive.compiled import Bank

_ENCODERS = {
    "incremental": EncoderKind.INCREMENTAL,
    "single_turn": EncoderKind.SINGLE_TURN,
    "multi_turn": EncoderKind.MULTI_TURN,
}


def make_drives(configs: Sequence[DriveConfig], bank: "Bank | None" = None) -> list[Drive]:
    """Return a drive for each table, in the memory of `bank` if there is one. Raises
    MachineError."""
    return [
        Drive(
            _machine(each),
            name=_name(each),
            identity=IDENTITIES[each.identity],
            compiled=bank or False,
        )
        for each in configs
    ]


def _name(config: DriveConfig) -> str:
    return f"Drive of axis {config.axis}"


def _machine(config: DriveConfig) -> Mechanics:
    usual = MACHINES[config.machine.kind]
    motor: Motor = usual.motor
    encoder: Encoder = replace(
        usual.encoder,
        kind=_ENCODERS[config.machine.encoder],
        resolution=config.resolution,
        index_pitch=None,
    )
    return replace(usual, motor=motor, encoder=encoder, switches=_switches(config))


def _switches(config: DriveConfig) -> Switches:
    """Return the switches in increments; those at the ends change places where the motor is
    inverted."""
    machine: DriveMachineConfig = config.machine
    sign = -1.0 if config.inverted else 1.0

    def place(position: float | None) -> float | None:
        return None if position is None else sign * position / config.scaling

    def span(ends: tuple[float, float] | None) -> tuple[float, float] | None:
        if ends is None:
            return None
        low, high = sorted(sign * end / config.scaling for end in ends)
        return low, high

    negative, positive = place(machine.negative_limit), place(machine.positive_limit)
    if config.inverted:
        negative, positive = positive, negative
    return Switches(
        negative_limit=negative,
        positive_limit=positive,
        home=span(machine.home),
        probe=span(machine.probe),
    )


def torque_per_acceleration(drive: Drive) -> float:
    """Thousandths of the rated torque that an increment a second² takes; 0 if unknown."""
    gain = drive.record.acceleration_gain * drive.record.inc_per_count
    return 1.0 / gain if gain > 0.0 and math.isfinite(gain) else 0.0


def digest_of(drive: Drive) -> bytes:
    """Return the state of a drive, equal for both kernels."""
    record = drive.record
    values = [list(content) if length else content for content, length in _values(record)]
    return repr(values).encode() + bytes((drive.state,))


def _values(record: DriveFields) -> Iterator[tuple[Any, int]]:
    """Yield all but what the compiled kernel keeps of the process data."""
    for name, slot in FIELDS.items():
        if name not in ExchangeFields.__annotations__:
            yield getattr(record, name), slot.length
