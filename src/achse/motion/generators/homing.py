"""Homing: the axis looks for its reference cam, leaves it, and takes its position from a mark.

The sequence is that of 004 §5.1.1: towards the cam, stop on it, off the cam, latch the sync pulse,
stop, and only then set the position, so that the mark has the reference position and the axis
comes to rest its braking distance beyond.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from achse.codes import NcError
from achse.codes.axis import CommandState, HomingState
from achse.codes.nc.choices import MotionPhase, ReferenceMode
from achse.motion.control.signals import LATCHED, begin_watch, homing_cam, latched_position
from achse.motion.generators import moves
from achse.motion.port import STATUS_HOMED, STATUS_HOMING_FAILED
from achse.motion.record import AxisFields
from achse.motion.setpoints.setpoint import arrived, end_homing, fail, shift_origin


def cam_direction(ax: AxisFields) -> float:
    """Return the direction in which the cam is searched, -1 or 1."""
    return -1.0 if ax.encoder.homing_cam_search_inverse else 1.0


def pulse_direction(ax: AxisFields) -> float:
    """Return the direction that leaves the cam and searches the sync pulse, -1 or 1."""
    return -1.0 if ax.encoder.sync_pulse_search_inverse else 1.0


def _run(ax: AxisFields, velocity: float, direction: float) -> None:
    """Go on endlessly, or come to rest with direction 0."""
    ax.job.velocity = velocity
    ax.job.direction = direction
    ax.profile.replan = 1


def _stop(ax: AxisFields) -> None:
    _run(ax, ax.job.velocity, 0.0)


def _stands(ax: AxisFields) -> bool:
    return (
        ax.profile.replan == 0
        and ax.drive.switch_phase == 0  # a two-speed axis is stopped by its brake
        and ax.set.velocity == 0.0
        and ax.set.acceleration == 0.0
        and arrived(ax) == 1
    )


def _arm(ax: AxisFields) -> None:
    """Latch here, off the cam, or with the sync pulse still to come."""
    position = ax.encoder.actual_position_unfiltered
    if ax.encoder.reference_mode == ReferenceMode.HOMING_SENSOR_ONLY:
        ax.homing.latch_position = position
        ax.homing.state = HomingState.SET_POSITION
        _stop(ax)
    else:
        ax.homing.latch_begin = position
        begin_watch(ax, ax.encoder)
        ax.homing.state = HomingState.AWAIT_LATCH


def _set_reference(ax: AxisFields, latched: float) -> None:
    """Give the place at `latched` the reference position, and end homing."""
    ax.target_position = ax.set.position
    end_homing(ax)
    shift_origin(ax, ax.encoder.reference_position - latched)
    ax.encoder.homed = 1
    ax.set_motion_phase = MotionPhase.NONE
    ax.set_command_state = CommandState.DONE


def home(ax: AxisFields) -> None:
    """Take the step of a homing sequence in this cycle; the set-point generator moves."""
    state = ax.homing.state
    cam = homing_cam(ax)
    if state == HomingState.TOWARDS_CAM:
        if cam == 0 and ax.job.direction == 0.0:
            _run(ax, ax.homing_velocity_towards_cam, cam_direction(ax))
        if ax.homing.begins:
            ax.homing.begins = 0  # the first cycle shows this step to those that read cyclically
        elif cam:
            ax.homing.state = HomingState.LEAVE_CAM
            _stop(ax)
        else:
            ax.homing.state = HomingState.AWAIT_CAM
    elif state == HomingState.AWAIT_CAM:
        if cam:
            ax.homing.state = HomingState.LEAVE_CAM
            _stop(ax)
    elif state == HomingState.LEAVE_CAM:
        if _stands(ax):
            if cam:
                ax.homing.state = HomingState.AWAIT_CAM_OFF
                _run(ax, ax.homing_velocity_off_cam, pulse_direction(ax))
            else:
                fail(ax, NcError.HOMING_CAM_LEFT_EARLY, 0)
    elif state == HomingState.AWAIT_CAM_OFF:
        if cam == 0:
            _arm(ax)
    elif state == HomingState.AWAIT_LATCH:
        if ax.homing.latch == LATCHED:
            ax.homing.state = HomingState.SET_POSITION
            _stop(ax)
    elif state == HomingState.SET_POSITION and _stands(ax):
        _set_reference(ax, ax.homing.latch_position)


def _by_drive(ax: AxisFields) -> None:
    """Follow a drive on a bus that homes by itself, with the set point.

    Its latch of the homing says what it counts at its reference.
    """
    encoder = ax.encoder
    ax.set.position = encoder.actual_position
    ax.set.velocity = 0.0
    ax.set.acceleration = 0.0
    status = ax.drive.io.state1
    if status & STATUS_HOMING_FAILED:
        fail(ax, NcError.HOMING_CAM_NOT_FOUND, 0)
    elif status & STATUS_HOMED:
        _set_reference(ax, latched_position(encoder))


def step(ax: AxisFields, dt: float) -> None:
    """Run one cycle: what the sequence wants now, moved like any move."""
    if ax.homed_by_drive and ax.drive.on_bus:
        _by_drive(ax)
        return
    home(ax)
    moves.step(ax, dt)
