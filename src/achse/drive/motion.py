"""Motion: the mode in charge makes the set point; stops and limit switches overrule it."""

from achse.drive.modes import (
    CSP,
    CST,
    CSV,
    HM,
    PP,
    PV,
    TQ,
    cyclic_position,
    cyclic_torque,
    cyclic_velocity,
    homing,
    profile_position,
    profile_torque,
    profile_velocity,
)
from achse.drive.modes.halt import hold_position, hold_velocity
from achse.drive.modes.profile_torque import limited_torque
from achse.drive.plant import CONTROL_OFF, CONTROL_TORQUE, take_over
from achse.drive.power import ENABLED, QUICK_STOP, REACTION, supply_ready
from achse.drive.profile import rate_of, stop
from achse.drive.record import DriveFields
from achse.drive.signals import NEGATIVE_LIMIT, POSITIVE_LIMIT
from achse.drive.supervision import standing_still

_START = 0x10
_STOP_PATIENCE = 0.5
"""A stop counts as finished if the motor is not at standstill this long after its ramp, s."""

_COAST = 0
_NOWHERE = -1e300


def choose_mode(d: DriveFields) -> None:
    """Take 6060h over into 6061h; 0 and what is not supported change nothing."""
    mode = d.mode_request
    if mode == d.mode_display:
        return
    position = mode in (PP, HM, CSP)
    other = mode in (PV, TQ, CSV, CST)
    if not position and not (other and not d.dual_loop):
        return
    d.mode_display = mode
    d.homing_attained = 0
    d.homing_error = 0
    d.homing_running = 0
    d.speed_exceeded = 0
    d.stop_deceleration = 0.0
    if d.power_state == ENABLED:
        enter_mode(d)


def enter_mode(d: DriveFields) -> None:
    """Begin the mode of 6061h; all internal set points are cleared (transition 4)."""
    mode = d.mode_display
    d.stop_deceleration = 0.0
    d.overtravel_stop = 0
    d.idle_at = _NOWHERE
    if mode == PP:
        profile_position.enter(d)
    elif mode == PV:
        profile_velocity.enter(d)
    elif mode == TQ:
        profile_torque.enter(d)
    elif mode == HM:
        homing.enter(d)
    elif mode == CSP:
        cyclic_position.enter(d)
    elif mode == CSV:
        cyclic_velocity.enter(d)
    elif mode == CST:
        cyclic_torque.enter(d)
    else:
        hold_position(d)


def switch_off(d: DriveFields) -> None:
    """Switch the drive function off: no torque, no motion left."""
    d.control = CONTROL_OFF
    d.speed_exceeded = 0
    d.overtravel_stop = 0
    profile_position.abandon(d)
    homing.abandon(d)


def generate(d: DriveFields, dt: float) -> None:
    """Generate the set point of this cycle."""
    state = d.power_state
    if (
        d.mode_display == HM
        and d.controlword & _START
        and not d.previous_controlword & _START
        and d.communication > 1
    ):
        homing.start(d)
    if state == ENABLED:
        _enabled(d, dt)
    elif state in (QUICK_STOP, REACTION):
        _ramp_down(d, dt)
    elif d.idle_at != d.motor_position:
        take_over(d)
        d.idle_at = d.motor_position


def _enabled(d: DriveFields, dt: float) -> None:
    """Generate the mode's set point; one into a limit switch ends motion with 6085h."""
    limits = d.digital_inputs & (POSITIVE_LIMIT | NEGATIVE_LIMIT)
    mode = d.mode_display
    if limits == 0 or mode == HM:
        d.overtravel_stop = 0
        _command(d, dt)
        return
    if mode in (TQ, CST):
        torque = limited_torque(d) + d.torque_offset
        d.overtravel_stop = _blocked(limits, torque if torque != 0.0 else d.motor_velocity)
        if not d.overtravel_stop:
            _command(d, dt)
            return
        hold_velocity(d)
        d.demand_torque = 0.0
    else:
        demand = d.demand
        velocity = d.demand_velocity
        _command(d, dt)
        d.overtravel_stop = _blocked(limits, d.demand_velocity)
        if not d.overtravel_stop:
            return
        d.demand = demand
        d.demand_velocity = velocity
    stop(d, rate_of(d.quick_stop_deceleration, d.max_deceleration), dt)
    if mode == PP:
        profile_position.abandon(d)


def _blocked(limits: int, wish: float) -> int:
    """Return 1 if a limit switch in the direction of `wish` is on, else 0."""
    blocked = POSITIVE_LIMIT if wish > 0.0 else NEGATIVE_LIMIT
    return 1 if wish != 0.0 and limits & blocked else 0


def _command(d: DriveFields, dt: float) -> None:
    mode = d.mode_display
    if mode == CSP:
        cyclic_position.command(d, dt)
    elif mode == PP:
        profile_position.command(d, dt)
    elif mode == PV:
        profile_velocity.command(d, dt)
    elif mode == TQ:
        profile_torque.command(d, dt)
    elif mode == HM:
        homing.command(d, dt)
    elif mode == CSV:
        cyclic_velocity.command(d, dt)
    elif mode == CST:
        cyclic_torque.command(d, dt)
    else:
        stop(d, rate_of(d.quick_stop_deceleration, d.max_deceleration), dt)


def _ramp_down(d: DriveFields, dt: float) -> None:
    """Decelerate with 6085h as it was when the quick stop or fault reaction began."""
    if d.power_state == REACTION and (
        d.fault_reaction_option == _COAST or not supply_ready(d) or d.encoder_fault
    ):
        d.control = CONTROL_OFF
        d.standing = 1
        return
    if d.control == CONTROL_OFF:
        d.standing = 1
        return
    if d.control == CONTROL_TORQUE:
        hold_velocity(d)
    limits = d.digital_inputs
    if d.stop_deceleration == 0.0:
        d.stop_deceleration = rate_of(d.quick_stop_deceleration, d.max_deceleration)
    rate = d.stop_deceleration
    if (limits & POSITIVE_LIMIT and d.demand_velocity > 0.0) or (
        limits & NEGATIVE_LIMIT and d.demand_velocity < 0.0
    ):
        rate = rate_of(d.quick_stop_deceleration, d.max_deceleration)
        if d.overtravel_stop_mode:
            d.stop_deceleration = rate
    stop(d, rate, dt)
    if d.demand_velocity == 0.0:
        d.stop_time += dt
        if standing_still(d) or d.stop_time > _STOP_PATIENCE:
            d.standing = 1


def report(d: DriveFields, dt: float) -> None:
    """Set bits 10, 12 and 13 of the statusword."""
    mode = d.mode_display
    if mode == CSP:
        cyclic_position.report(d, dt)
    elif mode == PP:
        profile_position.report(d, dt)
    elif mode == PV:
        profile_velocity.report(d, dt)
    elif mode == TQ:
        profile_torque.report(d, dt)
    elif mode == HM:
        homing.report(d, dt)
    elif mode == CSV:
        cyclic_velocity.report(d, dt)
    elif mode == CST:
        cyclic_torque.report(d, dt)
    else:
        d.target_reached = 0
        d.bit_12 = 0
        d.bit_13 = 0
    if d.power_state != ENABLED and mode != HM:
        d.target_reached = 0
