"""The cycle of the simulated machines: their inputs for the NC, and what they make of its outputs.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from achse.motion.control.curves import CurveSpan
from achse.motion.machine.amplifier import drive_servo, has_unreported_outputs, report
from achse.motion.machine.discrete import run_stepper, run_two_speeds
from achse.motion.machine.record import Amplifier, Machine, Sensor
from achse.motion.machine.sensor import arm_latches, sense

DIGITAL = 0
ANALOG = 1
TWO_SPEEDS = 2
STEPPER = 3
"""Kinds of amplifiers (`Amplifier.kind`)."""


@dataclass
class HardwareRows:
    """The records of simulated machines; machine code gets their addresses and numbers."""

    machines: Sequence[Machine]
    sensors: Sequence[Sensor]
    amplifiers: Sequence[Amplifier]


def write_inputs(machine: Machine, hardware: HardwareRows) -> None:
    """Write the inputs of the NC from a machine, before the NC's cycle."""
    if machine.fast_path and not machine.resting:
        sense(machine.sensor, fast=True)
        report(machine.amplifier, fast=True)
    elif machine.several:
        if machine.on_bus == 0:
            _write_all_inputs(machine, hardware)
    elif machine.resting == 0:
        sense(machine.sensor)
        report(machine.amplifier)
    elif machine.sensor.noise > 0.0:
        sense(machine.sensor)


def _write_all_inputs(machine: Machine, hardware: HardwareRows) -> None:
    for i in range(machine.first_sensor, machine.first_sensor + machine.sensor_count):
        sensor = hardware.sensors[i]
        if machine.resting == 0 or sensor.noise > 0.0:
            sense(sensor)
    if machine.resting == 0:
        for i in range(machine.first_amplifier, machine.first_amplifier + machine.amplifier_count):
            report(hardware.amplifiers[i])


def carry_out(
    machine: Machine, hardware: HardwareRows, spans: Sequence[CurveSpan], dt: float
) -> None:
    """Move a machine by the outputs of the NC until its next cycle."""
    amplifier = machine.amplifier
    if machine.fast_path and not machine.resting:
        if machine.sensor.io.fresh:
            arm_latches(machine.sensor)
        amplifier.io.fresh = 0
        drive_servo(amplifier, spans, dt, fast=True)
        return
    if machine.several:
        if machine.on_bus:
            return
        amplifier = hardware.amplifiers[machine.first_amplifier + machine.driver]
        for i in range(machine.first_sensor, machine.first_sensor + machine.sensor_count):
            if hardware.sensors[i].io.fresh:
                arm_latches(hardware.sensors[i])
    elif machine.sensor.io.fresh:
        arm_latches(machine.sensor)
    if not machine.resting or amplifier.io.fresh:
        amplifier.io.fresh = 0
        if machine.resting and has_unreported_outputs(amplifier):
            machine.resting = 0
            machine.quiet_cycles = 0
        if amplifier.kind <= ANALOG:  # or DIGITAL
            drive_servo(amplifier, spans, dt)
        elif amplifier.kind == TWO_SPEEDS:
            run_two_speeds(amplifier, dt)
        else:
            run_stepper(amplifier, dt)
