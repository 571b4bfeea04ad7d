"""The axis cycle: one step of every axis, the same source plain and compiled.

The hardware gives its inputs, the NC works, the hardware carries out what it says. Order within
the cycle of an axis: encoder, enables, set point, coupling, controller, supervision, outputs,
status.
"""

from achse.motion.controller import adapt_controller, control, control_coupling
from achse.motion.couplings.table import couple, led
from achse.motion.discrete import run_stepper, run_two_speeds, show_speed
from achse.motion.drive import adapt_drive, put_out, put_out_bytes, read_drive
from achse.motion.encoder import adapt_encoder, measure
from achse.motion.generators import coupled
from achse.motion.generators.homing import home
from achse.motion.generators.table import hand_over, lead
from achse.motion.limits import adapt_limits
from achse.motion.machine.kernel import HardwareRows, carry_out, give_inputs
from achse.motion.monitoring import (
    operation_mode,
    settle,
    show_state,
    stays_closed,
    supervise_arrival,
    supervise_enable,
    supervise_motion,
    watch_standstill,
)
from achse.motion.phasing import shift_phase
from achse.motion.record import POSITION_HISTORY, AxisFields, EncoderFields
from achse.motion.rows import NcRows
from achse.motion.setpoint import generate, keeps_its_table, show_remaining, walk
from achse.motion.signals import arm, watch
from achse.motion.states import AxisType, DriveType, MotionPhase

__all__ = ["adapt", "begin", "begin_encoder", "cycle", "cycles", "follow"]


def adapt(ax: AxisFields, dt: float) -> None:
    """Compute what follows from the parameters; done in the first cycle after a change."""
    adapt_encoder(ax, ax.encoder, dt)
    adapt_drive(ax, ax.drive, dt)
    adapt_controller(ax)
    adapt_limits(ax)
    ax.operation_mode_state_dword = operation_mode(ax)
    ax.adapt = 0


def begin_encoder(ax: AxisFields, encoder: EncoderFields, dt: float) -> None:
    """Show the truth before the first cycle: the axis is where its encoder reads."""
    adapt_encoder(ax, encoder, dt)
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


def _asleep(ax: AxisFields, rows: NcRows) -> bool:
    """Whether the axis rests on: nobody writes to it, no input has changed, no master moves."""
    if ax.encoder.io.news == 0 and ax.drive.io.news == 0 and not (ax.coupling and led(ax, rows)):
        return True
    ax.resting = 0
    ax.quiet_cycles = 0
    return False


def _cycle_with_all(ax: AxisFields, rows: NcRows, dt: float) -> None:
    """One cycle with all that an axis may do besides a plain move or following others."""
    encoder = ax.encoder
    if ax.external_setpoint_active or ax.drive_operation_mode:
        hand_over(ax)
    if ax.adapt or ax.drive_operation_mode != ax.drive.adapted_mode:
        adapt(ax, dt)
    measure(ax, encoder, dt)
    if encoder.latch_active or ax.homing_latch:
        watch(ax, encoder)
    read_drive(ax, dt)
    supervise_enable(ax, dt)
    if ax.phasing_active:
        shift_phase(ax, dt)
    discrete = ax.axis_type == AxisType.DISCRETE_RAPID_CREEP
    if discrete:
        if ax.set_motion_phase == MotionPhase.HOMING:
            home(ax)
        run_two_speeds(ax, dt)
    else:
        lead(ax, dt)
        if ax.coupling_state:
            couple(ax, rows, dt)
        control(ax, dt)
        if ax.coupling:
            control_coupling(ax, rows)
    supervise_motion(ax, dt)
    supervise_arrival(ax, dt)
    if ax.axis_type == AxisType.ENCODER:
        watch_standstill(ax, dt)
    if discrete:
        put_out_bytes(ax)
    elif ax.drive.type == DriveType.STEPPER:
        run_stepper(ax, dt)
        put_out_bytes(ax)
    else:
        put_out(ax, rows.pieces, dt)
    show_state(ax)
    if discrete:
        show_speed(ax)
    if encoder.latch_active or encoder.armed or ax.homing_latch:
        arm(ax, encoder)


def cycle(ax: AxisFields, rows: NcRows, dt: float) -> None:
    """One cycle of one axis."""
    ax.set_cycle_counter += 1
    if ax.resting and _asleep(ax, rows):
        return
    encoder = ax.encoder
    encoder.io.news = 0
    if ax.unusual:
        _cycle_with_all(ax, rows, dt)
    else:
        if encoder.special or encoder.position_filter_time > 0.0:
            measure(ax, encoder, dt)
        else:
            measure(ax, encoder, dt, plain=True)
        read_drive(ax, dt, plain=True)
        if not stays_closed(ax):
            supervise_enable(ax, dt)
        if ax.set_motion_phase == MotionPhase.COUPLED:
            coupled.step(ax, dt)
        elif keeps_its_table(ax, dt):
            walk(ax, ax.segment_elapsed + dt)
            show_remaining(ax, dt)
        else:
            generate(ax, dt)
        if ax.coupling_state:
            couple(ax, rows, dt)
        control(ax, dt, plain=True)
        if ax.coupling:
            control_coupling(ax, rows)
        supervise_motion(ax, dt, plain=True)
        supervise_arrival(ax, dt, plain=True)
        put_out(ax, rows.pieces, dt, plain=True)
        if ax.unusual:  # by what this cycle has begun
            show_state(ax)
        else:
            show_state(ax, plain=True)
    phase = ax.set_motion_phase
    if (phase and phase != MotionPhase.COUPLED) or (ax.coupling and led(ax, rows)):
        ax.quiet_cycles = 0
    else:
        settle(ax)


def follow(encoder: EncoderFields, dt: float) -> None:
    """One cycle of an encoder that its axis does not work with; it looks at the same motor."""
    ax = encoder.axis
    if encoder.adapt:
        adapt_encoder(ax, encoder, dt)
    elif ax.resting and encoder.io.news == 0:
        return
    encoder.io.news = 0
    measure(ax, encoder, dt)
    if encoder.latch_active:
        watch(ax, encoder)
    arm(ax, encoder)


def _follow_others(ax: AxisFields, rows: NcRows, dt: float) -> None:
    """One cycle of the encoders that the axis has besides."""
    for i in range(ax.first_encoder, ax.first_encoder + ax.encoder_count):
        encoder = rows.encoders[i]
        if encoder.leads == 0:
            follow(encoder, dt)


def cycles(rows: NcRows, hardware: HardwareRows, dt: float, count: int) -> None:
    """`count` cycles of all axes on simulated machines, masters first.

    Each axis has its inputs, its cycle and its outputs at once, while its records are at hand; it
    knows nothing of the machines of others, so this is as if all inputs came before all axes.
    """
    for _ in range(count):
        for n in range(len(rows.order)):
            i = rows.order[n]
            ax = rows.axes[i]
            machine = hardware.machines[i]
            give_inputs(machine, hardware)
            cycle(ax, rows, dt)
            if ax.encoder_count > 1:
                _follow_others(ax, rows, dt)
            carry_out(machine, hardware, rows.pieces, dt)
