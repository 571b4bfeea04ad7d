"""Targets of starts, and the velocity at borders that the commands behind them allow."""

from itertools import pairwise
from math import sqrt
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import NcError
from achse.motion import Axis, AxisParameters, BufferMode, Nc, StateBit, commands
from achse.motion.setpoints.targets import look_ahead, modulo_part

V, A, J = 200.0, 1500.0, 2250.0


def test_modulo_part_stays_below_the_period() -> None:
    assert modulo_part(-1e-17, 360.0) == 0.0
    assert modulo_part(360.0, 360.0) == 0.0
    assert modulo_part(-90.0, 360.0) == 270.0


def stopping_way(velocity: float) -> float:
    """Half the velocity for the time of its ramp, here always one without constant deceleration."""
    assert velocity * J <= A * A
    return velocity * sqrt(velocity / J)


def queue(rig: Any, *moves: tuple[float, float], mode: BufferMode) -> None:
    for target, velocity in moves:
        code = commands.universal_start(rig.axis, 1, target, velocity, buffer_mode=mode)
        assert code == 0, hex(code)


@pytest.mark.parametrize(
    ("mode", "border"),
    [
        (BufferMode.BUFFERED, 0.0),
        (BufferMode.BLENDING_LOW, 80.0),
        (BufferMode.BLENDING_PREVIOUS, 80.0),
        (BufferMode.BLENDING_NEXT, 150.0),
        (BufferMode.BLENDING_HIGH, 150.0),
    ],
)
def test_the_mode_names_the_velocity_of_the_border(
    rig: Any, mode: BufferMode, border: float
) -> None:
    queue(rig, (300.0, 80.0), (600.0, 150.0), mode=mode)
    look_ahead(rig.axis)
    assert rig.axis.border.position == 300.0
    assert rig.axis.border.velocity == border


def test_a_border_is_passed_no_faster_than_the_way_behind_it_allows(rig: Any) -> None:
    slow = 50.0
    queue(rig, (300.0, V), (300.0 + stopping_way(slow), V), mode=BufferMode.BLENDING_HIGH)
    look_ahead(rig.axis)
    assert rig.axis.border.velocity == pytest.approx(slow)


def test_further_commands_lengthen_the_way_to_brake(rig: Any) -> None:
    way = stopping_way(150.0)
    ends = [300.0 + share * way for share in (0.0, 0.1, 0.2, 0.3, 0.4, 0.6, 0.7, 0.9, 1.0)]
    queue(rig, *((end, V) for end in ends), mode=BufferMode.BLENDING_PREVIOUS)
    look_ahead(rig.axis)
    several = rig.axis.border.velocity
    # Each border has to be passed without acceleration: slower than one ramp over the whole way,
    # faster than the first stretch alone would allow.
    assert stopping_way(several) < way
    assert stopping_way(several) > 3.0 * 0.1 * way


def test_an_endless_command_behind_allows_any_velocity(rig: Any) -> None:
    queue(rig, (300.0, V), mode=BufferMode.BUFFERED)
    commands.universal_start(rig.axis, 3, 0.0, 150.0, buffer_mode=BufferMode.BLENDING_NEXT)
    look_ahead(rig.axis)
    assert rig.axis.border.velocity == 150.0


def test_a_new_target_beyond_the_next_one_ends_the_blending(rig: Any) -> None:
    queue(rig, (300.0, V), (600.0, V), mode=BufferMode.BLENDING_HIGH)
    assert commands.new_end_position(rig.axis, 1, 700.0) == 0
    look_ahead(rig.axis)
    assert rig.axis.border.velocity == 0.0
    assert rig.axis.border.position == 700.0
    assert commands.new_end_position(rig.axis, 1, 200.0) == 0
    look_ahead(rig.axis)
    assert rig.axis.border.velocity == V


def test_segment_velocities_stand_above_the_mode(rig: Any) -> None:
    axis = rig.axis
    assert commands.universal_start(axis, 1, 300.0, V, segment_end_velocity=60.0) == 0
    look_ahead(axis)
    assert axis.border.velocity == 60.0
    queue(rig, (600.0, V), mode=BufferMode.BUFFERED)
    look_ahead(axis)
    assert axis.border.velocity == 60.0
    axis.buffer_count = 0
    code = commands.universal_start(
        axis, 1, 600.0, V, buffer_mode=BufferMode.BLENDING_HIGH, segment_start_velocity=90.0
    )
    assert code == 0
    look_ahead(axis)
    assert axis.border.velocity == 90.0


def test_the_blending_position_is_the_border(rig: Any) -> None:
    queue(rig, (300.0, V), mode=BufferMode.BUFFERED)
    code = commands.universal_start(
        rig.axis, 1, 600.0, V, buffer_mode=BufferMode.BLENDING_NEXT, blending_position=250.0
    )
    assert code == 0
    look_ahead(rig.axis)
    assert (rig.axis.border.position, rig.axis.target_position) == (250.0, 300.0)


MODES = [BufferMode(18), BufferMode(19), BufferMode(20), BufferMode(21)]


def wanted(mode: BufferMode, before: float, after: float) -> float:
    return {18: min(before, after), 19: before, 20: after, 21: max(before, after)}[mode]


def fastest(way: float, other: float) -> float:
    """Highest velocity that one ramp joins with `other` within `way`, by halving."""
    low, high = other, 1e4
    for _ in range(60):
        middle = 0.5 * (low + high)
        change = middle - other
        time = 2.0 * sqrt(change / J) if change * J <= A * A else change / A + A / J
        low, high = (middle, high) if 0.5 * (middle + other) * time <= way else (low, middle)
    return low


@pytest.mark.usefixtures("checked_kernels")
@given(
    st.lists(
        st.tuples(st.floats(1.0, 300.0), st.floats(20.0, 400.0), st.sampled_from(MODES)),
        min_size=2,
        max_size=9,
    )
)
@settings(max_examples=20, deadline=None)
def test_any_chain_passes_each_border_as_its_modes_and_ways_allow(
    moves: list[tuple[float, float, BufferMode]],
) -> None:
    """Backwards for what can be braked, forwards for what can be reached from rest."""
    ways = [way for way, _, _ in moves]
    velocities = [velocity for _, velocity, _ in moves]
    modes = [mode for _, _, mode in moves]
    borders = [0.0] * (len(moves) + 1)
    for n in range(len(moves) - 1, 0, -1):
        requested = wanted(modes[n], velocities[n - 1], velocities[n])
        borders[n] = min(requested, fastest(ways[n], borders[n + 1]))
    for n in range(1, len(moves)):
        borders[n] = min(borders[n], fastest(ways[n - 1], borders[n - 1]))

    presets = {"control_dword": 7, "velocity_override": 1_000_000}
    nc = Nc(1_000_000, [AxisParameters(1, values=presets)], compiled=True)
    nc.cycle()
    axis: Axis = nc.axis(1)
    assert commands.universal_start(axis, 2, ways[0], velocities[0], A, A, J) == 0
    for way, velocity, mode in moves[1:]:
        assert commands.universal_start(axis, 2, way, velocity, A, A, J, mode) == 0
    ends = [sum(ways[: n + 1]) for n in range(len(ways))]
    samples = [(0.0, 0.0, 0.0)]
    while axis.set_motion_phase:
        nc.cycle()
        samples.append((axis.set_position, axis.set_velocity, axis.set_acceleration))
    assert samples[-1] == (pytest.approx(ends[-1]), 0.0, 0.0)
    steps = pairwise(samples)
    for n, end in enumerate(ends[:-1], 1):
        (_, v0, a0), (_, v1, a1) = next((s, t) for s, t in steps if t[0] >= end)
        # There the acceleration is zero, so jerk J moves the velocity little within the cycle.
        most = 0.5 * J * 0.001**2 + max(abs(a0), abs(a1)) * 0.001
        assert min(v0, v1) - most <= borders[n] * (1.0 + 1e-6), (n, borders)
        assert max(v0, v1) + most >= borders[n] * (1.0 - 1e-6), (n, borders)


def rest_to_rest(way: float, v: float, a: float, j: float) -> float:
    """Time of a symmetric move that reaches its velocity: s / v + ramp."""
    return way / v + (v / a + a / j if v * j >= a * a else 2.0 * sqrt(v / j))


@pytest.mark.parametrize(("loop", "target"), [(20.0, 100.0), (-20.0, -100.0)])
def test_a_loop_passes_its_target_and_comes_back(make_rig: Any, loop: float, target: float) -> None:
    rig = make_rig(loop_enable=1, loop_distance=loop)
    axis = rig.axis
    v, a, j = 50.0, 1000.0, 50_000.0
    assert commands.start(axis, 1, target, v, a, a, j) == 0
    rig.run(1)
    both = rest_to_rest(120.0, v, a, j), rest_to_rest(20.0, v, a, j)
    assert axis.remaining_time == pytest.approx(sum(both), abs=rig.dt)
    assert axis.remaining_distance == pytest.approx(140.0, abs=0.1)
    assert axis.target_position == target
    first = rig.until(lambda ax: ax.loop.outward == 0)
    assert first * rig.dt == pytest.approx(both[0], abs=2 * rig.dt)
    assert abs(axis.set_position - target) == pytest.approx(20.0, abs=0.01)
    assert not rig.has(StateBit.IN_TARGET_POSITION)
    assert (first + rig.until_rest()) * rig.dt == pytest.approx(sum(both), abs=2 * rig.dt)
    assert axis.set_position == target
    # from the other side the axis goes straight there
    assert commands.start(axis, 2, -target, v, a, a, j) == 0
    extremes = [p for p, _, _ in rig.trace(2000)]
    assert axis.set_position == 0.0
    assert min(extremes) >= min(0.0, target)
    assert max(extremes) <= max(0.0, target)


def test_every_start_of_a_loop_is_decided_again(make_rig: Any) -> None:
    rig = make_rig(loop_enable=1, loop_distance=5.0)
    for start_type, position in ((1, 50.0), (4, 0.0), (1, 50.0)):
        assert commands.universal_start(rig.axis, start_type, position, 100.0) == 0
        farthest = max(p for p, _, _ in rig.trace(300 if start_type == 4 else 1500))
        commands.stop(rig.axis)
        rig.until_rest()
        assert farthest == pytest.approx(55.0 if start_type == 1 else 50.0, abs=0.01)


def test_a_new_target_of_a_loop_is_decided_again(make_rig: Any) -> None:
    rig = make_rig(loop_enable=1, loop_distance=5.0)
    commands.start(rig.axis, 1, 500.0, 100.0)
    rig.seconds(1.0)
    assert commands.new_end_position(rig.axis, 1, 0.0) == 0
    lowest = min(p for p, _, _ in rig.trace(3000))
    assert rig.axis.set_position == 0.0
    assert lowest >= 0.0
    assert commands.new_dynamics(rig.axis, 1.0, 1.0, 1.0) != 0
    commands.start(rig.axis, 1, 50.0, 100.0)
    rig.until(lambda axis: axis.set_position > 51.0)
    rig.axis.velocity_override = 100_000  # planned again beyond the target: goes on outward
    highest = max(p for p, _, _ in rig.trace(3000))
    assert highest == pytest.approx(55.0, abs=0.01)
    assert rig.axis.set_position == 50.0


def test_a_loop_keeps_the_soft_limits(make_rig: Any) -> None:
    rig = make_rig(
        loop_enable=1, loop_distance=5.0, encoder_soft_limit_max_enable=1,
        encoder_soft_limit_max=100.0,
    )  # fmt: skip
    rig.refuses(NcError.SOFT_LIMIT_MAX_AT_START, commands.start, 1, 95.1, 100.0)
    assert commands.start(rig.axis, 1, 95.0, 100.0) == 0
    rig.until_rest()
    assert (rig.axis.set_position, rig.axis.error_code) == (95.0, 0)


def test_without_the_switch_there_is_no_loop(make_rig: Any) -> None:
    rig = make_rig(loop_distance=5.0)
    commands.start(rig.axis, 1, 50.0, 100.0)
    assert max(p for p, _, _ in rig.trace(1500)) == 50.0


def test_a_stop_ends_a_loop(make_rig: Any) -> None:
    rig = make_rig(loop_enable=1, loop_distance=50.0)
    commands.start(rig.axis, 1, 100.0, 100.0)
    rig.until(lambda axis: axis.set_position > 110.0)
    commands.stop(rig.axis)
    rig.until_rest()
    assert 110.0 < rig.axis.set_position <= 150.0
    rig.seconds(0.5)
    assert rig.has(StateBit.IN_TARGET_POSITION)  # where the stop ended


def test_both_kernels_agree_on_loops_jogs_and_oriented_stops(make_rig: Any) -> None:
    digests = []
    for compiled in (False, True):
        rig = make_rig(compiled=compiled, loop_enable=1, loop_distance=5.0, jog_velocity_slow=80.0)
        commands.start(rig.axis, 1, 50.0, 100.0)
        rig.seconds(0.5)
        rig.axis.velocity_override = 300_000
        rig.seconds(4.0)
        rig.axis.velocity_override = 1_000_000
        commands.start(rig.axis, 273, 0.0, 0.0)
        rig.seconds(1.0)
        assert commands.oriented_stop(rig.axis, 45.0, 100.0, 1000.0) == 0
        rig.seconds(6.0)
        assert rig.axis.set_position % 360.0 == pytest.approx(45.0, abs=1e-9)
        digests.append(rig.nc.digest())
    assert digests[0] == digests[1]


@pytest.mark.parametrize("beyond", [False, True], ids=["on its way out", "on its way back"])
def test_a_loop_that_is_switched_off_is_over(make_rig: Any, beyond: bool) -> None:
    """Blended moves behind it go on from its target."""
    rig = make_rig(loop_enable=1, loop_distance=50.0)
    queue(rig, (50.0, V), mode=BufferMode.ABORTING)
    rig.until(lambda axis: axis.set_position > 60.0)
    queue(rig, (20.0, V), (0.0, V), mode=BufferMode.BLENDING_PREVIOUS)
    if beyond:
        rig.until(lambda axis: axis.set_velocity < -1.0)
    rig.axis.loop_enable = 0
    rig.axis.velocity_override = 990_000
    rig.until(lambda axis: axis.set_motion_phase == axis.buffer_count == 0, 10.0)
    assert rig.axis.set_position == 0.0
