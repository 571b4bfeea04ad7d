"""Images of axes: machine code makes the bytes that the plain form makes, from every field."""

import struct

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from achse.codes.axis import StartType
from achse.codes.nc.choices import MotionPhase
from achse.devices.nc.axes.structures import NC_TO_PLC_TC3
from achse.motion import Axis, AxisParameters, Nc, commands
from achse.motion.readout.cyclic_image import IMAGE_BYTES, AxisImages, images_of
from achse.native.backend import compiler_installed
from achse.native.compiled import checked_builds

needs_compiler = pytest.mark.skipif(not compiler_installed(), reason="needs llvmlite")

WHOLES = (
    *("state_dword", "error_code", "motion_state", "operation_mode_feedback", "homing_state"),
    *("coupling_state", "buffer_count", "operation_mode_state_dword", "active_control_loop"),
    *("set_command_number", "set_command_state", "set_cycle_counter"),
)
REALS = (
    *("actual_position", "actual_velocity", "following_error", "set_position", "set_velocity"),
    *("set_acceleration", "target_position", "set_jerk", "set_torque", "drive_actual_torque"),
    *("drive_actual_torque_derivative", "set_torque_derivative", "phasing_position"),
    *("set_torque_offset", "actual_acceleration", "encoder_position_correction"),
    *("encoder_actual_position_unfiltered", "encoder_set_position_offset", "torque.target"),
    "drive_velocity_scaling",
)
PROBES = ("probe_active", "probe_valid", "probe_continuous", "probe_counter")

REAL = st.floats(allow_nan=False, allow_infinity=False, min_value=-1e290, max_value=1e290)
WHOLE = st.integers(0, (1 << 32) - 1) | st.integers(0, 3) | st.integers(0, 1 << 40)
PERIOD = st.floats(1e-6, 1e12) | st.sampled_from([360.0, 1.0, 0.1])


def one_axis() -> Axis:
    return Nc(2_000_000, [AxisParameters(7)], compiled=True).axis(7)


@needs_compiler
@example(
    dict.fromkeys(WHOLES, 0xFFFF_FFFF), dict.fromkeys(REALS, -1e-18), 360.0, 0x1_0014, 255, 2,
    MotionPhase.TORQUE, [1] * 32,
)  # fmt: skip
@example(
    dict.fromkeys(WHOLES, 1 << 40), dict.fromkeys(REALS, 1e25), 0.1, 0x1_0012, 1, -5,
    MotionPhase.TORQUE, [0] * 32,
)  # fmt: skip
@given(
    st.fixed_dictionaries(dict.fromkeys(WHOLES, WHOLE)),
    st.fixed_dictionaries(dict.fromkeys(REALS, REAL)),
    PERIOD,
    st.sampled_from([0, 0x1_0012, 0x1_0014, 0x1_0017]),
    st.integers(0, 255),
    st.integers(-(1 << 31), (1 << 31) - 1),
    st.sampled_from(MotionPhase),
    st.lists(st.integers(0, 1), min_size=32, max_size=32),
)
def test_every_value_is_shown_as_by_the_plain_form(
    ints: dict[str, int],
    floats: dict[str, float],
    period: float,
    user_data: int,
    inputs: int,
    velocity: int,
    phase: MotionPhase,
    probes: list[int],
) -> None:
    axis = one_axis()
    for name, value in (ints | floats).items():
        part, _, field = name.rpartition(".")
        setattr(getattr(axis, part) if part else axis, field, value)
    axis.encoder.modulo_factor, axis.user_data_state_offset = period, user_data
    axis.drive.io.state8, axis.drive.io.data_in3 = inputs, velocity
    axis.set_motion_phase = phase
    encoder = axis.encoder
    encoder.latch_active, encoder.latch_valid = probes[0], probes[-1]
    for name, values in zip(PROBES, (probes[n : n + 8] for n in range(0, 32, 8)), strict=True):
        for number, each in enumerate(values):
            getattr(encoder, name)[number] = each * (number + 1 if name == "probe_counter" else 1)
    images = AxisImages([axis, axis])
    images.show()
    expected = NC_TO_PLC_TC3.encode(axis)
    assert [bytes(view) for view in images.views] == [expected, expected]


@needs_compiler
def test_moving_axes_in_checked_code() -> None:
    """Checked: no index, no whole number out of its range, in any cycle."""
    with checked_builds():
        nc = Nc(2_000_000, [AxisParameters(n) for n in (1, 2)], compiled=True)
        axes = [nc.axis(1), nc.axis(2)]
        images = AxisImages(axes)
        ways = StartType.ENDLESS_POSITIVE, StartType.ENDLESS_NEGATIVE
        for axis, way in zip(axes, ways, strict=True):
            axis.control_dword, axis.velocity_override = 7, 1_000_000
            nc.cycle()
            assert commands.start(axis, way, 0.0, 100.0) == 0
        for _ in range(60):
            nc.cycle()
            images.show()
            for axis, view in zip(axes, images.views, strict=True):
                assert bytes(view) == NC_TO_PLC_TC3.encode(axis)
                assert len(view) == IMAGE_BYTES


@needs_compiler
def test_a_position_that_is_no_number_stops_no_other() -> None:
    axis = one_axis()
    axis.set_position = float("inf")
    images = AxisImages([axis])
    images.show()
    (shown,) = struct.unpack_from("<d", images.views[0], 80)
    assert shown == float("inf")
    assert bytes(images.views[0][112:124]) == bytes(12)  # modulo and turns


def test_an_axis_out_of_memory_has_none() -> None:
    axis = Nc(2_000_000, [AxisParameters(1)], compiled=False).axis(1)
    assert not images_of(axis)
    with pytest.raises(TypeError, match="not in memory"):
        AxisImages([axis])
