"""Axes that are enabled and quick, on either kernel."""

from collections.abc import Callable

import pytest

from achse.motion import Nc
from tests.motion.enabled_axes import enabled_axes


@pytest.fixture
def make_axes() -> Callable[..., Nc]:
    """`make_axes(count, compiled=None, second_encoders=(4,), **values)`: ids from 1 on."""
    return enabled_axes
