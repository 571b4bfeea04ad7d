"""Position controller: from the following error to the output of the axis.

The controller adds a proportional part to the velocity feed-forward.

Kernel source: compiled by Numba as it stands, see `compiled`.
"""

from achse.motion.record import AxisFields

__all__ = ["control"]


def control(ax: AxisFields) -> None:
    """Position controller: following error to drive output."""
    error = ax.set_position - ax.actual_position
    ax.following_error = error
    ax.drive_limit_active = 0
    ax.following_error_velocity = ax.set_velocity - ax.actual_velocity
    if error < ax.following_error_peak_negative:
        ax.following_error_peak_negative = error
    if error > ax.following_error_peak_positive:
        ax.following_error_peak_positive = error
    if ax.loop_closed == 0:
        ax.controller_output = 0.0
        ax.drive_output = 0.0
        ax.controller_output_percent = 0.0
        ax.drive_output_percent = 0.0
        return
    dead_band = ax.controller_position_dead_band
    if ax.set_motion_phase == 0 and dead_band < 0.5001 * ax.encoder_scaling_factor:
        dead_band = 0.5001 * ax.encoder_scaling_factor  # at rest the encoder shows no less
    if abs(error) <= dead_band:
        error = 0.0
    full = ax.drive_reference_velocity
    part = ax.controller_position_kv * error
    limit = ax.controller_output_limit * full
    if part > limit:
        part = limit
    elif part < -limit:
        part = -limit
    ax.controller_output = part
    ax.controller_output_percent = 100.0 * part / full
    output = part + ax.controller_velocity_feedforward_weight * ax.set_velocity
    if output > ax.drive_output_limit_max * full:
        output = ax.drive_output_limit_max * full
        ax.drive_limit_active = 1
    elif output < ax.drive_output_limit_min * full:
        output = ax.drive_output_limit_min * full
        ax.drive_limit_active = 1
    ax.drive_output = output
    ax.drive_output_percent = 100.0 * output / full
    if output < ax.drive_output_peak_negative:
        ax.drive_output_peak_negative = output
    if output > ax.drive_output_peak_positive:
        ax.drive_output_peak_positive = output
