"""Trapezoidal profiles: moves to a target, ramps to a velocity and stops, exact at any step.

Set points are in inc, inc/s and inc/s². A move is planned once as at most four parts of constant
acceleration and then evaluated; it starts from any velocity and may end at one.
"""

import math

from achse.drive.record import DriveFields

_NEVER = 1e30


def rate_of(value: int, limit: int) -> float:
    """Return an acceleration object within its limit, at least 1 inc/s²: no move lasts for ever."""
    rate = min(value, limit)
    return float(rate) if rate > 1 else 1.0


def plan(
    d: DriveFields,
    target: float,
    end_velocity: float,
    velocity: float,
    acceleration: float,
    deceleration: float,
) -> None:
    """Plan the move from the present set point to `target`.

    `velocity` is the largest speed, `end_velocity` the speed at the target (both ≥ 0); the latter
    holds as far as the distance allows and only if the move does not have to turn back.
    """
    d.plan_target = target
    d.plan_count = 0
    d.plan_index = 0
    d.plan_elapsed = 0.0
    distance = target - d.demand
    start = d.demand_velocity
    if velocity <= 0.0:
        velocity = 1e-9
    direction = 1.0 if distance - start * abs(start) / (2.0 * deceleration) >= 0.0 else -1.0
    distance *= direction
    start *= direction
    end = min(end_velocity, velocity)
    if start < 0.0:
        _part(d, -start / deceleration, direction * deceleration)
        distance += start * start / (2.0 * deceleration)
        start = 0.0
    elif start > velocity:
        _part(d, (start - velocity) / deceleration, -direction * deceleration)
        distance -= (start * start - velocity * velocity) / (2.0 * deceleration)
        start = velocity
    if distance < 0.0:
        distance = 0.0
    end = min(end, math.sqrt(start * start + 2.0 * acceleration * distance))
    peak = math.sqrt(
        2.0
        * acceleration
        * deceleration
        / (acceleration + deceleration)
        * (distance + start * start / (2.0 * acceleration) + end * end / (2.0 * deceleration))
    )
    if peak > velocity:
        peak = velocity
    if peak < start:
        peak = start
    way = (peak * peak - start * start) / (2.0 * acceleration)
    way += (peak * peak - end * end) / (2.0 * deceleration)
    if peak > start:
        _part(d, (peak - start) / acceleration, direction * acceleration)
    if distance > way and peak > 0.0:
        _part(d, (distance - way) / peak, 0.0)
    if peak > end:
        _part(d, (peak - end) / deceleration, -direction * deceleration)
    d.plan_end_velocity = direction * end


def _part(d: DriveFields, time: float, acceleration: float) -> None:
    d.plan_time[d.plan_count] = time
    d.plan_acceleration[d.plan_count] = acceleration
    d.plan_count += 1


def follow(d: DriveFields, dt: float) -> float:
    """Go on along the plan for `dt`; the time left over behind its end, -1 while it runs."""
    while d.plan_index < d.plan_count:
        rest = d.plan_time[d.plan_index] - d.plan_elapsed
        acceleration = d.plan_acceleration[d.plan_index]
        part = min(rest, dt)
        d.demand += (d.demand_velocity + 0.5 * acceleration * part) * part
        d.demand_velocity += acceleration * part
        if dt < rest:
            d.plan_elapsed += dt
            return -1.0
        dt -= rest
        d.plan_index += 1
        d.plan_elapsed = 0.0
    d.demand = d.plan_target
    d.demand_velocity = d.plan_end_velocity
    return dt


def ramp_velocity(
    d: DriveFields, target: float, acceleration: float, deceleration: float, dt: float
) -> None:
    """Lead the set velocity to `target`; slowing down uses `deceleration`, through zero both."""
    velocity = d.demand_velocity
    while dt > 0.0 and velocity != target:
        slows = velocity * target < 0.0 or abs(target) < abs(velocity)
        goal = 0.0 if velocity * target < 0.0 else target
        rate = deceleration if slows else acceleration
        change = goal - velocity
        time = abs(change) / rate
        if time > dt:
            change = rate * dt if change > 0.0 else -rate * dt
            time = dt
            goal = velocity + change
        d.demand += (velocity + 0.5 * change) * time
        velocity = goal
        dt -= time
    d.demand += velocity * dt
    d.demand_velocity = velocity


def stop(d: DriveFields, deceleration: float, dt: float) -> None:
    """Lead the set velocity to zero."""
    ramp_velocity(d, 0.0, deceleration, deceleration, dt)
