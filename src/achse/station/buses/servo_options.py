"""Options of the servo of an axis, from the keys of its table."""

import math
from typing import Protocol

from achse.motion.servo import ServoMode, ServoOptions
from achse.motion.servo.optional import ALL_PARTS, DriveParts

_BANDWIDTH = 0.03
"""Of the velocity loop of cst, as a share of the frequency of the cycle."""


class ServoKeys(Protocol):
    """Keys that `[[drive]]` and `[[fmu.axis]]` share."""

    @property
    def interface(self) -> ServoMode: ...

    @property
    def scaling(self) -> float: ...

    @property
    def dead_time(self) -> int | None: ...

    @property
    def velocity_bandwidth(self) -> float | None: ...

    @property
    def velocity_reset_time(self) -> int | None: ...

    @property
    def torque_per_acceleration(self) -> float | None: ...

    @property
    def torque_limit(self) -> float: ...


def servo_options(
    keys: ServoKeys,
    cycle_s: float,
    known_torque: float = 0.0,
    *,
    dead_cycles: float,
    home_offset: int = 0,
    parts: DriveParts = ALL_PARTS,
) -> ServoOptions:
    """Return the options; `known_torque` is in ‰ for an increment a second² where the table does
    not say it, `dead_cycles` the dead time in cycles where it is not measured."""
    dead_time = None if keys.dead_time is None else keys.dead_time * 1e-9
    if dead_time is None and keys.interface is not ServoMode.CSP:
        dead_time = dead_cycles * cycle_s
    bandwidth = keys.velocity_bandwidth or _BANDWIDTH / cycle_s
    reset = keys.velocity_reset_time
    torque = known_torque
    if keys.torque_per_acceleration is not None:
        torque = keys.torque_per_acceleration * keys.scaling
    return ServoOptions(
        keys.interface,
        home_offset=home_offset,
        dead_time=dead_time,
        velocity_gain=torque * math.tau * bandwidth,
        velocity_reset_time=4.0 / (math.tau * bandwidth) if reset is None else reset * 1e-9,
        torque_per_acceleration=torque,
        torque_limit=keys.torque_limit,
        parts=parts,
    )
