"""Oscillations: reversing, velocity steps, sine, 0x4200 + ID (002 §6.4.4.3)."""

from achse.devices.nc.functions.calling import function
from achse.devices.nc.layouts import request
from achse.motion import commands
from achse.server import Layout

__all__ = ["OSCILLATIONS"]

_REVERSING = request(
    start_type="I", end_position1="d", end_position2="d", velocity="d", idle_time="d"
)

_SINE = request(
    start_type="I", base_amplitude="d", base_frequency="d", start_amplitude="d",
    feed_constant="d", start_frequency="d", stop_frequency="d", step_duration="d",
    measurement_count="I", parallel_measurement_count="I",
)  # fmt: skip

OSCILLATIONS = (
    function(
        0x25,
        "start_reversing_positioning",
        commands.start_reversing,
        _REVERSING,
        "move to and fro between two positions",
    ),
    function(
        0x32,
        "start_reversing_velocity_steps",
        commands.start_velocity_steps,
        (Layout("<IddddI"), Layout("<I4xddddI4x")),
        "jump between two velocities, without ramps: velocities, move and idle time, repetitions",
    ),
    function(
        0x33,
        "start_sine_oscillation",
        commands.start_sine_oscillation,
        _SINE,
        "oscillate by a sine of the velocity, or by a sequence of frequencies",
    ),
)
