"""The plant: position, velocity and torque loop of the drive, with motor, load and encoder.

One call is one drive cycle, done in equal parts of at most 125 µs. The loops are those of a servo
drive: P position loop with velocity feed-forward, PI velocity loop with anti-windup, torque as a
first-order lag within its limits. Mechanics: inertia, Coulomb and viscous friction with sticking,
gravity, external load, brake and hard stops. Positions are counts of the machine.
"""

import math

from achse.drive.record import DriveFields

CONTROL_OFF = 0
CONTROL_POSITION = 1
CONTROL_VELOCITY = 2
CONTROL_TORQUE = 3

PART = 125e-6
"""Longest step of the simulation, s."""

_TWO_PI = 2.0 * math.pi


def prepare(d: DriveFields, dt: float) -> None:
    """Set the fields that depend on the step time only; `dt` in s."""
    d.step_time = dt
    d.substeps = max(1, math.ceil(dt / PART - 1e-9))
    d.torque_response = 1.0 - math.exp(-dt / d.substeps / d.torque_time)


def torque_limits(d: DriveFields) -> tuple[float, float]:
    """Largest torque in negative and positive direction, ‰ (6072h, 60E0h, 60E1h, motor)."""
    most = d.peak_torque
    if d.max_torque < most:
        most = float(d.max_torque)
    lowest = highest = most
    if d.negative_torque_limit < most:
        lowest = float(d.negative_torque_limit)
    if d.positive_torque_limit < most:
        highest = float(d.positive_torque_limit)
    return (lowest, highest)


def move(d: DriveFields, dt: float) -> None:
    """Run one drive cycle from the set point before to the one of now."""
    if dt != d.step_time:
        prepare(d, dt)
    control = d.control
    reference_end = (d.demand - d.active_home_offset) * d.counts_per_inc + d.encoder_zero
    velocity_end = d.demand_velocity * d.counts_per_inc
    velocity = d.motor_velocity
    if control == CONTROL_OFF and velocity == 0.0 and _rests(d):
        d.reference = reference_end
        d.reference_velocity = 0.0
        d.motor_torque = 0.0
        d.torque_command = 0.0
        d.torque_limited = 0
        d.previous_position = d.motor_position
        return

    parts = d.substeps
    h = dt / parts
    position = d.motor_position
    torque = d.motor_torque
    integral = d.velocity_integral
    reference = d.reference
    slope = (reference_end - reference) / parts
    set_velocity = d.reference_velocity
    change = (velocity_end - set_velocity) / parts
    lowest, highest = torque_limits(d)
    lowest = -lowest
    maximum = d.max_velocity
    gain = d.velocity_gain * d.velocity_loop_gain * 0.1 * _TWO_PI * (100 + d.inertia_ratio) * 0.01
    reset = h / (d.velocity_loop_integral * 1e-5) if d.velocity_loop_integral > 0 else 0.0
    stiffness = d.position_loop_gain * 0.1
    forward = d.feed_forward * 0.01 / h
    offset = d.velocity_offset * d.counts_per_inc
    torque_offset = float(d.torque_offset)
    response = d.torque_response
    load = d.gravity + d.external_load
    coulomb = d.coulomb
    viscous = d.viscous
    acceleration = d.acceleration_gain * h
    low_stop = d.negative_stop
    high_stop = d.positive_stop
    engaged = d.brake_engaged | d.jammed
    demanded = d.demand_torque + torque_offset
    command = 0.0
    limited = 0
    if control == CONTROL_TORQUE:  # the modes keep their demand within the limits themselves
        above = d.target_torque > highest and d.demand_torque >= highest
        below = d.target_torque < lowest and d.demand_torque <= lowest
        limited = 1 if above or below else 0
    d.previous_position = position

    for _ in range(parts):
        if control == CONTROL_OFF:
            command = 0.0
        elif control == CONTROL_TORQUE:
            # the motor's largest speed bounds the torque, a stopping one is never cut
            command = demanded
            most = gain * (maximum - velocity)
            least = -gain * (maximum + velocity)
            if command > most:
                command = most
            elif command < least:
                command = least
            if command > highest:
                command = highest
                limited = 1
            elif command < lowest:
                command = lowest
                limited = 1
        else:
            if control == CONTROL_POSITION:
                error = reference - position
                reference += slope
                if -0.5 < error < 0.5 and slope == 0.0:
                    error = 0.0  # the encoder does not see it
                wanted = stiffness * error + forward * slope + offset
            else:
                set_velocity += change
                wanted = set_velocity + offset
            if wanted > maximum:
                wanted = maximum
            elif wanted < -maximum:
                wanted = -maximum
            error = wanted - velocity
            command = gain * (error + integral) + torque_offset
            if command > highest:
                command = highest
                limited = 1
                if error < 0.0:
                    integral += error * reset
            elif command < lowest:
                command = lowest
                limited = 1
                if error > 0.0:
                    integral += error * reset
            else:
                integral += error * reset
        torque += (command - torque) * response

        drive = torque - load
        if engaged:
            velocity = 0.0
        elif velocity == 0.0:
            if drive > coulomb:
                velocity = (drive - coulomb) * acceleration
            elif drive < -coulomb:
                velocity = (drive + coulomb) * acceleration
            position += 0.5 * velocity * h
        else:
            before = velocity
            if before > 0.0:
                velocity += (drive - coulomb - viscous * before) * acceleration
            else:
                velocity += (drive + coulomb - viscous * before) * acceleration
            if velocity * before < 0.0 and -coulomb <= drive <= coulomb:
                velocity = 0.0
            position += 0.5 * (before + velocity) * h
        if position <= low_stop:
            position = low_stop
            if velocity < 0.0:
                velocity = 0.0
        elif position >= high_stop:
            position = high_stop
            if velocity > 0.0:
                velocity = 0.0

    d.reference = reference_end
    d.reference_velocity = velocity_end
    d.motor_position = position
    d.motor_velocity = velocity
    d.motor_torque = torque
    d.velocity_integral = integral
    d.torque_command = command
    d.torque_limited = limited


def _rests(d: DriveFields) -> bool:
    """Return True if a motor without torque stays at its position."""
    load = d.gravity + d.external_load
    return d.brake_engaged | d.jammed != 0 or -d.coulomb <= load <= d.coulomb


def take_over(d: DriveFields) -> None:
    """Start the set point at the motor's position and velocity: nothing jumps."""
    count = math.floor(d.motor_position + 0.5) - d.encoder_zero
    d.demand = count * d.inc_per_count + d.active_home_offset
    d.demand_velocity = 0.0
    d.demand_torque = 0.0
    d.velocity_integral = 0.0
    d.reference = float(count + d.encoder_zero)
    d.reference_velocity = 0.0
    d.plan_count = 0
    d.plan_index = 0
