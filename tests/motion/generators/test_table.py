"""The table of generators: each phase has one, each has its commands, a row is all it takes."""

from typing import Any

import pytest

from achse.motion import MotionPhase, commands
from achse.motion.generators import table
from achse.motion.generators.table import CONTINUOUS, GENERATORS, TRAVELLING, UNPLANNED
from achse.motion.record import AxisFields

UNLIMITED = {
    MotionPhase.EXTERNAL, MotionPhase.VELOCITY_STEPS, MotionPhase.SINE, MotionPhase.DRIVE_OUTPUT,
    MotionPhase.TORQUE,
}  # fmt: skip


def test_each_phase_belongs_to_one_row() -> None:
    phases = [phase for row in GENERATORS for phase in row.phases]
    assert sorted(phases) == sorted(MotionPhase)
    assert len({row.name for row in GENERATORS}) == len(GENERATORS)


@pytest.mark.parametrize("row", GENERATORS, ids=lambda row: row.name)
def test_each_row_names_the_commands_that_begin_it(row: table.Generator) -> None:
    assert row.begin
    assert set(row.begin) <= set(commands.__all__)


def test_what_a_phase_means_for_the_axis() -> None:
    endless = {MotionPhase.ENDLESS}
    for phase in MotionPhase:
        led = {MotionPhase.COUPLED, MotionPhase.GROUPED}
        assert UNPLANNED[phase] == (phase in UNLIMITED | led)
        assert CONTINUOUS[phase] == (phase in UNLIMITED | endless)
        brakes = endless | {MotionPhase.STOPPING, MotionPhase.GROUPED}
        assert TRAVELLING[phase] == (phase in UNLIMITED - {MotionPhase.EXTERNAL} | brakes)


def test_another_step_in_a_row_is_another_generator(
    make_rig: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    def creep(ax: AxisFields, dt: float) -> None:
        ax.set.velocity = 1.0
        ax.set.position += dt

    rows = [row._replace(step=creep) if row.name == "sine" else row for row in GENERATORS]
    monkeypatch.setattr(table, "GENERATORS", tuple(rows))
    axis = (rig := make_rig(compiled=False)).axis  # Python that is replaced now
    assert commands.start_sine_oscillation(axis, 1, 10.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1, 1) == 0
    rig.run(100)
    assert (axis.set_position, axis.set_velocity) == (pytest.approx(100 * rig.dt), 1.0)
    commands.stop(axis)
    rig.until_rest()


def test_external_set_points_lead_in_any_phase(make_rig: Any) -> None:
    rig = make_rig(allow_motion_commands_with_external_setpoint=1)
    axis = rig.axis
    assert commands.start_external_setpoint(axis, 1, 0.0) == 0
    assert commands.universal_start(axis, 1, 10.0, 100.0) == 0
    leading = next(row for row in GENERATORS if row.name == "external set points")
    rig.run(1)
    assert (axis.set_motion_phase, leading.is_active(axis)) == (MotionPhase.POSITIONING, True)
    commands.stop(axis)
    table.hand_over(axis)
    assert not leading.is_active(axis)


def test_the_heading_is_that_of_the_generator(make_rig: Any) -> None:
    rig = make_rig()
    assert commands.start_drive_output(rig.axis, 2, -50.0) == 0
    assert table.heading(rig.axis) == -50.0
    assert table.along_the_set_point(rig.axis) == 0.0
