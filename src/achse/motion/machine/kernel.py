"""The cycle of the simulated machines: their inputs for the NC, and what they make of its outputs.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from collections.abc import Sequence

from achse.motion.curves import Piece
from achse.motion.machine.amplifier import drive_servo, report
from achse.motion.machine.discrete import run_stepper, run_two_speeds
from achse.motion.machine.record import Amplifier, Sensor
from achse.motion.machine.sensor import arm_latches, sense

__all__ = ["ANALOG", "DIGITAL", "STEPPER", "TWO_SPEEDS", "carry_out", "give_inputs"]

DIGITAL = 0
ANALOG = 1
TWO_SPEEDS = 2
STEPPER = 3
"""How an amplifier is built (`Amplifier.kind`)."""


def give_inputs(sensors: Sequence[Sensor], amplifiers: Sequence[Amplifier]) -> None:
    """Before the cycle of the NC: what the hardware says now."""
    for i in range(len(sensors)):
        sensor = sensors[i]
        if sensor.machine.resting == 0 or sensor.noise > 0.0:
            sense(sensor)
    for i in range(len(amplifiers)):
        amplifier = amplifiers[i]
        if amplifier.machine.resting == 0:
            report(amplifier)


def carry_out(
    sensors: Sequence[Sensor], amplifiers: Sequence[Amplifier], pieces: Sequence[Piece], dt: float
) -> None:
    """After the cycle of the NC: its outputs move the machines until the next one."""
    for i in range(len(sensors)):
        if sensors[i].io.fresh:
            arm_latches(sensors[i])
    for i in range(len(amplifiers)):
        amplifier = amplifiers[i]
        machine = amplifier.machine
        if machine.driver == amplifier.number and (amplifier.io.fresh or machine.resting == 0):
            amplifier.io.fresh = 0
            if amplifier.kind == TWO_SPEEDS:
                run_two_speeds(amplifier, dt)
            elif amplifier.kind == STEPPER:
                run_stepper(amplifier, dt)
            else:
                drive_servo(amplifier, pieces, dt)
