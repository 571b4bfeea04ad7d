"""Velocity steps: constant velocities and pauses by turns, without ramps (0x32).

The answer of the axis to a step is what they are made for.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from achse.motion.generators.sequence import finish, override_share
from achse.motion.record import AxisFields
from achse.motion.setpoints.dynamics import fastest
from achse.motion.setpoints.limits import running_into

_STAGES = 4
"""First velocity, pause, second velocity, pause."""


def step(ax: AxisFields, dt: float) -> None:
    """Run one cycle of a velocity or a pause."""
    ax.profile.abrupt = 1
    stage = ax.sequence.stage
    pausing = stage % 2 == 1
    velocity = 0.0
    if not pausing:
        velocity = ax.sequence.velocity_1 if stage == 0 else ax.sequence.velocity_2
        velocity *= override_share(ax)
        top = fastest(ax)
        if velocity > top:
            velocity = top
        elif velocity < -top:
            velocity = -top
        if ax.limits.active:  # a jump is not braked in time
            ax.limits.reached = running_into(ax, velocity, dt)
            if ax.limits.reached != 0:
                velocity = 0.0
    if stage == _STAGES:
        ax.set.velocity = 0.0
        finish(ax)
        return
    ax.set.velocity = velocity
    ax.set.position += velocity * dt
    ax.target_position = ax.set.position
    ax.sequence.time += dt
    duration = ax.sequence.pause if pausing else ax.sequence.duration
    while ax.sequence.time >= duration - 0.5 * dt:
        ax.sequence.time = 0.0
        stage += 1
        if stage == _STAGES:
            ax.sequence.round += 1
            if ax.sequence.round == ax.sequence.rounds:
                break
            stage = 0
        duration = ax.sequence.pause if stage % 2 == 1 else ax.sequence.duration
    ax.sequence.stage = stage
