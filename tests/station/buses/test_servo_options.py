"""Options of a servo from the keys of a table."""

import math

import pytest

from achse.motion.servo import ServoMode
from achse.station.buses.servo_options import servo_options
from achse.station.configuration.bus import DriveConfig


def test_dead_time_is_measured_in_csp_only() -> None:
    options = [
        servo_options(DriveConfig(axis=1, mode=mode), 0.002, dead_cycles=2.5)
        for mode in ("csp", "csv", "cst")
    ]
    assert [each.dead_time for each in options] == [None, 0.005, 0.005]
    assert [each.interface for each in options] == [ServoMode.CSP, ServoMode.CSV, ServoMode.CST]


def test_velocity_loop_follows_from_the_torque() -> None:
    drive = DriveConfig(axis=1, mode="cst", torque_per_acceleration=2.0, velocity_bandwidth=10.0)
    options = servo_options(drive, 0.001, 99.0, dead_cycles=1.5)
    torque = 2.0 * drive.scaling
    assert options.torque_per_acceleration == pytest.approx(torque)
    assert options.velocity_gain == pytest.approx(torque * math.tau * 10.0)
    assert options.velocity_reset_time == pytest.approx(4.0 / (math.tau * 10.0))


def test_known_torque_counts_without_a_key() -> None:
    options = servo_options(DriveConfig(axis=1, mode="cst"), 0.001, 3.0, dead_cycles=1.5)
    assert options.torque_per_acceleration == 3.0
    assert options.velocity_gain == pytest.approx(3.0 * math.tau * 30.0)
