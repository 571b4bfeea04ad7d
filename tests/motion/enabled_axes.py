"""An NC whose axes are enabled and quick, on either kernel."""

from typing import Any

from achse.motion import AxisParameters, Nc

__all__ = ["QUICK", "enabled_axes", "gentle_axes"]

QUICK = {
    "control_dword": 7,
    "velocity_override": 1_000_000,
    "max_velocity": 1e4,
    "default_acceleration": 5e3,
    "default_deceleration": 5e3,
    "default_jerk": 1e5,
    "controller_following_error_position_monitoring_enable": 0,
}

_GENTLE = {"default_acceleration": 500.0, "default_deceleration": 500.0, "default_jerk": 5000.0}


def enabled_axes(
    count: int = 2,
    *,
    compiled: bool | None = None,
    second_encoders: tuple[int, ...] = (),
    cycle_ns: int = 2_000_000,
    **values: Any,
) -> Nc:
    """Return an NC of axes 1 to `count`, ready to move."""
    axes = [
        AxisParameters(
            number,
            values=QUICK | values,
            encoder_ids=(number, number + 100) if number in second_encoders else (),
        )
        for number in range(1, count + 1)
    ]
    nc = Nc(cycle_ns, axes, compiled=compiled)
    nc.cycle(3)
    return nc


def gentle_axes(count: int = 2, *, compiled: bool | None = None, **values: Any) -> Nc:
    """Return axes whose dynamics leave time to look at a synchronisation."""
    return enabled_axes(count, compiled=compiled, **_GENTLE | values)
