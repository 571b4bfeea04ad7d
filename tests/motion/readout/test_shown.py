"""Values that are computed when they are read: right at once, without a place in memory."""

import pytest

from achse.motion import AxisParameters, Nc
from achse.motion.readout.shown import SHOWN, modulo_place
from achse.motion.record import FIELDS, LAYOUT, PARTS
from achse.native.backend import compiler_installed


@pytest.mark.parametrize(
    ("position", "place"),
    [(-90.0, (270.0, -1)), (370.0, (10.0, 1)), (0.0, (0.0, 0)), (-1e-18, (0.0, 0))],
)
def test_place_within_a_period(position: float, place: tuple[float, int]) -> None:
    assert modulo_place(position, 360.0) == place


@pytest.mark.parametrize("compiled", [False, pytest.param(True, marks=pytest.mark.skipif(
    not compiler_installed(), reason="needs llvmlite"))])  # fmt: skip
def test_shown_without_a_cycle(compiled: bool) -> None:
    axis = Nc(2_000_000, [AxisParameters(1)], compiled=compiled).axis(1)
    axis.set_position, axis.velocity_override = -90.0, 500_000
    axis.encoder.actual_position = 370.0
    axis.drive.output = 0.5 * axis.drive.full
    axis.controller.output = 0.25 * axis.drive.full
    assert (axis.set_position_modulo, axis.set_modulo_turns) == (270.0, -1)
    assert (axis.actual_position_modulo, axis.encoder.actual_modulo_turns) == (10.0, 1)
    assert (axis.drive.output_percent, axis.controller.output_percent) == (50.0, 25.0)
    assert (axis.set_velocity_override, axis.set_direction) == (0.5, 0.0)
    axis.set_motion_phase, axis.set_velocity = 1, -3.0
    assert axis.set_direction == -1.0
    for name in ("set_position_modulo", "actual_position_modulo"):
        assert (axis.place_of(name, 8) is not None) is compiled
    assert axis.place_of("drive_output_percent", 8) is None


def test_they_have_no_place_in_a_record() -> None:
    for part, rows in SHOWN.items():
        layout = PARTS[part] if part else LAYOUT
        assert not rows.keys() & layout.fields.keys()
        assert all(row in FIELDS.values() for row in rows.values())
