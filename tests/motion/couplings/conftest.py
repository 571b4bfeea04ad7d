"""Axes that are enabled and quick, on either kernel."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.motion import AxisParameters, Nc

VALUES = {
    "control_dword": 7,
    "velocity_override": 1_000_000,
    "max_velocity": 1e4,
    "default_acceleration": 5e3,
    "default_deceleration": 5e3,
    "default_jerk": 1e5,
    "controller_following_error_position_monitoring_enable": 0,
}


@pytest.fixture
def make_axes() -> Callable[..., Nc]:
    """`make_axes(count, compiled=None, second_encoders=(4,), **values)`: ids from 1 on."""

    def make(
        count: int = 2,
        *,
        compiled: bool | None = None,
        second_encoders: tuple[int, ...] = (),
        cycle_ns: int = 2_000_000,
        **values: Any,
    ) -> Nc:
        nc = Nc(
            cycle_ns,
            [
                AxisParameters(
                    n,
                    values=VALUES | values,
                    encoder_ids=(n, n + 100) if n in second_encoders else (),
                )
                for n in range(1, count + 1)
            ],
            compiled=compiled,
        )
        nc.cycle(3)
        return nc

    return make
