"""The axis cycle: one step of every axis, the same source plain and compiled.

Order within a cycle: encoder, enables, set point, controller, supervision, drive, status.
"""

from collections.abc import Sequence

from achse.motion.controller import adapt_controller, control
from achse.motion.curves import Piece
from achse.motion.discrete import run_stepper, run_two_speeds, show_speed
from achse.motion.drive import adapt_drive, drive, drive_command, place_motor, position_output
from achse.motion.encoder import adapt_encoder, measure
from achse.motion.external import follow_external
from achse.motion.homing import home
from achse.motion.limits import adapt_limits
from achse.motion.monitoring import (
    operation_mode,
    settle,
    show_state,
    supervise_arrival,
    supervise_enable,
    supervise_motion,
)
from achse.motion.open_loop import choose_loop, follow_axis, run_torque
from achse.motion.oscillation import oscillate, position_in_turn
from achse.motion.phasing import shift_phase
from achse.motion.record import POSITION_HISTORY, AxisFields
from achse.motion.setpoint import generate
from achse.motion.signals import limit_switch, watch
from achse.motion.states import TORQUE_MODES, AxisType, DriveType, MotionPhase
from achse.motion.superposition import generate_superposed

__all__ = ["adapt", "begin", "cycle", "cycle_all", "cycles", "follow"]

_TWO_SPEEDS = AxisType.DISCRETE_RAPID_CREEP.value
_STEPPER = DriveType.STEPPER.value
_HOMING = MotionPhase.HOMING.value
_EXTERNAL = MotionPhase.EXTERNAL.value
_DRIVE_OUTPUT = MotionPhase.DRIVE_OUTPUT.value


def adapt(ax: AxisFields, dt: float) -> None:
    """Compute what follows from the parameters; done in the first cycle after a change."""
    adapt_encoder(ax)
    adapt_drive(ax, dt)
    adapt_controller(ax)
    adapt_limits(ax)
    ax.operation_mode_state_dword = operation_mode(ax)
    ax.adapt = 0


def begin(ax: AxisFields, dt: float) -> None:
    """Show the truth before the first cycle: the axis stands where its encoder reads."""
    adapt(ax, dt)
    measure(ax, dt)
    ax.encoder_actual_position_filtered = ax.encoder_actual_position_unfiltered
    measure(ax, dt)  # with a filter that has found its position
    ax.set_position = ax.actual_position
    ax.target_position = ax.actual_position
    ax.motion_position = ax.actual_position
    for i in range(POSITION_HISTORY):
        ax.encoder_history[i] = ax.actual_position
    ax.adapt = 1
    adapt(ax, dt)
    show_state(ax)


def _sense(ax: AxisFields, machine: AxisFields, dt: float) -> None:
    """Read the encoder, and whatever its latches wait for along the machine."""
    measure(ax, dt)
    if ax.encoder_latch_active or ax.homing_latch:
        watch(ax, machine)


def _lead(ax: AxisFields, dt: float) -> None:
    """Set point of this cycle, by whatever makes it."""
    phase = ax.set_motion_phase
    if ax.drive_operation_mode in TORQUE_MODES:
        run_torque(ax, dt)
    elif ax.external_setpoint_active:
        follow_external(ax, dt)
    elif phase < _EXTERNAL:
        if phase == _HOMING:
            home(ax)
        if ax.compensating:
            generate_superposed(ax, dt)
        else:
            generate(ax, dt)
        if ax.reversing_number:
            position_in_turn(ax)
    elif phase == _DRIVE_OUTPUT:
        follow_axis(ax)
    else:
        oscillate(ax, dt)


def cycle(ax: AxisFields, pieces: Sequence[Piece], dt: float) -> None:
    """One cycle of one axis; `pieces` are those of all curves."""
    ax.set_cycle_counter += 1
    if ax.resting:
        return
    if ax.adapt:
        adapt(ax, dt)
    if ax.drive_operation_mode in TORQUE_MODES:
        choose_loop(ax)
    ideal = ax.drive_ideal
    if ax.drive_operation_mode in TORQUE_MODES or ax.set_motion_phase == _DRIVE_OUTPUT:
        ideal = 0
    if ideal == 0:
        _sense(ax, ax, dt)
    ax.limit_switch = limit_switch(ax)
    supervise_enable(ax, dt)
    if ax.phasing_active:
        shift_phase(ax, dt)
    if ax.axis_type == _TWO_SPEEDS:
        if ax.set_motion_phase == _HOMING:
            home(ax)
        run_two_speeds(ax, dt)
        supervise_motion(ax, dt)
        supervise_arrival(ax, dt)
        show_state(ax)
        show_speed(ax)
        settle(ax)
        return
    _lead(ax, dt)
    if ideal:
        place_motor(ax, position_output(ax, dt) if ax.drive_special else ax.set_position, dt)
        _sense(ax, ax, dt)
    control(ax, dt)
    supervise_motion(ax, dt)
    supervise_arrival(ax, dt)
    command = drive_command(ax, pieces)
    if ax.drive_type == _STEPPER:
        run_stepper(ax, dt)
    elif ideal == 0:
        drive(ax, command, dt)
    show_state(ax)
    settle(ax)


def follow(ax: AxisFields, owner: AxisFields, dt: float) -> None:
    """One cycle of a further element of an axis: its encoder sees the same motor.

    A stepper moves by whole steps, whatever velocity their frequency means.
    """
    ax.set_cycle_counter = owner.set_cycle_counter
    if ax.adapt:
        adapt(ax, dt)
    elif owner.resting:
        return
    ax.set_velocity = owner.set_velocity
    ax.actual_position_correction = owner.actual_position_correction
    _sense(ax, owner, dt)
    ax.plant_velocity = owner.plant_velocity
    way = owner.plant_velocity * dt
    if owner.drive_type == _STEPPER:
        way = (owner.stepper_step - ax.stepper_step) * owner.stepper_step_scaling
        ax.stepper_step = owner.stepper_step
    if way != 0.0:
        if owner.drive_motor_polarity:
            way = -way
        ax.plant_position += way / ax.encoder_scaling_factor


def cycle_all(axes: Sequence[AxisFields], pieces: Sequence[Piece], dt: float) -> None:
    """One cycle of all axes, in the order of the records; elements come after their axis."""
    for i in range(len(axes)):
        ax = axes[i]
        if ax.element_number == 0:
            cycle(ax, pieces, dt)
        else:
            follow(ax, axes[i - ax.element_number], dt)


def cycles(axes: Sequence[AxisFields], pieces: Sequence[Piece], dt: float, count: int) -> None:
    """`count` cycles of all axes."""
    for _ in range(count):
        cycle_all(axes, pieces, dt)
