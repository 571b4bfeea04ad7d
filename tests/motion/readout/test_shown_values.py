"""Shown values: machine code gives those who watch them the bytes of the plain form."""

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from achse.codes.nc.choices import MotionPhase
from achse.devices.nc.axes.states import AXIS_STATES
from achse.motion import Axis, AxisParameters, Nc
from achse.motion.readout.shown_values import VALUES
from achse.native.backend import compiler_installed
from achse.native.memory import ComputedCell
from achse.native.sampling import Sampler

needs_compiler = pytest.mark.skipif(not compiler_installed(), reason="needs llvmlite")

ROWS = [row for row in AXIS_STATES if row.field in VALUES.fields]
REAL = st.floats(allow_nan=False, allow_infinity=False, min_value=-1e290, max_value=1e290)
VELOCITY = REAL | st.sampled_from([0.0, -0.0])


def axes(count: int, *, compiled: bool = True) -> list[Axis]:
    return list(Nc(2_000_000, [AxisParameters(n + 1) for n in range(count)], compiled=compiled))


def test_each_value_has_its_row() -> None:
    assert {row.field for row in ROWS} == VALUES.fields.keys() - {"axis"}


@needs_compiler
@example([1e25, -1e-18], [0.0, 0.0], [0.1, 360.0], [1_000_000] * 2, [1, 0], [1, 1], [4, 4])
@given(
    *(st.lists(drawn, min_size=2, max_size=2) for drawn in (
        REAL,
        VELOCITY,
        st.floats(1e-6, 1e12) | st.sampled_from([360.0, 1.0, 0.1]),
        st.integers(0, 1_000_000),
        st.integers(0, 1),
        st.sampled_from([-1, 0, 1]),
        st.sampled_from(MotionPhase),
    ))
)  # fmt: skip
def test_machine_code_gives_the_bytes_of_the_plain_form(
    positions: list[float],
    velocities: list[float],
    periods: list[float],
    overrides: list[int],
    external: list[int],
    directions: list[int],
    phases: list[MotionPhase],
) -> None:
    result = axes(2)
    readers, plain = [], []
    for n, axis in enumerate(result):
        axis.set_position, axis.encoder.actual_position = positions[n], positions[1 - n]
        axis.set_velocity, axis.velocity_override = velocities[n], overrides[n]
        axis.external_setpoint_active = external[n]
        axis.external_set_direction = directions[n]
        axis.encoder.modulo_factor, axis.set_motion_phase = periods[n], phases[n]
        for row in ROWS:
            assert row.sample is not None
            shows = row.element(axis, 0) if row.element is not None else axis
            cell = row.sample(shows, 8)
            assert isinstance(cell, ComputedCell)
            readers.append(cell)
            plain.append(row.encoder(8)(row.get(shows)))
    assert [read() for read in readers] == plain
    blank = [bytes(len(each)) for each in plain]
    sampled = Sampler(readers, [n.to_bytes(8, "little") for n in range(len(plain))], blank).sample()
    changed = [
        n.to_bytes(8, "little") + each for n, each in enumerate(plain) if each != bytes(len(each))
    ]
    assert sampled == (len(changed), b"".join(changed))


@needs_compiler
def test_axes_with_two_encoders_are_read_plainly() -> None:
    [axis] = axes(1)
    assert axis.place_of("actual_position_modulo", 8) is not None
    axis.parts()["encoder"].append(axis.encoder)
    assert axis.place_of("actual_position_modulo", 8) is None


def test_plain_axes_have_no_machine_code() -> None:
    [axis] = axes(1, compiled=False)
    assert axis.place_of("set_direction", 8) is None
