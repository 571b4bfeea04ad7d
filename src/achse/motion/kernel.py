"""The axis cycle: one step of every axis, the same source plain and compiled.

The hardware gives its inputs, the NC works, the hardware carries out what it says. Order within
the cycle of an axis: encoder, enables, set point, controller, supervision, outputs, status.
"""

from collections.abc import Sequence

from achse.motion.controller import adapt_controller, control
from achse.motion.curves import Piece
from achse.motion.discrete import run_stepper, run_two_speeds, show_speed
from achse.motion.drive import adapt_drive, put_out, put_out_bytes, read_drive
from achse.motion.encoder import adapt_encoder, measure
from achse.motion.generators.homing import home
from achse.motion.generators.table import hand_over, lead
from achse.motion.limits import adapt_limits
from achse.motion.machine.kernel import carry_out, give_inputs
from achse.motion.machine.record import Amplifier, Sensor
from achse.motion.monitoring import (
    operation_mode,
    settle,
    show_state,
    supervise_arrival,
    supervise_enable,
    supervise_motion,
)
from achse.motion.phasing import shift_phase
from achse.motion.record import POSITION_HISTORY, AxisFields, EncoderFields
from achse.motion.signals import arm, watch
from achse.motion.states import AxisType, DriveType, MotionPhase

__all__ = ["adapt", "begin", "begin_encoder", "cycle", "cycle_all", "cycles", "follow"]


def adapt(ax: AxisFields, dt: float) -> None:
    """Compute what follows from the parameters; done in the first cycle after a change."""
    adapt_encoder(ax, ax.encoder)
    adapt_drive(ax, ax.drive, dt)
    adapt_controller(ax)
    adapt_limits(ax)
    ax.operation_mode_state_dword = operation_mode(ax)
    ax.adapt = 0


def begin_encoder(ax: AxisFields, encoder: EncoderFields, dt: float) -> None:
    """Show the truth before the first cycle: the axis is where its encoder reads."""
    adapt_encoder(ax, encoder)
    measure(ax, encoder, dt)
    encoder.actual_position_filtered = encoder.actual_position_unfiltered
    measure(ax, encoder, dt)  # with a filter that has found its position
    for i in range(POSITION_HISTORY):
        encoder.history[i] = encoder.actual_position
    encoder.adapt = 1


def begin(ax: AxisFields, dt: float) -> None:
    """Begin with the present encoder, controller and drive."""
    adapt(ax, dt)
    begin_encoder(ax, ax.encoder, dt)
    ax.set_position = ax.encoder.actual_position
    ax.target_position = ax.encoder.actual_position
    ax.motion_position = ax.encoder.actual_position
    ax.adapt = 1
    adapt(ax, dt)
    show_state(ax)


def _sense(ax: AxisFields, dt: float) -> None:
    """Read the encoder, and what its latches took."""
    encoder = ax.encoder
    measure(ax, encoder, dt)
    if encoder.latch_active or ax.homing_latch:
        watch(ax, encoder)


def _asleep(ax: AxisFields) -> bool:
    """Whether the axis rests on: nobody has written to it, and no input has changed."""
    if ax.encoder.io.news == 0 and ax.drive.io.news == 0:
        return True
    ax.resting = 0
    ax.quiet_cycles = 0
    return False


def cycle(ax: AxisFields, pieces: Sequence[Piece], dt: float) -> None:
    """One cycle of one axis; `pieces` are those of all curves."""
    ax.set_cycle_counter += 1
    if ax.resting and _asleep(ax):
        return
    ax.encoder.io.news = 0
    if ax.external_setpoint_active or ax.drive_operation_mode:
        hand_over(ax)
    if ax.adapt or ax.drive_operation_mode != ax.drive.adapted_mode:
        adapt(ax, dt)
    _sense(ax, dt)
    read_drive(ax, dt)
    supervise_enable(ax, dt)
    if ax.phasing_active:
        shift_phase(ax, dt)
    if ax.axis_type == AxisType.DISCRETE_RAPID_CREEP:
        if ax.set_motion_phase == MotionPhase.HOMING:
            home(ax)
        run_two_speeds(ax, dt)
        supervise_motion(ax, dt)
        supervise_arrival(ax, dt)
        put_out_bytes(ax)
        show_state(ax)
        show_speed(ax)
    else:
        lead(ax, dt)
        control(ax, dt)
        supervise_motion(ax, dt)
        supervise_arrival(ax, dt)
        if ax.drive.type == DriveType.STEPPER:
            run_stepper(ax, dt)
            put_out_bytes(ax)
        else:
            put_out(ax, pieces, dt)
        show_state(ax)
    arm(ax, ax.encoder)
    settle(ax)


def follow(encoder: EncoderFields, dt: float) -> None:
    """One cycle of an encoder that its axis does not work with; it looks at the same motor."""
    ax = encoder.axis
    if encoder.adapt:
        adapt_encoder(ax, encoder)
    elif ax.resting and encoder.io.news == 0:
        return
    encoder.io.news = 0
    measure(ax, encoder, dt)
    if encoder.latch_active:
        watch(ax, encoder)
    arm(ax, encoder)


def cycle_all(
    axes: Sequence[AxisFields],
    encoders: Sequence[EncoderFields],
    pieces: Sequence[Piece],
    dt: float,
) -> None:
    """One cycle of all axes, in the order of the records, then of the encoders besides."""
    for i in range(len(axes)):
        cycle(axes[i], pieces, dt)
    for i in range(len(encoders)):
        encoder = encoders[i]
        if encoder.leads == 0:
            follow(encoder, dt)


def cycles(
    axes: Sequence[AxisFields],
    encoders: Sequence[EncoderFields],
    sensors: Sequence[Sensor],
    amplifiers: Sequence[Amplifier],
    pieces: Sequence[Piece],
    dt: float,
    count: int,
) -> None:
    """`count` cycles of all axes on simulated machines: inputs, NC, outputs."""
    for _ in range(count):
        give_inputs(sensors, amplifiers)
        cycle_all(axes, encoders, pieces, dt)
        carry_out(sensors, amplifiers, pieces, dt)
