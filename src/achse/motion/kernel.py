"""The axis cycle: one step of every axis, the same source plain and compiled.

The hardware gives its inputs, the NC works, the hardware carries out what it says. The cycle of an
axis is a list of stages (`STAGES`), from which come the full cycle and the fast one of an axis that
has no feature on (`achse.motion.features`).
"""

from collections.abc import Callable
from typing import NamedTuple

from achse.codes.nc.choices import AxisType, DriveType, MotionPhase
from achse.motion.control.controller import adapt_controller, control, control_coupling
from achse.motion.control.discrete import run_stepper, run_two_speeds, show_speed
from achse.motion.control.drive import adapt_drive, put_out, put_out_bytes, read_drive
from achse.motion.control.encoder import adapt_encoder, measure
from achse.motion.control.signals import arm, arm_in_force, watch
from achse.motion.couplings.table import couple, has_moving_master
from achse.motion.features import BY_PARAMETERS, Feature
from achse.motion.fields.encoder import POSITION_HISTORY
from achse.motion.generators import coupled
from achse.motion.generators.homing import home
from achse.motion.generators.table import BY_FAST_PATH, generate_set_point, hand_over
from achse.motion.machine.kernel import HardwareRows, carry_out, write_inputs
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
from achse.motion.record import AxisFields, EncoderFields
from achse.motion.rows import NcRows
from achse.motion.setpoints.limits import adapt_limits
from achse.motion.setpoints.phasing import shift_phase
from achse.motion.setpoints.setpoint import follow_segment, generate, show_remaining

_STORED_FEATURES = ~(BY_PARAMETERS | Feature.PARAMETERS.value)
"""Features that a change of parameters does not switch."""

_LEADING = Feature.EXTERNAL_SETPOINT.value | Feature.OPERATION_MODE.value
_LATCHES = Feature.LATCH.value | Feature.HOMING.value


def adapt(ax: AxisFields, dt: float) -> None:
    """Compute what follows from the parameters; done in the first cycle after a change."""
    adapt_encoder(ax, ax.encoder, dt)
    adapt_drive(ax, ax.drive, dt)
    adapt_controller(ax)
    adapt_limits(ax)
    ax.operation_mode_state_dword = operation_mode(ax)
    ax.features = ax.features & _STORED_FEATURES | _by_parameters(ax)


def _by_parameters(ax: AxisFields) -> int:
    """Return the features that parameters switch on."""
    encoder = ax.encoder
    drive = ax.drive
    features = 0
    if (
        ax.axis_type in (AxisType.DISCRETE_RAPID_CREEP, AxisType.ENCODER)
        or drive.type == DriveType.STEPPER
    ):
        features |= Feature.KIND
    if encoder.soft_limit_min_enable or encoder.soft_limit_max_enable:
        features |= Feature.SOFT_LIMITS
    if ax.fast_axis_stop_signal_type:
        features |= Feature.FAST_STOP
    if ax.setpoint_velocity_position_delay > 0.0:
        features |= Feature.POSITION_DELAY
    if drive.special or drive.delay:
        features |= Feature.DRIVE
    if ax.controller.special:
        features |= Feature.CONTROLLER
    return features


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
    ax.set.position = ax.encoder.actual_position
    ax.target_position = ax.encoder.actual_position
    ax.monitoring.motion_position = ax.encoder.actual_position
    adapt(ax, dt)
    show_state(ax)


def _asleep(ax: AxisFields, rows: NcRows) -> bool:
    """Return True if the axis may keep resting: no write, no changed input, no moving master."""
    if (
        ax.encoder.io.has_changed == 0
        and ax.drive.io.has_changed == 0
        and not (ax.coupling.law and has_moving_master(ax, rows))
    ):
        return True
    ax.resting = 0
    ax.quiet_cycles = 0
    return False


def _hand_over(ax: AxisFields, rows: NcRows, dt: float) -> None:
    if ax.features & _LEADING:
        hand_over(ax)
        if ax.external_setpoint_active == 0:
            ax.features &= ~Feature.EXTERNAL_SETPOINT


def _adapt(ax: AxisFields, rows: NcRows, dt: float) -> None:
    if ax.features & Feature.PARAMETERS or ax.drive_operation_mode != ax.drive.adapted_mode:
        adapt(ax, dt)
    if ax.drive_operation_mode == 0:
        ax.features &= ~Feature.OPERATION_MODE


def _measure(ax: AxisFields, rows: NcRows, dt: float) -> None:
    measure(ax, ax.encoder, dt)


def _measure_fast(ax: AxisFields, rows: NcRows, dt: float) -> None:
    encoder = ax.encoder
    if encoder.special or encoder.position_filter_time > 0.0:
        measure(ax, encoder, dt)
    else:
        measure(ax, encoder, dt, fast=True)


def _watch(ax: AxisFields, rows: NcRows, dt: float) -> None:
    if ax.features & _LATCHES:
        watch(ax, ax.encoder)


def _read_drive(ax: AxisFields, rows: NcRows, dt: float) -> None:
    read_drive(ax, dt)


def _read_drive_fast(ax: AxisFields, rows: NcRows, dt: float) -> None:
    read_drive(ax, dt, fast=True)


def _supervise_enable(ax: AxisFields, rows: NcRows, dt: float) -> None:
    supervise_enable(ax, dt)


def _supervise_enable_fast(ax: AxisFields, rows: NcRows, dt: float) -> None:
    if not stays_closed(ax):
        supervise_enable(ax, dt)


def _shift_phase(ax: AxisFields, rows: NcRows, dt: float) -> None:
    if ax.features & Feature.PHASING:
        shift_phase(ax, dt)


def _generate(ax: AxisFields, rows: NcRows, dt: float) -> None:
    if ax.axis_type == AxisType.DISCRETE_RAPID_CREEP:
        if ax.set_motion_phase == MotionPhase.HOMING:
            home(ax)
        run_two_speeds(ax, dt)
    else:
        generate_set_point(ax, dt)
    if BY_FAST_PATH[ax.set_motion_phase]:
        ax.features &= ~Feature.GENERATOR
    else:
        ax.features |= Feature.GENERATOR
    if ax.compensating == 0:
        ax.features &= ~Feature.SUPERPOSITION
    if ax.reversing.number == 0:
        ax.features &= ~Feature.REVERSING


def _generate_fast(ax: AxisFields, rows: NcRows, dt: float) -> None:
    if ax.set_motion_phase == MotionPhase.COUPLED:
        coupled.step(ax, dt)
    elif follow_segment(ax, dt):
        show_remaining(ax, dt)
    else:
        generate(ax, dt)


def _couple(ax: AxisFields, rows: NcRows, dt: float) -> None:
    if ax.coupling_state and ax.axis_type != AxisType.DISCRETE_RAPID_CREEP:
        couple(ax, rows, dt)


def _couple_fast(ax: AxisFields, rows: NcRows, dt: float) -> None:
    if ax.coupling_state:
        couple(ax, rows, dt)


def _control(ax: AxisFields, rows: NcRows, dt: float) -> None:
    if ax.axis_type != AxisType.DISCRETE_RAPID_CREEP:
        control(ax, dt)
        if ax.coupling.law:
            control_coupling(ax, rows)


def _control_fast(ax: AxisFields, rows: NcRows, dt: float) -> None:
    control(ax, dt, fast=True)
    if ax.coupling.law:
        control_coupling(ax, rows)


def _supervise(ax: AxisFields, rows: NcRows, dt: float) -> None:
    supervise_motion(ax, dt)
    supervise_arrival(ax, dt)
    if ax.axis_type == AxisType.ENCODER:
        watch_standstill(ax, dt)


def _supervise_fast(ax: AxisFields, rows: NcRows, dt: float) -> None:
    supervise_motion(ax, dt, fast=True)
    supervise_arrival(ax, dt, fast=True)


def _put_out(ax: AxisFields, rows: NcRows, dt: float) -> None:
    if ax.axis_type == AxisType.DISCRETE_RAPID_CREEP:
        put_out_bytes(ax)
    elif ax.drive.type == DriveType.STEPPER:
        run_stepper(ax, dt)
        put_out_bytes(ax)
    else:
        put_out(ax, rows.curve_spans, dt)


def _put_out_fast(ax: AxisFields, rows: NcRows, dt: float) -> None:
    put_out(ax, rows.curve_spans, dt, fast=True)


def _show_state(ax: AxisFields, rows: NcRows, dt: float) -> None:
    show_state(ax)
    if ax.axis_type == AxisType.DISCRETE_RAPID_CREEP:
        show_speed(ax)


def _show_state_fast(ax: AxisFields, rows: NcRows, dt: float) -> None:
    if ax.features:  # by what this cycle has begun
        show_state(ax)
    else:
        show_state(ax, fast=True)


def _arm(ax: AxisFields, rows: NcRows, dt: float) -> None:
    if ax.features & _LATCHES:
        arm_in_force(ax)


class Stage(NamedTuple):
    """A stage of the cycle of an axis."""

    name: str
    full: Callable[[AxisFields, NcRows, float], None]
    """Work of the stage with any feature on."""
    fast: Callable[[AxisFields, NcRows, float], None] | None = None
    """Work that a plain move or a coupling needs, None for no work."""


STAGES = (
    Stage("hand over", _hand_over),
    Stage("parameters", _adapt),
    Stage("encoder", _measure, _measure_fast),
    Stage("latches", _watch),
    Stage("drive inputs", _read_drive, _read_drive_fast),
    Stage("enables", _supervise_enable, _supervise_enable_fast),
    Stage("phasing", _shift_phase),
    Stage("set point", _generate, _generate_fast),
    Stage("coupling", _couple, _couple_fast),
    Stage("controller", _control, _control_fast),
    Stage("supervision", _supervise, _supervise_fast),
    Stage("outputs", _put_out, _put_out_fast),
    Stage("status", _show_state, _show_state_fast),
    Stage("arming", _arm),
)
"""The stages in their order."""

FULL = tuple(stage.full for stage in STAGES)
"""The cycle with all features."""

FAST = tuple(stage.fast for stage in STAGES if stage.fast is not None)
"""The cycle of an axis that has no feature on."""


def cycle(ax: AxisFields, rows: NcRows, dt: float) -> None:
    """Run one cycle of one axis."""
    ax.set_cycle_counter += 1
    if ax.resting and _asleep(ax, rows):
        return
    ax.encoder.io.has_changed = 0
    if ax.features:
        for step in FULL:
            step(ax, rows, dt)
    else:
        for step in FAST:
            step(ax, rows, dt)
    phase = ax.set_motion_phase
    if (phase and phase != MotionPhase.COUPLED) or (
        ax.coupling.law and has_moving_master(ax, rows)
    ):
        ax.quiet_cycles = 0
    else:
        settle(ax)


def follow(encoder: EncoderFields, dt: float) -> None:
    """Run one cycle of an encoder that its axis does not work with; it looks at the same motor."""
    ax = encoder.axis
    if encoder.adapt:
        adapt_encoder(ax, encoder, dt)
    elif ax.resting and encoder.io.has_changed == 0:
        return
    encoder.io.has_changed = 0
    measure(ax, encoder, dt)
    if encoder.latch_active:
        watch(ax, encoder)
    arm(ax, encoder)


def _follow_others(ax: AxisFields, rows: NcRows, dt: float) -> None:
    """Run one cycle of the encoders that the axis has besides."""
    for i in range(ax.first_encoder, ax.first_encoder + ax.encoder_count):
        encoder = rows.encoders[i]
        if encoder.in_use == 0:
            follow(encoder, dt)


def cycles(rows: NcRows, hardware: HardwareRows, dt: float, count: int) -> None:
    """Run `count` cycles of all axes on simulated machines, masters first.

    Each axis has its inputs, its cycle and its outputs at once, while its records are at hand; it
    knows nothing of the machines of others, so this is as if all inputs came before all axes.
    """
    for _ in range(count):
        for n in range(len(rows.order)):
            i = rows.order[n]
            ax = rows.axes[i]
            machine = hardware.machines[i]
            write_inputs(machine, hardware)
            cycle(ax, rows, dt)
            if ax.encoder_count > 1:
                _follow_others(ax, rows, dt)
            carry_out(machine, hardware, rows.curve_spans, dt)
